//! `tsc-family run` and `report` end to end, with SUMO, on the smoke scenario.

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::common::{program, run, stderr, stdout, succeed};
use crate::outcomes::records;
use serde_json::Value;

const SMOKE: &str = "run smoke --eval-seeds 2 --methods max-pressure,actuated";

#[test]
fn a_run_prints_a_line_per_task_and_per_method_and_resumes_to_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let text = succeed(folder.path(), &format!("{SMOKE} --json --out out"));
    let lines: Vec<Value> = text.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let of = |event: &str| lines.iter().filter(|l| l["event"] == event).count();
    assert_eq!((of("task"), of("method"), lines.len()), (6, 3, 9));
    let baseline = lines.iter().find(|l| l["method"] == "baseline" && l["event"] == "method");
    assert_eq!(baseline.unwrap()["overall"], 1.0);
    let documented =
        ["method", "overall", "overall_low", "overall_high", "delay_s", "points", "failed"];
    let further = ["against", "ratio_of_means", "median", "geometric_mean", "up_to_e", "at_f"];
    let of_episodes = ["unfinished_share", "gridlock_share", "episode_median", "episode_worst"];
    for field in documented.iter().chain(&further).chain(&of_episodes) {
        assert!(baseline.unwrap().get(field).is_some(), "{field}");
    }
    let again = succeed(folder.path(), &format!("{SMOKE} --json --out out"));
    assert_eq!(again.lines().count(), 3, "nothing is done twice: {again}");

    let scores = fs::read_to_string(folder.path().join("out/report/scores.csv")).unwrap();
    assert_eq!(
        scores.lines().next().unwrap(),
        "method,point,importance,replicate,delay_s,baseline_delay_s,score,waiting_s,queue_veh,\
         throughput_veh,unfinished_veh,teleports,level_of_service,lanes,speed_mph,length_m,\
         inflow_vph,left_turn_lanes,right_turn_lanes,weight,against"
    );
    assert_eq!(scores.lines().count(), 7);
}

#[test]
fn a_run_that_another_build_began_says_so_and_records_name_theirs() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), &format!("{SMOKE} --quiet --out out"));
    let record = folder.path().join("out/done/000/2.jsonl");
    let build = |path: &Path| {
        let text = fs::read_to_string(path).unwrap();
        let summary: Value = serde_json::from_str(text.lines().next().unwrap()).unwrap();
        summary["wall"]["git"].as_str().unwrap().to_owned()
    };
    let git = build(&record);
    let again = |began: &str| {
        fs::remove_file(&record).unwrap();
        let path = folder.path().join("out/manifest.json");
        let mut manifest: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
        manifest["provenance"]["git"] = began.into();
        fs::write(&path, manifest.to_string()).unwrap();
        let output = run(folder.path(), &format!("{SMOKE} --out out"));
        assert!(output.status.success(), "{}", stderr(&output));
        assert_eq!(build(&record), git);
        stderr(&output)
    };
    let told = format!("warning: this run was begun by the build 1234567 and goes on with {git}");
    let said = again("1234567");
    assert!(said.contains(&told), "{said}");
    assert!(!again(&git).contains("warning"));
}

#[test]
fn a_run_against_another_method_writes_a_second_report() {
    let folder = tempfile::tempdir().unwrap();
    let text = succeed(folder.path(), &format!("{SMOKE} --against actuated --out out"));
    assert!(text.contains("Scores against actuated, not against the baseline:"), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    let summary =
        |file: &str| fs::read_to_string(folder.path().join("out/report").join(file)).unwrap();
    assert!(summary("summary.csv").contains(",baseline,"));
    assert!(!summary("against-actuated/summary.csv").contains(",baseline,"));
    for command in
        ["report out --against idqn".to_owned(), format!("{SMOKE} --against idqn --out no")]
    {
        let output = run(folder.path(), &command);
        assert_eq!(output.status.code(), Some(2), "{command}");
        let expected = "error: no scores against `idqn`, which is not in the run; its methods are \
                        baseline, max-pressure, actuated";
        assert!(stderr(&output).contains(expected), "{}", stderr(&output));
    }
    assert!(!folder.path().join("no").exists());
}

#[test]
fn records_do_not_depend_on_the_number_of_workers() {
    let folder = tempfile::tempdir().unwrap();
    let methods = "run smoke --eval-seeds 1 --methods fixed-time,max-pressure,actuated --set demand.horizon_s=600 --quiet";
    succeed(folder.path(), &format!("{methods} --out one --jobs 1"));
    succeed(folder.path(), &format!("{methods} --out three --jobs 3"));
    let one = records(&folder.path().join("one"));
    assert_eq!(one.len(), 8);
    assert_eq!(one, records(&folder.path().join("three")));
}

#[test]
fn a_run_whose_process_is_killed_continues_to_the_same_records() {
    let folder = tempfile::tempdir().unwrap();
    let long = "run smoke --eval-seeds 4 --methods fixed-time,max-pressure --quiet";
    succeed(folder.path(), &format!("{long} --out whole"));
    let mut child = program(folder.path())
        .args(format!("{long} --out killed").split_whitespace())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let done = folder.path().join("killed/done/000");
    let start = Instant::now();
    while fs::read_dir(&done).map_or(0, Iterator::count) < 2 {
        assert!(start.elapsed() < Duration::from_secs(60), "no task was finished in a minute");
        sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let killed = fs::read_dir(&done).unwrap().count();
    assert!(killed < 6, "it was over before it was killed, so that nothing is shown");
    succeed(folder.path(), &format!("{long} --out killed"));
    let whole = records(&folder.path().join("whole"));
    assert_eq!(whole.len(), 6);
    assert_eq!(whole, records(&folder.path().join("killed")));
}

#[test]
fn two_runs_on_one_folder_exclude_each_other() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), &format!("{SMOKE} --quiet --out out"));
    let lock = fs::File::options().write(true).open(folder.path().join("out/lock.json")).unwrap();
    lock.lock().unwrap();
    let output = run(folder.path(), &format!("{SMOKE} --quiet --out out"));
    assert_eq!(output.status.code(), Some(5));
    assert!(stderr(&output).contains("in use by another run"), "{}", stderr(&output));
}

#[test]
fn an_altered_record_is_named_and_its_task_alone_is_repeated_once_it_is_deleted() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), &format!("{SMOKE} --quiet --out out"));
    let before = records(&folder.path().join("out"));
    let path = folder.path().join("out/done/000/2.jsonl");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, &text[..text.len() / 2]).unwrap();
    for args in ["report out", &format!("{SMOKE} --quiet --out out")] {
        let output = run(folder.path(), args);
        assert_eq!(output.status.code(), Some(2), "{args}");
        assert!(stderr(&output).contains("done/000/2.jsonl"), "{}", stderr(&output));
    }
    fs::remove_file(&path).unwrap();
    let text = succeed(folder.path(), &format!("{SMOKE} --json --out out"));
    assert_eq!(text.lines().filter(|l| l.contains("\"event\":\"task\"")).count(), 1);
    assert_eq!(before, records(&folder.path().join("out")));
}

#[test]
fn an_altered_network_is_refused_until_it_is_built_again() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), "build-networks smoke --quiet");
    let net = folder.path().join("networks/smoke/busy/busy.net.xml");
    let text = fs::read_to_string(&net).unwrap();
    fs::write(&net, text.replacen("speed=\"", "speed=\"1", 1)).unwrap();
    let output = run(folder.path(), &format!("{SMOKE} --quiet"));
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("busy.net.xml: was altered"), "{}", stderr(&output));
    fs::remove_file(&net).unwrap();
    let output = run(folder.path(), &format!("{SMOKE} --quiet"));
    assert!(stderr(&output).contains("busy.net.xml: was deleted"), "{}", stderr(&output));
    succeed(folder.path(), "build-networks smoke --force --quiet");
    assert_eq!(fs::read_to_string(&net).unwrap(), text);
    succeed(folder.path(), &format!("{SMOKE} --quiet"));
}

#[test]
fn a_sumo_scenario_is_a_point_mdp_too() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), "build-networks smoke --quiet");
    let args = "run --sumocfg networks/smoke/busy/busy.sumocfg --methods program,max-pressure \
                --eval-seeds 1 --json";
    let text = succeed(folder.path(), args);
    let program =
        text.lines().find(|l| l.contains("\"event\":\"method\"") && l.contains("program"));
    let program: Value = serde_json::from_str(program.unwrap()).unwrap();
    assert!(program["overall"].as_f64().unwrap() > 0.0);
}

#[test]
fn settings_from_the_command_line_are_part_of_what_a_run_is() {
    let folder = tempfile::tempdir().unwrap();
    let short = "run smoke --eval-seeds 1 --methods ippo --quiet --set demand.horizon_s=300";
    succeed(folder.path(), &format!("{short} --episodes 2 --out out"));
    let manifest = fs::read_to_string(folder.path().join("out/manifest.json")).unwrap();
    let manifest: Value = serde_json::from_str(&manifest).unwrap();
    let settings = &manifest["identity"]["settings"];
    assert_eq!(settings["demand"]["horizon_s"], 300.0);
    assert_eq!(settings["training"]["episodes"], 2);
    succeed(folder.path(), &format!("{short} --set training.episodes=2 --episodes 2 --out out"));
    let output = run(folder.path(), &format!("{short} --episodes 8 --out out"));
    assert_eq!(output.status.code(), Some(5));
    let expected =
        "out holds another run: the setting training.episodes is 2 there and 8 now; give";
    assert!(stderr(&output).contains(expected), "{}", stderr(&output));
}

#[test]
fn replicates_are_trainings_of_their_own_and_the_score_is_their_mean() {
    let folder = tempfile::tempdir().unwrap();
    let short = "run smoke --eval-seeds 1 --methods fixed-time,max-pressure --replicates 2 \
                 --set demand.horizon_s=300 --set fixed_time.simulations=8 --out out";
    let text = succeed(folder.path(), &format!("{short} --json"));
    let scores = fs::read_to_string(folder.path().join("out/report/scores.csv")).unwrap();
    let rows: Vec<Vec<&str>> =
        scores.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 2 * (1 + 2 + 1));
    let tuned: Vec<_> = rows.iter().filter(|row| row[0] == "fixed-time").collect();
    assert!(tuned.iter().any(|row| row[3] == "1"));
    let mean: f64 = tuned
        .iter()
        .map(|row| row[2].parse::<f64>().unwrap() * row[6].parse::<f64>().unwrap() / 2.0)
        .sum();
    let line = text.lines().find(|l| l.contains("\"event\":\"method\"") && l.contains("fixed"));
    let line: Value = serde_json::from_str(line.unwrap()).unwrap();
    assert!((line["overall"].as_f64().unwrap() - mean).abs() < 1e-9, "{line} {mean}");
    let page = fs::read_to_string(folder.path().join("out/report/index.html")).unwrap();
    assert!(page.contains("and so are the 2 independent trainings of fixed-time"));
}

#[test]
fn bad_requests_are_usage_errors_and_write_nothing() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("no.sumocfg"), "<configuration/>").unwrap();
    let cases = [
        (
            "run smoke --methods maxpressure",
            "unknown method \"maxpressure\"; known are baseline, fixed-time, max-pressure, ",
        ),
        ("run smoke --methods maxpressure", "; did you mean max-pressure?"),
        (
            "run smok",
            "(salt-lake-city, salt-lake-city-peak, smoke, cartpole, pendulum, mountain-car, acrobot, pendulum-swing-up, \
             quad, half-cheetah, swimmer)",
        ),
        ("run smok", "did you mean smoke?"),
        ("rum smoke", "some similar subcommands exist: 'run', 'resume'"),
        ("run smoke --episodes 0", "expected a whole number from 1 to 4294967295"),
        ("run smoke --jobs two", "expected a whole number from 1 to 1024"),
        ("run smoke --seed -1.5", "unexpected argument"),
        ("run smoke --seed=-1", "expected a whole number from 0 to 18446744073709551615"),
        (
            "run smoke --methods idqn --episodes 2000000",
            "--episodes 2000000: training.episodes = 2000000: expected",
        ),
        (
            "run smoke --methods ippo --episodes 20 --set training.episodes=30",
            "--episodes 20: --set says training.episodes=30; give one of the two",
        ),
        ("run smoke --set idqn.learning_rat=1", "--set idqn.learning_rat=1: unknown setting"),
        ("run smoke --budget 0", "budget 0: the family has 2 point MDPs"),
        ("run smoke --budget 3", "budget 3: the family has 2 point MDPs"),
        ("run smoke --budget some", "expected a whole number or `all`"),
        ("run --sumocfg nowhere.sumocfg", "nowhere.sumocfg does not exist"),
        ("run --sumocfg no.sumocfg", "no `<net-file>`"),
        ("report .", "not a results directory"),
    ];
    for (args, expected) in cases {
        let output = run(folder.path(), args);
        assert_eq!(output.status.code(), Some(2), "{args}: {}", stderr(&output));
        assert!(stderr(&output).contains(expected), "{args}: {}", stderr(&output));
        assert!(stdout(&output).is_empty(), "{args}");
    }
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(left.len(), 1, "{left:?}");
}

#[test]
fn a_sumo_scenario_without_signals_fails_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("n.nod.xml"),
        "<nodes><node id=\"a\" x=\"0\" y=\"0\"/><node id=\"b\" x=\"99\" y=\"0\"/></nodes>",
    )
    .unwrap();
    fs::write(
        folder.path().join("n.edg.xml"),
        "<edges><edge id=\"e\" from=\"a\" to=\"b\"/></edges>",
    )
    .unwrap();
    let built = std::process::Command::new("netconvert")
        .current_dir(folder.path())
        .args(["-n", "n.nod.xml", "-e", "n.edg.xml", "-o", "n.net.xml", "-X", "never"])
        .output();
    if built.is_err() {
        // SUMO is not on the path, as with the wheel; the check is the same with any SUMO.
        return;
    }
    fs::write(
        folder.path().join("n.sumocfg"),
        "<configuration><net-file value=\"n.net.xml\"/><end value=\"60\"/></configuration>",
    )
    .unwrap();
    let output = run(folder.path(), "run --sumocfg n.sumocfg --eval-seeds 1 --out out");
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(!folder.path().join("out").exists());
    assert!(stderr(&output).contains("has no traffic signal"), "{}", stderr(&output));
}

#[test]
fn a_plan_that_was_cut_short_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), &format!("{SMOKE} --quiet --out out"));
    let path = folder.path().join("out/plan.jsonl");
    let text = fs::read_to_string(&path).unwrap();
    let (short, _) = text.trim_end().rsplit_once('\n').unwrap();
    fs::write(&path, format!("{short}\n")).unwrap();
    let output = run(folder.path(), "report out");
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("it is not the plan of manifest.json"), "{}", stderr(&output));
}

#[test]
fn a_dry_run_lists_the_plan_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    insta::assert_snapshot!("dry_run", succeed(folder.path(), "run --budget 4 --jobs 2 --dry-run"));
    let text = succeed(folder.path(), "run smoke --replicates 3 --dry-run");
    assert!(text.starts_with("2 of 2 point MDPs (all, seed 0), 5 methods, 14 tasks\n"), "{text}");
    // Tuning of fixed-time takes 8 episodes in this scenario, evaluation 5.
    assert!(text.contains(&format!("{} episodes at most", 2 * (3 * (8 + 5) + 4 * 5))), "{text}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn doctor_finds_nothing_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let text = succeed(folder.path(), "doctor --json");
    let findings: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(findings["problems"], Value::Array(vec![]));
    assert!(findings["sumo_version"].as_str().unwrap().starts_with("SUMO 1."));
}

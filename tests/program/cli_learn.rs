//! A learner end to end, with SUMO: trained, killed, continued, and its model elsewhere.

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::common::{program, run, stderr, stdout, succeed};
use crate::outcomes::record;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

/// Two point MDPs of ten minutes, the second with more lanes.
const POINTS: &str = "\
point,intersections,lanes,speed_mph,length_m,inflow_vph,left_turn_lanes,right_turn_lanes
narrow,1,2,30,200,250,0,0
wide,1,6,30,200,250,1,1
";

/// Trains `idqn` on both point MDPs; it is task 1 on the first and task 3 on the second.
const RUN: &str = "run city.toml --methods idqn --eval-seeds 2 --quiet";

/// A folder with a scenario whose learners train for some episodes.
fn city(episodes: u32) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let scenario = format!(
        "name = \"city\"\n[family]\npoints = \"points.csv\"\n[demand]\nhorizon_s = 600.0\n\
         [training]\nepisodes = {episodes}\n"
    );
    fs::write(folder.path().join("city.toml"), scenario).unwrap();
    fs::write(folder.path().join("points.csv"), POINTS).unwrap();
    folder
}

fn json_lines(text: &str) -> Vec<Value> {
    text.lines().map(|l| serde_json::from_str(l).unwrap()).collect()
}

#[test]
fn a_trained_model_drives_elsewhere_as_it_did_where_it_was_trained() {
    let folder = city(2);
    succeed(folder.path(), &format!("{RUN} --out out"));
    let out = folder.path().join("out");
    let record = record(&out, 1);
    let summary = &record[0]["metrics"];
    let training: Vec<&Value> = record.iter().filter(|r| r["kind"] == "training").collect();
    assert_eq!(training.len(), 2);
    assert!(training.iter().all(|r| r["metrics"]["return"].is_f64()), "{training:?}");
    let delays: Vec<f64> =
        training.iter().map(|r| r["metrics"]["delay_s"].as_f64().unwrap()).collect();
    assert_eq!(summary["resco_best_delay_s"].as_f64().unwrap(), delays[0].min(delays[1]));
    assert!(!out.join("ckpt/000/1.safetensors").exists());

    let evaluate = "evaluate --model out/models/000/1.safetensors --eval-seeds 2 --json";
    let lines =
        json_lines(&succeed(folder.path(), &format!("{evaluate} --point narrow city.toml")));
    assert_eq!((&lines[0]["method"], &lines[0]["score"]), (&"baseline".into(), &1.0.into()));
    assert_eq!(lines[1]["method"], "idqn-of-narrow");
    assert_eq!(lines[1]["delay_s"], summary["delay_s"], "as in the run");
    let of_model = |lines: &[Value]| {
        let of_all = lines.iter().find(|l| l["event"] == "method" && l["method"] != "baseline");
        of_all.unwrap().clone()
    };
    assert_eq!(of_model(&lines)["score"], lines[1]["score"]);
    let interval = of_model(&lines)["interval"].as_array().unwrap().clone();
    assert!(interval[0].as_f64() <= lines[1]["score"].as_f64(), "{interval:?}");
    let config = "networks/city/narrow/narrow.sumocfg";
    let lines = json_lines(&succeed(folder.path(), &format!("{evaluate} --sumocfg {config}")));
    assert_eq!((lines.len(), &lines[1]["point"]), (4, &"narrow".into()));

    let text = succeed(folder.path(), &format!("{evaluate} --point narrow city.toml"));
    assert_eq!(text, succeed(folder.path(), &format!("{evaluate} --point narrow city.toml")));
}

#[test]
fn a_model_for_other_signals_or_another_family_is_refused() {
    let folder = city(1);
    succeed(folder.path(), &format!("{RUN} --out out"));
    let evaluate = "evaluate --model out/models/000/1.safetensors --eval-seeds 1 --json";
    for (place, words) in [
        (
            "--point wide city.toml",
            "idqn-of-narrow on wide: the model does not fit these signals: ",
        ),
        ("--point nowhere city.toml", "has no point MDP \"nowhere\"; it has narrow, wide"),
        ("--sumocfg nowhere.sumocfg", "nowhere.sumocfg does not exist"),
        ("--point narrow atlantis", "no scenario \"atlantis\""),
    ] {
        let output = run(folder.path(), &format!("{evaluate} {place}"));
        assert_eq!(output.status.code(), Some(2), "{place}: {}", stderr(&output));
        assert!(stderr(&output).contains(words), "{place}: {}", stderr(&output));
        assert!(stdout(&output).is_empty(), "{place}");
    }
}

#[test]
fn models_are_evaluated_on_many_point_mdps_and_the_baseline_once() {
    let folder = city(2);
    succeed(folder.path(), "run city.toml --methods mplight,idqn --eval-seeds 2 --quiet --out out");
    let models = "--model out/models/000/1.safetensors --model wide=out/models/000/4.safetensors";
    let evaluate = format!("evaluate {models} --budget all --eval-seeds 2 --out on-all city.toml");
    let text = succeed(folder.path(), &evaluate);
    assert!(text.contains("mplight-of-narrow") && text.contains("95% interval"), "{text}");
    let records = fs::read_dir(folder.path().join("on-all/done/000")).unwrap().count();
    assert_eq!(records, 6, "two models and the baseline on two point MDPs");
    // The same command continues, and finds everything done.
    let before = fs::metadata(folder.path().join("on-all/done/000/0.jsonl")).unwrap().modified();
    assert_eq!(succeed(folder.path(), &evaluate), text);
    let after = fs::metadata(folder.path().join("on-all/done/000/0.jsonl")).unwrap().modified();
    assert_eq!(before.unwrap(), after.unwrap());
    // As methods of a run they are what they are alone; another timing of signals is warned of.
    let run_them = "run city.toml --methods max-pressure --model m=out/models/000/1.safetensors \
                    --eval-seeds 2 --out beside";
    let output = run(folder.path(), run_them);
    assert!(output.status.success() && !stderr(&output).contains("another timing"));
    let m = record(&folder.path().join("beside"), 2);
    assert_eq!(
        m[0]["metrics"]["delay_s"],
        record(&folder.path().join("out"), 1)[0]["metrics"]["delay_s"]
    );
    let output = run(folder.path(), &format!("{run_them}-short --set signal.delta_time_s=5"));
    let words = "m was trained with another timing of signals (signal.delta_time_s = 10 there, 5 here; preset resco)";
    assert!(stderr(&output).contains(words), "{}", stderr(&output));
    let index = fs::read_to_string(folder.path().join("out/report/models.csv")).unwrap();
    let rows: Vec<&str> = index.lines().collect();
    assert_eq!(rows[0], "file,method,point,replicate,episode,episodes,seed,delay_s");
    assert!(rows[1].starts_with("models/000/1.safetensors,mplight,narrow,0,2,2,"), "{index}");
    assert_eq!(rows.len(), 5);
}

#[test]
fn an_interrupted_evaluation_has_the_exit_code_of_an_interrupted_run() {
    let folder = city(1);
    succeed(folder.path(), &format!("{RUN} --out out"));
    let evaluate = "evaluate --model out/models/000/1.safetensors --point narrow city.toml \
                    --eval-seeds 1000 --jobs 1 --out moved";
    let mut command = program(folder.path());
    command.args(evaluate.split_whitespace()).stdout(Stdio::null()).stderr(Stdio::piped());
    let child = command.spawn().unwrap();
    let start = Instant::now();
    while !folder.path().join("moved/logs").is_dir() {
        assert!(start.elapsed() < Duration::from_secs(60), "no task began");
        sleep(Duration::from_millis(10));
    }
    kill_process(Pid::from_child(&child), Signal::INT).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    let said = "interrupted with 2 tasks to do; the same command does them";
    assert!(stderr(&output).contains(said), "{}", stderr(&output));
}

#[test]
fn a_transfer_simulates_models_alone_and_names_what_does_not_carry_over() {
    let folder = city(2);
    succeed(folder.path(), "run city.toml --methods mplight,idqn --eval-seeds 2 --quiet --out out");
    let output = run(folder.path(), "transfer out --out moved --json");
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    let words = "no score: idqn-of-narrow on wide: the model does not fit these signals: it is for signals of 4 lanes";
    assert!(stderr(&output).contains(words), "{}", stderr(&output));
    let lines = json_lines(&stdout(&output));
    let named: Vec<_> =
        lines.iter().map(|l| (&l["method"], &l["trained_on"], &l["points"])).collect();
    let expected = [
        ("mplight", "narrow", 1),
        ("mplight", "wide", 1),
        ("idqn", "narrow", 0),
        ("idqn", "wide", 0),
    ];
    for ((method, trained_on, points), expected) in named.into_iter().zip(expected) {
        assert_eq!((method.as_str(), trained_on.as_str()), (Some(expected.0), Some(expected.1)));
        assert_eq!(*points, expected.2);
    }
    // Baseline and own training are the run's records with their wall-clock values; at home a model is what its training was.
    let first = |dir: &str, task: usize| -> Value {
        let text = fs::read_to_string(folder.path().join(format!("{dir}/done/000/{task}.jsonl")));
        serde_json::from_str(text.unwrap().lines().next().unwrap()).unwrap()
    };
    for task in 0..3 {
        let wall_s = |dir: &str| first(dir, task)["wall"]["wall_s"].clone();
        assert_eq!(wall_s("moved"), wall_s("out"), "{task}");
    }
    assert_eq!(first("moved", 3)["method"], "mplight-of-narrow");
    let delay = |record: &Value| record["metrics"]["delay_s"].clone();
    assert_eq!(delay(&first("moved", 3)), delay(&first("out", 1)));
    let moved = folder.path().join("moved/transfer");
    let table = fs::read_to_string(moved.join("transfer.csv")).unwrap();
    assert_eq!(table.lines().count(), 9);
    assert!(table.contains("mplight,narrow,narrow,0.5,"), "{table}");
    for file in ["summary.csv", "transfer.tex", "transfer.svg"] {
        assert!(moved.join(file).is_file(), "{file}");
    }
    let svg = fs::read_to_string(moved.join("transfer.svg")).unwrap();
    assert!(svg.contains("mplight: own training") && svg.contains("trained on"), "{svg}");
    // The same command finds everything done, and fewer models are taken by their names.
    let output = run(folder.path(), "transfer out --out moved");
    assert!(
        stderr(&output).contains("heat map: moved/transfer/transfer.svg"),
        "{}",
        stderr(&output)
    );
    let output = run(folder.path(), "transfer out --out ./out");
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("whose models are taken; give another folder"));
    let few = "transfer out --methods mplight --trained-on wide --out few --json";
    assert_eq!(json_lines(&succeed(folder.path(), few)).len(), 1);
    fs::remove_dir_all(folder.path().join("out/models")).unwrap();
    let output = run(folder.path(), "transfer out --out none");
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("out has no model of what is asked for"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn a_killed_training_continues_to_the_same_record_and_model() {
    let folder = city(12);
    succeed(folder.path(), &format!("{RUN} --out whole"));
    let (whole, killed) = (folder.path().join("whole"), folder.path().join("killed"));
    fs::create_dir(&killed).unwrap();
    for file in ["manifest.json", "plan.jsonl"] {
        fs::copy(whole.join(file), killed.join(file)).unwrap();
    }
    succeed(folder.path(), "worker killed --task 0");
    let worker = "worker killed --task 1 --checkpoint-every-s 0";
    let mut child = program(folder.path())
        .args(worker.split_whitespace())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let checkpoint = killed.join("ckpt/000/1.safetensors");
    let start = Instant::now();
    while !checkpoint.exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "no checkpoint in a minute");
        sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(checkpoint.exists() && !killed.join("done/000/1.jsonl").exists());

    let output = run(folder.path(), worker);
    assert!(stderr(&output).contains("training continues after episode "), "{}", stderr(&output));
    assert_eq!(record(&killed, 1), record(&whole, 1));
    let model = |results: &Path| fs::read(results.join("models/000/1.safetensors")).unwrap();
    assert!(model(&killed) == model(&whole), "the models differ");
    assert!(!checkpoint.exists());
}

#[test]
fn a_checkpoint_that_cannot_be_used_is_named_and_costs_only_time() {
    let folder = city(2);
    succeed(folder.path(), &format!("{RUN} --out whole"));
    let (whole, other) = (folder.path().join("whole"), folder.path().join("other"));
    fs::create_dir_all(other.join("ckpt/000")).unwrap();
    for file in ["manifest.json", "plan.jsonl"] {
        fs::copy(whole.join(file), other.join(file)).unwrap();
    }
    // A model is no checkpoint.
    let checkpoint = other.join("ckpt/000/1.safetensors");
    fs::copy(whole.join("models/000/1.safetensors"), checkpoint).unwrap();
    let output = run(folder.path(), "worker other --task 1");
    assert!(output.status.success());
    let text = stderr(&output);
    assert!(
        text.contains("other/ckpt/000/1.safetensors is not used: it is not a checkpoint"),
        "{text}"
    );
    assert_eq!(record(&other, 1), record(&whole, 1));
}

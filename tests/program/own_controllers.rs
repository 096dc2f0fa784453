//! Controllers of one's own as the command line knows them: commands, tables of scores, a program with its own methods.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::common::{program, run, stderr, stdout, succeed};
use serde_json::Value;

const SHORT: &str = "--eval-seeds 2 --set demand.horizon_s=120";

/// Runs the program; an argument may have blanks in quotation marks.
fn tsc(folder: &Path, args: &str) -> Output {
    program(folder).args(shlex::split(args).unwrap()).output().unwrap()
}

/// A controller in a shell, which answers a decision with what `act` prints.
fn script(act: &str) -> String {
    format!(
        "while read -r line; do case $line in\n*'\"event\":\"begin\"'*) echo '{{}}';;\n\
         *'\"event\":\"act\"'*) {act};;\nesac; done\n"
    )
}

/// A folder with such a controller.
fn folder(act: &str) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("mine.sh"), script(act)).unwrap();
    dir
}

const FIRST: &str = "echo '{\"phases\":[0]}'";

fn mine(out: &str) -> String {
    format!(
        "run smoke --methods max-pressure {SHORT} --controller \"mine=exec:sh mine.sh\" --out {out}"
    )
}

/// The lines of a record that do not depend on the clock.
fn rows(folder: &Path, out: &str, task: usize) -> Vec<Value> {
    let text = fs::read_to_string(folder.join(out).join(format!("done/000/{task}.jsonl"))).unwrap();
    let mut lines: Vec<Value> = text.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    lines[0].as_object_mut().unwrap().retain(|key, _| key != "wall" && key != "checksum");
    lines
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

#[test]
fn what_failed_is_not_forgotten_before_it_can_be_tried_again() {
    let dir = folder("exit 7");
    let folder = dir.path();
    assert_eq!(code(&tsc(folder, &mine("a"))), 3);
    let records = || fs::read_dir(folder.join("a/done/000")).unwrap().count();
    let all = records();
    // Without the controller, and with networks that are not there.
    for lacking in ["", "--controller \"mine=exec:sh mine.sh\" --networks nowhere"] {
        let output = tsc(folder, &format!("resume a --retry-failed {lacking}"));
        assert_eq!((code(&output), records()), (2, all), "{lacking}: {}", stderr(&output));
    }
    assert_eq!(code(&tsc(folder, "status a")), 3);
}

#[test]
fn nothing_is_set_aside_before_it_can_be_done_again() {
    let dir = folder(FIRST);
    let folder = dir.path();
    assert_eq!(code(&tsc(folder, &mine("a"))), 0);
    let record = folder.join("a/done/000/2.jsonl");
    fs::write(&record, "").unwrap();
    let output = tsc(folder, "check a --repair");
    assert_eq!(code(&output), 2, "{}", stderr(&output));
    assert!(stderr(&output).contains("controller mine (exec:sh mine.sh) was not given"));
    assert!(record.exists() && !folder.join("a/damaged").exists());
    let output = tsc(folder, "check a --repair --controller \"mine=exec:sh mine.sh\"");
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(folder.join("a/damaged/done/000/2.jsonl").exists());
}

#[test]
fn a_command_with_a_line_break_is_refused_before_anything_is_written() {
    let dir = folder(FIRST);
    let command = "mine=exec:sh -c 'exec sh\n mine.sh'";
    let mut program = program(dir.path());
    let output = program.args(["run", "smoke", "--controller", command, "--out", "a"]).output();
    let output = output.unwrap();
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("a line break"), "{}", stderr(&output));
    assert!(!dir.path().join("a").exists());
}

#[test]
fn a_command_is_ranked_and_a_changed_one_is_another_run() {
    let dir = folder(FIRST);
    let folder = dir.path();
    let output = tsc(folder, &mine("a"));
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("   mine   "), "{}", stdout(&output));
    let manifest = fs::read_to_string(folder.join("a/manifest.json")).unwrap();
    let manifest: Value = serde_json::from_str(&manifest).unwrap();
    let own = &manifest["identity"]["controllers"][0];
    assert_eq!((&own["kind"], &own["source"]), (&"exec".into(), &"exec:sh mine.sh".into()));
    assert!(own["sha256"]["mine.sh"].is_string() && own["sha256"]["sh"].is_string());
    let page = fs::read_to_string(folder.join("a/report/index.html")).unwrap();
    assert!(
        page.contains("controller mine")
            && page.contains(own["sha256"]["mine.sh"].as_str().unwrap())
    );
    // Whoever only reads needs no controller, whoever goes on does.
    succeed(folder, "status a");
    succeed(folder, "check a");
    fs::remove_file(folder.join("a/done/000/2.jsonl")).unwrap();
    let output = run(folder, "resume a");
    assert_eq!(code(&output), 2);
    assert!(
        stderr(&output).contains("controller mine (exec:sh mine.sh) was not given"),
        "{}",
        stderr(&output)
    );
    let output = tsc(folder, "resume a --controller \"mine=exec:sh mine.sh\"");
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    // With more workers the records are the same.
    let output = tsc(folder, &format!("{} --jobs 3", mine("b")));
    assert_eq!(code(&output), 0);
    (0..6).for_each(|task| assert_eq!(rows(folder, "a", task), rows(folder, "b", task)));
    let script = fs::read_to_string(folder.join("mine.sh")).unwrap();
    fs::write(folder.join("mine.sh"), script + "# changed\n").unwrap();
    let output = tsc(folder, &mine("a"));
    assert_eq!(code(&output), 5);
    assert!(
        stderr(&output).contains("controller mine: mine.sh has changed"),
        "{}",
        stderr(&output)
    );
    fs::remove_file(folder.join("a/done/000/2.jsonl")).unwrap();
    let output = tsc(folder, "resume a --controller \"mine=exec:sh mine.sh\"");
    assert_eq!(code(&output), 5);
    assert!(stderr(&output).contains("mine.sh has changed"), "{}", stderr(&output));
}

#[test]
fn a_command_that_misbehaves_is_a_failed_record_and_the_run_goes_on() {
    let misbehaviours = [
        (
            "echo 'trouble here' >&2; exit 7",
            "it ended (exit status: 7) instead of answering act; it said last\\ntrouble here",
        ),
        ("echo '{\"phases\":[99]}'", "it chose phase 99 of signal 0"),
        // Found before the next question, or, where the machine is slow, as its answer.
        ("echo '{\"phases\":[0]}'; echo more", "\\\"more\\\""),
        ("echo hello", "it answered act with \\\"hello\\\""),
        ("sleep 30", "it did not answer act within 1 s"),
        // A child that outlives it holds its pipes open.
        ("sleep 300 & exit 1", "it ended (exit status: 1) instead of answering act"),
    ];
    let dir = tempfile::tempdir().unwrap();
    let mut command =
        format!("run smoke --methods max-pressure {SHORT} --answer-timeout 1 --out a");
    for (i, (act, _)) in misbehaviours.iter().enumerate() {
        fs::write(dir.path().join(format!("{i}.sh")), script(act)).unwrap();
        command += &format!(" --controller \"c{i}=exec:sh {i}.sh\"");
    }
    let output = tsc(dir.path(), &command);
    assert_eq!(code(&output), 3, "{}", stderr(&output));
    // The first two tasks are those of the baseline and of max pressure.
    assert_eq!(rows(dir.path(), "a", 1)[0]["outcome"], "ok");
    for (i, (act, expected)) in misbehaviours.iter().enumerate() {
        let failed = rows(dir.path(), "a", 2 + i);
        assert_eq!(failed[0]["outcome"], "failed", "{act}");
        let reason = failed[0]["reason"].to_string();
        assert!(reason.contains(expected), "{act}: {reason}");
    }
}

#[test]
fn scores_from_elsewhere_rank_beside_the_others_and_are_marked() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path();
    let table = |delay: &str| {
        let rows = ["quiet,0", "quiet,1", "busy,0", "busy,1"].map(|row| format!("{row},{delay}\n"));
        fs::write(folder.join("s.csv"), format!("point,episode,delay_s\n{}", rows.concat()))
            .unwrap();
    };
    table("12.5");
    let command = format!(
        "run smoke --methods max-pressure {SHORT} --controller-results theirs=s.csv --out a"
    );
    let output = tsc(folder, &command);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let said = stdout(&output);
    assert_eq!(said.matches("theirs (external)").count(), 2, "in both tables: {said}");
    assert_eq!(rows(folder, "a", 2)[1]["metrics"]["delay_s"], 12.5);
    let page = fs::read_to_string(folder.join("a/report/index.html")).unwrap();
    assert!(page.contains("measured elsewhere"));
    assert!(page.contains("<th scope=\"row\">theirs (external)</th>"), "in the ranking");
    assert!(page.contains(">theirs (external)</th>") && !page.contains(">theirs</th>"));
    assert!(!page.contains("<td>theirs</td>"));
    table("13.5");
    assert_eq!(code(&tsc(folder, &command)), 5, "another table is another run");
    fs::write(folder.join("s.csv"), "point,episode,delay_s\nquiet,0,3\nquiet,1,3\n").unwrap();
    let output = tsc(folder, &command.replace("--out a", "--out b"));
    assert_eq!(code(&output), 3);
    let lacks = "theirs (s.csv) has no rows, or too few, of busy; the task there will fail";
    assert!(stderr(&output).contains(lacks), "{}", stderr(&output));
    let reason = &rows(folder, "b", 5)[0]["reason"];
    assert_eq!(reason, "the table has no row of busy with episode 0");
    let further = "point,episode,delay_s\nquiet,0,3\nquiet,1,3\nquiet,2,3\nbusy,0,3\nbusy,1,3\n";
    fs::write(folder.join("s.csv"), further).unwrap();
    let output = tsc(folder, &command.replace("--out a", "--out c --dry-run"));
    let unused = "1 row of s.csv is not used, the first in line 4: the run has 2 evaluation episodes on 2 point MDPs";
    assert!(stderr(&output).contains(unused), "{}", stderr(&output));
    fs::write(folder.join("s.csv"), "point,episode,delay_s\nquiet,0,3\nbsuy,0,3\n").unwrap();
    for last in ["--out c", "--out c --dry-run"] {
        let output = tsc(folder, &command.replace("--out a", last));
        assert_eq!(code(&output), 2);
        let wrong = "s.csv: line 3: the family has no point MDP \"bsuy\"; did you mean busy?";
        assert!(stderr(&output).contains(wrong), "{}", stderr(&output));
        assert!(!folder.join("c").exists());
    }
    fs::write(folder.join("s.csv"), "point,delay_s\n").unwrap();
    let output = tsc(folder, &command);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("s.csv: line 1: give one column of"), "{}", stderr(&output));
}

#[test]
fn scores_from_elsewhere_are_paired_only_where_their_vehicles_are_those_of_the_run() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path();
    succeed(folder, &format!("run smoke --methods max-pressure {SHORT} --out a"));
    let mut table = String::new();
    for task in [0, 2] {
        let record = rows(folder, "a", task);
        let point = record[0]["point"].as_str().unwrap();
        for row in &record[1..] {
            let seed = &row["seed"];
            let args = format!(
                "routes --point {point} smoke --seed {seed} --set demand.horizon_s=120 --out r.rou.xml"
            );
            let output = run(folder, &args);
            assert!(output.status.success(), "{}", stderr(&output));
            let sha256 = stderr(&output).trim_end().rsplit(' ').next().unwrap().to_owned();
            assert_eq!(sha256.len(), 64, "{sha256}");
            table.push_str(&format!("{point},{seed},0.5,{sha256}\n"));
        }
    }
    let evaluate = |table: &str, out: &str| {
        fs::write(folder.join("s.csv"), table).unwrap();
        run(
            folder,
            &format!(
                "run smoke --methods max-pressure {SHORT} --controller-results theirs=s.csv --out {out}"
            ),
        )
    };
    let paired = evaluate(&format!("point,seed,delay_s,vehicles\n{table}"), "b");
    assert_eq!(code(&paired), 0, "{}", stderr(&paired));
    assert!(!stderr(&paired).contains("unpaired"), "{}", stderr(&paired));
    let without: String =
        table.lines().map(|line| format!("{}\n", line.rsplit_once(',').unwrap().0)).collect();
    let unpaired = evaluate(&format!("point,seed,delay_s\n{without}"), "c");
    assert_eq!(code(&unpaired), 0);
    let said =
        "nothing shows that it was on the same vehicles: theirs. Comparisons with it are unpaired";
    assert!(stderr(&unpaired).contains(said), "{}", stderr(&unpaired));
    let page = fs::read_to_string(folder.join("c/report/index.html")).unwrap();
    assert!(page.contains("unpaired: nothing shows that both met the same vehicles"));
    // A digit of the last one is another.
    let last = table.trim_end().len() - 1;
    let digit = if table.as_bytes()[last] == b'0' { "1" } else { "0" };
    let altered = format!("{}{digit}\n", &table[..last]);
    let refused = evaluate(&format!("point,seed,delay_s,vehicles\n{altered}"), "d");
    assert_eq!(code(&refused), 3);
    assert!(stderr(&refused).contains("have the sha256"), "{}", stderr(&refused));
}

#[test]
fn what_cannot_be_a_controller_is_refused_before_anything_runs() {
    let dir = folder(FIRST);
    for (args, expected) in [
        ("run smoke --controller mine=exec:./nowhere", "there is no ./nowhere"),
        ("run smoke --controller mine=mine.sh:A", "this program has no Python"),
        ("run smoke --controller idqn=exec:true", "there is a method idqn already"),
        (
            "run smoke --controller a=exec:true --controller a=exec:true",
            "there is a method a already",
        ),
        ("run cartpole --controller a=exec:true", "has no effect on cartpole"),
        ("run smoke --answer-timeout 5", "--answer-timeout has no effect"),
    ] {
        let output = tsc(dir.path(), args);
        assert_eq!(code(&output), 2, "{args}: {}", stderr(&output));
        assert!(stderr(&output).contains(expected), "{args}: {}", stderr(&output));
        assert!(!dir.path().join("results").exists(), "{args}");
    }
}

#[test]
fn a_program_with_a_method_of_its_own_is_command_and_worker() {
    let command = PathBuf::from(env!("CARGO_BIN_EXE_tsc-family"));
    let example = command.parent().unwrap().join("examples/own_controller");
    let dir = tempfile::tempdir().unwrap();
    let args = format!("run smoke --methods longest-queue,max-pressure {SHORT} --out a");
    let output = Command::new(&example).args(args.split(' ')).current_dir(dir.path()).output();
    let output = output.unwrap();
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("longest-queue"), "{}", stdout(&output));
    let manifest = fs::read_to_string(dir.path().join("a/manifest.json")).unwrap();
    assert!(manifest.contains("\"kind\": \"program\""), "{manifest}");
    // The plain command reads what came of it, and does not take it for its own.
    succeed(dir.path(), "status a");
    succeed(dir.path(), "report a");
}

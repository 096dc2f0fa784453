//! Controllers of one's own as the command line knows them: commands, tables of scores, a program with its own methods.

use std::path::PathBuf;
use std::process::Command;

use crate::common::{stderr, stdout};
use crate::folder::Folder;

const SHORT: &str = "--eval-seeds 2 --set demand.horizon_s=120";

/// A controller in a shell, which answers a decision with what `act` prints.
fn script(act: &str) -> String {
    format!(
        "while read -r line; do case $line in\n*'\"event\":\"begin\"'*) echo '{{}}';;\n\
         *'\"event\":\"act\"'*) {act};;\nesac; done\n"
    )
}

const MINE: &str = "--controller \"mine=exec:sh mine.sh\"";

#[test]
fn a_command_is_ranked_and_a_changed_one_is_another_run() {
    let folder = Folder::with(&[("mine.sh", &script("echo '{\"phases\":[0]}'"))]);
    let command = format!("run smoke --methods max-pressure {SHORT} --budget 1 {MINE} --out");
    let said = folder.run(&format!("{command} a"));
    assert!(said.contains("   mine   "), "{said}");
    let own = folder.json("a/manifest.json")["identity"]["controllers"][0].clone();
    assert_eq!((&own["kind"], &own["source"]), (&"exec".into(), &"exec:sh mine.sh".into()));
    assert!(own["sha256"]["sh"].is_string());
    folder.shows(
        "a/report/index.html",
        &["controller mine", own["sha256"]["mine.sh"].as_str().unwrap()],
    );
    // Whoever only reads needs no controller, whoever goes on does.
    let (all, record) = (folder.records("a"), folder.join("a/done/000/2.jsonl"));
    folder.run("status a");
    std::fs::remove_file(&record).unwrap();
    assert!(folder.says(2, "resume a").contains("controller mine (exec:sh mine.sh) was not given"));
    folder.run(&format!("resume a {MINE}"));
    assert_eq!(folder.records("a"), all);
    folder.run(&format!("{command} b --jobs 3"));
    assert_eq!(folder.records("b"), all);
    folder.edit("mine.sh", "done\n", "done # changed\n");
    assert!(folder.says(5, &format!("{command} a")).contains("mine: mine.sh has changed"));
    std::fs::remove_file(&record).unwrap();
    assert!(folder.says(5, &format!("resume a {MINE}")).contains("mine.sh has changed"));
}

#[test]
fn a_command_that_misbehaves_is_a_failed_record_and_the_run_goes_on() {
    let misbehaviours = [
        ("echo 'trouble here' >&2; exit 7", "it said last\\ntrouble here"),
        ("echo '{\"phases\":[99]}'", "it chose phase 99 of signal 0"),
        // Found before the next question, or, where the machine is slow, as its answer.
        ("echo '{\"phases\":[0]}'; echo more", "\\\"more\\\""),
        ("sleep 30", "it did not answer act within 1 s"),
        // A child that outlives it holds its pipes open.
        ("sleep 300 & exit 1", "it ended (exit status: 1) instead of answering act"),
    ];
    let folder = Folder::new();
    let mut command =
        format!("run smoke --methods max-pressure {SHORT} --budget 1 --answer-timeout 1 --out a");
    for (i, (act, _)) in misbehaviours.iter().enumerate() {
        folder.write(&format!("{i}.sh"), &script(act));
        command += &format!(" --controller \"c{i}=exec:sh {i}.sh\"");
    }
    folder.says(3, &command);
    // The first two tasks are those of the baseline and of max pressure.
    assert_eq!(folder.record("a", 1)[0]["outcome"], "ok");
    for (i, (act, expected)) in misbehaviours.iter().enumerate() {
        let failed = folder.record("a", 2 + i).remove(0);
        assert_eq!(failed["outcome"], "failed", "{act}");
        assert!(failed["reason"].to_string().contains(expected), "{act}: {failed}");
    }
    // What failed is not forgotten before it can be tried again.
    let all = folder.records("a");
    folder.says(2, "resume a --retry-failed");
    assert_eq!(folder.records("a"), all);
}

#[test]
fn what_cannot_be_a_controller_is_refused_before_anything_runs() {
    let folder = Folder::with(&[("mine.sh", "")]);
    folder.refuses(&[
        ("run smoke --controller mine=exec:./nowhere", "there is no ./nowhere"),
        ("run smoke --controller mine=mine.sh:A", "this program has no Python"),
        ("run smoke --controller idqn=exec:true", "there is a method idqn already"),
        ("run smoke --controller \"a=exec:sh -c 'sh\nmine.sh'\"", "a line break"),
        ("run cartpole --controller a=exec:true", "only signals have methods of your own"),
    ]);
}

#[test]
fn a_program_with_a_method_of_its_own_is_command_and_worker() {
    let command = PathBuf::from(env!("CARGO_BIN_EXE_tsc-family"));
    let example = command.parent().unwrap().join("examples/own_controller");
    let folder = Folder::new();
    let args = format!("run smoke --methods longest-queue,max-pressure {SHORT} --out a");
    let output = Command::new(&example).args(args.split(' ')).current_dir(folder.path()).output();
    let output = output.unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stdout(&output).contains("longest-queue"), "{}", stdout(&output));
    folder.shows("a/manifest.json", &["\"kind\": \"program\""]);
    // The plain command reads what came of it, and does not take it for its own.
    folder.run("report a");
}

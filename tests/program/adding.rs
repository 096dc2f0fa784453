//! `tsc-family run` in the folder of a run: what is there stays, and what is added is what a run of everything at once has.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::common::{stderr, stdout};
use crate::outcomes::records;
use serde_json::Value;

const PPO: &str = "--set ppo.total_steps=2048";
const DQN: &str = "--set dqn.total_steps=2000";

fn run(args: &str, dir: &Path) -> Output {
    let program = env!("CARGO_BIN_EXE_tsc-family");
    let args = format!("run cartpole {args}");
    Command::new(program).args(args.split_whitespace()).current_dir(dir).output().unwrap()
}

fn done(args: &str, dir: &Path) -> String {
    let output = run(args, dir);
    assert!(output.status.success(), "{}", stderr(&output));
    stderr(&output)
}

fn refused(args: &str, dir: &Path) -> (Option<i32>, String) {
    let output = run(args, dir);
    (output.status.code(), stderr(&output))
}

fn manifest(out: &Path) -> Value {
    let text = fs::read_to_string(out.join("manifest.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn identity(out: &Path) -> Value {
    manifest(out)["identity"].take()
}

fn assert_same(dir: &Path, a: &str, b: &str) {
    let (a, b) = (dir.join(a), dir.join(b));
    assert_eq!(identity(&a), identity(&b));
    assert_eq!(records(&a), records(&b));
    for file in ["report/scores.csv", "report/pairs.csv"] {
        assert_eq!(fs::read(a.join(file)).unwrap(), fs::read(b.join(file)).unwrap(), "{file}");
    }
}

#[test]
fn methods_seeds_and_trainings_are_added_as_if_they_had_been_asked_for_at_once() {
    let dir = tempfile::tempdir().unwrap();
    done(
        &format!("{PPO} --methods ppo --budget 4 --eval-seeds 2 --seed 7 --out added"),
        dir.path(),
    );
    let both = format!("{PPO} {DQN} --seed 7");
    let said = done(&format!("{both} --methods dqn --out added"), dir.path());
    assert!(said.contains("added: 4 tasks are added to 4; 4 records stay"), "{said}");
    let said = done(&format!("{both} --replicates 2 --out added"), dir.path());
    assert!(said.contains("added: 8 tasks are added to 8; 8 records stay"), "{said}");
    let once = "--methods ppo,dqn --replicates 2 --budget 4 --eval-seeds 2 --out once";
    done(&format!("{both} {once}"), dir.path());
    assert_same(dir.path(), "added", "once");
    let again = done(&format!("{both} --out added"), dir.path());
    assert!(!again.contains("are added"), "{again}");
    // All commands that added something, in their order; the last one once, though it was repeated.
    let all = manifest(&dir.path().join("added"))["provenance"]["command"].take();
    let commands: Vec<&str> = all.as_str().unwrap().split(" && ").collect();
    assert_eq!(commands.len(), 3, "{commands:?}");
    for (command, words) in
        commands.iter().zip(["--methods ppo", "--methods dqn", "--replicates 2"])
    {
        assert!(
            command.starts_with("tsc-family run cartpole ") && command.contains(words),
            "{all}"
        );
    }
}

#[test]
fn evaluation_seeds_are_added_and_what_was_learned_is_not_trained_again() {
    let dir = tempfile::tempdir().unwrap();
    let both = format!("{PPO} {DQN} --methods ppo,dqn --budget 3");
    done(&format!("{both} --eval-seeds 2 --out added"), dir.path());
    let models = |out: &str| -> Vec<Vec<u8>> {
        let model = |task: usize| format!("{out}/models/000/{task}.safetensors");
        (0..6).map(|task| fs::read(dir.path().join(model(task))).unwrap()).collect()
    };
    // One whose model is lost is trained again, to the same record.
    fs::remove_file(dir.path().join("added/models/000/5.safetensors")).unwrap();
    let said = done(&format!("{both} --eval-seeds 5 --out added"), dir.path());
    assert!(said.contains("plays 5 evaluation seeds instead of 2; 0 records stay"), "{said}");
    done(&format!("{both} --eval-seeds 5 --out once"), dir.path());
    assert_same(dir.path(), "added", "once");
    assert!(models("added") == models("once"), "cards have the new seeds");
    let waiting = fs::read_dir(dir.path().join("added/before/000")).into_iter().flatten();
    assert_eq!(waiting.count(), 0);
    let again = done(&format!("{both} --out added"), dir.path());
    assert!(!again.contains("instead of"), "{again}");
}

#[test]
fn a_sample_grows_where_it_contains_the_one_that_is_there() {
    let dir = tempfile::tempdir().unwrap();
    let quadrature = format!("{PPO} --methods ppo --eval-seeds 2 --sampling bayesian-quadrature");
    done(&format!("{quadrature} --budget 3 --out added"), dir.path());
    let said = done(&format!("{quadrature} --budget 5 --out added"), dir.path());
    assert!(said.contains("added: 2 tasks are added to 3; 3 records stay"), "{said}");
    assert!(
        said.contains("The sample grew from 3 to 5 point MDPs after results were seen"),
        "{said}"
    );
    let said = done(&format!("{quadrature} --budget 5 --out once"), dir.path());
    assert!(!said.contains("The sample grew"), "{said}");
    assert_same(dir.path(), "added", "once");
    // The sampling is that of the folder, where another budget is all that is asked for.
    // A published run goes on like any other.
    fs::create_dir(dir.path().join("packed")).unwrap();
    let mut export = Command::new(env!("CARGO_BIN_EXE_tsc-family"));
    let packed = export.args("export added --out packed/run.jsonl.xz".split(' '));
    assert!(packed.current_dir(dir.path()).status().unwrap().success());
    let alone = format!("{PPO} --methods ppo --eval-seeds 2 --budget 6 --out packed");
    let said = done(&alone, dir.path());
    assert!(said.contains("packed: 1 task is added to 5; 5 records stay"), "{said}");

    let balanced = format!("{PPO} --methods ppo --eval-seeds 2 --out balanced");
    done(&format!("{balanced} --budget 3"), dir.path());
    let (code, said) = refused(&format!("{balanced} --budget 5"), dir.path());
    assert_eq!(code, Some(5));
    assert!(said.contains("does not contain all 3 of the one there"), "{said}");
    assert_eq!(records(&dir.path().join("balanced")).len(), 3);
}

#[test]
fn a_method_is_computed_again_where_that_is_asked_for() {
    let dir = tempfile::tempdir().unwrap();
    let both = format!("{PPO} {DQN}");
    done(&format!("{both} --methods ppo,dqn --budget 2 --eval-seeds 2 --out r"), dir.path());
    let before = records(&dir.path().join("r"));
    let said = done(&format!("{both} --replace dqn --out r"), dir.path());
    assert!(said.contains("r: computed again: dqn; 2 records stay"), "{said}");
    assert_eq!(records(&dir.path().join("r")), before, "the same build makes the same records");
    let (code, said) = refused(&format!("{both} --replace ppi --out r"), dir.path());
    assert!(code == Some(2) && said.contains("has no records of it"), "{said}");
}

#[test]
fn what_would_change_records_is_still_another_run() {
    let dir = tempfile::tempdir().unwrap();
    done(&format!("{PPO} --methods ppo --budget 2 --eval-seeds 2 --out r"), dir.path());
    let before = records(&dir.path().join("r"));
    for (args, differs) in [
        ("--methods ppo --eval-seeds 1 --out r", "evaluation_seeds is ["),
        ("--methods ppo --seed 1 --out r", "base_seed is 0 there and 1 now"),
        ("--methods dqn --set environment.start=0.05 --out r", "environment.start"),
    ] {
        let (code, said) = refused(&format!("{PPO} {args}"), dir.path());
        assert!(code == Some(5) && said.contains(differs), "{args}: {said}");
        assert_eq!(records(&dir.path().join("r")), before, "{args}: nothing changes");
    }
    // A setting of a method that is not there has been read by nobody.
    let said =
        done(&format!("{PPO} {DQN} --methods dqn --set dqn.batch_size=16 --out r"), dir.path());
    assert!(said.contains("2 records stay"), "{said}");
    let check = Command::new(env!("CARGO_BIN_EXE_tsc-family"))
        .args(["check", "r"])
        .current_dir(dir.path())
        .output()
        .unwrap();
    assert!(check.status.success(), "{}{}", stdout(&check), stderr(&check));
}

#[test]
fn evaluation_seeds_may_come_from_a_file_and_stay_those_of_the_folder() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("seeds.txt"), "7 # as people count\n1889785958\n").unwrap();
    let begin = format!("{PPO} --methods ppo --budget 1 --out a");
    done(&format!("{begin} --seeds seeds.txt"), dir.path());
    let seeds = &identity(&dir.path().join("a"))["evaluation_seeds"];
    assert_eq!(*seeds, serde_json::json!([1_073_741_831, 1_889_785_958]));
    let said = done(&format!("{PPO} {DQN} --methods dqn --out a"), dir.path());
    assert!(said.contains("2 records stay") || said.contains("1 record stays"), "{said}");
    assert_eq!(identity(&dir.path().join("a"))["evaluation_seeds"], *seeds);
    fs::write(dir.path().join("others.txt"), "8\n9\n").unwrap();
    let (code, said) = refused(&format!("{PPO} {DQN} --out a --seeds others.txt"), dir.path());
    assert_eq!(code, Some(5), "{said}");
    assert!(said.contains("evaluation_seeds is [1073741831,1889785958] there"), "{said}");
    let (code, said) = refused(&format!("{begin} --seeds seeds.txt --eval-seeds 2"), dir.path());
    assert!(code == Some(2) && said.contains("cannot be used with"), "{said}");
    fs::write(dir.path().join("bad.txt"), "7\nx\n").unwrap();
    let (code, said) =
        refused(&format!("{PPO} --methods ppo --budget 1 --seeds bad.txt --out b"), dir.path());
    assert!(code == Some(2) && said.contains("bad.txt, line 2: expected one whole"), "{said}");
}

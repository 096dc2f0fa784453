//! Batch systems as the command line knows them: a Slurm that is made up of scripts, and a script that does packs.
//! scripts/cluster.sh tries real ones.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};
use std::thread;
use std::time::{Duration, Instant};

use crate::common::{program, run, stderr, stdout, succeed};
use crate::outcomes::records;
use rustix::process::{Pid, Signal, kill_process};

const RUN: &str = "run smoke --methods max-pressure --eval-seeds 1 --set demand.horizon_s=60";

/// A Slurm that takes everything and does nothing: what it was told is in `told`, what `squeue` says in `queue`.
fn slurm(folder: &Path) {
    let bin = folder.join("bin");
    fs::create_dir(&bin).unwrap();
    let log = "echo \"$(basename \"$0\") $*\" >> told";
    for (name, does) in [
        ("sbatch", "echo '40;trial'"),
        ("squeue", "cat queue 2>/dev/null || true"),
        ("scancel", ":"),
        ("scontrol", ":"),
    ] {
        let path = bin.join(name);
        fs::write(&path, format!("#!/bin/sh\n{log}\n{does}\n")).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    }
}

fn with_slurm(folder: &Path, args: &str) -> Output {
    let path = format!("{}:{}", folder.join("bin").display(), std::env::var("PATH").unwrap());
    program(folder).env("PATH", path).args(args.split_whitespace()).output().unwrap()
}

/// What a run with a Slurm says, with what differs between machines left out.
fn said(folder: &Path, output: &Output) -> String {
    let here = folder.canonicalize().unwrap();
    let text = format!("{}{}code {:?}\n", stdout(output), stderr(output), output.status.code());
    text.replace(&*here.to_string_lossy(), "HERE")
}

#[test]
fn a_run_is_submitted_and_resumed_when_no_job_of_it_is_queued() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path();
    slurm(folder);
    fs::write(folder.join("lines"), "#SBATCH --partition=long\n").unwrap();
    let mut text = String::new();
    let mut step = |args: &str| {
        let output = with_slurm(folder, args);
        text.push_str(&format!("$ tsc-family {args}\n{}\n", said(folder, &output)));
    };
    step(&format!("{RUN} --out out --executor slurm --sbatch lines --job-minutes 0.005"));
    fs::write(folder.join("queue"), "40_0\n40_1\n").unwrap();
    step("status out");
    step("resume out --sbatch lines");
    fs::write(folder.join("queue"), "").unwrap();
    step("resume out --sbatch lines --job-minutes 0.005");
    let told = fs::read_to_string(folder.join("told")).unwrap();
    let here = folder.canonicalize().unwrap();
    text.push_str(&format!(
        "--- what Slurm was told\n{}",
        told.replace(&*here.to_string_lossy(), "HERE")
    ));
    insta::with_settings!({filters => vec![(r"tsc-family-[0-9a-f]{8}", "NAME"), (r"about \d.* (s|min|h) of", "about TIME of")]}, {
        insta::assert_snapshot!(text);
    });
    let job = fs::read_to_string(folder.join("out/jobs/000/job.sh")).unwrap();
    assert!(job.contains("\n#SBATCH --partition=long\n"), "{job}");
}

#[test]
fn the_memory_of_a_worker_is_asked_of_slurm_for_each_and_watched_by_the_job() {
    let dir = tempfile::tempdir().unwrap();
    slurm(dir.path());
    let args = format!("{RUN} --out out --executor slurm --jobs 2 --memory-per-worker 4000");
    let output = with_slurm(dir.path(), &args);
    assert!(output.status.success(), "{}", stderr(&output));
    let job = fs::read_to_string(dir.path().join("out/jobs/000/job.sh")).unwrap();
    assert!(job.contains("\n#SBATCH --mem=8100M\n"), "{job}");
    assert!(job.contains(" --jobs 2 ") && job.contains(" --memory-per-worker 4000 "), "{job}");
}

#[test]
fn without_slurm_the_message_says_where_to_go_and_nothing_is_left_submitted() {
    let dir = tempfile::tempdir().unwrap();
    succeed(dir.path(), &format!("{RUN} --out out --executor script"));
    let mut command = program(dir.path());
    command.env("PATH", dir.path().join("empty")).args(["resume", "out", "--executor", "slurm"]);
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("cannot start squeue"), "{}", stderr(&output));
    assert!(stderr(&output).contains("such as a login node"), "{}", stderr(&output));
    let status = run(dir.path(), "status out");
    assert_eq!(status.status.code(), Some(6));
    assert!(stdout(&status).contains("0 of 4 tasks are done, 4 to do"), "{}", stdout(&status));
    // Here it can be done all the same.
    succeed(dir.path(), "resume out --quiet");
    assert_eq!(run(dir.path(), "status out").status.code(), Some(0));
}

#[test]
fn packs_of_a_script_leave_the_records_of_one_machine_and_twice_is_once() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("it's my $HOME; folder");
    fs::create_dir(&folder).unwrap();
    succeed(&folder, &format!("{RUN} --quiet --out here"));
    let how = succeed(&folder, &format!("{RUN} --out out --executor script --job-minutes 0.005"));
    assert!(
        how.contains("4 tasks in 4 packs, about ") && how.contains("seq 0 3 | parallel "),
        "{how}"
    );
    let job = folder.join("out/jobs/000/job.sh");
    let pack = |pack: &str| Command::new(&job).arg(pack).current_dir("/").output().unwrap();
    for k in ["0", "1", "1", "2"] {
        let output = pack(k);
        assert!(output.status.success(), "{}", stderr(&output));
    }
    let before = fs::metadata(folder.join("out/done/000/0.jsonl")).unwrap().modified().unwrap();
    assert!(pack("0").status.success());
    assert_eq!(
        fs::metadata(folder.join("out/done/000/0.jsonl")).unwrap().modified().unwrap(),
        before
    );
    let by_index = Command::new(&job).env("PBS_ARRAY_INDEX", "3").output().unwrap();
    assert!(by_index.status.success(), "{}", stderr(&by_index));
    assert_eq!(records(&folder.join("out")), records(&folder.join("here")));
    let wrong = pack("4");
    assert_eq!(wrong.status.code(), Some(2));
    assert!(stderr(&wrong).contains("submission 0 has 4 packs, from 0, and no pack 4"));
    assert_eq!(Command::new(&job).output().unwrap().status.code().map(|c| c != 0), Some(true));
}

#[test]
fn a_pack_of_a_run_that_another_build_planned_says_so() {
    let dir = tempfile::tempdir().unwrap();
    succeed(dir.path(), &format!("{RUN} --out out --executor script"));
    let path = dir.path().join("out/manifest.json");
    let mut manifest: serde_json::Value =
        serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    let work = "work out --submission 0 --pack 0 --prepared networks/smoke";
    let build = manifest["provenance"]["git"].clone();
    for (begun, told) in [("1234567".into(), 1), (build, 0)] {
        manifest["provenance"]["git"] = begun;
        fs::write(&path, manifest.to_string()).unwrap();
        let _ = fs::remove_dir_all(dir.path().join("out/done"));
        let output = run(dir.path(), work);
        assert!(output.status.success(), "{}", stderr(&output));
        let said = stderr(&output);
        let warning = "warning: this run was begun by the build 1234567 and goes on with";
        assert_eq!(said.matches(warning).count(), told, "{said}");
    }
}

#[test]
fn a_pack_that_is_asked_to_stop_keeps_its_training_and_goes_on_to_the_same_record() {
    let dir = tempfile::tempdir().unwrap();
    let learn = "run smoke --methods idqn --budget 1 --episodes 24 --eval-seeds 1 \
                 --set demand.horizon_s=120";
    succeed(dir.path(), &format!("{learn} --quiet --out here"));
    succeed(dir.path(), &format!("{learn} --out out --executor script"));
    let (log, checkpoint) =
        (dir.path().join("out/logs/000/1.log"), dir.path().join("out/ckpt/000/1.safetensors"));
    // Until an episode is over there is nothing to keep; how long that takes, the machine's other work decides.
    let mut patience = [(Signal::TERM, 200), (Signal::USR1, 200)].into_iter();
    let mut next = patience.next();
    while let Some((signal, wait_ms)) = next {
        let _ = (fs::remove_file(&log), fs::remove_file(&checkpoint));
        let work = "work out --submission 0 --pack 0 --prepared networks/smoke --grace 60";
        let mut work = program(dir.path()).args(work.split_whitespace()).spawn().unwrap();
        // The baseline has its record, and the training has begun.
        let start = Instant::now();
        while !log.exists() {
            assert!(start.elapsed() < Duration::from_secs(60), "no training began");
            thread::sleep(Duration::from_millis(5));
        }
        thread::sleep(Duration::from_millis(wait_ms));
        kill_process(Pid::from_child(&work), signal).unwrap();
        assert_eq!(work.wait().unwrap().code(), Some(75), "{signal:?}");
        assert!(checkpoint.exists() || wait_ms < 5000, "{signal:?}");
        next = if checkpoint.exists() { patience.next() } else { Some((signal, 2 * wait_ms)) };
    }
    let begun = run(dir.path(), "status out");
    assert!(stdout(&begun).contains("1 of the missing with a checkpoint"), "{}", stdout(&begun));
    succeed(dir.path(), "resume out --quiet");
    let log = fs::read_to_string(dir.path().join("out/logs/000/1.log")).unwrap();
    assert!(log.contains("training continues after episode"), "{log}");
    assert_eq!(records(&dir.path().join("out")), records(&dir.path().join("here")));
}

#[test]
fn a_run_is_resumed_here_where_its_networks_are() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path();
    succeed(folder, &format!("{RUN} --out here --executor script"));
    let mut elsewhere = program(Path::new("/"));
    let output = elsewhere.arg("resume").arg(folder.join("here")).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("--networks"), "{}", stderr(&output));
    let lock = fs::File::open(folder.join("here/lock.json")).unwrap();
    lock.lock().unwrap();
    let status = run(folder, "status here");
    assert!(stderr(&status).contains("a run is in progress: process"), "{}", stderr(&status));
    drop(lock);
    let resumed = run(folder, "resume here");
    assert_eq!(resumed.status.code(), Some(0), "{}", stderr(&resumed));
    assert!(stderr(&resumed).contains("this machine does the missing tasks: 4 tasks"));
}

#[test]
fn what_has_no_effect_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("lines"), "module load sumo\n").unwrap();
    for (args, why) in [
        ("--sbatch lines", "--sbatch has no effect: it is for slurm"),
        ("--executor script --sbatch lines", "--sbatch has no effect: it is for slurm"),
        ("--job-minutes 3", "--job-minutes has no effect: this machine needs no jobs"),
        ("--job-minutes 0 --executor slurm", "expected a number from 0.001"),
        ("--executor slurm --sbatch lines", "line 1: \"module load sumo\" is no #SBATCH line"),
        ("--executor script --against max-pressure", "--against has no effect"),
    ] {
        let output = run(dir.path(), &format!("{RUN} --out out {args}"));
        assert_eq!(output.status.code(), Some(2), "{args}: {}", stderr(&output));
        assert!(stderr(&output).contains(why), "{args}: {}", stderr(&output));
    }
    assert_eq!(run(dir.path(), "status nowhere").status.code(), Some(2));
}

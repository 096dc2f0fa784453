//! What a machine may refuse: processes and threads, programs in temporary folders, writing.

use std::ffi::OsStr;
use std::fs;
use std::io::Write;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread::sleep;
use std::time::Duration;

use crate::common::{program, run, stderr, stdout, succeed};
use crate::quick::{RUN as QUICK, quick_results};

/// Users that no machine has; every folder has its own, with whose processes no other test's count.
static NOBODY: AtomicU32 = AtomicU32::new(54_321);

/// Whether this is root, whom permissions and limits do not bind.
fn is_root() -> bool {
    stdout(&Command::new("id").arg("-u").output().unwrap()).trim() == "0"
}

/// A folder that everybody may enter and write.
fn open_folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o777)).unwrap();
    if is_root() {
        chown(folder.path(), Some(NOBODY.fetch_add(1, Ordering::Relaxed)), None).unwrap();
    }
    folder
}

/// Runs a shell's line as a user whose processes are those of the line; `None` where only root could.
fn as_nobody(folder: &Path, line: &str) -> Option<Output> {
    if !is_root() {
        let mut said = std::io::stderr();
        writeln!(said, "skipped: only root can run as another user").unwrap();
        return None;
    }
    let program = folder.join("tsc-family");
    if !program.exists() {
        // Not opened for writing here: a program that another test starts meanwhile would hold it open, and what is open for
        // writing cannot be started.
        let mut copy = Command::new("cp");
        assert!(
            copy.arg(env!("CARGO_BIN_EXE_tsc-family")).arg(&program).status().unwrap().success()
        );
    }
    let nobody = fs::metadata(folder).unwrap().uid();
    assert_ne!(nobody, 0, "the folder is somebody's");
    let mut shell = Command::new("bash");
    shell.current_dir(folder).args(["-c", line]).uid(nobody).gid(nobody).env("NO_COLOR", "1");
    Some(shell.env_remove("COLUMNS").output().unwrap())
}

/// More workers than any limit here allows.
const RUN: &str = "./tsc-family run cartpole --methods ppo --budget 12 --eval-seeds 1 --set ppo.total_steps=600 --jobs 100";

#[test]
fn under_a_limit_on_processes_the_run_goes_on_with_the_workers_that_can_be_started() {
    let folder = open_folder();
    let line = format!("ulimit -u 20; exec {RUN} --out results --json");
    let Some(output) = as_nobody(folder.path(), &line) else { return };
    let said = stderr(&output);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("of 12 workers can run at a time: "), "{said}");
    assert!(said.contains("raise it (ulimit -u, the pids of the container"), "{said}");
    assert!(!said.contains("panicked"), "{said}");
    let done = stdout(&output).lines().filter(|l| l.contains("\"outcome\":\"ok\"")).count();
    assert_eq!(done, 12, "no task is lost");
}

#[test]
fn where_no_worker_can_be_started_the_run_says_so_and_goes_on_later() {
    let folder = open_folder();
    // With 4, a worker is started where the pool of threads is small.
    for most in [1, 2] {
        let line = format!("ulimit -u {most}; exec {RUN} --out results --quiet");
        let Some(output) = as_nobody(folder.path(), &line) else { return };
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("error: cannot start ") && said.contains("raise it"), "{said}");
        assert!(!said.contains("panicked"), "{said}");
    }
    let output = as_nobody(folder.path(), &format!("{RUN} --out results --quiet")).unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let line = "ulimit -u 1; exec ./tsc-family report results";
    let output = as_nobody(folder.path(), line).unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stderr(&output).contains("threads can be used: a limit"), "{}", stderr(&output));
}

#[test]
#[cfg(feature = "libsumo")]
fn sumo_is_loaded_without_a_folder_for_temporary_files() {
    let folder = tempfile::tempdir().unwrap();
    let mut doctor = crate::common::program(folder.path());
    let output =
        doctor.arg("doctor").env("TMPDIR", folder.path().join("missing")).output().unwrap();
    assert!(output.status.success(), "{}{}", stdout(&output), stderr(&output));
}

#[test]
fn results_that_may_not_be_written_are_reported_elsewhere() {
    let folder = open_folder();
    quick_results(folder.path());
    let results = folder.path().join("results");
    fs::remove_dir_all(results.join("report")).unwrap();
    fs::set_permissions(&results, fs::Permissions::from_mode(0o555)).unwrap();
    let run = |args: &str| match is_root() {
        true => as_nobody(folder.path(), &format!("./tsc-family {args}")).unwrap(),
        false => run(folder.path(), args),
    };
    for (command, usual) in
        [("report", "report"), ("estimate", "estimate"), ("sensitivity", "sensitivity")]
    {
        let output = run(&format!("{command} results"));
        assert_eq!(output.status.code(), Some(2));
        let expected = format!(
            "error: cannot write to results/{usual}: Permission denied (os error 13); give a folder with --out\n"
        );
        assert_eq!(stderr(&output), expected);
    }
    // The second finds what the first wrote.
    for _ in 0..2 {
        let output = run("report results --out elsewhere");
        assert!(output.status.success(), "{}", stderr(&output));
    }
    assert!(folder.path().join("elsewhere/index.html").exists());
    let output = run("across results results");
    assert!(!stderr(&output).contains("cannot write"), "{}", stderr(&output));
    fs::set_permissions(&results, fs::Permissions::from_mode(0o755)).unwrap();
    succeed(folder.path(), "report results");
}

#[test]
fn a_report_is_not_written_among_other_things() {
    let folder = tempfile::tempdir().unwrap();
    quick_results(folder.path());
    fs::create_dir(folder.path().join("thesis")).unwrap();
    fs::write(folder.path().join("thesis/thesis.tex"), "").unwrap();
    let output = run(folder.path(), "report results --out thesis");
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(
        stderr(&output),
        "error: --out thesis is not empty and no folder that report wrote (it holds thesis.tex); give another folder\n"
    );
}

#[test]
fn with_nohup_a_run_goes_on_when_the_terminal_closes() {
    // Said both ways, as whoever runs the tests may have ignored the signal.
    for (heard, expected) in [("--default-signal=HUP", 130), ("--ignore-signal=HUP", 0)] {
        let folder = tempfile::tempdir().unwrap();
        let line = QUICK.replace("total_steps=600", "total_steps=15000");
        let mut command = Command::new("env");
        command.args([heard, env!("CARGO_BIN_EXE_tsc-family")]).args(line.split_whitespace());
        let mut child = command.current_dir(folder.path()).spawn().unwrap();
        for _ in 0..1000 {
            if folder.path().join("results/logs").is_dir() {
                break;
            }
            sleep(Duration::from_millis(10));
        }
        let pid = child.id().to_string();
        assert!(Command::new("kill").args(["-HUP", &pid]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(expected), "{heard}");
    }
}

#[test]
fn a_folder_may_be_called_what_is_no_text() {
    let folder = tempfile::tempdir().unwrap();
    let called = OsStr::from_bytes(b"a\xff");
    let mut program = crate::common::program(folder.path());
    let line = QUICK.replace(" --out results", "");
    let output = program.args(line.split_whitespace()).arg("--out").arg(called).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(folder.path().join(called).join("report/index.html").is_file());
}

/// A library of the name of libsumo that has none of its functions, in a folder of its own.
fn other_libsumo(folder: &Path) -> PathBuf {
    let told = succeed(folder, "doctor");
    let line = told.lines().find_map(|line| line.strip_prefix("libsumo ")).unwrap();
    let name = Path::new(line.split_whitespace().next().unwrap()).file_name().unwrap().to_owned();
    let (source, other) = (folder.join("nothing.c"), folder.join("other"));
    fs::create_dir(&other).unwrap();
    fs::write(&source, "int nothing;\n").unwrap();
    // The compiler has made the library that loads libsumo, so it is there.
    let mut compiler = Command::new("cc");
    compiler.args(["-shared", "-fPIC", "-o"]).arg(other.join(&name)).arg(source);
    compiler.arg(format!("-Wl,-soname,{}", name.to_string_lossy()));
    assert!(compiler.status().unwrap().success());
    other
}

#[test]
fn another_libsumo_than_that_of_the_build_is_the_machine_s_fault_and_fails_no_task() {
    let folder = tempfile::tempdir().unwrap();
    let other = other_libsumo(folder.path());
    let command = "run smoke --methods max-pressure --eval-seeds 1 --budget 1 --out out";
    let with = |args: &str| {
        let mut program = program(folder.path());
        program.args(args.split_whitespace()).env("LD_LIBRARY_PATH", &other).output().unwrap()
    };
    let output = with(command);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(4), "{said}");
    assert!(
        said.contains("undefined symbol: ") && said.contains("it is another libsumo than the one"),
        "{said}"
    );
    assert!(!folder.path().join("out/done").exists(), "no task has failed");
    succeed(folder.path(), &format!("{command} --quiet"));
}

#[test]
fn a_full_standard_output_is_told_from_a_full_disk() {
    let folder = tempfile::tempdir().unwrap();
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = program(folder.path()).args(["list", "smoke"]).stdout(full).output().unwrap();
    let said = stderr(&output);
    assert!(said.starts_with("error: cannot write to standard output: No space left"), "{said}");
    assert!(!output.status.success());
}

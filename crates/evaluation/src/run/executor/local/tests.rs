//! Workers that are shell scripts: whatever they do, the run goes on or stops as it should.

use std::path::Path;
use std::process::Command;

use super::*;
use crate::run::progress::Progress;
use crate::store::record::Outcome;

fn task() -> Task {
    Task { task: 0, method: "m".into(), point: "p".into(), replicate: 0, seed: 1 }
}

/// Workers which workers are a shell script.
fn local(dir: &Path, script: &str) -> Local {
    let program = dir.join("worker.sh");
    // Another process writes it: a descriptor that is open for writing here could be inherited by
    // the worker of another test, and a file that is open for writing cannot be started.
    let status = Command::new("sh")
        .args(["-c", "printf '#!/bin/sh\\n%s\\n' \"$1\" > \"$0\" && chmod +x \"$0\""])
        .arg(&program)
        .arg(script)
        .status()
        .unwrap();
    assert!(status.success());
    Local {
        layout: Layout::new(dir),
        manifest: "abc".into(),
        launcher: Launcher::of(program),
        prepared: "prepared".into(),
        jobs: 2,
        stall_timeout: Duration::from_secs(600),
        grace: Duration::from_secs(2),
        memory_per_worker_mb: None,
    }
}

/// A script of a worker that says whose fault its end is.
fn says(fault: Fault, reason: &str) -> String {
    let line = WorkerLine::Failed(Failure { fault, reason: reason.to_owned() });
    format!("echo '{}'; exit 1", serde_json::to_string(&line).unwrap())
}

fn events(local: &Local, interrupted: &AtomicBool) -> Vec<Event> {
    let mut events = Vec::new();
    local.run(&[task()], interrupted, &mut |e| events.push(e)).unwrap();
    events
}

#[test]
fn a_worker_that_fails_twice_becomes_a_failed_record_with_its_reason() {
    let dir = tempfile::tempdir().unwrap();
    let local = local(dir.path(), "echo 'Error: no such edge' >&2; exit 7");
    let events = events(&local, &AtomicBool::new(false));
    assert!(matches!(&events[0], Event::Retry { task: 0, .. }));
    let Event::Finished(record) = &events[1] else { panic!("{events:?}") };
    assert_eq!(record.summary.outcome, Outcome::Failed);
    assert_eq!(
        record.summary.reason.as_deref(),
        Some("the worker ended with exit code 7: Error: no such edge")
    );
    assert_eq!(record.summary.wall.attempts, 2);
}

#[test]
fn a_worker_whose_input_is_wrong_is_not_tried_again() {
    let dir = tempfile::tempdir().unwrap();
    let script = says(Fault::Input, "no such method");
    let events = events(&local(dir.path(), &script), &AtomicBool::new(false));
    let [Event::Finished(record)] = events.as_slice() else { panic!("{events:?}") };
    assert_eq!(record.summary.outcome, Outcome::Failed);
    assert_eq!(record.summary.wall.attempts, 1);
}

#[test]
fn a_full_disk_stops_the_run_and_leaves_no_record() {
    let dir = tempfile::tempdir().unwrap();
    let script = says(Fault::Machine, "cannot write x: no space");
    let local = local(dir.path(), &script);
    let e = local.run(&[task()], &AtomicBool::new(false), &mut |_| {}).unwrap_err();
    assert!(e.to_string().starts_with("cannot write x: no space; nothing is lost"), "{e}");
    assert!(!local.layout.record(0).exists());
}

#[test]
fn a_worker_that_is_killed_twice_leaves_its_task_undone() {
    let dir = tempfile::tempdir().unwrap();
    let local = local(dir.path(), "kill -9 $$");
    let events = events(&local, &AtomicBool::new(false));
    let [Event::Retry { .. }, Event::Undone { task: 0, reason }] = events.as_slice() else {
        panic!("{events:?}")
    };
    assert!(reason.contains("signal 9"), "{reason}");
    assert!(!local.layout.record(0).exists());
}

#[test]
fn a_worker_that_was_killed_once_and_failed_once_is_tried_a_third_time() {
    let dir = tempfile::tempdir().unwrap();
    let script = "n=$(cat \"$2/n\" 2>/dev/null || echo 0); echo $((n + 1)) > \"$2/n\"; \
                  [ $n = 0 ] && kill -9 $$; exit 7";
    let events = events(&local(dir.path(), script), &AtomicBool::new(false));
    let [Event::Retry { .. }, Event::Retry { .. }, Event::Finished(record)] = events.as_slice()
    else {
        panic!("{events:?}")
    };
    assert_eq!(record.summary.wall.attempts, 3);
}

#[test]
fn a_worker_that_was_stopped_is_ended_and_its_task_left_undone() {
    let dir = tempfile::tempdir().unwrap();
    let stall_timeout = Duration::from_millis(100);
    let local = Local { stall_timeout, ..local(dir.path(), "kill -STOP $$; exit 7") };
    let events = events(&local, &AtomicBool::new(false));
    let [Event::Retry { reason, .. }, Event::Undone { .. }] = events.as_slice() else {
        panic!("{events:?}")
    };
    assert_eq!(reason, "the worker did not answer for 0.2 s and was ended");
}

#[test]
fn a_worker_that_says_that_it_lives_is_left_alone() {
    let dir = tempfile::tempdir().unwrap();
    let script = "for k in 1 2 3 4 5 6 7 8; do echo '{\"alive\":1}'; sleep 0.1; done; exit 7";
    let stall_timeout = Duration::from_millis(200);
    let local = Local { stall_timeout, ..local(dir.path(), script) };
    let events = events(&local, &AtomicBool::new(false));
    assert!(matches!(events[1], Event::Finished(_)), "{events:?}");
}

#[test]
fn an_interrupted_run_leaves_no_record() {
    let dir = tempfile::tempdir().unwrap();
    let local = local(
        dir.path(),
        "echo '{\"progress\":{\"episodes\":1,\"objective\":9.5}}'; exec sleep 60",
    );
    let interrupted = AtomicBool::new(false);
    let start = Instant::now();
    local
        .run(&[task()], &interrupted, &mut |event| {
            let Event::Progress { task: 0, progress } = event else { panic!("{event:?}") };
            assert_eq!(progress, Progress { episodes: 1, objective: 9.5 });
            interrupted.store(true, Ordering::Relaxed);
        })
        .unwrap();
    assert!(start.elapsed() < Duration::from_secs(30));
    assert!(!local.layout.record(0).exists());
}

#[test]
fn a_worker_is_asked_to_stop_and_has_time_to_keep_what_it_has() {
    let dir = tempfile::tempdir().unwrap();
    let kept = dir.path().join("kept");
    let keeps = format!(
        "trap 'sleep 0.2; touch {}; exit 75' TERM; touch {}; while :; do sleep 0.01; done",
        kept.display(),
        dir.path().join("up").display()
    );
    for (script, is_kept) in [
        (keeps.as_str(), true),
        ("trap '' TERM; touch \"$0.up\"; while :; do sleep 0.01; done", false),
    ] {
        let _ = std::fs::remove_file(&kept);
        let local = Local { grace: Duration::from_millis(800), ..local(dir.path(), script) };
        let (up, interrupted) = (dir.path().to_path_buf(), AtomicBool::new(false));
        let start = Instant::now();
        thread::scope(|scope| {
            scope.spawn(|| {
                while !up.join("up").exists() && !up.join("worker.sh.up").exists() {
                    thread::sleep(POLL);
                }
                interrupted.store(true, Ordering::Relaxed);
            });
            assert!(events(&local, &interrupted).is_empty(), "no record, no message");
        });
        assert_eq!(kept.exists(), is_kept);
        assert!(start.elapsed() < Duration::from_secs(30), "it is ended all the same");
        let _ = std::fs::remove_file(dir.path().join("up"));
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_worker_that_uses_more_memory_than_it_may_is_ended_with_what_it_started_and_fails_at_once() {
    let dir = tempfile::tempdir().unwrap();
    // A child of the worker holds a text that grows without end.
    let grows = "echo 'Error: no such lane' >&2; export OWN=\"$0.own\"; \
                 sh -c 'echo $$ > \"$OWN\"; x=0123456789abcdef; while :; do x=$x$x; done'; exit 7";
    for limit in [None, Some(2_000)] {
        let quick = Local { memory_per_worker_mb: limit, ..local(dir.path(), "exit 7") };
        let events = events(&quick, &AtomicBool::new(false));
        assert!(matches!(events[0], Event::Retry { .. }), "what is small goes on: {events:?}");
        std::fs::remove_file(quick.layout.record(0)).unwrap();
    }
    let local = Local { memory_per_worker_mb: Some(100), ..local(dir.path(), grows) };
    let events = events(&local, &AtomicBool::new(false));
    let [Event::Finished(record)] = events.as_slice() else { panic!("{events:?}") };
    assert_eq!(record.summary.outcome, Outcome::Failed);
    assert_eq!(record.summary.wall.attempts, 1);
    let reason = record.summary.reason.as_deref().unwrap();
    assert!(reason.contains("more than its limit of 100 MB, and was ended"), "{reason}");
    assert!(reason.contains("--memory-per-worker MB with --retry-failed"), "{reason}");
    assert!(reason.contains("said before: no such lane; mend that first"), "{reason}");
    let own = std::fs::read_to_string(dir.path().join("worker.sh.own")).unwrap();
    let stat = format!("/proc/{}/stat", own.trim());
    // Whoever inherits it has yet to take note that it has ended.
    let is_left = || std::fs::read_to_string(&stat).is_ok_and(|text| !text.contains(") Z "));
    let start = Instant::now();
    while is_left() && start.elapsed() < Duration::from_secs(5) {
        thread::sleep(POLL);
    }
    assert!(!is_left(), "nothing of it is left");
}

//! What comes from outside while a run goes on: files that are exchanged, signals, a full disk. Nothing of it
//! becomes a number or a method's failure, and the same command continues.

use std::fs;
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::common::{program, run, stderr, stdout, succeed};

/// Exit code of a run that tasks are missing from.
const INCOMPLETE: i32 = 6;

fn start(folder: &Path, args: &str) -> Child {
    let mut program = program(folder);
    program.args(args.split_whitespace()).stdout(Stdio::null()).stderr(Stdio::piped());
    program.spawn().unwrap()
}

/// Waits until a task of a run simulates.
fn wait_for_an_episode(results: &Path) {
    let start = Instant::now();
    let simulates = || {
        let tasks = fs::read_dir(results.join("tmp")).into_iter().flatten().flatten();
        tasks
            .flat_map(|task| fs::read_dir(task.path()).into_iter().flatten().flatten())
            .any(|file| file.file_name() == "tripinfo.xml")
    };
    while !simulates() {
        assert!(start.elapsed() < Duration::from_secs(60), "no task began in a minute");
        sleep(Duration::from_millis(2));
    }
}

/// The rows of all records.
fn rows(results: &Path) -> Vec<String> {
    let rows = |task: usize| {
        let path = results.join(format!("done/000/{task}.jsonl"));
        let text = fs::read_to_string(path).ok()?;
        Some(text.lines().skip(1).collect::<Vec<_>>().join("\n"))
    };
    (0..).map_while(rows).collect()
}

#[test]
fn networks_that_are_built_anew_meanwhile_change_no_record() {
    let folder = tempfile::tempdir().unwrap();
    let long = "run smoke --methods baseline --eval-seeds 20 --jobs 1 --quiet --out";
    let child = start(folder.path(), &format!("{long} long"));
    wait_for_an_episode(&folder.path().join("long"));
    let other = "run smoke --methods baseline --eval-seeds 1 --quiet --out";
    succeed(folder.path(), &format!("{other} other --set network.default_cycle_s=30"));
    assert!(!folder.path().join("long/done/000/1.jsonl").exists(), "it was over before");
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    succeed(folder.path(), &format!("{long} alone --networks elsewhere"));
    assert_eq!(rows(&folder.path().join("long")), rows(&folder.path().join("alone")));
    // What was really simulated is another network.
    succeed(folder.path(), &format!("{other} same"));
    assert_ne!(rows(&folder.path().join("other")), rows(&folder.path().join("same")));
}

/// A folder with somebody's own scenario.
fn city() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), "build-networks smoke --quiet");
    fs::create_dir(folder.path().join("city")).unwrap();
    for ending in ["net.xml", "rou.xml", "sumocfg"] {
        let from = folder.path().join(format!("networks/smoke/busy/busy.{ending}"));
        fs::copy(from, folder.path().join(format!("city/busy.{ending}"))).unwrap();
    }
    folder
}

const OWN: &str = "run --sumocfg city/busy.sumocfg --methods program --eval-seeds 12 --quiet --out";

#[test]
fn vehicles_that_are_edited_within_a_task_leave_no_record() {
    let folder = city();
    let routes = folder.path().join("city/busy.rou.xml");
    let text = fs::read_to_string(&routes).unwrap();
    // Every second vehicle, as people try what less traffic does.
    let vehicle = |line: &&str| line.contains("<vehicle");
    let dropped: Vec<&str> = text.lines().filter(vehicle).step_by(2).collect();
    let half: Vec<&str> = text.lines().filter(|line| !dropped.contains(line)).collect();
    let child = start(folder.path(), &format!("{OWN} out"));
    wait_for_an_episode(&folder.path().join("out"));
    fs::write(&routes, half.join("\n")).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let said = "busy.rou.xml: the file was altered since the run was planned; restore it";
    assert!(stderr(&output).contains(said), "{}", stderr(&output));
    assert_eq!(rows(&folder.path().join("out")).len(), 0);
    fs::write(&routes, &text).unwrap();
    succeed(folder.path(), &format!("{OWN} out"));
    succeed(folder.path(), &format!("{OWN} whole"));
    assert_eq!(rows(&folder.path().join("out")), rows(&folder.path().join("whole")));
}

#[test]
fn vehicles_that_are_edited_and_put_back_within_a_task_count_for_nothing() {
    let folder = city();
    let routes = folder.path().join("city/busy.rou.xml");
    let kept = folder.path().join("city/kept.xml");
    fs::copy(&routes, &kept).unwrap();
    let child = start(folder.path(), &OWN.replace("--quiet", "").replace("--out", "--out out"));
    wait_for_an_episode(&folder.path().join("out"));
    // Only the last step of it, which leaves no time in which the file is another.
    fs::rename(&kept, &routes).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let said = stderr(&output);
    assert!(said.contains("is tried again") && said.contains("the file was written"), "{said}");
    succeed(folder.path(), &format!("{OWN} whole"));
    assert_eq!(rows(&folder.path().join("out")), rows(&folder.path().join("whole")));
}

/// Runs the program under limits of the shell.
fn limited(folder: &Path, limit: &str, args: &str) -> Output {
    Command::new("sh")
        .args(["-c", &format!("{limit}; exec \"$0\" {args}"), env!("CARGO_BIN_EXE_tsc-family")])
        .current_dir(folder)
        .output()
        .unwrap()
}

const SMOKE: &str = "run smoke --methods baseline --eval-seeds 1 --jobs 1";

#[test]
fn workers_that_are_killed_leave_their_tasks_to_the_next_run() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), "build-networks smoke --quiet");
    let long = SMOKE.replace("--eval-seeds 1", "--eval-seeds 25");
    // The busy point takes more than a second of any processor, the quiet one of most, the program that
    // waits for them less.
    let output = limited(folder.path(), "ulimit -t 1", &format!("{long} --json --out out"));
    assert_eq!(output.status.code(), Some(INCOMPLETE), "{}", stderr(&output));
    let said = stderr(&output);
    assert!(said.contains("killed by signal 9 (somebody, or the system"), "{said}");
    let undone = stdout(&output).lines().filter(|l| l.contains("\"event\":\"undone\"")).count();
    assert!(undone > 0, "{said}");
    let left = match undone {
        1 => "1 task has no record, for reasons that are not its own".to_owned(),
        _ => format!("{undone} tasks have no record, for reasons that are not their own"),
    };
    assert!(said.contains(&left), "{said}");
    assert_eq!(rows(&folder.path().join("out")).len(), 2 - undone);
    succeed(folder.path(), &format!("{long} --quiet --out out"));
    succeed(folder.path(), &format!("{long} --quiet --out whole"));
    assert_eq!(rows(&folder.path().join("out")), rows(&folder.path().join("whole")));
}

#[test]
fn a_full_disk_fails_no_task() {
    let folder = tempfile::tempdir().unwrap();
    let disk = folder.path().join("disk");
    fs::create_dir(&disk).unwrap();
    let mount = ["-t", "tmpfs", "-o", "size=512k", "tmpfs"];
    if !Command::new("mount").args(mount).arg(&disk).status().is_ok_and(|s| s.success()) {
        writeln!(std::io::stderr(), "skipped: a small disk cannot be mounted here").unwrap();
        return;
    }
    succeed(folder.path(), &format!("{SMOKE} --quiet --out whole"));
    for kilobytes in [400, 470, 500, 512] {
        fs::write(disk.join("other"), vec![1; kilobytes << 10]).unwrap();
        let output = run(folder.path(), &format!("{SMOKE} --quiet --out disk/out"));
        fs::remove_file(disk.join("other")).unwrap();
        let said = stderr(&output);
        assert!(!output.status.success(), "{kilobytes}");
        assert!(said.contains("is the disk full?") || said.contains("No space left"), "{said}");
        succeed(folder.path(), &format!("{SMOKE} --quiet --out disk/out"));
        assert_eq!(rows(&disk.join("out")), rows(&folder.path().join("whole")), "{kilobytes}");
        fs::remove_dir_all(disk.join("out")).unwrap();
    }
    assert!(Command::new("umount").arg(&disk).status().unwrap().success());
}

#[test]
fn an_intersection_is_not_left_out_because_its_network_could_not_be_written() {
    let folder = tempfile::tempdir().unwrap();
    let bin = folder.path().join("sumo/bin");
    fs::create_dir_all(&bin).unwrap();
    let real = Command::new("sh").args(["-c", "command -v netconvert"]).output().unwrap();
    // On a full disk netconvert ends well and leaves half a file.
    let script = format!(
        "#!/bin/sh\n{} \"$@\" || exit\nfor last; do [ -f \"$last\" ] && case \"$last\" in *second*) \
         truncate -s 4096 \"$last\";; esac; done; exit 0\n",
        stdout(&real).trim()
    );
    fs::write(bin.join("netconvert"), script).unwrap();
    fs::set_permissions(bin.join("netconvert"), fs::Permissions::from_mode(0o755)).unwrap();
    let map = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("osm-signals/tests/networks/four_arms/input.osm");
    let build = |home: &str| {
        let args = ["build-networks", "--quiet", "--out", "city", "--osm"];
        program(folder.path()).args(args).arg(&map).env("SUMO_HOME", home).output().unwrap()
    };
    let output = build(bin.parent().unwrap().to_str().unwrap());
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let said =
        "netconvert could not write all of the network; is the disk full?; this says nothing of";
    assert!(stderr(&output).contains(said), "{}", stderr(&output));
    let output = build("");
    assert!(output.status.success(), "{}", stderr(&output));
}

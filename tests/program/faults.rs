//! Files that are exchanged while a run goes on: nothing of it becomes a number, and the same command continues.

use std::fs;
use std::path::Path;
use std::process::{Child, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::common::{program, stderr, succeed};
use crate::folder::Folder;

fn start(folder: &Path, args: &str) -> Child {
    let mut program = program(folder);
    program.args(args.split_whitespace()).stdout(Stdio::null()).stderr(Stdio::piped());
    program.spawn().unwrap()
}

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
    let long = "run smoke --methods baseline --eval-seeds 12 --jobs 1 --quiet --out";
    let child = start(folder.path(), &format!("{long} long"));
    wait_for_an_episode(&folder.path().join("long"));
    let other = "build-networks smoke --quiet --force --set network.default_cycle_s=30";
    succeed(folder.path(), other);
    assert!(!folder.path().join("long/done/000/1.jsonl").exists(), "it was over before");
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    succeed(folder.path(), &format!("{long} alone --networks elsewhere"));
    assert_eq!(rows(&folder.path().join("long")), rows(&folder.path().join("alone")));
}

#[test]
fn vehicles_that_are_edited_within_a_task_leave_no_record() {
    let folder = Folder::after("build-networks smoke --quiet");
    fs::create_dir(folder.path().join("city")).unwrap();
    for ending in ["net.xml", "rou.xml", "sumocfg"] {
        let from = folder.path().join(format!("networks/smoke/busy/busy.{ending}"));
        fs::copy(from, folder.path().join(format!("city/busy.{ending}"))).unwrap();
    }
    let run = "run --sumocfg city/busy.sumocfg --methods program --eval-seeds 3 --quiet --out";
    let routes = folder.path().join("city/busy.rou.xml");
    let text = fs::read_to_string(&routes).unwrap();
    let vehicle = text.lines().find(|line| line.contains("<vehicle")).unwrap();
    let child = start(folder.path(), &format!("{run} out"));
    wait_for_an_episode(&folder.path().join("out"));
    fs::write(&routes, text.replacen(vehicle, "", 1)).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("busy.rou.xml: the file was altered"), "{}", stderr(&output));
    assert_eq!(rows(&folder.path().join("out")).len(), 0);
    fs::write(&routes, &text).unwrap();
    succeed(folder.path(), &format!("{run} out"));
    succeed(folder.path(), &format!("{run} whole"));
    assert_eq!(rows(&folder.path().join("out")), rows(&folder.path().join("whole")));
}

//! Pipes, devices, sockets, folders and endless files in place of those that people and strangers give.

use std::fs;
use std::os::unix::fs::symlink;
use std::os::unix::net::UnixListener;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::{program, stderr};
use crate::quick::{RUN, quick_results};

/// What stands in place of a file, and how it is called.
const STRANGE: [(&str, &str); 4] = [
    (
        "pipe",
        "it is a pipe, which can be read only once; write its content to a file and give that",
    ),
    ("zeros", "it is a device; give a regular file"),
    ("socket", "it is a socket; give a regular file"),
    ("hole", ""),
];

/// Makes a strange file.
fn make(path: &Path, what: &str) {
    let _ = fs::remove_file(path);
    match what {
        "pipe" => assert!(Command::new("mkfifo").arg(path).status().unwrap().success()),
        "zeros" => symlink("/dev/zero", path).unwrap(),
        "socket" => drop(UnixListener::bind(path).unwrap()),
        "hole" => fs::File::create(path).unwrap().set_len(1 << 40).unwrap(),
        other => panic!("{other}"),
    }
}

/// Runs a command that must end soon, with exit code 2, and returns what it says.
fn refused(folder: &Path, args: &str) -> String {
    let start = Instant::now();
    let mut command = program(folder);
    command.args(args.split_whitespace()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
            panic!("{args}: hangs");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let output = child.wait_with_output().unwrap();
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{args}: {said}");
    said
}

/// Puts every strange file into a place and expects a command to name it.
fn each_is_refused(folder: &Path, place: &str, args: &str) {
    for (what, expected) in STRANGE {
        make(&folder.join(place), what);
        let said = refused(folder, args);
        assert!(said.contains(place) && said.contains(expected), "{what} as {place}: {said}");
    }
    fs::remove_file(folder.join(place)).unwrap();
}

#[test]
fn scenarios_and_tables_are_regular_files() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("city.toml"), "family.points = \"points.csv\"").unwrap();
    fs::write(folder.join("arms.toml"), "family.approaches = \"arms.csv\"").unwrap();
    fs::write(folder.join("carts.toml"), "domain = \"cartpole\"\nfamily.points = \"carts.csv\"")
        .unwrap();
    each_is_refused(folder, "own.toml", "list own.toml");
    each_is_refused(folder, "points.csv", "list city.toml");
    each_is_refused(folder, "arms.csv", "list arms.toml");
    each_is_refused(folder, "carts.csv", "list carts.toml");
    fs::create_dir(folder.join("points.csv")).unwrap();
    assert!(refused(folder, "list city.toml").contains("it is a folder; give a regular file"));
}

#[test]
fn maps_and_their_tables_are_regular_files() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    each_is_refused(folder, "town.osm", "build-networks --osm town.osm --out city");
    each_is_refused(folder, "town.osm.pbf", "build-networks --osm town.osm.pbf --out city");
    let osm = "<osm version=\"0.6\"><node id=\"1\" lat=\"40\" lon=\"-111\"/><node id=\"2\" lat=\"40.001\" \
               lon=\"-111\"/><way id=\"1\"><nd ref=\"1\"/><nd ref=\"2\"/><tag k=\"highway\" v=\"primary\"/></way></osm>";
    fs::write(folder.join("town.osm"), osm).unwrap();
    for (option, file) in [
        ("--signals", "signals.csv"),
        ("--aadt", "counts.csv"),
        ("--boundary", "town.geojson"),
        ("--config", "own.toml"),
    ] {
        each_is_refused(
            folder,
            file,
            &format!("build-networks --osm town.osm {option} {file} --out city"),
        );
        let said = refused(folder, &format!("build-networks --osm town.osm {option} . --out city"));
        assert!(said.contains("cannot read .: it is a folder"), "{option}: {said}");
    }
    assert!(refused(folder, "build-networks --osm . --out city").contains("it is a folder"));
}

#[test]
#[cfg(feature = "libsumo")]
fn what_sumo_reads_is_of_regular_files() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let run = "run --sumocfg a.sumocfg --methods max-pressure --out out";
    let config = |files: &str| {
        let text = format!("<configuration>{files}<end value=\"9\"/></configuration>");
        fs::write(folder.join("a.sumocfg"), text).unwrap();
    };
    config("<net-file value=\"a.net.xml\"/>");
    each_is_refused(folder, "a.net.xml", run);
    fs::write(folder.join("a.net.xml"), "<net/>").unwrap();
    config("<net-file value=\"a.net.xml\"/><route-files value=\"a.rou.xml\"/>");
    each_is_refused(folder, "a.rou.xml", run);
    config("<net-file value=\"a.net.xml\"/><additional-files value=\"a.add.xml\"/>");
    fs::write(folder.join("a.add.xml"), "<additional><include href=\"b.add.xml\"/></additional>")
        .unwrap();
    each_is_refused(folder, "b.add.xml", run);
    for (what, _) in STRANGE {
        make(&folder.join("a.sumocfg"), what);
        assert!(refused(folder, run).contains("a.sumocfg"));
    }
}

#[test]
fn a_results_directory_of_a_stranger_has_regular_files() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    quick_results(folder);
    for file in ["manifest.json", "plan.jsonl", "done/000/1.jsonl"] {
        let file = format!("results/{file}");
        let text = fs::read(folder.join(&file)).unwrap();
        each_is_refused(folder, &file, "report results");
        each_is_refused(folder, &file, "estimate results");
        fs::write(folder.join(&file), text).unwrap();
    }
    each_is_refused(folder, "model", "evaluate --model model --point quiet smoke");
    // What would be written or tidied up.
    fs::remove_file(folder.join("results/done/000/1.jsonl")).unwrap();
    let lock = folder.join("results/lock.json");
    make(&lock, "pipe");
    let said = refused(folder, RUN);
    assert!(said.contains("a pipe or device stands in its place; remove it"), "{said}");
    fs::remove_file(lock).unwrap();
    // A log is a new file, whatever stood in its place.
    let log = folder.join("results/logs/000/1.log");
    make(&log, "pipe");
    let output = program(folder).args(RUN.split_whitespace()).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(!log.exists() || log.metadata().unwrap().is_file());
    fs::remove_file(folder.join("results/done/000/1.jsonl")).unwrap();
    let scratch = folder.join("results/tmp/1.left");
    fs::create_dir_all(&scratch).unwrap();
    make(&scratch.join(".lock"), "pipe");
    let output = program(folder).args(RUN.split_whitespace()).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
}

//! Links within a results directory of a stranger: nothing is written, replaced or removed where they lead.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

use crate::common::{run, stderr, succeed};
use crate::quick::{RUN, quick_results};

/// Every file beneath a folder with its bytes.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.insert(path.clone(), Vec::new());
            found.extend(files(&path));
        } else {
            found.insert(path.clone(), fs::read(&path).unwrap());
        }
    }
    found
}

/// Results, and a folder away from them with what nobody may touch.
fn stage() -> tempfile::TempDir {
    let stage = tempfile::tempdir().unwrap();
    quick_results(stage.path());
    let away = stage.path().join("away");
    for folder in ["000", "1.left"] {
        fs::create_dir_all(away.join(folder)).unwrap();
    }
    for name in
        ["precious", "000/0.log", "000/1.log", "000/1.safetensors", "1.left/.lock", "index.html"]
    {
        fs::write(away.join(name), "precious").unwrap();
        let long_ago = std::time::SystemTime::now() - std::time::Duration::from_secs(100_000);
        fs::File::options()
            .write(true)
            .open(away.join(name))
            .unwrap()
            .set_modified(long_ago)
            .unwrap();
    }
    stage
}

/// Replaces something of the results by a link, runs a command and returns what it says; what the link leads to must
/// be as before.
fn with_link(place: &str, to: &str, args: &str) -> String {
    let stage = stage();
    let (link, away) = (stage.path().join("results").join(place), stage.path().join("away"));
    let _ = fs::remove_dir_all(&link).or_else(|_| fs::remove_file(&link));
    fs::create_dir_all(link.parent().unwrap()).unwrap();
    symlink(away.join(to), &link).unwrap();
    let _ = fs::remove_file(stage.path().join("results/done/000/1.jsonl"));
    let before = files(&away);
    let output = run(stage.path(), args);
    assert_eq!(files(&away), before, "{place}: {}", stderr(&output));
    assert_eq!(output.status.code(), Some(2), "{place}: {}", stderr(&output));
    stderr(&output)
}

#[test]
fn a_run_follows_no_link_out_of_its_folder() {
    for (place, to) in [
        ("lock.json", "precious"),
        ("lock.json", "new"),
        ("done", ""),
        ("done/000", "000"),
        ("logs", ""),
        ("logs/000", "000"),
        ("logs/000/1.log", "000/1.log"),
        ("models", ""),
        ("models/000", "000"),
        ("ckpt", ""),
        ("ckpt/000", "000"),
        ("tmp", ""),
        ("report", ""),
    ] {
        let said = with_link(place, to, RUN);
        let expected = format!(
            "results/{place}: it is a link, which would lead what is written out of the folder"
        );
        assert!(said.contains(&expected), "{place}: {said}");
    }
}

/// Gives every file beneath a folder a second name in another.
fn link_all(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let (path, name) = entry.map(|entry| (entry.path(), entry.file_name())).unwrap();
        match path.is_dir() {
            true => link_all(&path, &to.join(name)),
            false => fs::hard_link(&path, to.join(name)).unwrap(),
        }
    }
}

#[test]
fn no_file_that_has_a_second_name_is_written() {
    let stage = stage();
    let [results, copy] = ["results", "copy"].map(|name| stage.path().join(name));
    succeed(stage.path(), "export results --out results/all.csv");
    // What a run with a worker process leaves, beside what is there: logs, jobs, checkpoints, drafts.
    for (from, to) in [
        ("lock.json", "logs/000/0.log"),
        ("lock.json", "logs/000/1.log"),
        ("lock.json", "ckpt/000/1.safetensors"),
        ("manifest.json", "tmp/left"),
    ] {
        let _ = fs::remove_file(results.join(to));
        fs::create_dir_all(results.join(to).parent().unwrap()).unwrap();
        fs::copy(results.join(from), results.join(to)).unwrap();
    }
    link_all(&results, &copy);
    let before = files(&copy);
    assert!(before.len() > 25, "{}", before.len());
    fs::remove_file(results.join("done/000/1.jsonl")).unwrap();
    fs::remove_file(results.join("models/000/1.safetensors")).unwrap();
    for command in
        [RUN, "report results", "export results --out results/all.csv", "check results --repair"]
    {
        let output = run(stage.path(), command);
        assert!(output.status.success(), "{command}: {}", stderr(&output));
        assert_eq!(files(&copy), before, "{command}");
    }
    // And the other way round: who goes on with the copy leaves the original alone.
    let before = files(&results);
    fs::remove_file(copy.join("done/000/0.jsonl")).unwrap();
    let output = run(stage.path(), &RUN.replace("--out results", "--out copy"));
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(files(&results), before);
}

#[test]
fn pages_follow_no_link_out_of_the_results() {
    for (command, place) in [
        ("report results", "report"),
        ("estimate results", "estimate"),
        ("sensitivity results", "sensitivity"),
    ] {
        let said = with_link(place, "", command);
        assert!(said.contains(&format!("results/{place}: it is a link")), "{place}: {said}");
    }
}

#[test]
fn networks_follow_no_link_out_of_their_folder() {
    let stage = tempfile::tempdir().unwrap();
    let [away, networks] = ["away", "networks"].map(|name| stage.path().join(name));
    for folder in [&away, &networks] {
        fs::create_dir(folder).unwrap();
    }
    symlink(&away, networks.join("quiet")).unwrap();
    symlink(&away, networks.join("by-hash")).unwrap();
    let build = || run(stage.path(), "build-networks smoke --out networks --force --quiet");
    let output = build();
    assert!(!output.status.success(), "{}", stderr(&output));
    assert!(stderr(&output).contains("networks/by-hash: it is a link"), "{}", stderr(&output));
    assert!(files(&away).is_empty());
    // Links called like point MDPs are made here, so that another one is replaced and not followed.
    fs::remove_file(networks.join("by-hash")).unwrap();
    let output = build();
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(files(&away).is_empty() && networks.join("quiet/quiet.net.xml").exists());
}

#[test]
fn files_are_replaced_and_not_written_through() {
    let stage = stage();
    let before = files(&stage.path().join("away"));
    let page = stage.path().join("results/report/index.html");
    fs::remove_file(&page).unwrap();
    symlink(stage.path().join("away/index.html"), &page).unwrap();
    succeed(stage.path(), "report results");
    assert!(!page.is_symlink());
    assert_eq!(files(&stage.path().join("away")), before);
}

#[test]
fn results_that_are_a_link_themselves_are_gone_on_with() {
    let stage = stage();
    fs::rename(stage.path().join("results"), stage.path().join("disk")).unwrap();
    symlink(stage.path().join("disk"), stage.path().join("results")).unwrap();
    fs::remove_file(stage.path().join("disk/done/000/1.jsonl")).unwrap();
    succeed(stage.path(), RUN);
    assert!(stage.path().join("disk/done/000/1.jsonl").exists());
}

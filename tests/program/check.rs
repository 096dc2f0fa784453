//! `check`: all that is damaged in a results directory is found at once; what it names is done again once it is gone.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{run, stderr, stdout, succeed};
use crate::folder::Folder;
use crate::outcomes::refused;

const LEARN: &str = "run smoke --methods idqn,max-pressure --episodes 2 --eval-seeds 1 --quiet \
                     --set signal.delta_time_s=30 --set demand.horizon_s=120 --out out";

fn content(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut content = BTreeMap::new();
    for part in ["out/done/000", "out/models/000"] {
        for entry in fs::read_dir(folder.join(part)).unwrap() {
            let path = entry.unwrap().path();
            let mut bytes = fs::read(&path).unwrap();
            if let Some(wall) = bytes.windows(8).position(|w| w == b"\"wall\":{") {
                let end = wall + bytes[wall..].iter().position(|b| *b == b'}').unwrap();
                bytes.drain(wall..end);
            }
            content.insert(path, bytes);
        }
    }
    content
}

fn flip(path: &Path) {
    let mut bytes = fs::read(path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(path, bytes).unwrap();
}

fn check(folder: &Path, args: &str) -> (Option<i32>, String, String) {
    let output = run(folder, &format!("check out {args}"));
    (output.status.code(), stdout(&output), stderr(&output))
}

#[test]
fn a_sound_folder_is_said_to_be_sound() {
    let folder = Folder::after(LEARN);
    let (code, said, notes) = check(folder.path(), "");
    let expected =
        "out: 6 of 6 records are sound, 2 models are sound, 2 point MDPs have their files\n";
    assert_eq!((code, said.as_str(), notes.as_str()), (Some(0), expected, ""));
    let (_, said, _) = check(folder.path(), "--json");
    let value: serde_json::Value = serde_json::from_str(said.trim()).unwrap();
    assert_eq!((&value["damaged"], &value["done"]), (&0.into(), &6.into()));
}

#[test]
fn every_kind_of_damage_is_named_at_once_and_done_again_when_it_is_gone() {
    let folder = Folder::after(LEARN);
    let before = content(folder.path());
    let out = folder.path().join("out");
    flip(&out.join("done/000/1.jsonl"));
    fs::write(out.join("done/000/4.jsonl"), "").unwrap();
    let models: Vec<_> =
        before.keys().filter(|path| path.extension().is_some_and(|e| e == "safetensors")).collect();
    flip(models[1]);
    fs::create_dir_all(out.join("ckpt/000")).unwrap();
    fs::write(out.join("ckpt/000/2.safetensors"), "no tensors").unwrap();
    let (code, said, _) = check(folder.path(), "");
    assert_eq!(code, Some(2), "{said}");
    for path in ["done/000/1.jsonl", "done/000/4.jsonl", "ckpt/000/2.safetensors"] {
        assert!(said.contains(&format!("out/{path}: ")), "{path}: {said}");
    }
    assert!(said.contains("models/000/") && said.contains("4 of 6 records are sound"), "{said}");
    assert!(said.contains("4 files are damaged"), "{said}");

    let number = models[1].file_stem().unwrap().to_str().unwrap();
    for task in ["1", "4", number] {
        for file in [format!("done/000/{task}.jsonl"), format!("models/000/{task}.safetensors")] {
            let _ = fs::remove_file(out.join(file));
        }
    }
    fs::remove_file(out.join("ckpt/000/2.safetensors")).unwrap();
    succeed(folder.path(), "resume out --quiet");
    let (code, said, notes) = check(folder.path(), "");
    assert_eq!(code, Some(0), "{said}{notes}");
    assert_eq!(content(folder.path()), before);
    succeed(folder.path(), "report out");
}

#[test]
fn damaged_networks_are_built_again_by_the_command_of_the_run() {
    let folder = Folder::after(LEARN);
    let before = content(folder.path());
    let net = fs::canonicalize(folder.path().join("networks/smoke/busy/busy.net.xml")).unwrap();
    flip(&net);
    let record = folder.path().join("out/done/000/0.jsonl");
    fs::write(&record, "").unwrap();
    let (code, said, _) = check(folder.path(), "");
    assert_eq!(code, Some(2));
    assert!(said.contains("busy.net.xml: it was altered since the run was planned"), "{said}");
    fs::remove_file(record).unwrap();
    fs::remove_dir_all(net.parent().unwrap()).unwrap();
    succeed(folder.path(), LEARN);
    assert_eq!(check(folder.path(), "").0, Some(0));
    assert_eq!(content(folder.path()), before);
}

#[test]
fn what_can_only_come_from_a_copy_is_named() {
    let folder = Folder::after(LEARN);
    let manifest = folder.path().join("out/manifest.json");
    let text = fs::read_to_string(&manifest).unwrap();
    fs::write(&manifest, text.replacen("\"base_seed\": 0", "\"base_seed\": 1", 1)).unwrap();
    let (code, said, _) = check(folder.path(), "");
    assert_eq!(code, Some(2));
    assert!(
        said.contains("out/manifest.json: it is not the manifest of the records beside it, 6 of"),
        "{said}"
    );
    assert!(!said.contains("done/000"), "{said}");
    fs::write(&manifest, &text[..text.len() / 2]).unwrap();
    let (code, said, notes) = check(folder.path(), "");
    assert_eq!(code, Some(2), "{said}{notes}");
    assert!(
        said.contains("out/manifest.json: ") && said.contains("restore it from a copy"),
        "{said}"
    );
    fs::write(&manifest, text).unwrap();
    assert_eq!(check(folder.path(), "").0, Some(0));
    fs::remove_file(manifest).unwrap();
    assert_eq!(check(folder.path(), "").0, Some(2));
}

#[test]
fn the_same_command_writes_what_a_run_began_with_again_and_keeps_the_records() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), &format!("{LEARN} --budget 2"));
    let out = folder.path().join("out");
    let read = |name: &str| fs::read(out.join(name)).unwrap();
    let (manifest, design, before) =
        (read("manifest.json"), read("design.json"), content(folder.path()));
    let identity = |manifest: &[u8]| {
        let manifest: serde_json::Value = serde_json::from_slice(manifest).unwrap();
        manifest["identity"].clone()
    };
    // Of another run: what lies beside it shows that this one is meant.
    let text = String::from_utf8(manifest.clone()).unwrap();
    let other = text.replacen("\"base_seed\": 0", "\"base_seed\": 1", 1);
    fs::write(out.join("manifest.json"), other).unwrap();
    let said = refused(folder.path(), &format!("{LEARN} --budget 2"));
    assert!(said.contains("it is not the manifest of the records beside it"), "{said}");
    assert!(said.contains("move it away and repeat the command that began the run"), "{said}");
    fs::remove_file(out.join("manifest.json")).unwrap();
    succeed(folder.path(), &format!("{LEARN} --budget 2"));
    assert_eq!(identity(&read("manifest.json")), identity(&manifest));
    for damage in [Some(&b"{"[..]), None] {
        fs::remove_file(out.join("design.json")).unwrap();
        if let Some(bytes) = damage {
            fs::write(out.join("design.json"), bytes).unwrap();
            let output = run(folder.path(), &format!("{LEARN} --budget 2"));
            let said = stderr(&output);
            assert!(said.contains("design.json: it is not what the sample"), "{said}");
            assert!(said.contains("or move it away and repeat the command"), "{said}");
            fs::remove_file(out.join("design.json")).unwrap();
        } else {
            let (_, said, _) = check(folder.path(), "");
            assert!(said.contains("design.json: it is missing; restore it from a copy"), "{said}");
        }
        succeed(folder.path(), &format!("{LEARN} --budget 2"));
        assert_eq!(read("design.json"), design);
    }
    assert_eq!(content(folder.path()), before);
    assert_eq!(check(folder.path(), "").0, Some(0));
}

#[test]
fn places_in_which_a_digit_is_another_are_refused_and_written_again() {
    let folder = tempfile::tempdir().unwrap();
    let run = "run salt-lake-city --methods max-pressure --budget 1 --eval-seeds 1 --quiet \
               --set demand.horizon_s=60 --out out";
    succeed(folder.path(), run);
    let path = folder.path().join("out/places.json");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replacen("\"latitude\":40.", "\"latitude\":41.", 1)).unwrap();
    let output = crate::common::run(folder.path(), "report out");
    assert_eq!(output.status.code(), Some(2));
    let said = "out/places.json: altered: the checksum does not match; delete it, and the next";
    assert!(stderr(&output).contains(said), "{}", stderr(&output));
    let (code, said, _) = check(folder.path(), "");
    assert_eq!(code, Some(2));
    let expected = "out/places.json: altered: the checksum does not match; delete it, and the next `tsc-family run` writes it again\n";
    assert!(said.starts_with(expected), "{said}");
    fs::remove_file(&path).unwrap();
    succeed(folder.path(), run);
    assert_eq!(fs::read_to_string(&path).unwrap(), text);
}

#[test]
fn a_run_that_is_not_over_is_sound_and_incomplete() {
    let folder = Folder::after(LEARN);
    fs::remove_file(folder.path().join("out/done/000/3.jsonl")).unwrap();
    let (code, said, notes) = check(folder.path(), "");
    assert_eq!(code, Some(6));
    assert!(said.starts_with("out: 5 of 6 records are sound, 1 task has none"), "{said}");
    let next = "1 task has no record; tsc-family resume out does it";
    assert!(notes.contains(next), "{notes}");
}

//! Damaged results directories: all damage is named at once, and what is whole is not blamed.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::made_up::{evaluations, manifest, write_results};
use tsc_family::store::Layout;
use tsc_family::store::record::TaskResult;

fn results(root: &Path) -> Layout {
    write_results(root, &manifest(&["baseline", "steady"]), |_| {
        Some(Ok(TaskResult { rows: evaluations(&[20.0, 22.0]), ..TaskResult::default() }))
    })
}

fn said(root: &Path) -> (Option<i32>, String) {
    let program = env!("CARGO_BIN_EXE_tsc-family");
    let output = Command::new(program).arg("report").arg(root).output().unwrap();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

fn edit(path: &Path, from: &str, to: &str) {
    let text = fs::read_to_string(path).unwrap();
    assert!(text.contains(from), "{text}");
    fs::write(path, text.replacen(from, to, 1)).unwrap();
}

#[test]
fn all_damaged_records_are_named_at_once() {
    let dir = tempfile::tempdir().unwrap();
    let layout = results(dir.path());
    edit(&layout.record(1), "22.0", "21.0");
    fs::write(layout.record(3), "").unwrap();
    let (code, said) = said(dir.path());
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("2 files are damaged:"), "{said}");
    assert!(said.contains("1.jsonl: altered: the checksum does not match"), "{said}");
    assert!(said.contains("3.jsonl: empty file") && !said.contains("2.jsonl"), "{said}");
}

#[test]
fn a_damaged_manifest_is_blamed_and_not_the_records() {
    let dir = tempfile::tempdir().unwrap();
    let layout = results(dir.path());
    edit(&layout.manifest(), "\"abababab", "\"bbababab");
    let (code, said) = said(dir.path());
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("manifest.json: it is not the manifest of the records beside it"),
        "{said}"
    );
    assert!(
        said.contains(
            "; restore it from a copy, or move it away and repeat the command that began the run"
        ) && !said.contains("delete"),
        "{said}"
    );
}

#[test]
fn a_damaged_manifest_says_what_to_do() {
    let dir = tempfile::tempdir().unwrap();
    let layout = results(dir.path());
    let manifest = fs::read(layout.manifest()).unwrap();
    let cut = manifest.len() / 2;
    let schema = String::from_utf8(manifest.clone()).unwrap().replace("schema_version", "schema");
    for bytes in [&b""[..], b"\xff\xfe", b"{}", &manifest[..cut], schema.as_bytes()] {
        fs::write(layout.manifest(), bytes).unwrap();
        let (code, said) = said(dir.path());
        assert_eq!(code, Some(2), "{said}");
        let way = "; restore it from a copy, or move it away and repeat the command that began the run, which \
                   writes it again and keeps the records\n";
        assert!(said.contains("manifest.json: ") && said.ends_with(way), "{said}");
    }
}

#[test]
fn a_record_of_another_run_among_others_is_named() {
    let (dir, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let layout = results(dir.path());
    let mut foreign = manifest(&["baseline", "steady"]);
    foreign.identity.scenario = "elsewhere".into();
    let foreign = write_results(other.path(), &foreign, |_| {
        Some(Ok(TaskResult { rows: evaluations(&[1.0, 1.0]), ..TaskResult::default() }))
    });
    fs::copy(foreign.record(2), layout.record(2)).unwrap();
    let (_, said) = said(dir.path());
    assert!(said.contains("2.jsonl: it belongs to another manifest; delete the file"), "{said}");
}

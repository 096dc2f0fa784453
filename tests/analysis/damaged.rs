//! Damaged results directories: all damage is named at once, and what is whole is not blamed.

use std::fs;
use std::path::Path;

use crate::common::{run, stderr};
use crate::made_up::{ended, manifest, write_results};
use tsc_family::store::Layout;

fn results(root: &Path) -> Layout {
    write_results(root, &manifest(&["baseline", "steady"]), |_| ended(&[20.0, 22.0]))
}

fn said(root: &Path) -> (Option<i32>, String) {
    let output = run(root, "report .");
    (output.status.code(), stderr(&output))
}

#[test]
fn all_damaged_records_are_named_at_once() {
    let dir = tempfile::tempdir().unwrap();
    let layout = results(dir.path());
    let record = fs::read_to_string(layout.record(1)).unwrap();
    fs::write(layout.record(1), record.replace("22.0", "21.0")).unwrap();
    fs::write(layout.record(3), "").unwrap();
    let (code, said) = said(dir.path());
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("2 files are damaged:"), "{said}");
    assert!(said.contains("1.jsonl: altered: the checksum does not match"), "{said}");
    assert!(said.contains("3.jsonl: empty file") && !said.contains("2.jsonl"), "{said}");
}

#[test]
fn a_damaged_manifest_is_blamed_with_what_to_do() {
    let dir = tempfile::tempdir().unwrap();
    let layout = results(dir.path());
    let manifest = fs::read(layout.manifest()).unwrap();
    let text = String::from_utf8(manifest.clone()).unwrap();
    let other = text.replacen("\"abababab", "\"bbababab", 1);
    let schema = text.replace("schema_version", "schema");
    let cut = &manifest[..manifest.len() / 2];
    for bytes in [&b""[..], b"\xff\xfe", b"{}", cut, schema.as_bytes(), other.as_bytes()] {
        fs::write(layout.manifest(), bytes).unwrap();
        let (code, said) = said(dir.path());
        assert_eq!(code, Some(2), "{said}");
        let way =
            "; restore it from a copy, or move it away and repeat the command that began the run";
        assert!(said.contains("manifest.json: ") && said.contains(way), "{said}");
        assert!(!said.contains("delete"), "{said}");
    }
}

#[test]
fn a_record_of_another_run_among_others_is_named() {
    let (dir, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let layout = results(dir.path());
    let mut foreign = manifest(&["baseline", "steady"]);
    foreign.identity.scenario = "elsewhere".into();
    let foreign = write_results(other.path(), &foreign, |_| ended(&[1.0, 1.0]));
    fs::copy(foreign.record(2), layout.record(2)).unwrap();
    let (_, said) = said(dir.path());
    assert!(said.contains("2.jsonl: it belongs to another manifest; delete the file"), "{said}");
}

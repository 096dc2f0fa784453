//! What the program left behind: a refusal, or records.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::common::{run, stderr};

pub(crate) fn refused(folder: &Path, args: &str) -> String {
    let output = run(folder, args);
    assert_eq!(output.status.code(), Some(2), "{args}: {}", stderr(&output));
    stderr(&output)
}

pub(crate) fn record(results: &Path, task: usize) -> Vec<Value> {
    lines(&results.join(format!("done/000/{task}.jsonl")))
}

/// The records of a run by their files' names, without wall-clock values.
pub(crate) fn records(results: &Path) -> BTreeMap<String, Vec<Value>> {
    let paths = fs::read_dir(results.join("done/000")).unwrap().map(|e| e.unwrap().path());
    paths.map(|p| (p.file_name().unwrap().to_string_lossy().into_owned(), lines(&p))).collect()
}

fn lines(path: &Path) -> Vec<Value> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines: Vec<Value> = text.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    lines[0].as_object_mut().unwrap().remove("wall").unwrap();
    lines
}

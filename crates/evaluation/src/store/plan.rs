//! `plan.jsonl`, the tasks that follow from a manifest: for people and for whoever distributes them.

use std::path::Path;

use super::Layout;
use super::manifest::{Identity, Task};
use super::packed::is_packed;
use crate::store::error::StoreError;
use basics::files::{self, FileError, limits, write_atomically};

/// Reads `plan.jsonl`, which must be the plan of the manifest.
///
/// # Errors
///
/// [`StoreError::Plan`] when a row is not a task or the plan is another one.
pub fn read_plan(layout: &Layout, identity: &Identity) -> Result<Vec<Task>, StoreError> {
    let path = &layout.plan();
    let tasks = identity.tasks();
    // What is published of a run has its plan packed, too; it follows from the manifest.
    if is_packed(layout) && !path.exists() {
        return Ok(tasks);
    }
    let damaged = |reason: &str| StoreError::Plan { path: path.clone(), reason: reason.to_owned() };
    let bytes = files::if_present(files::read(path, limits::DOCUMENT))?;
    let bytes = bytes.ok_or_else(|| damaged("it is missing"))?;
    // As it was written, else as whoever wrote it otherwise means it.
    if bytes != plan_text(&tasks) && parse_rows(&bytes, path)? != tasks {
        return Err(damaged("it is not the plan of manifest.json"));
    }
    Ok(tasks)
}

/// Writes `plan.jsonl`.
///
/// # Errors
///
/// [`FileError`] when the folder cannot be written.
pub fn write_plan(layout: &Layout, tasks: &[Task]) -> Result<(), FileError> {
    write_atomically(&layout.plan(), &plan_text(tasks))
}

/// Returns the text of a plan.
pub fn plan_text(tasks: &[Task]) -> Vec<u8> {
    let mut text = Vec::new();
    for task in tasks {
        serde_json::to_writer(&mut text, task).expect("a task is plain data");
        text.push(b'\n');
    }
    text
}

/// Returns the tasks of a plan; the path is for messages.
///
/// # Errors
///
/// [`StoreError::Plan`] when a row is not a task.
pub fn parse_rows(bytes: &[u8], path: &Path) -> Result<Vec<Task>, StoreError> {
    let task = |(i, line): (usize, &[u8])| {
        serde_json::from_slice(line).map_err(|e| StoreError::Plan {
            path: path.to_path_buf(),
            reason: format!("line {}: {e}", i + 1),
        })
    };
    bytes.split_inclusive(|byte| *byte == b'\n').enumerate().map(task).collect()
}

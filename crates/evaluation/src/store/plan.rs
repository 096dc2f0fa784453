//! `plan.jsonl`, the tasks that follow from a manifest: for people and for whoever distributes them.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use super::Layout;
use super::manifest::{Identity, Task};
use super::packed::is_packed;
use crate::store::error::StoreError;
use basics::files::{self, FileError, Streamed};

/// Most bytes of a line of a plan.
const LINE_BYTES: u64 = 1 << 20;

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
    let mut expected = tasks.iter();
    let mut is_this = true;
    let mut text = Vec::new();
    let damaged = |reason: &str| StoreError::Plan { path: path.clone(), reason: reason.to_owned() };
    let file = files::if_present(files::open(path))?.ok_or_else(|| damaged("it is missing"))?;
    each_line(BufReader::new(file), path, |line| {
        let task = expected.next();
        text.clear();
        task.into_iter().for_each(|task| write_line(&mut text, task));
        // As it was written, else as whoever wrote it otherwise means it.
        if line != text {
            let read: Task = serde_json::from_slice(line)?;
            is_this &= Some(&read) == task;
        }
        Ok(())
    })?;
    if !is_this || expected.next().is_some() {
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
    let mut file = Streamed::new(&layout.plan())?;
    let mut line = Vec::new();
    for task in tasks {
        line.clear();
        write_line(&mut line, task);
        file.write(&line)?;
    }
    file.finish()
}

fn write_line(text: &mut Vec<u8>, task: &Task) {
    serde_json::to_writer(&mut *text, task).expect("a task is plain data");
    text.push(b'\n');
}

/// Returns the text of a plan.
pub fn plan_text(tasks: &[Task]) -> Vec<u8> {
    let mut text = Vec::new();
    tasks.iter().for_each(|task| write_line(&mut text, task));
    text
}

/// Returns the tasks of a plan; the path is for messages.
///
/// # Errors
///
/// [`StoreError::Plan`] when a row is not a task, [`StoreError::Io`] when it cannot be read.
pub fn parse_rows(file: impl BufRead, path: &Path) -> Result<Vec<Task>, StoreError> {
    let mut tasks = Vec::new();
    each_line(file, path, |line| {
        tasks.push(serde_json::from_slice(line)?);
        Ok(())
    })?;
    Ok(tasks)
}

/// Calls with every line of a plan, its end included.
fn each_line(
    mut file: impl BufRead,
    path: &Path,
    mut found: impl FnMut(&[u8]) -> Result<(), serde_json::Error>,
) -> Result<(), StoreError> {
    let malformed = |line: usize, e: String| StoreError::Plan {
        path: path.to_path_buf(),
        reason: format!("line {line}: {e}"),
    };
    let mut line = Vec::new();
    for number in 1.. {
        line.clear();
        let read = (&mut file).take(LINE_BYTES).read_until(b'\n', &mut line);
        let read = read.map_err(FileError::at("read", path))?;
        if read as u64 == LINE_BYTES {
            return Err(malformed(number, format!("it has more than {LINE_BYTES} bytes")));
        }
        if read == 0 {
            break;
        }
        found(&line).map_err(|e| malformed(number, e.to_string()))?;
    }
    Ok(())
}

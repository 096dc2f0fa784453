//! How far a run is, told from the names of files: what takes seconds for a million tasks.

use std::ffi::OsStr;
use std::fs;
use std::io::{ErrorKind, Read};
use std::path::Path;

use rayon::prelude::*;

use super::Layout;
use super::packed::Packed;
use crate::store::error::StoreError;
use basics::files::{self, FileError};

/// Bytes of a record in which its outcome stands, unless names are very long.
const HEAD: usize = 1024;

/// What stands in a failed record.
const FAILED: &[u8] = br#""outcome":"failed""#;

/// What stands in a record.
const OUTCOME: &[u8] = br#""outcome":"#;

/// What there is of a run.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Tally {
    /// By task, whether it has a record.
    pub done: Vec<bool>,
    /// Tasks with a record that says that they failed.
    pub failed: Vec<usize>,
    /// Tasks with a checkpoint and no record.
    pub begun: Vec<usize>,
}

impl Tally {
    /// Looks at a results directory of so many tasks. Another machine's newest records may not show yet where a network's
    /// file system remembers folders for some seconds.
    ///
    /// # Errors
    ///
    /// [`StoreError`] when a folder or record cannot be read.
    pub fn of(layout: &Layout, tasks: usize) -> Result<Self, StoreError> {
        let mut done = vec![false; tasks];
        if let Some(packed) = Packed::of(layout)? {
            let text = |task: usize| packed.text(task);
            let has = |task: &usize, what: &[u8]| {
                let head = text(*task).map_or(&[][..], str::as_bytes);
                let line = head.split(|byte| *byte == b'\n').next().unwrap_or_default();
                line.windows(what.len()).any(|part| part == what)
            };
            (0..tasks).for_each(|task| done[task] = text(task).is_some());
            let failed = (0..tasks).filter(|task| has(task, FAILED)).collect();
            return Ok(Self { done, failed, begun: Vec::new() });
        }
        numbers(&layout.record(0), tasks, &mut |task| done[task] = true)?;
        let mut begun = Vec::new();
        numbers(&layout.checkpoint(0), tasks, &mut |task| {
            if !done[task] {
                begun.push(task);
            }
        })?;
        begun.sort_unstable();
        let recorded: Vec<usize> = (0..tasks).filter(|task| done[*task]).collect();
        let failed = recorded
            .into_par_iter()
            .map(|task| Ok::<_, FileError>(has_failed(&layout.record(task))?.then_some(task)));
        let failed = failed.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
        Ok(Self { done, failed, begun })
    }
}

/// Tells the numbers of the files that are called like one of task 0, but for the number.
fn numbers(first: &Path, tasks: usize, found: &mut dyn FnMut(usize)) -> Result<(), FileError> {
    let extension = first.extension();
    let root = first.parent().and_then(Path::parent).expect("it lies in a folder of a folder");
    for folder in 0..tasks.div_ceil(1000) {
        let folder = root.join(format!("{folder:03}"));
        let entries = match fs::read_dir(&folder) {
            Err(e) if e.kind() == ErrorKind::NotFound => continue,
            entries => entries.map_err(FileError::at("read", &folder))?,
        };
        for entry in entries {
            let name = entry.map_err(FileError::at("read", &folder))?.file_name();
            let name = Path::new(&name);
            let number = name.file_stem().and_then(number);
            if let Some(number) = number.filter(|n| *n < tasks && name.extension() == extension) {
                found(number);
            }
        }
    }
    Ok(())
}

/// Returns the number that a file is called by; `01` is none, as no task's file is called so.
pub(super) fn number(stem: &OsStr) -> Option<usize> {
    let text = stem.to_str()?;
    text.parse().ok().filter(|number: &usize| number.to_string() == text)
}

/// Whether a record says that its task failed; one that is damaged is for others to name.
fn has_failed(path: &Path) -> Result<bool, FileError> {
    let read = |most: usize| -> Result<Vec<u8>, FileError> {
        let mut head = Vec::with_capacity(HEAD);
        let file = match files::open(path) {
            Err(e) if e.reason.kind() == ErrorKind::InvalidInput => return Ok(head),
            file => file?,
        };
        file.take(most as u64).read_to_end(&mut head).map_err(FileError::at("read", path))?;
        Ok(head)
    };
    let has = |head: &[u8], what: &[u8]| head.windows(what.len()).any(|part| part == what);
    let mut head = read(HEAD)?;
    if head.len() == HEAD && !has(&head, OUTCOME) {
        head = read(1 << 20)?;
    }
    Ok(has(&head, FAILED))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::manifest::Task;
    use crate::store::record::{Record, TaskResult};
    use crate::store::wall::Wall;

    #[test]
    fn records_checkpoints_and_failures_are_counted_and_strangers_are_not() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        assert_eq!(Tally::of(&layout, 2).unwrap().done, [false, false]);
        let task = |task: usize, method: &str| Task {
            task,
            method: method.into(),
            point: "p".into(),
            replicate: 0,
            seed: 1,
        };
        let failed = |t: &Task| Record::failed(t, "abc", "it fell".into(), Wall::default());
        Record::finished(&task(0, "m"), "abc", TaskResult::default()).commit(&layout).unwrap();
        failed(&task(1001, "m")).commit(&layout).unwrap();
        failed(&task(3, &"long".repeat(HEAD))).commit(&layout).unwrap();
        for (task, text) in [(2, "x"), (0, "x"), (5000, "x")] {
            fs::create_dir_all(layout.checkpoint(task).parent().unwrap()).unwrap();
            fs::write(layout.checkpoint(task), text).unwrap();
        }
        fs::write(dir.path().join("done/000/7.jsonl.part"), "").unwrap();
        let tally = Tally::of(&layout, 1002).unwrap();
        let missing = tally.done.iter().filter(|done| !**done).count();
        assert_eq!((missing, tally.failed, tally.begun), (999, vec![3, 1001], vec![2]));
    }
}

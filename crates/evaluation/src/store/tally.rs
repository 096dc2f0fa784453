//! How far a run is, told from the names of files: what takes seconds for a million tasks.

use std::ffi::OsStr;
use std::fs;
use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::path::Path;

use rayon::prelude::*;

use super::Layout;
use super::builds::Builds;
use super::packed::Packed;
use crate::store::error::StoreError;
use basics::files::{self, FileError};

/// Bytes that are read of a record at once; its first line has its outcome and its build.
const HEAD: usize = 2048;

/// Most bytes of that line.
const MOST_HEAD: u64 = 1 << 20;

/// What stands in a failed record.
const FAILED: &str = r#""outcome":"failed""#;

/// After what the build stands that made a record: its wall-clock values, and there its name.
const BUILD: [&str; 2] = [r#""wall":{"#, r#""git":""#];

/// What there is of a run.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Tally {
    /// By task, whether it has a record.
    pub done: Vec<bool>,
    /// Tasks with a record that says that they failed.
    pub failed: Vec<usize>,
    /// Tasks with a checkpoint and no record.
    pub begun: Vec<usize>,
    /// Which builds made the records.
    pub builds: Builds,
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
        let packed = Packed::of(layout)?;
        match &packed {
            Some(packed) => (0..tasks).for_each(|t| done[t] = packed.text(t).is_some()),
            None => numbers(&layout.record(0), tasks, &mut |task| done[task] = true)?,
        }
        let mut begun = Vec::new();
        numbers(&layout.checkpoint(0), tasks, &mut |task| {
            if !done[task] {
                begun.push(task);
            }
        })?;
        begun.sort_unstable();
        let recorded: Vec<usize> = (0..tasks).filter(|task| done[*task]).collect();
        let heads = recorded.into_par_iter().map(|task| {
            let head = match packed.as_ref().and_then(|packed| packed.text(task)) {
                Some(text) => text.lines().next().unwrap_or_default().to_owned(),
                None => head(&layout.record(task))?,
            };
            let failed = head.contains(FAILED).then_some(task);
            Ok::<_, FileError>((failed, build_in(&head).to_owned()))
        });
        let (mut failed, mut builds) = (Vec::new(), Builds::default());
        for (task, build) in heads.collect::<Result<Vec<_>, _>>()? {
            failed.extend(task);
            builds.add_build(&build);
        }
        Ok(Self { done, failed, begun, builds })
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

/// Returns the first line of a record; nothing of one that is no regular file, which is for others to name.
fn head(path: &Path) -> Result<String, FileError> {
    let file = match files::open(path) {
        Err(e) if e.reason.kind() == ErrorKind::InvalidInput => return Ok(String::new()),
        file => file?,
    };
    let mut head = Vec::with_capacity(HEAD);
    let mut lines = BufReader::with_capacity(HEAD, file.take(MOST_HEAD));
    lines.read_until(b'\n', &mut head).map_err(FileError::at("read", path))?;
    Ok(String::from_utf8_lossy(&head).into_owned())
}

/// Returns the build in the first line of a record; nothing of one from before builds were kept.
fn build_in(head: &str) -> &str {
    let [wall, git] = BUILD;
    let after = head.rsplit_once(wall).and_then(|(_, wall)| wall.split_once(git));
    after.and_then(|(_, rest)| rest.split_once('"')).map_or("", |(build, _)| build)
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
        let wall = |git: &str| Wall { git: git.into(), ..Wall::default() };
        let failed = |t: &Task| Record::failed(t, "abc", "it fell".into(), wall("b"));
        let result = TaskResult { wall: wall("a"), ..TaskResult::default() };
        Record::finished(&task(0, "m"), "abc", result).commit(&layout).unwrap();
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
        assert_eq!(
            tally.builds.several().unwrap(),
            "Several builds made the records: 1 by a, 2 by b."
        );
    }
}

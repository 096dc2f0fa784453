//! Batch systems that users have already: a run hands its tasks over in packs and goes away.
//!
//! What was handed over lies in `jobs/N/` of the results directory: `packs.jsonl`, a pack of tasks per line, and the script
//! `job.sh`. Every job does one pack by `tsc-family work DIR --submission N --pack K`, wherever it runs: the directory is
//! shared or shipped, and nothing else is, neither clock nor lock. What is done is what has a record, so that a job that
//! runs twice, on a node that was believed dead and on the next one, changes nothing.

pub mod pack;
pub mod slurm;

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use crate::run::error::RunError;
use crate::run::executor::Launcher;
use crate::store::Layout;
use basics::files::{self, FileError, limits, make_folder_beneath, quoted, write_atomically};
use pack::Pack;

/// Times that a job which was stopped at a checkpoint is queued again by itself.
pub const RESTARTS: u32 = 20;

/// Most submissions of a results directory.
const MOST: usize = 100_000;

/// A hand-over: where it lies, and how jobs work.
#[derive(Debug, Clone)]
pub struct Submission {
    /// Which of the results directory, from 0.
    pub number: usize,
    /// The results directory, absolute.
    pub results: PathBuf,
    /// Folder in which jobs start: that of whoever submits, so that relative paths mean the same.
    pub from: PathBuf,
    /// Folder of what was prepared, absolute; empty where nothing was.
    pub prepared: PathBuf,
    /// What to start, absolute.
    pub launcher: Launcher,
    /// Lines of the user's for the batch system.
    pub lines: Vec<String>,
    /// Number of packs.
    pub packs: usize,
    /// Time that the longest pack is expected to take with these workers, seconds.
    pub longest_s: f64,
    /// Workers of a job.
    pub workers: usize,
    /// Memory that a worker is expected to need, MB.
    pub memory_mb: u64,
    /// Memory that a worker may use, MB; `None` for its share of what the job has.
    pub memory_per_worker_mb: Option<u64>,
    /// Time without a step of the simulation after which a task is given up, seconds.
    pub stall_timeout_s: u64,
}

impl Submission {
    /// The script that does a pack.
    pub fn script(&self) -> PathBuf {
        folder(&self.results, self.number).join("job.sh")
    }

    /// Folder of what jobs print.
    pub fn output(&self) -> PathBuf {
        folder(&self.results, self.number).join("out")
    }

    /// Returns the command that does a pack, without the pack's number.
    fn command(&self) -> String {
        let word = |word: &OsString| quoted(word.as_ref());
        let first = self.launcher.first.iter().map(word);
        let program = std::iter::once(quoted(&self.launcher.program)).chain(first);
        let mut words: Vec<String> = program.collect();
        words.extend(["work".to_owned(), quoted(&self.results)]);
        words.push(format!("--submission {} --jobs {}", self.number, self.workers));
        words.push(format!("--stall-timeout {}", self.stall_timeout_s));
        words.extend(self.memory_per_worker_mb.map(|mb| format!("--memory-per-worker {mb}")));
        if !self.prepared.as_os_str().is_empty() {
            words.push(format!("--prepared {}", quoted(&self.prepared)));
        }
        words.extend(self.launcher.last().map(word));
        words.join(" ")
    }

    /// Writes a script for whatever starts scripts: GNU parallel, PBS, Kubernetes' indexed jobs.
    pub fn write_script(&self) -> Result<(), FileError> {
        let last = self.packs.saturating_sub(1);
        self.write_executable(&format!(
            "#!/bin/sh\n\
             # Does one pack of tasks of a tsc-family run: job.sh PACK, from 0 to {last}.\n\
             # PBS and Kubernetes' indexed jobs give the number by themselves. Exit code 75: stopped at a checkpoint,\n\
             # start it again. A pack that is over ends at once, and one that runs twice does no harm.\n\
             pack=${{1:-${{PBS_ARRAY_INDEX:-$JOB_COMPLETION_INDEX}}}}\n\
             case $pack in\n\
             '' | *[!0-9]*) echo \"usage: $0 PACK, from 0 to {last}\" >&2; exit 2 ;;\n\
             esac\n\
             cd {from} || exit 1\n\
             exec {work} --pack \"$pack\"\n",
            from = quoted(&self.from),
            work = self.command(),
        ))
    }

    fn write_executable(&self, text: &str) -> Result<(), FileError> {
        let path = self.script();
        write_atomically(&path, text.as_bytes())?;
        let executable = fs::Permissions::from_mode(0o755);
        fs::set_permissions(&path, executable).map_err(FileError::at("make executable", &path))
    }
}

fn folder(results: &Path, number: usize) -> PathBuf {
    Layout::new(results).jobs().join(format!("{number:03}"))
}

/// Makes the folder of the next submission, writes its packs and returns its number.
pub fn begin(layout: &Layout, packs: &[Pack]) -> Result<usize, FileError> {
    make_folder_beneath(layout.root(), &layout.jobs())?;
    let mut number = 0;
    let folder = loop {
        let path = folder(layout.root(), number);
        match fs::create_dir(&path) {
            Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists && number < MOST => number += 1,
            made => {
                made.map_err(FileError::at("create", &path))?;
                break path;
            }
        }
    };
    make_folder_beneath(layout.root(), &folder.join("out"))?;
    let line = |pack: &Pack| serde_json::to_string(&pack.tasks).expect("numbers are plain data");
    let lines: Vec<String> = packs.iter().map(|pack| line(pack) + "\n").collect();
    write_atomically(&folder.join("packs.jsonl"), lines.concat().as_bytes())?;
    Ok(number)
}

/// Returns the packs of a submission, each of them rows of the plan; `None` where there is none of this number.
pub fn packs_of(layout: &Layout, number: usize) -> Result<Option<Vec<Vec<usize>>>, RunError> {
    let path = folder(layout.root(), number).join("packs.jsonl");
    let Some(text) = files::if_present(files::read_text(&path, limits::DOCUMENT))? else {
        return Ok(None);
    };
    let pack = |(line, text): (usize, &str)| {
        serde_json::from_str(text).map_err(|e| {
            RunError::Refused(format!("{}: line {}: {e}; submit anew", path.display(), line + 1))
        })
    };
    text.lines().enumerate().map(pack).collect::<Result<_, _>>().map(Some)
}

/// Returns what tells whether a task was begun: it was handed over, or something of it is kept.
pub fn begun(layout: &Layout) -> Result<impl Fn(usize) -> bool + use<'_>, RunError> {
    let mut handed = BTreeSet::new();
    for number in (0..MOST).take_while(|number| folder(layout.root(), *number).exists()) {
        handed.extend(packs_of(layout, number)?.into_iter().flatten().flatten());
    }
    Ok(move |task| handed.contains(&task) || layout.checkpoint(task).exists())
}

/// Makes a path absolute and checks that scripts and batch systems can pass it on.
///
/// # Errors
///
/// [`RunError`] when they cannot, or it is not there.
pub fn absolute(path: &Path) -> Result<PathBuf, RunError> {
    let path = fs::canonicalize(path).map_err(FileError::at("find", path))?;
    let what = match path.to_str() {
        None => "bytes that are no text",
        Some(text) if text.chars().any(char::is_control) => "control characters",
        Some(_) => return Ok(path),
    };
    Err(RunError::Refused(format!(
        "{} has {what} in its name, which batch systems do not pass on; choose another name",
        path.display()
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn submissions_are_numbered_and_their_packs_read_back() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        let pack = |tasks: &[usize]| Pack { tasks: tasks.to_vec(), seconds: 1.0, longest_s: 1.0 };
        assert_eq!(begin(&layout, &[pack(&[0, 2]), pack(&[1])]).unwrap(), 0);
        assert_eq!(begin(&layout, &[pack(&[5])]).unwrap(), 1);
        assert_eq!(packs_of(&layout, 0).unwrap().unwrap(), [vec![0, 2], vec![1]]);
        assert!(packs_of(&layout, 2).unwrap().is_none());
        let begun = begun(&layout).unwrap();
        assert_eq!([1, 3, 5].map(begun), [true, false, true]);
    }

    #[test]
    fn a_path_that_scripts_cannot_pass_on_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let named = dir.path().join("a\nb");
        fs::create_dir(&named).unwrap();
        assert!(absolute(&named).unwrap_err().to_string().contains("control characters"));
    }
}

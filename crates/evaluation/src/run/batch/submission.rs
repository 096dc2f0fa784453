//! What was handed over to a batch system: `jobs/N/submission.json`, its packs and its script.
//!
//! Nothing in it is executed when it is read back: the program, the way to the networks and the lines for it
//! come from whoever resumes.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error::BatchError;
use super::pack::Pack;
use crate::run::executor::Launcher;
use crate::store::Layout;
use basics::files::{self, FileError, limits, make_folder_beneath, write_atomically};

/// Most submissions of a results directory.
const MOST: usize = 100_000;

/// A hand-over.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Submission {
    /// Version of the file.
    pub format_version: u32,
    /// Which of the results directory, from 0.
    #[serde(skip)]
    pub number: usize,
    /// Name of it.
    pub executor: String,
    /// sha256 of the manifest.
    pub manifest: String,
    /// The results directory, absolute, into which its jobs write: not the one that it is read from, where that is a
    /// copy. Unknown of submissions that are older than this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub results: Option<PathBuf>,
    /// Number of packs.
    pub packs: usize,
    /// Tasks in them.
    pub tasks: usize,
    /// Time that the longest pack is expected to take with these workers, seconds.
    pub longest_s: f64,
    /// Memory that a worker is expected to need, MB.
    pub memory_mb: u64,
    /// Workers of a job.
    pub workers: usize,
    /// Time without a step of the simulation after which a task is given up, seconds.
    pub stall_timeout_s: u64,
    /// Memory that a worker may use, MB; `None` for its share of what the job has.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub memory_per_worker_mb: Option<u64>,
    /// Whether lines of the user's were added, which resuming needs again.
    pub has_lines: bool,
    /// Ids that it gave; of the packs in their order, so many per id.
    pub ids: Vec<String>,
    /// Packs per id.
    pub packs_per_id: usize,
    /// When it was cancelled, if it was: ISO 8601, UTC.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cancelled: Option<String>,
}

impl Submission {
    /// Version of the file; a change of its form raises it.
    pub const VERSION: u32 = 1;

    /// Whether its jobs write into a results directory.
    pub fn is_of(&self, layout: &Layout) -> bool {
        let here = || fs::canonicalize(layout.root()).ok();
        self.results.as_ref().is_none_or(|results| here().as_ref() == Some(results))
    }
}

/// Where a submission lies, and from where jobs work.
#[derive(Debug, Clone)]
pub struct Place {
    /// The results directory, absolute.
    pub results: PathBuf,
    /// The folder of the submission, absolute.
    pub folder: PathBuf,
    /// Folder in which jobs start: that of whoever submits, so that relative paths mean the same.
    pub from: PathBuf,
    /// Folder of what was prepared, absolute; empty where nothing was.
    pub prepared: PathBuf,
    /// What to start, absolute.
    pub launcher: Launcher,
    /// Lines of the user's for it.
    pub lines: Vec<String>,
}

impl Place {
    /// The script that a job runs.
    pub fn script(&self) -> PathBuf {
        self.folder.join("job.sh")
    }

    /// Folder of what jobs print.
    pub fn output(&self) -> PathBuf {
        self.folder.join("out")
    }
}

/// Returns the folder of a submission.
pub fn folder(layout: &Layout, number: usize) -> PathBuf {
    layout.jobs().join(format!("{number:03}"))
}

/// Returns all submissions of a results directory in their order.
///
/// # Errors
///
/// [`BatchError`] when one cannot be read.
pub fn all(layout: &Layout) -> Result<Vec<Submission>, BatchError> {
    let mut found = Vec::new();
    for number in 0..MOST {
        let path = folder(layout, number).join("submission.json");
        let text = files::if_present(files::read_text(&path, limits::DOCUMENT))?;
        let Some(text) = text else {
            // One that was killed before it had handed anything over leaves a gap.
            if folder(layout, number).exists() {
                continue;
            }
            break;
        };
        let malformed = |reason: String| BatchError::Malformed {
            path: path.clone(),
            reason: format!("{reason}; cancel its jobs by hand and remove its folder"),
        };
        let submission: Submission =
            serde_json::from_str(&text).map_err(|e| malformed(e.to_string()))?;
        if submission.format_version != Submission::VERSION {
            let (found, own) = (submission.format_version, Submission::VERSION);
            return Err(malformed(format!("it has version {found}, not {own}")));
        }
        // They become arguments: one that is an option would be obeyed.
        if !submission.ids.iter().all(|id| is_number(id)) {
            return Err(malformed("it has ids that no batch system gave".to_owned()));
        }
        found.push(Submission { number, ..submission });
    }
    Ok(found)
}

/// Whether an id is as batch systems give it.
pub(super) fn is_number(id: &str) -> bool {
    !id.is_empty() && id.bytes().all(|byte| byte.is_ascii_digit())
}

/// Makes the folder of the next submission and writes its packs.
///
/// # Errors
///
/// [`FileError`] when it cannot be written.
pub fn begin(layout: &Layout, packs: &[Pack]) -> Result<usize, FileError> {
    make_folder_beneath(layout.root(), &layout.jobs())?;
    let mut number = 0;
    loop {
        let path = folder(layout, number);
        match fs::create_dir(&path) {
            Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists && number < MOST => number += 1,
            made => {
                made.map_err(FileError::at("create", &path))?;
                break;
            }
        }
    }
    let folder = folder(layout, number);
    make_folder_beneath(layout.root(), &folder.join("out"))?;
    let mut text = String::new();
    for pack in packs {
        text.push_str(&serde_json::to_string(&pack.tasks).expect("numbers are plain data"));
        text.push('\n');
    }
    write_atomically(&folder.join("packs.jsonl"), text.as_bytes())?;
    Ok(number)
}

/// Writes what was handed over.
///
/// # Errors
///
/// [`FileError`] when it cannot be written.
pub fn write(layout: &Layout, submission: &Submission) -> Result<(), FileError> {
    let text = serde_json::to_string_pretty(submission).expect("plain data");
    let path = folder(layout, submission.number).join("submission.json");
    write_atomically(&path, format!("{text}\n").as_bytes())
}

/// Packs of a submission: each line has rows of the plan, which are read where they are asked for.
#[derive(Debug, Clone)]
pub struct Packs {
    path: PathBuf,
    text: String,
}

impl Packs {
    /// Reads the file of a submission.
    ///
    /// # Errors
    ///
    /// [`BatchError`] when it cannot be read.
    pub fn read(layout: &Layout, number: usize) -> Result<Self, BatchError> {
        let path = folder(layout, number).join("packs.jsonl");
        let text = files::read_text(&path, limits::DOCUMENT)?;
        Ok(Self { path, text })
    }

    /// Number of packs.
    pub fn count(&self) -> usize {
        self.text.lines().count()
    }

    /// Returns the rows of the plan of some packs, ascending by pack; what is no pack has none.
    ///
    /// # Errors
    ///
    /// [`BatchError`] when a line is no pack.
    pub fn tasks(&self, of: &BTreeSet<usize>) -> Result<Vec<Vec<usize>>, BatchError> {
        let lines = self.text.lines().enumerate().filter(|(pack, _)| of.contains(pack));
        let pack = |(line, text): (usize, &str)| {
            serde_json::from_str(text).map_err(|e| BatchError::Line {
                path: self.path.clone(),
                line: line + 1,
                reason: format!("{e}; submit anew"),
            })
        };
        lines.map(pack).collect()
    }
}

/// Returns the tasks of all submissions of a results directory, whatever became of them.
///
/// # Errors
///
/// [`BatchError`] when a submission cannot be read.
pub fn tasks(layout: &Layout) -> Result<BTreeSet<usize>, BatchError> {
    let mut tasks = BTreeSet::new();
    for submission in all(layout)? {
        let packs = Packs::read(layout, submission.number)?;
        tasks.extend(packs.tasks(&(0..packs.count()).collect())?.into_iter().flatten());
    }
    Ok(tasks)
}

/// Returns what tells whether a task was begun: it was handed over, or something of it is kept.
pub fn begun(layout: &Layout, handed: BTreeSet<usize>) -> impl Fn(usize) -> bool {
    move |task| handed.contains(&task) || layout.checkpoint(task).exists()
}

/// Makes a path absolute and checks that scripts and batch systems can pass it on.
///
/// # Errors
///
/// [`BatchError`] when they cannot, or it is not there.
pub fn absolute(path: &Path) -> Result<PathBuf, BatchError> {
    let path = fs::canonicalize(path).map_err(FileError::at("find", path))?;
    let what = match path.to_str() {
        None => "bytes that are no text",
        Some(text) if text.chars().any(char::is_control) => "control characters",
        Some(_) => return Ok(path),
    };
    Err(BatchError::Name { path, what })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn submission(number: usize) -> Submission {
        Submission {
            format_version: Submission::VERSION,
            number,
            executor: "slurm".into(),
            manifest: "abc".into(),
            results: None,
            packs: 2,
            tasks: 3,
            longest_s: 60.0,
            memory_mb: 500,
            workers: 1,
            stall_timeout_s: 600,
            memory_per_worker_mb: None,
            has_lines: false,
            ids: vec!["7".into()],
            packs_per_id: 1000,
            cancelled: None,
        }
    }

    #[test]
    fn submissions_are_numbered_and_read_back_and_one_that_was_killed_is_passed_over() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        assert!(all(&layout).unwrap().is_empty());
        let pack = |tasks: &[usize]| Pack { tasks: tasks.to_vec(), seconds: 1.0, longest_s: 1.0 };
        let own = [pack(&[0, 2]), pack(&[1])];
        assert_eq!(begin(&layout, &own).unwrap(), 0);
        write(&layout, &submission(0)).unwrap();
        assert_eq!(begin(&layout, &own[..1]).unwrap(), 1);
        assert_eq!(begin(&layout, &own).unwrap(), 2);
        write(&layout, &submission(2)).unwrap();
        assert_eq!(all(&layout).unwrap(), [submission(0), submission(2)]);
        let packs = Packs::read(&layout, 0).unwrap();
        assert_eq!(packs.count(), 2);
        assert_eq!(packs.tasks(&BTreeSet::from([0, 1, 7])).unwrap(), [vec![0, 2], vec![1]]);
        assert_eq!(packs.tasks(&BTreeSet::from([1])).unwrap(), [vec![1]]);
        assert_eq!(tasks(&layout).unwrap(), BTreeSet::from([0, 1, 2]));
        fs::write(folder(&layout, 0).join("submission.json"), "{").unwrap();
        let e = all(&layout).unwrap_err().to_string();
        assert!(e.contains("000/submission.json: EOF"), "{e}");
        for id in ["--user=me", "", "7,8", "7 8"] {
            write(&layout, &Submission { ids: vec![id.into()], ..submission(0) }).unwrap();
            let e = all(&layout).unwrap_err().to_string();
            assert!(e.contains("it has ids that no batch system gave"), "{id:?}: {e}");
        }
    }

    #[test]
    fn a_path_that_scripts_cannot_pass_on_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let named = dir.path().join("a\nb");
        fs::create_dir(&named).unwrap();
        assert!(absolute(&named).unwrap_err().to_string().contains("control characters"));
    }
}

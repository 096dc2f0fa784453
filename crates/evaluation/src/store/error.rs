//! Why a results directory cannot be used.

use std::fmt;
use std::path::PathBuf;

use basics::files::FileError;

/// A file that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Damage {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub reason: String,
    /// What to do.
    pub remedy: Remedy,
}

/// What to do with a damaged file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Remedy {
    /// Without it, its task is done again, to the same record.
    Repeat,
    /// Without it and its record, its task is done again.
    Retrain,
    /// Nothing but time is lost without it.
    Discard,
    /// The command that began the run writes it again.
    Renew,
    /// The command that began the run builds it again, once it is gone.
    Rebuild,
    /// It comes from a copy, or from the command that began the run once it is away.
    Begin,
    /// It can only come from a copy.
    Restore,
}

impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Repeat => "delete the file and run again: only this task is repeated",
            Self::Retrain => {
                "delete it and the record of this number, and run again: only this task is repeated"
            }
            Self::Discard => "delete it; the training starts from the beginning",
            Self::Renew => "delete it, and the next `tsc-family run` writes it again",
            Self::Rebuild => "delete its folder; the command of the run builds it again",
            Self::Begin => {
                "restore it from a copy, or move it away and repeat the command that began the run, which writes it \
                 again and keeps the records"
            }
            Self::Restore => "restore it from a copy",
        })
    }
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}; {}", self.path.display(), self.reason, self.remedy)
    }
}

/// Why a results directory cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// No manifest.
    #[error(
        "{} is not a results directory (it has no manifest.json); give the folder that \
         `tsc-family run --out` wrote",
        .0.display()
    )]
    NotResults(PathBuf),
    /// Written by a version with other files.
    #[error(
        "{}: schema version {found}, but this tsc-family reads {expected}; use the version that \
         wrote it, restore it from a copy where it is damaged, or give another --out",
        .path.display()
    )]
    Version {
        /// The manifest.
        path: PathBuf,
        /// Version found.
        found: u64,
        /// Version understood.
        expected: u32,
    },
    /// Files that cannot be used.
    #[error("{}", all(.0))]
    Damaged(Vec<Damage>),
    /// The directory belongs to another run.
    #[error(
        "{} holds another run: {difference}; give another --out, or repeat the first command ({command}) \
         to continue it",
        .path.display()
    )]
    Mismatch {
        /// The directory.
        path: PathBuf,
        /// What differs, with both values.
        difference: String,
        /// The command that began the run.
        command: String,
    },
    /// A run that was to be added to, and was interrupted.
    #[error(
        "{}: a command that adds to it was interrupted while files took their places; nothing is lost: repeat that \
         command, or the one that began the run",
        .0.display()
    )]
    Adding(PathBuf),
    /// A run to which jobs of a batch system may still add records.
    #[error(
        "{}: jobs of a batch system may still add records, so nothing can be added to the run; wait until \
         `tsc-family status` says that all tasks are done; if no job is left, do the missing tasks first with \
         `tsc-family resume`; or give another --out",
        .0.display()
    )]
    Submitted(PathBuf),
    /// Another process works on the directory.
    #[error(
        "{} is in use by another run ({holder}); wait for it, stop it, or give another --out",
        .path.display()
    )]
    Locked {
        /// The directory.
        path: PathBuf,
        /// What the lock file says.
        holder: String,
    },
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] FileError),
}

impl StoreError {
    /// Returns the error of one file that cannot be used.
    pub fn damaged(path: impl Into<PathBuf>, reason: impl ToString, remedy: Remedy) -> Self {
        Self::Damaged(vec![Damage { path: path.into(), reason: reason.to_string(), remedy }])
    }
}

fn all(damage: &[Damage]) -> String {
    let lines: Vec<String> = damage.iter().map(Damage::to_string).collect();
    match damage {
        [_] => lines.concat(),
        _ => format!("{} files are damaged:\n{}", damage.len(), lines.join("\n")),
    }
}

//! Why a results directory cannot be used.

use std::path::PathBuf;

use basics::files::FileError;

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
    /// A manifest that is damaged.
    #[error(
        "{}: {reason}; restore it from a copy, or move it away and repeat the command that began the run, which \
         writes it again and keeps the records",
        .path.display()
    )]
    Manifest {
        /// The manifest.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A file that a person wrote for reports has something else.
    #[error("{}: {reason}; correct it, or delete it for the defaults", .path.display())]
    Setting {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A file that every run writes anew is damaged.
    #[error(
        "{}: {reason}; delete it, and the next `tsc-family run` writes it again",
        .path.display()
    )]
    Renewable {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// What the sample was spread over is damaged, or of another manifest.
    #[error(
        "{}: {reason}; restore it from a copy, or move it away and repeat the command that began the run, which \
         writes it again",
        .path.display()
    )]
    Design {
        /// The design.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A file that does not parse.
    #[error("{}: {reason}", .path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The parser's message.
        reason: String,
    },
    /// A record whose content does not match its own checksum or task.
    #[error(
        "{}: {reason}; delete the file and run again: only this task is repeated",
        .path.display()
    )]
    Record {
        /// The record.
        path: PathBuf,
        /// What does not match.
        reason: String,
    },
    /// Several damaged records.
    #[error(
        "{} records are damaged; delete these files and run again: only their tasks are repeated:{}",
        .0.len(),
        .0.iter().map(|(path, reason)| format!("\n{}: {reason}", path.display())).collect::<String>()
    )]
    Records(Vec<(PathBuf, String)>),
    /// A manifest that is not the one of the records beside it.
    #[error(
        "{}: it is not the manifest of the records beside it, which are whole ({records} of another one): it was altered \
         or damaged, or they were copied here; restore it from a copy, or move it away and repeat the command that \
         began the run, which writes it again; keep the records",
        .path.display()
    )]
    OtherManifest {
        /// The manifest.
        path: PathBuf,
        /// Records that carry the sha256 of another one.
        records: usize,
    },
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

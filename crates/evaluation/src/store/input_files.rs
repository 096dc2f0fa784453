//! Files that a task reads: whatever comes of them counts only if they stay those of the plan.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use basics::files::FileError;
use basics::hash::sha256_file;

/// Why what was read does not count.
#[derive(Debug, thiserror::Error)]
pub enum Changed {
    /// A file that differs from the manifest.
    #[error(
        "{}: the file {what} since the run was planned; restore it, or start a new run with \
         another --out",
        .path.display()
    )]
    Altered {
        /// The file.
        path: PathBuf,
        /// `was deleted` or `was altered`.
        what: &'static str,
    },
    /// A file that was written while it was in use.
    #[error(
        "{}: the file was written while it was simulated, and is as planned again; nothing that came of it counts",
        .0.display()
    )]
    Disturbed(PathBuf),
    /// A file could not be read.
    #[error(transparent)]
    Io(#[from] FileError),
}

/// Files that a task reads; none by default.
#[derive(Debug, Default)]
pub struct InputFiles {
    /// Path, sha256 and stamp of each.
    files: Vec<(PathBuf, String, Stamp)>,
}

/// What changes when a file is written or exchanged for another: device, inode, bytes, and when it was modified.
type Stamp = (u64, u64, u64, i64, i64);

impl InputFiles {
    /// Compares a file with the plan, and holds on to it.
    /// * `sha256` — as planned; `None` where the plan does not have the file.
    ///
    /// Fails with [`Changed::Altered`] when it is not the planned one.
    pub fn add(&mut self, path: &Path, sha256: Option<&String>) -> Result<(), Changed> {
        let is_planned = sha256.map(String::as_str) == Some(self.hold(path)?);
        is_planned.then_some(()).ok_or_else(|| altered(path, "was altered"))
    }

    /// Holds on to those of another point MDP too.
    pub fn join(&mut self, other: Self) {
        self.files.extend(other.files);
    }

    /// Holds on to a file as it is, which somebody else has compared with the plan, and returns its sha256.
    /// Fails with [`Changed::Altered`] when there is none.
    pub fn hold(&mut self, path: &Path) -> Result<&str, Changed> {
        // Before it is read: what is written in between shows in the next stamp.
        let stamp = stamp(path)?.ok_or_else(|| altered(path, "was deleted"))?;
        self.files.push((path.to_path_buf(), sha256_file(path)?, stamp));
        Ok(&self.files[self.files.len() - 1].1)
    }

    /// Checks that no file was written, exchanged or deleted since it was added.
    /// Fails with [`Changed::Altered`] when one is not the planned one any more, [`Changed::Disturbed`] when it
    /// is, but was written meanwhile.
    pub fn verify(&self) -> Result<(), Changed> {
        for (path, sha256, before) in &self.files {
            match stamp(path)? {
                None => return Err(altered(path, "was deleted")),
                Some(now) if now == *before => {}
                Some(_) if sha256_file(path)? == *sha256 => {
                    return Err(Changed::Disturbed(path.clone()));
                }
                Some(_) => return Err(altered(path, "was altered")),
            }
        }
        Ok(())
    }
}

fn altered(path: &Path, what: &'static str) -> Changed {
    Changed::Altered { path: path.to_path_buf(), what }
}

/// Returns the stamp of a file; `None` if there is none.
fn stamp(path: &Path) -> Result<Option<Stamp>, FileError> {
    match fs::metadata(path) {
        Ok(m) => Ok(Some((m.dev(), m.ino(), m.len(), m.mtime(), m.mtime_nsec()))),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(FileError::at("read", path)(e)),
    }
}

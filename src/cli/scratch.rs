//! A folder for the files of a simulation that belongs to no results directory.
//!
//! It lies in the folder for temporary files, which everybody may write: its name cannot be guessed, and it is locked by
//! whoever works in it. What a killed process has left there goes when the next one begins: folders of this user, of
//! this name, that nobody has locked.

use std::fs::{self, File};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use tempfile::TempDir;

use crate::files::{self, FileError};

/// How the names of these folders begin.
const NAME: &str = "tsc-family-evaluate-";

/// Name of the file that is locked.
const LOCK: &str = ".lock";

/// Age from which on a folder that nobody has locked was left behind.
const ABANDONED: Duration = Duration::from_secs(5);

/// A folder that is removed when it is dropped.
#[derive(Debug)]
pub(super) struct Scratch {
    folder: TempDir,
    _lock: File,
}

impl Scratch {
    /// Makes a folder in another, and removes those that killed processes have left there.
    ///
    /// # Errors
    ///
    /// [`FileError`] when the folder cannot be written.
    pub(super) fn new(within: &Path) -> Result<Self, FileError> {
        tidy_up(within);
        let folder = tempfile::Builder::new().prefix(NAME).tempdir_in(within);
        let folder = folder.map_err(FileError::at("create", within))?;
        let path = folder.path().join(LOCK);
        let lock = File::create(&path).map_err(FileError::at("create", &path))?;
        // Where files cannot be locked, nobody removes what others have.
        let _ = lock.try_lock();
        Ok(Self { folder, _lock: lock })
    }

    /// The folder.
    pub(super) fn path(&self) -> &Path {
        self.folder.path()
    }
}

fn tidy_up(within: &Path) {
    let entries = fs::read_dir(within).into_iter().flatten().flatten();
    let left = entries.map(|entry| entry.path()).filter(|path| is_abandoned(path));
    for path in left.collect::<Vec<PathBuf>>() {
        // Another process may have been first.
        let _ = fs::remove_dir_all(path);
    }
}

fn is_abandoned(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let Ok(about) = fs::symlink_metadata(path) else { return false };
    let is_ours = about.is_dir() && about.uid() == rustix::process::geteuid().as_raw();
    if !name.starts_with(NAME) || !is_ours {
        return false;
    }
    let age = about.modified().ok().and_then(|at| SystemTime::now().duration_since(at).ok());
    let is_free = files::open(&path.join(LOCK)).is_ok_and(|lock| lock.try_lock().is_ok());
    is_free && age.is_some_and(|age| age > ABANDONED)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_killed_process_left_goes_and_what_is_in_use_stays() {
        let folder = tempfile::tempdir().unwrap();
        let used = Scratch::new(folder.path()).unwrap();
        let long_ago = SystemTime::now() - 2 * ABANDONED;
        let [left, other] = [format!("{NAME}left"), "other".into()].map(|n| folder.path().join(n));
        for path in [&left, &other] {
            fs::create_dir(path).unwrap();
            fs::write(path.join(LOCK), "").unwrap();
        }
        for path in [&left, &other, &used.path().to_path_buf()] {
            File::open(path).unwrap().set_modified(long_ago).unwrap();
        }
        let next = Scratch::new(folder.path()).unwrap();
        assert!(!left.exists() && other.exists() && used.path().exists());
        let path = next.path().to_path_buf();
        drop(next);
        assert!(!path.exists());
    }
}

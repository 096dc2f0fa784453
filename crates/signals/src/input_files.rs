//! The files that a task reads, compared with the plan when it begins and held on to: what was written
//! meanwhile is noticed, even where it was put back.

use std::fs::{self, File};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use super::error::TrafficError;
use basics::files::FileError;
use basics::hash::sha256_file;

/// Files that a task reads; none by default.
#[derive(Debug, Default)]
pub struct InputFiles {
    files: Vec<InputFile>,
    /// Keeps those who tidy up from removing the folder.
    lock: Option<File>,
}

#[derive(Debug)]
struct InputFile {
    path: PathBuf,
    sha256: String,
    stamp: Stamp,
}

/// What changes when a file is written or exchanged for another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Stamp {
    device: u64,
    inode: u64,
    bytes: u64,
    modified: (i64, i64),
}

impl InputFiles {
    /// Keeps others from removing a folder while this lives, where the file system has locks.
    pub fn keep(&mut self, folder: &Path) {
        self.lock = File::open(folder).ok().filter(|file| file.try_lock_shared().is_ok());
    }

    /// Compares a file with the plan, and holds on to it.
    ///
    /// # Arguments
    ///
    /// * `sha256` — as planned; `None` where the plan does not have the file.
    ///
    /// # Errors
    ///
    /// [`TrafficError::Altered`] when it is not the planned one.
    pub fn add(&mut self, path: &Path, sha256: Option<&String>) -> Result<(), TrafficError> {
        match sha256.map(String::as_str) == Some(self.hold(path)?) {
            true => Ok(()),
            false => Err(altered(path, "was altered")),
        }
    }

    /// Holds on to a file as it is, which somebody else has compared with the plan, and returns its sha256.
    ///
    /// # Errors
    ///
    /// [`TrafficError::Altered`] when there is none.
    pub fn hold(&mut self, path: &Path) -> Result<&str, TrafficError> {
        // Before it is read: what is written in between shows in the next stamp.
        let stamp = stamp(path)?.ok_or_else(|| altered(path, "was deleted"))?;
        let sha256 = sha256_file(path)?;
        self.files.push(InputFile { path: path.to_path_buf(), sha256, stamp });
        Ok(&self.files[self.files.len() - 1].sha256)
    }

    /// Checks that no file was written, exchanged or deleted since it was added.
    ///
    /// # Errors
    ///
    /// [`TrafficError::Altered`] when one is not the planned one any more, [`TrafficError::Disturbed`] when it
    /// is, but was written meanwhile.
    pub fn verify(&self) -> Result<(), TrafficError> {
        for InputFile { path, sha256, stamp: before } in &self.files {
            match stamp(path)? {
                None => return Err(altered(path, "was deleted")),
                Some(now) if now == *before => {}
                Some(_) if sha256_file(path)? == *sha256 => {
                    return Err(TrafficError::Disturbed(path.clone()));
                }
                Some(_) => return Err(altered(path, "was altered")),
            }
        }
        Ok(())
    }
}

fn altered(path: &Path, what: &'static str) -> TrafficError {
    TrafficError::Altered { path: path.to_path_buf(), what }
}

/// Returns the stamp of a file; `None` if there is none.
fn stamp(path: &Path) -> Result<Option<Stamp>, FileError> {
    let metadata = match fs::metadata(path) {
        Ok(metadata) => metadata,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(FileError::at("read", path)(e)),
    };
    Ok(Some(Stamp {
        device: metadata.dev(),
        inode: metadata.ino(),
        bytes: metadata.len(),
        modified: (metadata.mtime(), metadata.mtime_nsec()),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use basics::hash::sha256;

    /// A folder with a file that is held.
    fn held() -> (tempfile::TempDir, PathBuf, InputFiles) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.xml");
        fs::write(&path, "<a/>").unwrap();
        let mut held = InputFiles::default();
        held.keep(folder.path());
        held.add(&path, Some(&sha256(b"<a/>"))).unwrap();
        held.verify().unwrap();
        (folder, path, held)
    }

    #[test]
    fn a_file_that_was_deleted_is_named() {
        let (_folder, path, held) = held();
        fs::remove_file(&path).unwrap();
        let e = held.verify().unwrap_err().to_string();
        assert!(e.contains("a.xml: the file was deleted"), "{e}");
    }

    #[test]
    fn a_file_that_the_plan_does_not_have_or_has_otherwise_is_refused() {
        let (_folder, path, mut held) = held();
        for planned in [None, Some(&sha256(b"<b/>"))] {
            let e = held.add(&path, planned).unwrap_err();
            assert!(matches!(e, TrafficError::Altered { what: "was altered", .. }), "{e}");
        }
    }

    #[test]
    fn a_folder_that_is_kept_cannot_be_locked_by_others() {
        let (folder, _, held) = held();
        let other = File::open(folder.path()).unwrap();
        assert!(other.try_lock().is_err());
        drop(held);
        other.try_lock().unwrap();
    }
}

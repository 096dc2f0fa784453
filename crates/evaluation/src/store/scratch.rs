//! Folders for the files of running episodes, which outlive nobody: each is locked by the process that
//! works in it, so that whoever tidies up leaves those alone that are in use.

use std::fs::{self, File, TryLockError};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use super::Layout;
use super::lock::has_no_locks;
use basics::files::{self, FileError, beneath, make_folder_beneath};

/// Name of the file that is locked.
const LOCK: &str = ".lock";

/// Age from which on a folder that another machine works in is taken to be left behind: its locks may not show here.
const FOREIGN: Duration = Duration::from_secs(7 * 24 * 3600);

/// Age from which on a loose file is what a killed process left behind: writing one takes seconds.
const ABANDONED: Duration = Duration::from_secs(3600);

/// A folder of a task in `tmp/`, removed when it is dropped.
#[derive(Debug)]
pub struct Scratch {
    folder: tempfile::TempDir,
    _lock: File,
}

impl Scratch {
    /// Makes a folder for a task.
    pub fn new(layout: &Layout, task: usize) -> Result<Self, FileError> {
        let tmp = layout.tmp();
        make_folder_beneath(layout.root(), &tmp)?;
        let folder = tempfile::Builder::new()
            .prefix(&format!("{task}."))
            .tempdir_in(&tmp)
            .map_err(FileError::at("create", &tmp))?;
        let path = folder.path().join(LOCK);
        let mut lock = File::create(&path).map_err(FileError::at("create", &path))?;
        lock.write_all(host().as_bytes()).map_err(FileError::at("write", &path))?;
        match lock.lock() {
            Err(e) if !has_no_locks(&e) => return Err(FileError::at("lock", &path)(e)),
            _ => {}
        }
        Ok(Self { folder, _lock: lock })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// Removes what processes that were killed have left in `tmp/`.
pub fn tidy_up(layout: &Layout) -> Result<(), FileError> {
    let tmp = layout.tmp();
    beneath(layout.root(), &tmp)?;
    let Ok(entries) = fs::read_dir(&tmp) else { return Ok(()) };
    for entry in entries {
        let path = entry.map_err(FileError::at("read", &tmp))?.path();
        let removed = match path.is_dir() {
            true if is_in_use(&path) => continue,
            true => fs::remove_dir_all(&path),
            false if !is_older(&path, ABANDONED) => continue,
            false => fs::remove_file(&path),
        };
        match removed {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
                return Err(FileError::at("remove", &path)(e));
            }
            _ => {}
        }
    }
    Ok(())
}

/// Whether a process works in a folder, or has just made it and is about to lock it.
fn is_in_use(folder: &Path) -> bool {
    let lock: PathBuf = folder.join(LOCK);
    match files::open(&lock) {
        Ok(file) if is_foreign(&file) => !is_older(folder, FOREIGN),
        Ok(file) => match file.try_lock() {
            Err(TryLockError::WouldBlock) => true,
            Err(TryLockError::Error(_)) => !is_older(folder, FOREIGN),
            Ok(()) => false,
        },
        Err(_) => !is_older(folder, ABANDONED),
    }
}

/// Whether another machine holds the lock, which may not show here.
fn is_foreign(mut lock: &File) -> bool {
    let mut text = String::new();
    let read = lock.read_to_string(&mut text);
    read.is_ok() && !text.is_empty() && text != host()
}

/// Returns the name of this machine.
fn host() -> String {
    rustix::system::uname().nodename().to_string_lossy().into_owned()
}

fn is_older(path: &Path, limit: Duration) -> bool {
    let modified = fs::metadata(path).and_then(|m| m.modified());
    modified.is_ok_and(|at| SystemTime::now().duration_since(at).is_ok_and(|age| age > limit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_in_use_stays_and_one_that_was_left_goes() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        let used = Scratch::new(&layout, 1).unwrap();
        fs::write(used.path().join("routes.xml"), "<routes/>").unwrap();
        let left = layout.tmp().join("2.left");
        fs::create_dir(&left).unwrap();
        fs::write(left.join(LOCK), "").unwrap();
        let draft = layout.tmp().join("3.draft");
        fs::write(&draft, "").unwrap();
        tidy_up(&layout).unwrap();
        assert!(used.path().join("routes.xml").exists() && draft.exists() && !left.exists());
        let long_ago = SystemTime::now() - 2 * ABANDONED;
        File::options().write(true).open(&draft).unwrap().set_modified(long_ago).unwrap();
        tidy_up(&layout).unwrap();
        assert!(!draft.exists());
        let path = used.path().to_path_buf();
        drop(used);
        assert!(!path.exists());
    }

    #[test]
    fn the_folder_of_another_machine_is_left_alone_for_a_week() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        let folder = layout.tmp().join("1.elsewhere");
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join(LOCK), format!("not-{}", host())).unwrap();
        tidy_up(&layout).unwrap();
        assert!(folder.exists(), "its lock does not show here");
        let long_ago = SystemTime::now() - 2 * FOREIGN;
        File::open(&folder).unwrap().set_modified(long_ago).unwrap();
        tidy_up(&layout).unwrap();
        assert!(!folder.exists());
    }
}

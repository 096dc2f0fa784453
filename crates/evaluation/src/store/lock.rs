//! Keeps two runs from working on one directory.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Error, ErrorKind, Read};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::Path;
use std::thread;
use std::time::Duration;

use rustix::fs::OFlags;
use rustix::io::Errno;
use serde::{Deserialize, Serialize};

use super::Layout;
use crate::store::error::StoreError;
use basics::files::{FileError, beneath, new_beneath};

/// Most bytes that are read of it.
const HOLDER_BYTES: u64 = 4096;

/// Time after which a lock is asked for again.
const INSTANT: Duration = Duration::from_millis(20);

/// Who holds the lock, for people.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Holder {
    /// Process id.
    pub pid: u32,
    /// Version of tsc-family.
    pub version: String,
    /// Start, ISO 8601, UTC.
    pub started: String,
}

/// A held lock; the operating system releases it when the process ends, however it ends.
#[derive(Debug)]
pub struct RunLock {
    _file: File,
}

impl RunLock {
    /// Takes the lock of a results directory.
    ///
    /// The file says who holds it, and is not written in place: it may have a second name somewhere else. Whoever has
    /// its lock puts a new one there, locked before anybody can see it; whoever asked for the old one asks again.
    ///
    /// # Errors
    ///
    /// [`StoreError::Locked`] when another process has it.
    pub fn take(layout: &Layout, holder: &Holder) -> Result<Self, StoreError> {
        let path = layout.lock();
        let text = serde_json::to_vec(holder).expect("plain data");
        let mut asked = 0;
        let _old = loop {
            if !is_alone(&path)? {
                // Nobody can have locked it for this folder but one who is just putting a new one there.
                new_beneath(layout.root(), &path, &layout.tmp(), b"")?;
            }
            let mut file = open(layout, &path)?;
            match file.try_lock() {
                Ok(()) if is_at(&file, &path) => break file,
                // Another process has put a new one there.
                Ok(()) => {}
                // Whoever asks for the holder has it for an instant.
                Err(TryLockError::WouldBlock) if asked < 3 => thread::sleep(INSTANT),
                Err(TryLockError::WouldBlock) => {
                    let holder = describe(&mut file);
                    return Err(StoreError::Locked { path: layout.root().to_path_buf(), holder });
                }
                // Some file systems of a network have no locks. Two runs at a time leave the same records, only twice the work.
                Err(TryLockError::Error(e)) if has_no_locks(&e) => break file,
                Err(TryLockError::Error(e)) => return Err(FileError::at("lock", &path)(e).into()),
            }
            asked += 1;
        };
        Ok(Self { _file: new_beneath(layout.root(), &path, &layout.tmp(), &text)? })
    }
}

/// Whether a file has no other name; one that is not there yet has none.
fn is_alone(path: &Path) -> Result<bool, FileError> {
    match fs::symlink_metadata(path) {
        Ok(about) => Ok(about.nlink() <= 1),
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(true),
        Err(e) => Err(FileError::at("read", path)(e)),
    }
}

/// Opens the file to lock it, made where it is missing; locks of network file systems take one that is open for writing.
fn open(layout: &Layout, path: &Path) -> Result<File, FileError> {
    beneath(layout.root(), path)?;
    // Without `NONBLOCK`, a pipe without a reader would block.
    let flags = (OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::NOCTTY).bits();
    let failed = |e: Error| FileError::at("create", path)(e);
    let flags = i32::try_from(flags).map_err(|_| failed(ErrorKind::Unsupported.into()))?;
    let mut options = OpenOptions::new();
    options.read(true).write(true).create(true).truncate(false).custom_flags(flags);
    let file = options.open(path).map_err(failed)?;
    if !file.metadata().map_err(failed)?.is_file() {
        let reason = "a pipe or device stands in its place; remove it";
        return Err(failed(Error::new(ErrorKind::InvalidInput, reason)));
    }
    Ok(file)
}

/// Whether a file is still the one that a path leads to.
fn is_at(file: &File, path: &Path) -> bool {
    let of = |about: fs::Metadata| (about.dev(), about.ino());
    let there = fs::symlink_metadata(path).ok().map(of);
    there.is_some() && there == file.metadata().ok().map(of)
}

/// Returns who works on a results directory just now, in words; `None` where nobody does or that cannot be told.
pub fn holder(layout: &Layout) -> Option<String> {
    let mut file = File::open(layout.lock()).ok()?;
    match file.try_lock_shared() {
        Err(TryLockError::WouldBlock) => Some(describe(&mut file)),
        _ => None,
    }
}

/// Whether a file cannot be locked because its file system has no locks.
pub(super) fn has_no_locks(e: &std::io::Error) -> bool {
    let code = e.raw_os_error().map(rustix::io::Errno::from_raw_os_error);
    e.kind() == ErrorKind::Unsupported
        || code.is_some_and(|code| [Errno::NOLCK, Errno::NOSYS, Errno::OPNOTSUPP].contains(&code))
}

fn describe(file: &mut File) -> String {
    let mut text = String::new();
    match file
        .take(HOLDER_BYTES)
        .read_to_string(&mut text)
        .ok()
        .and_then(|_| serde_json::from_str(&text).ok())
    {
        Some(Holder { pid, started, .. }) => format!("process {pid}, started {started}"),
        None => "unknown process".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn holder() -> Holder {
        Holder { pid: 42, version: "0".into(), started: "2026-01-01T00:00:00Z".into() }
    }

    #[test]
    fn a_second_lock_is_refused_and_names_the_holder() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        let _first = RunLock::take(&layout, &holder()).unwrap();
        let e = RunLock::take(&layout, &holder()).unwrap_err().to_string();
        assert!(e.contains("process 42, started 2026-01-01T00:00:00Z"), "{e}");
    }

    #[test]
    fn a_lock_with_a_second_name_is_replaced_and_still_keeps_others_out() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path().join("results"));
        layout.make().unwrap();
        let other = dir.path().join("precious");
        fs::write(&other, "precious").unwrap();
        fs::hard_link(&other, layout.lock()).unwrap();
        let _first = RunLock::take(&layout, &holder()).unwrap();
        assert_eq!(fs::read_to_string(&other).unwrap(), "precious");
        let e = RunLock::take(&layout, &holder()).unwrap_err().to_string();
        assert!(e.contains("process 42"), "{e}");
        // What `cp -rl` makes of it while it is held.
        fs::remove_file(&other).unwrap();
        fs::hard_link(layout.lock(), &other).unwrap();
        drop(_first);
        let _second = RunLock::take(&layout, &Holder { pid: 43, ..holder() }).unwrap();
        assert!(fs::read_to_string(&other).unwrap().contains("42"));
        assert!(super::holder(&layout).unwrap().contains("process 43"));
    }

    #[test]
    fn a_pipe_in_place_of_the_lock_is_refused_and_does_not_block() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        let made = std::process::Command::new("mkfifo").arg(layout.lock()).status().unwrap();
        assert!(made.success());
        let e = RunLock::take(&layout, &holder()).unwrap_err().to_string();
        assert!(e.contains("a pipe or device stands in its place; remove it"), "{e}");
    }

    #[test]
    fn a_released_lock_can_be_taken_again() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        drop(RunLock::take(&layout, &holder()).unwrap());
        RunLock::take(&layout, &holder()).unwrap();
    }
}

//! Keeps two runs from working on one directory.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Error, ErrorKind, Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::thread;
use std::time::Duration;

use rustix::fs::OFlags;
use rustix::io::Errno;
use serde_json::{Value, json};

use super::Layout;
use crate::store::error::StoreError;
use basics::files::{FileError, beneath};

/// Most bytes that are read of it.
const HOLDER_BYTES: u64 = 4096;

/// Time after which a lock is asked for again.
const INSTANT: Duration = Duration::from_millis(20);

/// Takes the lock of a results directory for a run that was started then; the operating system releases it when the file is
/// closed or the process ends, however it ends.
///
/// # Errors
///
/// [`StoreError::Locked`] when another process has it.
pub fn take(layout: &Layout, started: &str) -> Result<File, StoreError> {
    let path = layout.lock();
    beneath(layout.root(), &path)?;
    let failed = |e: Error| FileError::at("lock", &path)(e);
    // Locks of network file systems take a file that is open for writing; without `NONBLOCK`, a pipe in its place would
    // block.
    let flags = (OFlags::NOFOLLOW | OFlags::NONBLOCK).bits().cast_signed();
    let mut options = OpenOptions::new();
    options.read(true).write(true).create(true).truncate(false).custom_flags(flags);
    let mut file = options.open(&path).map_err(failed)?;
    for asked in 0.. {
        match file.try_lock() {
            Ok(()) => break,
            // Whoever asks for the holder has it for an instant.
            Err(TryLockError::WouldBlock) if asked < 3 => thread::sleep(INSTANT),
            Err(TryLockError::WouldBlock) => {
                let holder = describe(&mut file);
                return Err(StoreError::Locked { path: layout.root().to_path_buf(), holder });
            }
            // Some file systems of a network have no locks. Two runs at a time leave the same records, only twice the work.
            Err(TryLockError::Error(e)) if has_no_locks(&e) => break,
            Err(TryLockError::Error(e)) => return Err(failed(e).into()),
        }
    }
    let (pid, version) = (std::process::id(), env!("CARGO_PKG_VERSION"));
    let text = json!({"pid": pid, "version": version, "started": started}).to_string();
    file.set_len(0).and_then(|()| file.write_all(text.as_bytes())).map_err(failed)?;
    Ok(file)
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
    let read = file.take(HOLDER_BYTES).read_to_string(&mut text);
    let said: Value = read.ok().and_then(|_| serde_json::from_str(&text).ok()).unwrap_or_default();
    match (said["pid"].as_u64(), said["started"].as_str()) {
        (Some(pid), Some(started)) => format!("process {pid}, started {started}"),
        _ => "unknown process".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_lock_is_refused_and_names_the_holder() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        let _first = take(&layout, "2026-01-01T00:00:00Z").unwrap();
        let e = take(&layout, "2026-01-01T00:00:00Z").unwrap_err().to_string();
        assert!(e.contains(", started 2026-01-01T00:00:00Z"), "{e}");
    }
}

//! Opening files that people name: regular ones only, never so large that memory ends.
//!
//! A pipe without a writer would block, a device may have no end, and what a pipe holds can be read only
//! once while hashes and messages read a file again.

use std::fs::{File, OpenOptions};
use std::io::{Error, ErrorKind, Read, Result};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

use rustix::fs::OFlags;

/// Most bytes of a table that is read into memory.
pub const TABLE_BYTES: u64 = 1 << 30;

/// Opens a regular file and returns it with its size, bytes.
/// The error is the system's, or what it is instead of a regular file and the way out.
pub fn open(path: &Path) -> Result<(File, u64)> {
    let flags = (OFlags::NONBLOCK | OFlags::NOCTTY).bits().cast_signed();
    let file = OpenOptions::new().read(true).custom_flags(flags).open(path)?;
    let about = file.metadata()?;
    if about.is_file() {
        return Ok((file, about.len()));
    }
    let what = if about.is_dir() { "a folder" } else { "a pipe or device" };
    Err(Error::new(ErrorKind::InvalidInput, format!("it is {what}; give a regular file")))
}

/// Returns the bytes of a regular file that has at most so many.
/// Fails as [`open`], and when the file is larger.
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>> {
    let (file, size) = open(path)?;
    let mut bytes = Vec::new();
    if size <= most {
        bytes.try_reserve_exact(usize::try_from(size).unwrap_or(usize::MAX))?;
        // A file may grow while it is read.
        file.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    }
    if size.max(bytes.len() as u64) > most {
        let reason = format!("it has more than {most} bytes; give a smaller file");
        return Err(Error::new(ErrorKind::FileTooLarge, reason));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    #[test]
    fn what_is_no_regular_file_or_beyond_its_limit_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let [file, pipe] = ["file", "pipe"].map(|name| folder.path().join(name));
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        std::fs::write(&file, "0123456789").unwrap();
        assert_eq!(read(&file, 10).unwrap(), b"0123456789");
        let kind = |path: &Path, most| read(path, most).unwrap_err().kind();
        assert_eq!(kind(&file, 9), ErrorKind::FileTooLarge);
        for path in [&pipe, folder.path(), Path::new("/dev/zero")] {
            assert_eq!(kind(path, 9), ErrorKind::InvalidInput);
        }
    }
}

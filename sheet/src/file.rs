//! Opening files that people name: regular ones only, never so large that memory ends.
//!
//! A pipe without a writer would block, a device may have no end, and what a pipe holds can be read only
//! once while hashes and messages read a file again. So all of them are refused by name, before they are
//! opened and, should something have been exchanged meanwhile, once more when they are. A link to a
//! regular file is one, and so is `/dev/stdin` after `< FILE`.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{Error, ErrorKind, Read, Result};
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;

use rustix::fs::OFlags;

/// Most bytes of a table that is read into memory.
pub const TABLE_BYTES: u64 = 1 << 30;

/// Opens a regular file and returns it with its size, bytes.
///
/// # Errors
///
/// The system's, or what it is instead of a regular file and the way out.
pub fn open(path: &Path) -> Result<(File, u64)> {
    regular(&fs::metadata(path)?)?;
    let flags = (OFlags::NONBLOCK | OFlags::NOCTTY).bits();
    let flags = i32::try_from(flags).map_err(|_| Error::from(ErrorKind::Unsupported))?;
    let file = OpenOptions::new().read(true).custom_flags(flags).open(path)?;
    let about = file.metadata()?;
    regular(&about)?;
    Ok((file, about.len()))
}

/// Returns the bytes of a regular file that has at most so many.
///
/// # Errors
///
/// As [`open`], and when the file is larger.
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>> {
    let (file, size) = open(path)?;
    let refused = |size: u64| {
        let reason = format!(
            "it has {size} bytes, but at most {most} are read of such a file; give a smaller one"
        );
        Err(Error::new(ErrorKind::FileTooLarge, reason))
    };
    if size > most {
        return refused(size);
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(usize::try_from(size).unwrap_or(usize::MAX))?;
    // A file may grow while it is read.
    file.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    match bytes.len() as u64 {
        size if size > most => refused(size),
        _ => Ok(bytes),
    }
}

/// Refuses what is no regular file.
fn regular(about: &Metadata) -> Result<()> {
    let kind = about.file_type();
    let (error, what) = match () {
        () if kind.is_file() => return Ok(()),
        () if kind.is_dir() => (ErrorKind::IsADirectory, "a folder; give a regular file"),
        () if kind.is_fifo() => (
            ErrorKind::InvalidInput,
            "a pipe, which can be read only once; write its content to a file and give that",
        ),
        () if kind.is_socket() => (ErrorKind::InvalidInput, "a socket; give a regular file"),
        () => (ErrorKind::InvalidInput, "a device; give a regular file"),
    };
    Err(Error::new(error, format!("it is {what}")))
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;
    use std::os::unix::net::UnixListener;
    use std::process::Command;

    use super::*;

    fn refused(path: &Path) -> String {
        let [opened, read] = [open(path).map(drop), read(path, 9).map(drop)];
        let [opened, read] = [opened, read].map(|result| result.unwrap_err().to_string());
        assert_eq!(opened, read);
        opened
    }

    #[test]
    fn what_is_no_regular_file_is_refused_at_once_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        assert!(Command::new("mkfifo").arg(at("pipe")).status().unwrap().success());
        let _socket = UnixListener::bind(at("socket")).unwrap();
        for (name, to) in [("zeros", "/dev/zero"), ("to-pipe", "pipe"), ("nowhere", "missing")] {
            symlink(to, at(name)).unwrap();
        }
        let pipe =
            "it is a pipe, which can be read only once; write its content to a file and give that";
        assert_eq!([refused(&at("pipe")), refused(&at("to-pipe"))], [pipe, pipe]);
        assert_eq!(refused(&at("socket")), "it is a socket; give a regular file");
        assert_eq!(refused(&at("zeros")), "it is a device; give a regular file");
        assert_eq!(refused(folder.path()), "it is a folder; give a regular file");
        assert!(refused(&at("nowhere")).starts_with("No such file"));
    }

    #[test]
    fn a_file_is_read_through_a_link_and_refused_beyond_its_limit() {
        let folder = tempfile::tempdir().unwrap();
        let [file, link] = ["file", "link"].map(|name| folder.path().join(name));
        fs::write(&file, "0123456789").unwrap();
        symlink(&file, &link).unwrap();
        assert_eq!(read(&link, 10).unwrap(), b"0123456789");
        let e = read(&link, 9).unwrap_err();
        assert_eq!(e.kind(), ErrorKind::FileTooLarge);
        assert_eq!(
            e.to_string(),
            "it has 10 bytes, but at most 9 are read of such a file; give a smaller one"
        );
        // Nothing is allocated for a hole of a terabyte.
        File::options().write(true).open(&file).unwrap().set_len(1 << 40).unwrap();
        assert_eq!(read(&link, TABLE_BYTES).unwrap_err().kind(), ErrorKind::FileTooLarge);
    }
}

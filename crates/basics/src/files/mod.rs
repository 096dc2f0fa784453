//! Files that are read whole, and files that are either as before or complete.

pub mod beneath;
mod draft;
pub mod limits;
pub mod numbers;
mod rows;
mod shell;

use std::fs::File;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

pub use beneath::{beneath, make_folder, make_folder_beneath};
pub use draft::{new_beneath, readable, replace, write_atomically};
pub use rows::lines;
pub use shell::quoted;

/// A file operation that failed, with the file's name.
#[derive(Debug, thiserror::Error)]
#[error("cannot {action} {}: {reason}", .path.display())]
pub struct FileError {
    /// What was tried: `read`, `write`, `create`, ...
    pub action: &'static str,
    /// The file or directory.
    pub path: PathBuf,
    /// The operating system's reason; part of the message, so it is no source of its own.
    pub reason: io::Error,
}

impl FileError {
    /// Returns a closure for `map_err` that adds the action and the path.
    pub fn at(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_path_buf();
        move |reason| Self { action, path, reason }
    }
}

/// Opens a file that somebody named; see [`sheet::file::open`].
pub fn open(path: &Path) -> Result<File, FileError> {
    sheet::file::open(path).map(|(file, _)| file).map_err(FileError::at("read", path))
}

/// Returns the bytes of a file that somebody named, which has at most so many; see [`sheet::file::read`].
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>, FileError> {
    sheet::file::read(path, most).map_err(FileError::at("read", path))
}

/// Returns the text of a file that somebody named.
/// Fails as [`read`]; of the kind [`ErrorKind::InvalidData`] where it is no text in UTF-8.
pub fn read_text(path: &Path, most: u64) -> Result<String, FileError> {
    let no_text = |_| io::Error::new(ErrorKind::InvalidData, "it is no text in UTF-8");
    String::from_utf8(read(path, most)?).map_err(no_text).map_err(FileError::at("read", path))
}

/// Returns what is read of a file; `None` where there is none.
pub fn if_present<T>(read: Result<T, FileError>) -> Result<Option<T>, FileError> {
    let absent = |e: &FileError| e.reason.kind() == ErrorKind::NotFound;
    read.map(Some).or_else(|e| if absent(&e) { Ok(None) } else { Err(e) })
}

//! Opening an extract by its name.

use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;

use super::format::{Format, HEAD_BYTES, agreed};
use super::{Progress, read_gz, read_pbf, read_xml};
use crate::OsmError;
use crate::extract::Extract;

/// Reads what is needed of an extract: `.osm.pbf`, `.osm` or `.osm.gz`.
///
/// # Errors
///
/// [`OsmError::Format`] when the content is not what the name promises or the name promises
/// nothing that is read, [`OsmError::Damaged`] and [`OsmError::Malformed`] when it cannot be read
/// to its end, [`OsmError::Nothing`] without any drivable way, [`OsmError::Unreadable`] when the file
/// cannot be read.
pub fn read(path: &Path, progress: Progress<'_>) -> Result<Extract, OsmError> {
    let (mut file, size) = open(path)?;
    let mut head = Vec::new();
    (&mut file)
        .take(HEAD_BYTES as u64)
        .read_to_end(&mut head)
        .and_then(|_| file.rewind())
        .map_err(OsmError::unreadable(path))?;
    match agreed(path, &head)? {
        Format::Pbf => read_pbf(path, &mut file, progress),
        Format::Xml => read_xml(path, size, || again(path), progress),
        Format::Gzip => read_gz(path, size, || again(path), progress),
    }
}

/// Opens a file once more.
fn again(path: &Path) -> std::io::Result<File> {
    sheet::file::open(path).map(|(file, _)| file)
}

/// Opens a file that can be read twice and returns its size.
fn open(path: &Path) -> Result<(File, u64), OsmError> {
    sheet::file::open(path).map_err(OsmError::unreadable(path))
}

//! Reading of OpenStreetMap files: PBF, XML and gzipped XML.
//!
//! PBF is read in two passes: the first keeps drivable ways and turn restrictions, the second finds where the nodes on
//! those ways are, and the signals. Of XML, all nodes are kept until its ways are known.
//!
//! Choices where readers differ:
//! - **Bad data** is no panic: a damaged file is an error with the byte, a strange element is
//!   skipped and counted in [`Extract::oddities`](super::extract::Extract::oddities).
//! - **Two elements with one id**: the later one in the file wins; both formats count them.
//! - **The same data gives the same extract**, whatever the format and the number of threads.
//!
//! Source: <https://wiki.openstreetmap.org/wiki/PBF_Format>, <https://wiki.openstreetmap.org/wiki/OSM_XML>.

#[cfg(test)]
mod bad;
mod collect;
mod pbf;
#[cfg(test)]
mod properties;
#[cfg(test)]
mod sample;
#[cfg(test)]
mod tests;
mod turns;
mod xml;

use std::io::{Read, Seek};
use std::path::Path;

use crate::OsmError;
use crate::extract::Extract;
pub use pbf::read_pbf;
pub use xml::read_xml;

/// Bytes that suffice to recognise a format.
const HEAD_BYTES: usize = 512;

/// Why a part of a PBF file cannot be used, before its place is known.
type Fault = String;

/// Told how many bytes are done of how many in all.
pub type Progress<'a> = &'a (dyn Fn(u64, u64) + Sync);

/// Reads what is needed of an extract: `.osm.pbf`, `.osm` or `.osm.gz`, whatever its name.
///
/// [`OsmError::Damaged`] when it cannot be read to its end, [`OsmError::Nothing`] when it is something else or has no
/// drivable way, [`OsmError::Unreadable`] when the file cannot be read.
pub fn read(path: &Path, progress: Progress<'_>) -> Result<Extract, OsmError> {
    let (mut file, size) = sheet::file::open(path).map_err(OsmError::unreadable(path))?;
    let mut head = Vec::new();
    let read = (&mut file).take(HEAD_BYTES as u64).read_to_end(&mut head);
    read.and_then(|_| file.rewind()).map_err(OsmError::unreadable(path))?;
    match Format::of(path, &head)? {
        Format::Pbf => read_pbf(path, &mut file, progress),
        Format::Xml | Format::Gzip => read_xml(path, size, file, progress),
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Pbf,
    Xml,
    Gzip,
}

impl Format {
    fn of(path: &Path, head: &[u8]) -> Result<Self, OsmError> {
        let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
        match head {
            [] => Err(nothing(path, "the file is empty; fetch it again")),
            [0x1f, 0x8b, ..] => Ok(Self::Gzip),
            [0, 0, ..] if head.windows(9).any(|bytes| bytes == b"OSMHeader") => Ok(Self::Pbf),
            _ if text.trim_ascii_start().starts_with(b"<") => Ok(Self::Xml),
            _ => Err(no_extract(path)),
        }
    }
}

fn no_extract(path: &Path) -> OsmError {
    nothing(path, "no OpenStreetMap extract; give .osm.pbf, .osm or .osm.gz")
}

fn no_streets(path: &Path) -> OsmError {
    nothing(
        path,
        "no drivable street in it; take an extract with the ways tagged `highway` and their nodes",
    )
}

fn nothing(path: &Path, reason: &str) -> OsmError {
    OsmError::Nothing { path: path.to_path_buf(), reason: reason.to_owned() }
}

fn damaged(path: &Path, byte: u64, reason: Fault) -> OsmError {
    OsmError::Damaged { path: path.to_path_buf(), byte, reason }
}

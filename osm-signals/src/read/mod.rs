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
//! Source: <https://wiki.openstreetmap.org/wiki/PBF_Format>,
//! <https://wiki.openstreetmap.org/wiki/OSM_XML>.

#[cfg(test)]
mod bad;
mod block;
mod collect;
mod fault;
mod format;
mod frame;
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
use fault::Fault;
use format::{Format, HEAD_BYTES};
pub use pbf::read_pbf;
pub use xml::read_xml;

/// Told how many bytes are done of how many in all.
pub type Progress<'a> = &'a (dyn Fn(u64, u64) + Sync);

/// Reads what is needed of an extract: `.osm.pbf`, `.osm` or `.osm.gz`, whatever its name.
///
/// # Errors
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

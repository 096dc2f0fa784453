//! Reading of OpenStreetMap files: PBF, XML and gzipped XML, in two passes.
//!
//! The first pass keeps drivable ways and turn restrictions, the second finds where the nodes on
//! those ways are, and the signals. What lies in memory is what is kept and a bounded part of the
//! file.
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
mod file;
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
mod wire;
mod xml;
mod xml_elements;
mod xml_source;

use fault::Fault;
pub use file::read;
pub use pbf::read_pbf;
pub use xml::{read_gz, read_xml};

/// Told how many bytes are done of how many in all; a file is read twice, so that counts double.
pub type Progress<'a> = &'a (dyn Fn(u64, u64) + Sync);

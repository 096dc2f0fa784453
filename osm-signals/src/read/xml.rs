//! The two passes over an XML file, plain or gzipped.

use std::io::{self, Read};
use std::path::Path;

use super::Progress;
use super::collect::{Places, Streets, complete};
use super::fault::{no_streets, placed};
use super::format::Format;
use super::turns::Kind;
use super::xml_elements::Elements;
use crate::OsmError;
use crate::extract::{Extract, Place};

/// Bytes after which the progress is told.
const TELL_BYTES: u64 = 1024 * 1024;

/// Reads what is needed of an XML file, which `open` opens twice; `size` is in bytes, `path` is
/// for messages only.
///
/// # Errors
///
/// [`OsmError::Format`] when it is no OpenStreetMap XML, [`OsmError::Damaged`] when it cannot be
/// read to its end, [`OsmError::Malformed`] in another encoding than UTF-8, [`OsmError::Nothing`]
/// without any drivable way or any place of one, [`OsmError::Unreadable`] when reading fails.
pub fn read_xml<R: Read>(
    path: &Path,
    size: u64,
    open: impl Fn() -> io::Result<R>,
    progress: Progress<'_>,
) -> Result<Extract, OsmError> {
    passes(path, size, Format::Xml, open, progress)
}

/// Reads what is needed of a gzipped XML file, like [`read_xml`]; several gzip files one after the
/// other are read as one.
///
/// # Errors
///
/// Those of [`read_xml`].
pub fn read_gz<R: Read>(
    path: &Path,
    size: u64,
    open: impl Fn() -> io::Result<R>,
    progress: Progress<'_>,
) -> Result<Extract, OsmError> {
    passes(path, size, Format::Gzip, open, progress)
}

fn passes<R: Read>(
    path: &Path,
    size: u64,
    format: Format,
    open: impl Fn() -> io::Result<R>,
    progress: Progress<'_>,
) -> Result<Extract, OsmError> {
    let in_all = 2 * size;
    progress(0, in_all);
    let mut told = 0;
    let mut tell = |byte: u64| {
        if byte >= told + TELL_BYTES {
            told = byte;
            progress(byte.min(in_all), in_all);
        }
    };

    let mut streets = Streets::default();
    let mut elements = Elements::open(path, format, &open)?;
    while let Some(element) = elements.next(|kind| kind != Kind::Node)? {
        tell(elements.byte());
        if element.kind == Kind::Way {
            streets.way(element.id, &element.tags(), &element.refs);
        } else {
            streets.relation(element.id, &element.tags(), &element.members());
        }
    }
    // The second pass ends after the last node, which mostly comes before the first way.
    let last_node = elements.last_node();
    let mut extract = streets.finish();
    extract.oddities.merge(elements.into_oddities());
    if extract.ways.is_empty() {
        return Err(no_streets(path));
    }

    let mut elements = Elements::open(path, format, &open)?;
    while elements.seen() < last_node
        && let Some(node) = elements.next(|kind| kind == Kind::Node)?
    {
        tell(size + elements.byte());
        let mut places = Places::default();
        let place = || Place::from_degrees(node.latitude, node.longitude);
        places.node(&extract.nodes, node.id, &node.tags(), place);
        places.put(&mut extract);
    }
    extract.oddities.merge(elements.into_oddities());
    complete(&mut extract);
    progress(in_all, in_all);
    placed(path, extract)
}

//! What a file is, by its first bytes.

use std::path::Path;

use crate::OsmError;

/// Bytes that suffice to recognise a format.
pub(super) const HEAD_BYTES: usize = 512;

/// A format that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Pbf,
    Xml,
    Gzip,
}

impl Format {
    /// Returns the format of a file that begins like this.
    pub(super) fn of(path: &Path, head: &[u8]) -> Result<Self, OsmError> {
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

/// Returns the error for a file that is something else.
pub(super) fn no_extract(path: &Path) -> OsmError {
    nothing(path, "no OpenStreetMap extract; give .osm.pbf, .osm or .osm.gz")
}

/// Returns the error for an extract without streets.
pub(super) fn no_streets(path: &Path) -> OsmError {
    nothing(
        path,
        "no drivable street in it; take an extract with the ways tagged `highway` and their nodes",
    )
}

pub(super) fn nothing(path: &Path, reason: &str) -> OsmError {
    OsmError::Nothing { path: path.to_path_buf(), reason: reason.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_bytes_give_the_format() {
        for (head, format) in [
            (&b"\0\0\0\x0e\x0a\x09OSMHeader\x18\x40"[..], Some(Format::Pbf)),
            (b"\xef\xbb\xbf\n<?xml version='1.0'?><osm>", Some(Format::Xml)),
            (b"\x1f\x8b\x08", Some(Format::Gzip)),
            (b"PK\x03\x04", None),
            (b"{\"version\": 0.6}", None),
            (b"", None),
        ] {
            assert_eq!(Format::of(Path::new("a.osm"), head).ok(), format, "{head:?}");
        }
    }
}

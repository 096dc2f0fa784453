//! What a file's name promises and what its first bytes say it holds.

use std::path::Path;

use crate::OsmError;

/// Bytes that suffice to recognise a format.
pub(super) const HEAD_BYTES: usize = 512;

/// Endings of names that are read.
const ENDINGS: [(&str, Format); 6] = [
    (".osm.pbf", Format::Pbf),
    (".pbf", Format::Pbf),
    (".osm.gz", Format::Gzip),
    (".xml.gz", Format::Gzip),
    (".osm", Format::Xml),
    (".xml", Format::Xml),
];

/// A format that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    /// OpenStreetMap's binary format.
    Pbf,
    /// OpenStreetMap's XML.
    Xml,
    /// The same, compressed by gzip.
    Gzip,
}

impl Format {
    /// Returns what the name of a file promises.
    pub(super) fn promised(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_string_lossy().to_lowercase();
        ENDINGS.iter().find(|(ending, _)| name.ends_with(ending)).map(|(_, format)| *format)
    }

    fn name(self) -> &'static str {
        match self {
            Self::Pbf => "OpenStreetMap PBF",
            Self::Xml => "OpenStreetMap XML",
            Self::Gzip => "gzipped OpenStreetMap XML",
        }
    }

    fn ending(self) -> &'static str {
        match self {
            Self::Pbf => ".osm.pbf",
            Self::Xml => ".osm",
            Self::Gzip => ".osm.gz",
        }
    }
}

/// What the first bytes of a file say that it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Content {
    /// A format that is read, as far as the first bytes tell.
    Known(Format),
    /// Nothing at all.
    Empty,
    /// Something else: what it is and how to make it readable.
    Other(&'static str, &'static str),
}

/// First bytes of formats that are not read, what they are and the way out.
const OTHERS: [(&[u8], &str, &str); 13] = [
    (b"BZh", "bzip2 data", "decompress it with `bunzip2`"),
    (b"PK\x03\x04", "a zip archive", "unpack it and give the extract in it"),
    (b"\xfd7zXZ\0", "xz data", "decompress it with `unxz`"),
    (b"\x28\xb5\x2f\xfd", "zstd data", "decompress it with `unzstd`"),
    (b"7z\xbc\xaf\x27\x1c", "a 7-Zip archive", "unpack it and give the extract in it"),
    (b"\xff\xe0\x04o5m2", "o5m data", "convert it with `osmconvert` or `osmium cat` to .osm.pbf"),
    (b"\xff\xe0\x04o5c2", "o5c changes", "apply them to an extract and give that"),
    (b"\xff\xfe", "text in UTF-16", "convert it to UTF-8 with `iconv`"),
    (b"\xfe\xff", "text in UTF-16", "convert it to UTF-8 with `iconv`"),
    (b"{", "JSON", "ask for XML, which Overpass calls `[out:xml]`"),
    (b"[Network]", "a network in UTDF", "give it with `build-networks --utdf`"),
    (b"[", "JSON", "ask for XML, which Overpass calls `[out:xml]`"),
    (b"SQLite format 3\0", "an SQLite database", "give the extract that it was made from"),
];

/// Byte order mark of UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

impl Content {
    /// Returns what a file with these first bytes holds.
    pub(super) fn of(head: &[u8]) -> Self {
        if head.is_empty() {
            return Self::Empty;
        }
        if head.starts_with(b"\x1f\x8b") {
            return Self::Known(Format::Gzip);
        }
        let other = OTHERS.iter().find(|(magic, ..)| head.starts_with(magic));
        if let Some((_, what, way_out)) = other {
            return Self::Other(what, way_out);
        }
        // A length, then a blob header of fields in any order.
        let header = head.get(4..).unwrap_or_default();
        if head.starts_with(&[0, 0]) && header.windows(9).any(|bytes| bytes == b"OSMHeader") {
            return Self::Known(Format::Pbf);
        }
        if without_mark(head).trim_ascii_start().starts_with(b"<") {
            return Self::Known(Format::Xml);
        }
        Self::Other("something unknown", "look at where it came from")
    }

    fn name(self) -> &'static str {
        match self {
            Self::Known(Format::Gzip) => "gzipped data",
            Self::Known(Format::Xml) => "XML",
            Self::Known(format) => format.name(),
            Self::Empty => "nothing",
            Self::Other(what, _) => what,
        }
    }
}

/// Returns text without its byte order mark.
pub(super) fn without_mark(text: &[u8]) -> &[u8] {
    text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text)
}

/// Returns the format of a file if its name and its content agree.
pub(super) fn agreed(path: &Path, head: &[u8]) -> Result<Format, OsmError> {
    match (Format::promised(path), Content::of(head)) {
        (Some(promised), content) => expect(path, promised, content).map(|()| promised),
        (None, content) => Err(disagreement(path, None, content)),
    }
}

/// Refuses content other than what is expected.
pub(super) fn expect(path: &Path, expected: Format, content: Content) -> Result<(), OsmError> {
    if content == Content::Known(expected) {
        return Ok(());
    }
    Err(disagreement(path, Some(expected), content))
}

/// Refuses other text than XML in a file, which is gzipped if its format says so.
pub(super) fn expect_xml(path: &Path, format: Format, text: &[u8]) -> Result<(), OsmError> {
    let content = Content::of(text);
    if content == Content::Known(Format::Xml) {
        return Ok(());
    }
    Err(match disagreement(path, Some(format), content) {
        OsmError::Format { path, found, expected, way_out } if format == Format::Gzip => {
            let way_out = format!("decompress it with `gunzip`, then {way_out}");
            OsmError::Format { path, found, expected, way_out }
        }
        other => other,
    })
}

/// Refuses XML whose root element is not that of an extract.
pub(super) fn expect_root(path: &Path, format: Format, root: &str) -> Result<(), OsmError> {
    let (found, way_out) = match root {
        "osm" => return Ok(()),
        "osmChange" => (
            "changes (osmChange), no extract",
            "apply them with `osmium apply-changes` and give the outcome".to_owned(),
        ),
        "html" | "HTML" => {
            let way_out = "open it in a browser, it may say why no extract was sent".to_owned();
            ("a web page", way_out)
        }
        _ => (
            "XML that is not OpenStreetMap's",
            format!("its root element is `{root}`, that of an extract is `osm`"),
        ),
    };
    let path = path.to_path_buf();
    Err(OsmError::Format { path, found, expected: format.name(), way_out })
}

fn disagreement(path: &Path, promised: Option<Format>, content: Content) -> OsmError {
    let read = "read are .osm.pbf, .pbf, .osm, .xml, .osm.gz and .xml.gz";
    let way_out = match (content, promised) {
        (Content::Empty, _) => {
            let reason = "the file is empty; fetch it again".to_owned();
            return OsmError::Nothing { path: path.to_path_buf(), reason };
        }
        (Content::Known(Format::Gzip), Some(Format::Pbf | Format::Gzip)) => {
            "decompress it with `gunzip`".to_owned()
        }
        (Content::Known(format), Some(_)) => format!("rename it to end in {}", format.ending()),
        (Content::Known(format), None) => {
            format!("rename it to end in {} ({read})", format.ending())
        }
        (Content::Other(_, way_out), Some(_)) => way_out.to_owned(),
        (Content::Other(_, way_out), None) => format!("{way_out} ({read})"),
    };
    OsmError::Format {
        path: path.to_path_buf(),
        found: content.name(),
        expected: promised.map_or("no format that is read", Format::name),
        way_out,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PBF: &[u8] = b"\0\0\0\x0e\x0a\x09OSMHeader\x18\x40";
    const XML: &[u8] = b"\xef\xbb\xbf\n<?xml version='1.0'?><osm>";
    const GZIP: &[u8] = b"\x1f\x8b\x08";

    fn message(name: &str, head: &[u8]) -> String {
        agreed(Path::new(name), head).unwrap_err().to_string()
    }

    #[test]
    fn name_and_content_that_agree_give_the_format() {
        for (name, head, format) in [
            ("utah.osm.pbf", PBF, Format::Pbf),
            ("UTAH.PBF", PBF, Format::Pbf),
            ("map.osm", XML, Format::Xml),
            ("map.xml", b"<osm/>", Format::Xml),
            ("map.osm.gz", GZIP, Format::Gzip),
        ] {
            assert_eq!(agreed(Path::new(name), head).unwrap(), format, "{name}");
        }
    }

    #[test]
    fn a_wrong_name_is_told_with_the_way_out() {
        insta::assert_snapshot!(
            [
                message("a.osm.pbf", XML),
                message("a.osm.pbf", GZIP),
                message("a.osm", GZIP),
                message("a.osm", PBF),
                message("a.osm.gz", PBF),
                message("a.osm.gz", b"BZh91AY"),
                message("a.osm", b"{\"version\": 0.6}"),
                message("a.osm", b"\xff\xfe<\0"),
                message("a.osm", b"nonsense"),
                message("a.osm", b""),
                message("a.dat", PBF),
                message("a.zip", b"PK\x03\x04"),
                message("a.o5m", b"\xff\xe0\x04o5m2"),
                message("a", b"nonsense"),
            ]
            .join("\n"),
            @r"
        a.osm.pbf: holds XML, but its name promises OpenStreetMap PBF; rename it to end in .osm
        a.osm.pbf: holds gzipped data, but its name promises OpenStreetMap PBF; decompress it with `gunzip`
        a.osm: holds gzipped data, but its name promises OpenStreetMap XML; rename it to end in .osm.gz
        a.osm: holds OpenStreetMap PBF, but its name promises OpenStreetMap XML; rename it to end in .osm.pbf
        a.osm.gz: holds OpenStreetMap PBF, but its name promises gzipped OpenStreetMap XML; rename it to end in .osm.pbf
        a.osm.gz: holds bzip2 data, but its name promises gzipped OpenStreetMap XML; decompress it with `bunzip2`
        a.osm: holds JSON, but its name promises OpenStreetMap XML; ask for XML, which Overpass calls `[out:xml]`
        a.osm: holds text in UTF-16, but its name promises OpenStreetMap XML; convert it to UTF-8 with `iconv`
        a.osm: holds something unknown, but its name promises OpenStreetMap XML; look at where it came from
        a.osm: the file is empty; fetch it again
        a.dat: holds OpenStreetMap PBF, but its name promises no format that is read; rename it to end in .osm.pbf (read are .osm.pbf, .pbf, .osm, .xml, .osm.gz and .xml.gz)
        a.zip: holds a zip archive, but its name promises no format that is read; unpack it and give the extract in it (read are .osm.pbf, .pbf, .osm, .xml, .osm.gz and .xml.gz)
        a.o5m: holds o5m data, but its name promises no format that is read; convert it with `osmconvert` or `osmium cat` to .osm.pbf (read are .osm.pbf, .pbf, .osm, .xml, .osm.gz and .xml.gz)
        a: holds something unknown, but its name promises no format that is read; look at where it came from (read are .osm.pbf, .pbf, .osm, .xml, .osm.gz and .xml.gz)
        "
        );
    }
}

//! Readers of maps and of what a city knows.

use std::io::Cursor;
use std::path::Path;

use osm_signals::OsmError;
use osm_signals::boundary::Boundary;
use osm_signals::counts::{CountSettings, Counts};
use osm_signals::extract::Place;
use osm_signals::read::{read_pbf, read_xml};
use osm_signals::signals::{SignalColumns, SignalList};

/// A block with streets, without which there is no second pass.
const STREETS: &[u8] = include_bytes!("../seeds/pbf/block-ways");

/// A PBF file, and a block of one.
pub(crate) fn pbf(bytes: &[u8]) {
    read_as_pbf(bytes);
    // A block within a file is what compression hides from the fuzzer.
    let blobs = [(&b"OSMHeader"[..], &b""[..]), (b"OSMData", STREETS), (b"OSMData", bytes)];
    read_as_pbf(&blobs.map(|(kind, bytes)| framed(kind, bytes)).concat());
}

fn read_as_pbf(bytes: &[u8]) {
    let result = read_pbf(Path::new("fuzz.osm.pbf"), &mut Cursor::new(bytes), &|_, _| {});
    if let Err(OsmError::Damaged { byte, .. }) = result {
        assert!(byte <= bytes.len() as u64, "damage beyond the file");
    }
}

/// Returns bytes as a blob without compression.
fn framed(kind: &[u8], bytes: &[u8]) -> Vec<u8> {
    let blob = [&[0x0a], &*varint(bytes.len()), bytes].concat();
    let header = [&[0x0a, kind.len() as u8], kind, &[0x18], &*varint(blob.len())].concat();
    [&(header.len() as u32).to_be_bytes()[..], &header, &blob].concat()
}

fn varint(mut number: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    while number >= 0x80 {
        bytes.push(number as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
    bytes
}

/// An XML file, plain or gzipped.
pub(crate) fn xml(bytes: &[u8]) {
    let size = bytes.len() as u64;
    let result = read_xml(Path::new("fuzz.osm"), size, bytes, &|_, _| {});
    if let Err(OsmError::Damaged { byte, .. }) = result {
        assert!(byte <= size, "damage beyond the file");
    }
}

/// A signal list.
pub(crate) fn signals(bytes: &[u8]) {
    if let Ok(list) =
        SignalList::from_bytes(bytes, Path::new("fuzz.csv"), &SignalColumns::default())
    {
        assert!(!list.signals.is_empty(), "a list without signals is an error");
    }
}

/// Traffic counts, GeoJSON or CSV, and what is read joined to a street.
pub(crate) fn counts(bytes: &[u8]) {
    let settings = CountSettings::default();
    if let Ok(counts) = Counts::from_bytes(bytes, Path::new("fuzz.geojson"), &settings) {
        let place = |latitude_e7| Place { latitude_e7, longitude_e7: -1_119_000_000 };
        if let Some(found) = counts.along(&[place(407_600_000), place(407_620_000)], 4) {
            assert!(found.aadt_veh_per_day >= 0.0 && found.distance_m >= 0.0);
        }
    }
}

/// A boundary in GeoJSON, and as an argument.
pub(crate) fn boundary(bytes: &[u8]) {
    let place = Place { latitude_e7: 407_600_000, longitude_e7: -1_119_000_000 };
    if let Ok(boundary) = Boundary::from_bytes(bytes, Path::new("fuzz.geojson")) {
        boundary.contains(place);
    }
    // Only numbers: anything else is the path of a file.
    if bytes.iter().all(|b| b"0123456789.,-+eE ".contains(b))
        && let Ok(Ok(boundary)) = std::str::from_utf8(bytes).map(Boundary::parse)
    {
        boundary.contains(place);
    }
}

//! Any bytes as a PBF file, and as a block of one.
#![no_main]

use std::io::Cursor;
use std::path::Path;

use libfuzzer_sys::fuzz_target;
use osm_signals::OsmError;
use osm_signals::read::read_pbf;

/// A block with streets, without which there is no second pass.
const STREETS: &[u8] = include_bytes!("../seeds/pbf/block-ways");

fuzz_target!(|bytes: &[u8]| {
    read(bytes);
    // A block within a file is what compression hides from the fuzzer.
    let blobs = [(&b"OSMHeader"[..], &b""[..]), (b"OSMData", STREETS), (b"OSMData", bytes)];
    read(&blobs.map(|(kind, bytes)| framed(kind, bytes)).concat());
});

fn read(bytes: &[u8]) {
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

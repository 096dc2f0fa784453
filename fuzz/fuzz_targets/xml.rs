//! Any bytes as an XML file.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use osm_signals::OsmError;
use osm_signals::read::read_xml;

fuzz_target!(|bytes: &[u8]| {
    let size = bytes.len() as u64;
    let result = read_xml(Path::new("fuzz.osm"), size, || Ok(bytes), &|_, _| {});
    if let Err(OsmError::Damaged { byte, .. }) = result {
        assert!(byte <= size, "damage beyond the file");
    }
});

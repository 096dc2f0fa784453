//! Any bytes as a gzipped XML file.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use osm_signals::OsmError;
use osm_signals::read::read_gz;

fuzz_target!(|bytes: &[u8]| {
    let size = bytes.len() as u64;
    let result = read_gz(Path::new("fuzz.osm.gz"), size, || Ok(bytes), &|_, _| {});
    if let Err(OsmError::Damaged { byte, .. }) = result {
        assert!(byte <= size, "damage beyond the file");
    }
});

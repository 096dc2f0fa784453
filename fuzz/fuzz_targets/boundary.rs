//! Any bytes as a boundary in GeoJSON, and as an argument.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use osm_signals::boundary::Boundary;
use osm_signals::extract::Place;

fuzz_target!(|bytes: &[u8]| {
    let place = Place { latitude_e7: 407_600_000, longitude_e7: -1_119_000_000 };
    if let Ok(boundary) = Boundary::from_bytes(bytes, Path::new("fuzz.geojson")) {
        boundary.contains(place);
    }
    // Only numbers: anything else is the path of a file.
    if bytes.iter().all(|b| b"0123456789.,-+eE ".contains(b)) {
        if let Ok(Ok(boundary)) = std::str::from_utf8(bytes).map(Boundary::parse) {
            boundary.contains(place);
        }
    }
});

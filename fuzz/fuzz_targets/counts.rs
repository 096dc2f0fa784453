//! Any bytes as traffic counts, GeoJSON or CSV, and what is read joined to a street.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use osm_signals::counts::{CountSettings, Counts};
use osm_signals::extract::Place;

fuzz_target!(|bytes: &[u8]| {
    let settings = CountSettings::default();
    if let Ok(counts) = Counts::from_bytes(bytes, Path::new("fuzz.geojson"), &settings) {
        let place = |latitude_e7| Place { latitude_e7, longitude_e7: -1_119_000_000 };
        if let Some(found) = counts.along(&[place(407_600_000), place(407_620_000)], 4) {
            assert!(found.aadt_veh_per_day >= 0.0 && found.distance_m >= 0.0);
        }
    }
});

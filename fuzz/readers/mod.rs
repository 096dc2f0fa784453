//! What is done with any bytes, by the name of the reader: the fuzz targets and `tests/readers.rs` call the same.
//!
//! Nothing may panic, hang or take memory without bounds; what is accepted has to be as it promises, and reads back
//! equal where something writes it.

mod maps;
mod models;
mod store;
mod sumo;
mod tables;

/// What is done with bytes.
pub(crate) type Reader = fn(&[u8]);

/// All readers; the seeds of each are in `seeds/NAME`.
pub(crate) const READERS: [(&str, Reader); 20] = [
    ("pbf", maps::pbf),
    ("xml", maps::xml),
    ("signals", maps::signals),
    ("counts", maps::counts),
    ("boundary", maps::boundary),
    ("points", tables::points),
    ("approaches", tables::approaches),
    ("turning_counts", tables::turning_counts),
    ("utdf", tables::utdf),
    ("existing", tables::existing),
    ("scenario", tables::scenario),
    ("sumocfg", sumo::sumocfg),
    ("sources", sumo::sources),
    ("net", sumo::net),
    ("tripinfo", sumo::tripinfo),
    ("demand", sumo::demand),
    ("record", store::record),
    ("manifest", store::manifest),
    ("places", store::places),
    ("archive", models::archive),
];

//! Tests of the readers as a whole: equal data, bad data, real extracts.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use super::sample::{Columns, Packing, Town};
use super::{read, read_gz, read_pbf, read_xml};
use crate::osm::OsmError;
use crate::osm::extract::Extract;

pub(super) fn pbf(bytes: &[u8]) -> Result<Extract, OsmError> {
    read_pbf(Path::new("town.osm.pbf"), &mut Cursor::new(bytes), &|_, _| {})
}

pub(super) fn xml(bytes: &[u8]) -> Result<Extract, OsmError> {
    read_xml(Path::new("town.osm"), bytes.len() as u64, || Ok(bytes), &|_, _| {})
}

pub(super) fn gz(bytes: &[u8]) -> Result<Extract, OsmError> {
    read_gz(Path::new("town.osm.gz"), bytes.len() as u64, || Ok(bytes), &|_, _| {})
}

#[test]
fn pbf_and_xml_of_the_same_town_give_the_same_extract() {
    let town = Town::small();
    let extract = xml(town.xml().as_bytes()).unwrap();
    assert_eq!(extract.ways.iter().map(|w| w.id).collect::<Vec<_>>(), [100, 101, 102]);
    assert_eq!(extract.ways[0].street.name.as_deref(), Some("State St & \"Main\""));
    assert_eq!(extract.refs, [10, 12, 12, 11, 13, 12, 14]);
    assert_eq!(extract.signals.iter().map(|s| s.id).collect::<Vec<_>>(), [-7, 12]);
    assert_eq!(extract.restrictions.len(), 1);
    assert!((0..extract.nodes.len()).all(|i| extract.nodes.place(i).is_some()));
    assert_eq!(gz(&town.gz()).unwrap(), extract);
    for packing in [Packing::Raw, Packing::Zlib] {
        for columns in [Columns::Dense, Columns::Plain] {
            assert_eq!(
                pbf(&town.pbf(packing, columns)).unwrap(),
                extract,
                "{packing:?} {columns:?}"
            );
        }
    }
}

/// Returns an extract that is not part of this repository; `None`, with a word, if it is absent.
fn real(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/osm").join(name);
    let found = path.exists().then_some(path);
    if found.is_none() {
        eprintln!("skipped: {name} is not at hand");
    }
    found
}

#[test]
fn real_extracts_are_read() {
    for (name, signals) in [
        ("r5_washington_dc.osm.pbf", Some(978)),
        ("valhalla_harrisburg.osm.pbf", Some(92)),
        ("quad_intersection.osm.gz", None),
        ("seattle_triangle.osm.gz", None),
        ("tempe_light_rail.osm.gz", None),
    ] {
        let Some(path) = real(name) else { continue };
        let extract = read(&path, &|_, _| {}).unwrap();
        eprintln!(
            "{name}: {} ways, {} signals, {} turns, {:#?}",
            extract.ways.len(),
            extract.signals.len(),
            extract.restrictions.len(),
            extract.oddities
        );
        if let Some(signals) = signals {
            assert_eq!(extract.signals.len(), signals, "{name}");
        }
    }
}

//! Tests of the readers as a whole: equal data, bad data, real extracts.

use std::fs::{self, File};
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use osmpbfreader::{OsmObj, OsmPbfReader};

use super::sample::{Columns, Packing, Town};
use super::{read, read_gz, read_pbf, read_xml};
use crate::OsmError;
use crate::extract::{Extract, Place};
use crate::tags::{SignalTags, drivable, tag};

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
        writeln!(std::io::stderr(), "skipped: {name} is not at hand").unwrap();
    }
    found
}

#[test]
fn real_extracts_hold_what_another_reader_finds() {
    for (name, signals, relations) in
        [("r5_washington_dc.osm.pbf", 978, 158), ("valhalla_harrisburg.osm.pbf", 92, 11)]
    {
        let Some(path) = real(name) else { continue };
        let extract = read(&path, &|_, _| {}).unwrap();
        assert_eq!(extract.signals.len(), signals, "{name}");
        let mut other = OsmPbfReader::new(File::open(&path).unwrap());
        let (mut ways, mut turns, mut u_turns) = (0, 0, 0);
        for object in other.iter().map(Result::unwrap) {
            let tags: Vec<_> = object.tags().iter().map(|(k, v)| (&**k, &**v)).collect();
            match &object {
                OsmObj::Node(node) => {
                    let place =
                        Place { latitude_e7: node.decimicro_lat, longitude_e7: node.decimicro_lon };
                    if let Some(index) = extract.nodes.index(node.id.0) {
                        assert_eq!(extract.nodes.place(index), Some(place), "{:?}", node.id);
                    }
                    let signal = extract.signals.iter().find(|s| s.id == node.id.0);
                    assert_eq!(signal.map(|s| s.tags), SignalTags::parse(&tags));
                    assert!(signal.is_none_or(|s| s.place == place));
                }
                OsmObj::Way(way) if drivable(&tags) => {
                    ways += 1;
                    let found = extract.ways.binary_search_by_key(&way.id.0, |w| w.id).unwrap();
                    let nodes: Vec<_> = way.nodes.iter().map(|n| n.0).collect();
                    assert_eq!(extract.nodes_of(&extract.ways[found]), nodes);
                }
                OsmObj::Relation(_) if tag(&tags, "type") == Some("restriction") => {
                    turns += 1;
                    u_turns += u64::from(tag(&tags, "restriction") == Some("no_u_turn"));
                }
                _ => {}
            }
        }
        assert_eq!(extract.ways.len(), ways, "{name}");
        let counted = extract.oddities.iter().filter(|(r, _)| r.starts_with("turn restriction"));
        let counted: u64 = counted.map(|(_, oddity)| oddity.count).sum();
        assert_eq!(extract.restrictions.len() as u64 + counted + u_turns, turns, "{name}");
        assert_eq!(turns, relations, "{name}");
    }
}

#[test]
fn real_extracts_in_gzipped_xml_are_read() {
    for (name, signals) in [
        ("quad_intersection.osm.gz", 9),
        ("seattle_triangle.osm.gz", 5),
        ("tempe_light_rail.osm.gz", 3),
    ] {
        let Some(path) = real(name) else { continue };
        let extract = read(&path, &|_, _| {}).unwrap();
        assert_eq!(extract.signals.len(), signals, "{name}");
        assert!((0..extract.nodes.len()).all(|i| extract.nodes.place(i).is_some()), "{name}");
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let town = Town::small().pbf(Packing::Zlib, Columns::Dense);
    let header = town.windows(7).position(|bytes| bytes == b"OSMData").unwrap() - 6;
    // Blobs of the same ids again and again, in which the order decides who wins.
    let mut bytes = town.clone();
    for _ in 0..50 {
        bytes.extend_from_slice(&town[header..]);
    }
    let read = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| pbf(&bytes)).unwrap()
    };
    let one = read(1);
    assert_eq!(one.oddities.count("two ways with one id"), 150);
    assert_eq!(read(4), one);
}

#[test]
fn the_progress_rises_to_twice_the_size() {
    let folder = tempfile::tempdir().unwrap();
    let town = Town::small();
    for (name, bytes) in [
        ("town.osm.pbf", town.pbf(Packing::Zlib, Columns::Dense)),
        ("town.osm", town.xml().into_bytes()),
        ("town.osm.gz", town.gz()),
    ] {
        let path = folder.path().join(name);
        fs::write(&path, &bytes).unwrap();
        let in_all = 2 * bytes.len() as u64;
        let last = AtomicU64::new(0);
        let extract = read(&path, &|done, all| {
            assert_eq!(all, in_all, "{name}");
            assert!(last.swap(done, Ordering::Relaxed) <= done && done <= all, "{name}");
        });
        assert_eq!(extract.unwrap(), xml(town.xml().as_bytes()).unwrap(), "{name}");
        assert_eq!(last.into_inner(), in_all, "{name}");
    }
}

#[test]
fn what_is_no_file_or_no_extract_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = folder.path().join("town.osm.pbf");
    fs::write(&wrong, Town::small().xml()).unwrap();
    for (path, expected) in [
        (wrong, "holds XML, but its name promises OpenStreetMap PBF"),
        (folder.path().into(), "it is a folder; give a regular file"),
        (folder.path().join("none.osm"), "none.osm: No such file or directory"),
    ] {
        let e = read(&path, &|_, _| {}).unwrap_err().to_string();
        assert!(e.contains(expected), "{e}");
    }
}

#[test]
fn ways_without_nodes_are_told_from_a_small_extract() {
    let text = "<osm version=\"0.6\"><way id=\"1\"><nd ref=\"1\" lat=\"40.0\" lon=\"-75.0\"/><nd ref=\"2\" \
                lat=\"40.1\" lon=\"-75.0\"/><tag k=\"highway\" v=\"primary\"/></way></osm>";
    let error = xml(text.as_bytes()).unwrap_err().to_string();
    assert!(
        error.contains("holds streets and no node of them") && error.contains("out body"),
        "{error}"
    );
}

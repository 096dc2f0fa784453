//! Tests of the readers as a whole: equal data, bad data, real extracts.

use std::fs::{self, File};
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use osmpbfreader::{OsmObj, OsmPbfReader};

use super::sample::{Columns, Packing, Town};
use super::{Format, read, read_pbf, read_xml};
use crate::OsmError;
use crate::extract::{Extract, Place};
use crate::oddities::Oddities;
use crate::tags::{SignalTags, Street, tag};

pub(super) fn pbf(bytes: &[u8]) -> Result<Extract, OsmError> {
    read_pbf(Path::new("town.osm.pbf"), &mut Cursor::new(bytes), &|_, _| {})
}

pub(super) fn xml(bytes: &[u8]) -> Result<Extract, OsmError> {
    read_xml(Path::new("town.osm"), bytes.len() as u64, bytes, &|_, _| {})
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
    assert!(extract.nodes.places.iter().all(Option::is_some));
    assert_eq!(xml(&town.gz()).unwrap(), extract);
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
                        assert_eq!(extract.nodes.places[index], Some(place), "{:?}", node.id);
                    }
                    let signal = extract.signals.iter().find(|s| s.id == node.id.0);
                    assert_eq!(signal.map(|s| s.tags), SignalTags::parse(&tags));
                    assert!(signal.is_none_or(|s| s.place == place));
                }
                OsmObj::Way(_) if Street::parse(0, &tags, &mut Oddities::default()).is_none() => {}
                OsmObj::Way(way) => {
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
fn a_file_is_read_whatever_its_name_and_the_progress_rises_to_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let town = Town::small();
    for bytes in [town.pbf(Packing::Zlib, Columns::Dense), town.xml().into_bytes(), town.gz()] {
        let path = folder.path().join("town.map");
        fs::write(&path, &bytes).unwrap();
        let last = AtomicU64::new(0);
        let extract = read(&path, &|done, all| {
            assert!(last.swap(done, Ordering::Relaxed) <= done && done <= all);
        });
        assert_eq!(extract.unwrap(), xml(town.xml().as_bytes()).unwrap());
        assert!(last.into_inner() >= bytes.len() as u64);
    }
    assert!(matches!(read(folder.path(), &|_, _| {}), Err(OsmError::Unreadable { .. })));
}

#[test]
fn the_first_bytes_give_the_format() {
    for (head, format) in [
        (&b"\0\0\0\x0e\x0a\x09OSMHeader\x18\x40"[..], Some(Format::Pbf)),
        (b"\xef\xbb\xbf\n<?xml version='1.0'?><osm>", Some(Format::Xml)),
        (b"\x1f\x8b\x08", Some(Format::Gzip)),
        (b"PK\x03\x04", None),
        (b"{\"version\": 0.6}", None),
        (b"", None),
    ] {
        assert_eq!(Format::of(Path::new("a.osm"), head).ok(), format, "{head:?}");
    }
}

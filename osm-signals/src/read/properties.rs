//! Tests of what holds for all files: no panic, equal formats, damage inside the file.

use proptest::prelude::*;

use osmpbfreader::osmformat::relation::MemberType;

use super::sample::{Columns, Members, Packing, Text, Town};
use super::tests::{pbf, xml};
use crate::OsmError;
use crate::extract::Extract;

/// Whatever comes out, damage has to lie within the file.
fn check(result: &Result<Extract, OsmError>, size: usize) {
    if let Err(OsmError::Damaged { byte, .. }) = result {
        assert!(*byte <= size as u64, "byte {byte} of {size}");
    }
}

/// Reads the bytes of a file.
type Reader = fn(&[u8]) -> Result<Extract, OsmError>;

fn all_formats() -> [(Vec<u8>, Reader); 5] {
    let town = Town::small();
    [
        (town.pbf(Packing::Raw, Columns::Dense), pbf),
        (town.pbf(Packing::Raw, Columns::Plain), pbf),
        (town.pbf(Packing::Zlib, Columns::Dense), pbf),
        (town.xml().into_bytes(), xml),
        (town.gz(), xml),
    ]
}

#[test]
fn a_file_cut_off_anywhere_is_an_error_unless_nothing_needed_is_missing() {
    for (bytes, read) in all_formats() {
        for size in 0..bytes.len() {
            check(&read(&bytes[..size]), size);
        }
    }
}

fn tags() -> impl Strategy<Value = Text> {
    let key = prop::sample::select(vec![
        "highway", "name", "oneway", "lanes", "type", "restriction", "except", "maxspeed", "area",
    ]);
    let value = prop::sample::select(vec![
        "primary", "traffic_signals", "yes", "-1", "no", "2;3", "restriction", "no_left_turn",
        "only_right_turn", "no_entry", "25 mph", "é&<\">'", "",
    ]);
    let tag = (key, value).prop_map(|(k, v)| (k.to_owned(), v.to_owned()));
    prop::collection::vec(tag, 0..4)
}

fn members() -> impl Strategy<Value = Members> {
    let kind = prop::sample::select(vec![MemberType::NODE, MemberType::WAY, MemberType::RELATION]);
    let role = prop::sample::select(vec!["from", "via", "to", ""]);
    prop::collection::vec((kind, 0..12_i64, role.prop_map(str::to_owned)), 0..6)
}

fn town() -> impl Strategy<Value = Town> {
    let node = (-4..12_i64, -900_000_010..=900_000_010_i64, -1_800_000_010..=1_800_000_010_i64);
    let node = (node, tags()).prop_map(|((id, lat, lon), tags)| (id, lat, lon, tags));
    let way = (0..12_i64, prop::collection::vec(-4..12_i64, 0..5), tags());
    let relation = (0..6_i64, members(), tags());
    (
        prop::collection::vec(node, 0..20),
        prop::collection::vec(way, 0..12),
        prop::collection::vec(relation, 0..6),
    )
        .prop_map(|(nodes, ways, relations)| Town { nodes, ways, relations })
}

proptest! {
    #[test]
    fn any_bytes_are_read_without_panic(bytes: Vec<u8>) {
        for read in [pbf, xml] {
            check(&read(&bytes), bytes.len());
        }
    }

    #[test]
    fn flipped_bits_are_read_without_panic(
        flips in prop::collection::vec((any::<prop::sample::Index>(), 0..8_u32), 1..6),
    ) {
        for (mut bytes, read) in all_formats() {
            for (at, bit) in &flips {
                let at = at.index(bytes.len());
                bytes[at] ^= 1 << bit;
            }
            check(&read(&bytes), bytes.len());
        }
    }

    #[test]
    fn any_town_is_the_same_in_all_formats(town in town()) {
        let expected = xml(town.xml().as_bytes());
        let others = [
            xml(&town.gz()),
            pbf(&town.pbf(Packing::Raw, Columns::Dense)),
            pbf(&town.pbf(Packing::Zlib, Columns::Plain)),
        ];
        for other in others {
            match (&expected, other) {
                (Ok(expected), Ok(other)) => prop_assert_eq!(expected, &other),
                (Err(OsmError::Nothing { .. }), Err(OsmError::Nothing { .. })) => {}
                (expected, other) => prop_assert!(false, "{:?} and {:?}", expected, other),
            }
        }
    }
}

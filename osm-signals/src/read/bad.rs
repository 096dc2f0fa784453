//! Tests with bad data: each is an error that says where, or skipped and counted.

use flate2::Compression;
use osmpbfreader::osmformat::{Info, PrimitiveBlock};
use protobuf::Message;

use super::sample::{Columns, Packing, Town, framed, gzip, stored, text};
use super::tests::{pbf, xml};
use crate::OsmError;
use crate::extract::Extract;

fn file(blocks: &[PrimitiveBlock]) -> Vec<u8> {
    let blocks = blocks.iter().map(|block| block.write_to_bytes().unwrap());
    let blobs = blocks.map(|block| stored("OSMData", &block, Packing::Raw));
    [stored("OSMHeader", b"", Packing::Raw)].into_iter().chain(blobs).collect::<Vec<_>>().concat()
}

fn changed(columns: Columns, change: impl FnOnce(&mut [PrimitiveBlock])) -> Vec<u8> {
    let mut blocks = Town::small().blocks(columns);
    change(&mut blocks);
    file(&blocks)
}

fn damage(result: Result<Extract, OsmError>) -> u64 {
    match result {
        Err(OsmError::Damaged { byte, .. }) => byte,
        other => panic!("{other:?}"),
    }
}

fn blob(field: u8, size: &[u8], bytes: &[u8]) -> Vec<u8> {
    let blob = [size, &[field << 3 | 2, bytes.len() as u8], bytes].concat();
    [stored("OSMHeader", b"", Packing::Raw), framed("OSMData", &blob)].concat()
}

#[test]
fn frames_of_pbf_that_cannot_be_are_damage_with_its_place() {
    let header = stored("OSMHeader", b"", Packing::Raw);
    let negative = [&[0, 0, 0, 14, 0x0a, 1, b'x', 0x18][..], &[0xff; 9], &[1]].concat();
    let within = stored("OSMData", b"abc", Packing::Raw);
    for (frame, byte) in [
        (&[0, 1, 0, 1, b'O'][..], 19),
        (&[0, 0], 19),
        (&[0, 0, 0, 2, 0x0a, 9], 19),
        (&negative, 19),
        (&[0, 0, 0, 7, 0x0a, 0, 0x18, 0x81, 0x80, 0x80, 0x10], 19),
        (&within[..19], 34),
    ] {
        assert_eq!(damage(pbf(&[&header[..], frame].concat())), byte, "{frame:?}");
    }
    assert_eq!(damage(pbf(&stored("OSMData", b"", Packing::Raw))), 0);
}

#[test]
fn blobs_that_cannot_be_inflated_or_are_not_understood_are_damage() {
    let bomb = stored("OSMData", &vec![0; 4 << 20], Packing::Zlib);
    let bomb = [stored("OSMHeader", b"", Packing::Raw), bomb].concat();
    assert_eq!(damage(pbf(&bomb)), 36);
    for (field, size) in [(3, &[][..]), (3, &[0x10, 0x05]), (4, &[]), (7, &[]), (9, &[])] {
        assert_eq!(damage(pbf(&blob(field, size, b"no zlib"))), 34, "{field}");
    }
    let history = [0x22, 21].into_iter().chain(*b"HistoricalInformation").collect::<Vec<_>>();
    assert_eq!(damage(pbf(&stored("OSMHeader", &history, Packing::Zlib))), 17);
    // What may be skipped.
    let town = Town::small().pbf(Packing::Zlib, Columns::Dense);
    let optional = [0x2a, 15].into_iter().chain(*b"LocationsOnWays").collect::<Vec<_>>();
    let header = stored("OSMHeader", &optional, Packing::Zlib);
    let bytes = [&header[..], &stored("Other", b"?", Packing::Raw), &town].concat();
    assert_eq!(pbf(&bytes).unwrap(), pbf(&town).unwrap());
}

#[test]
fn blocks_of_pbf_that_contradict_themselves_are_damage() {
    let dense = |change: fn(&mut osmpbfreader::osmformat::DenseNodes)| {
        changed(Columns::Dense, |blocks| {
            change(blocks[0].primitivegroup[0].dense.mut_or_insert_default());
        })
    };
    let way = |change: fn(&mut osmpbfreader::osmformat::Way)| {
        changed(Columns::Dense, |blocks| change(&mut blocks[1].primitivegroup[0].ways[1]))
    };
    let relation = |change: fn(&mut osmpbfreader::osmformat::Relation)| {
        changed(Columns::Dense, |blocks| change(&mut blocks[2].primitivegroup[0].relations[0]))
    };
    for (bytes, byte) in [
        (dense(|nodes| nodes.lat.truncate(1)), 35),
        (dense(|nodes| nodes.keys_vals.truncate(3)), 35),
        (dense(|nodes| nodes.keys_vals = vec![1]), 35),
        (dense(|nodes| nodes.keys_vals[2] = -1), 35),
        (dense(|nodes| nodes.id = vec![i64::MAX; nodes.id.len()]), 35),
        (dense(|nodes| nodes.denseinfo.mut_or_insert_default().visible = vec![true]), 35),
        (way(|way| way.keys[0] = 999), 211),
        (way(|way| way.vals.truncate(1)), 211),
        (way(|way| way.refs = vec![i64::MIN, -1]), 211),
        (way(|way| way.refs = vec![1; (1 << 20) + 1]), 212),
        (relation(|relation| relation.types.truncate(1)), 397),
        (relation(|relation| relation.roles_sid[0] = -1), 397),
        (relation(|relation| relation.types[0] = protobuf::EnumOrUnknown::from_i32(7)), 397),
    ] {
        assert_eq!(damage(pbf(&bytes)), byte);
    }
}

#[test]
fn deleted_elements_are_skipped() {
    let gone = || Info { visible: Some(false), ..Info::new() };
    let mut expected = Town::small();
    expected.ways.remove(1);
    expected.relations.remove(0);
    expected.nodes.remove(5);
    let expected = xml(expected.xml().as_bytes()).unwrap();
    for columns in [Columns::Dense, Columns::Plain] {
        let bytes = changed(columns, |blocks| {
            blocks[1].primitivegroup[0].ways[1].info = Some(gone()).into();
            blocks[2].primitivegroup[0].relations[0].info = Some(gone()).into();
            let nodes = &mut blocks[0].primitivegroup[0];
            if let Some(node) = nodes.nodes.get_mut(5) {
                node.info = Some(gone()).into();
            } else {
                let dense = nodes.dense.mut_or_insert_default();
                let visible = (0..dense.id.len()).map(|i| i != 5).collect();
                dense.denseinfo.mut_or_insert_default().visible = visible;
            }
        });
        assert_eq!(pbf(&bytes).unwrap(), expected);
    }
    let deleted = Town::small()
        .xml()
        .replace("<way id='101'", "<way id='101' visible='false'")
        .replace("<relation id='200'", "<relation id='200' action='delete'")
        .replace("<node id='-7'", "<node id='-7' action='delete'");
    assert_eq!(xml(deleted.as_bytes()).unwrap(), expected);
}

#[test]
fn granularity_and_offsets_are_applied() {
    let shifted = changed(Columns::Plain, |blocks| {
        blocks[0].granularity = Some(1000);
        blocks[0].lat_offset = Some(1_000_000_000);
        blocks[0].lon_offset = Some(-2_000_000_000);
        for node in &mut blocks[0].primitivegroup[0].nodes {
            node.lat = node.lat.map(|lat| (lat - 10_000_000) / 10);
            node.lon = node.lon.map(|lon| (lon + 20_000_000) / 10);
        }
    });
    assert_eq!(pbf(&shifted).unwrap(), xml(Town::small().xml().as_bytes()).unwrap());
}

#[test]
fn nodes_that_are_missing_or_not_on_earth_have_no_place() {
    let mut town = Town::small();
    town.nodes[0].1 = 910_000_000;
    town.nodes[5].2 = i64::MAX / 1_000_000;
    town.nodes.remove(1);
    let extract = xml(town.xml().as_bytes()).unwrap();
    assert_eq!(extract.oddities.count("node without a place on Earth"), 2);
    assert_eq!(extract.oddities.count("node is missing in the file"), 2);
    assert_eq!(extract.signals.len(), 1);
    assert_eq!(pbf(&town.pbf(Packing::Zlib, Columns::Dense)).unwrap(), extract);
    let no_number = town.xml().replace("lat='91.0000000'", "lat='NaN'");
    assert_eq!(xml(no_number.as_bytes()).unwrap(), extract);
    let no_place = town.xml().replace("lat='91.0000000'", "");
    assert_eq!(xml(no_place.as_bytes()).unwrap(), extract);
}

#[test]
fn what_holds_no_extract_is_told_from_what_is_damaged() {
    let mut town = Town::small();
    let without_nodes = Town { nodes: vec![], ..town.clone() };
    town.ways.drain(..3);
    let texts = [&*town.xml(), "", "<osmChange/>", "<gpx/>", "{}", &without_nodes.xml()];
    for text in texts {
        let nothing = |result| matches!(result, Err(OsmError::Nothing { .. }));
        assert!(nothing(xml(text.as_bytes())), "{text}");
        assert!(nothing(xml(&gzip(text.as_bytes(), Compression::none()))), "{text}");
    }
    let bytes = town.pbf(Packing::Raw, Columns::Dense);
    assert!(matches!(pbf(&bytes), Err(OsmError::Nothing { .. })));
}

#[test]
fn xml_that_is_damaged_says_where() {
    let text = Town::small().xml();
    let with = |from: &str, to: &str| damage(xml(text.replacen(from, to, 1).as_bytes()));
    assert_eq!(damage(xml(&text.as_bytes()[..500])), 500);
    for (from, to, byte) in [
        ("</osm>", "", 1780),
        ("</osm>", "</osm><osm></osm>", 1790),
        ("</way>", "</weg>", 771),
        ("v=\"primary\"", "v=\"prim&ary;\"", 696),
        ("</osm>", "<remark>runtime error: Query timed out</remark></osm>", 1817),
    ] {
        assert_eq!(with(from, to), byte, "{to}");
    }
    with("<node", &"<a>".repeat(70));
    let gz = gzip(text.as_bytes(), Compression::none());
    damage(xml(&gz[..gz.len() - 30]));
    damage(xml(&[&gz[..], b"more"].concat()));
    let way = |parts: &str| damage(xml(format!("<osm><way id='1'>{parts}").as_bytes()));
    way(&"<nd ref='1'/>".repeat(1_000_000));
    way(&format!("<tag k='name' v='{}'/>", "x".repeat(17_000_000)));
}

#[test]
fn strange_elements_of_xml_are_skipped_and_counted() {
    let expected = xml(Town::small().xml().as_bytes()).unwrap();
    let strange = Town::small()
        .xml()
        .replace(
            "<way id='100'>",
            "<way id='x'/><way/><way id='100'><nd/><nd ref='1e3'/><tag k='a'/>",
        )
        .replace("<relation id='200'>", "<relation id='200'><member type='area' ref='1' role=''/>")
        .replace(
            "<osm version=\"0.6\">",
            "<osm><bounds/><note>a &amp; b</note><changeset id='1'/>",
        );
    let mut extract = xml(strange.as_bytes()).unwrap();
    for (reason, count) in [
        ("element whose id is no number", 2),
        ("node of a way whose id is no number", 2),
        ("tag without a key or value", 1),
        ("member of a relation without a type or id", 1),
    ] {
        assert_eq!(extract.oddities.count(reason), count, "{reason}");
    }
    extract.oddities = expected.oddities.clone();
    assert_eq!(extract, expected);
}

#[test]
fn of_two_elements_with_one_id_the_later_one_wins() {
    let mut town = Town::small();
    town.ways.push((100, vec![13, 12], text(&[("highway", "tertiary")])));
    town.nodes.push((-7, 0, 0, text(&[("highway", "traffic_signals")])));
    town.nodes.push((11, 5, 5, vec![]));
    town.relations.push(town.relations[0].clone());
    let extract = xml(town.xml().as_bytes()).unwrap();
    assert_eq!(extract.nodes_of(&extract.ways[0]), [13, 12]);
    assert_eq!(extract.signals[0].place.latitude_e7, 0);
    assert_eq!(extract.nodes.places[0].unwrap().latitude_e7, 5);
    assert_eq!(extract.restrictions.len(), 1);
    assert_eq!(extract.oddities.iter().filter(|(r, _)| r.starts_with("two ")).count(), 4);
    assert_eq!(pbf(&town.pbf(Packing::Zlib, Columns::Plain)).unwrap(), extract);
}

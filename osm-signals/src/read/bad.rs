//! Tests with bad data: each is an error that says where and what, or skipped and counted.

use flate2::Compression;
use osmpbfreader::osmformat::{Info, PrimitiveBlock};
use protobuf::Message;

use super::sample::{Columns, Packing, Town, framed, gzip, stored, text};
use super::tests::{gz, pbf, xml};
use crate::OsmError;
use crate::extract::Extract;

/// Returns a PBF file of these blocks after its header.
fn file(blocks: &[PrimitiveBlock]) -> Vec<u8> {
    let blocks = blocks.iter().map(|block| block.write_to_bytes().unwrap());
    let blobs = blocks.map(|block| stored("OSMData", &block, Packing::Raw));
    [stored("OSMHeader", b"", Packing::Raw)].into_iter().chain(blobs).collect::<Vec<_>>().concat()
}

/// Returns the small town after a change of its blocks of nodes, ways and relations.
fn changed(columns: Columns, change: impl FnOnce(&mut [PrimitiveBlock])) -> Vec<u8> {
    let mut blocks = Town::small().blocks(columns);
    change(&mut blocks);
    file(&blocks)
}

fn message(result: Result<Extract, OsmError>) -> String {
    result.unwrap_err().to_string()
}

/// Returns gzipped bytes whose places do not depend on how well they are compressed.
fn store(bytes: &[u8]) -> Vec<u8> {
    gzip(bytes, Compression::none())
}

/// Returns a blob of this field after the header of a file.
fn blob(field: u8, size: &[u8], bytes: &[u8]) -> Vec<u8> {
    let blob = [size, &[field << 3 | 2, bytes.len() as u8], bytes].concat();
    [stored("OSMHeader", b"", Packing::Raw), framed("OSMData", &blob)].concat()
}

#[test]
fn frames_of_pbf_that_cannot_be_are_damage_with_its_place() {
    let header = stored("OSMHeader", b"", Packing::Raw);
    let huge = [&header[..], &[0, 1, 0, 1], b"OSMHeader"].concat();
    let cut = [&header[..], &[0, 0]].concat();
    let garbled = [&header[..], &[0, 0, 0, 2, 0x0a, 9]].concat();
    let negative = [&header[..], &[0, 0, 0, 14, 0x0a, 1, b'x', 0x18], &[0xff; 9], &[1]].concat();
    let beyond = [&header[..], &[0, 0, 0, 7, 0x0a, 0, 0x18, 0x81, 0x80, 0x80, 0x10]].concat();
    let bare = stored("OSMData", b"", Packing::Raw);
    let within = [&header[..], &stored("OSMData", b"abc", Packing::Raw)[..19]].concat();
    let texts =
        [huge, cut, garbled, negative, beyond, within, bare].map(|bytes| message(pbf(&bytes)));
    insta::assert_snapshot!(texts.join("\n"), @r"
    town.osm.pbf, byte 19: a header of 65537 bytes, more than a PBF file can have; fetch the file again
    town.osm.pbf, byte 19: the file ends within the length of a header; fetch the file again
    town.osm.pbf, byte 19: the header of a blob is garbled (Unexpected EOF); fetch the file again
    town.osm.pbf, byte 19: a blob of impossible size, -1 bytes; fetch the file again
    town.osm.pbf, byte 19: a blob of impossible size, 33554433 bytes; fetch the file again
    town.osm.pbf, byte 34: the file ends within a blob, 5 bytes were announced; fetch the file again
    town.osm.pbf, byte 0: no header of a PBF file; fetch the file again
    ");
}

#[test]
fn blobs_that_cannot_be_inflated_are_damage() {
    let sizes =
        [&[0x10, 0x05][..], &[0x10, 0x81, 0x80, 0x80, 0x10], &[0x10, 0xff, 0xff, 0x03], &[]];
    let bomb = {
        use std::io::Write;
        let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), Compression::best());
        zlib.write_all(&[0; 20_000]).unwrap();
        zlib.finish().unwrap()
    };
    let mut texts: Vec<_> = sizes.map(|size| message(pbf(&blob(3, size, &bomb)))).into();
    texts.push(message(pbf(&blob(3, &[], b"no zlib"))));
    texts.push(message(pbf(&blob(3, &[], &bomb[..bomb.len() / 2]))));
    texts.push(message(pbf(&blob(9, &[], b"?"))));
    insta::assert_snapshot!(texts.join("\n"), @r"
    town.osm.pbf, byte 34: a blob inflates to another size than announced; fetch the file again
    town.osm.pbf, byte 34: a blob that is to inflate to more than 32 MiB; fetch the file again
    town.osm.pbf, byte 34: a blob inflates to another size than announced; fetch the file again
    town.osm.pbf, byte 34: the data is garbled (a field without a number); fetch the file again
    town.osm.pbf, byte 34: the compressed data is garbled (corrupt deflate stream); fetch the file again
    town.osm.pbf, byte 34: the compressed data is garbled (incomplete deflate stream); fetch the file again
    town.osm.pbf, byte 34: a blob without data; fetch the file again
    ");
}

#[test]
fn compressions_and_features_that_are_not_built_in_are_named() {
    let mut texts: Vec<_> = (4..8).map(|f| message(pbf(&blob(f, &[], b"?")))).collect();
    let history = [0x22, 21].into_iter().chain(*b"HistoricalInformation").collect::<Vec<_>>();
    texts.push(message(pbf(&stored("OSMHeader", &history, Packing::Zlib))));
    insta::assert_snapshot!(texts.join("\n"), @r"
    town.osm.pbf, byte 34: the data is compressed by LZMA, of which no reader is built in; rewrite the file with `osmium cat in.osm.pbf -o out.osm.pbf`
    town.osm.pbf, byte 34: the data is compressed by bzip2, of which no reader is built in; rewrite the file with `osmium cat in.osm.pbf -o out.osm.pbf`
    town.osm.pbf, byte 34: the data is compressed by LZ4, of which no reader is built in; rewrite the file with `osmium cat in.osm.pbf -o out.osm.pbf`
    town.osm.pbf, byte 34: the data is compressed by zstd, of which no reader is built in; rewrite the file with `osmium cat in.osm.pbf -o out.osm.pbf`
    town.osm.pbf, byte 17: the file needs the feature `HistoricalInformation`, which this reader does not have; take an extract of the present state without it, as Geofabrik and BBBike offer
    ");
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
    let plain = |change: fn(&mut osmpbfreader::osmformat::Node)| {
        changed(Columns::Plain, |blocks| change(&mut blocks[0].primitivegroup[0].nodes[0]))
    };
    let texts = [
        dense(|nodes| nodes.lat.truncate(1)),
        dense(|nodes| nodes.keys_vals.truncate(3)),
        dense(|nodes| nodes.keys_vals = vec![1]),
        dense(|nodes| nodes.keys_vals[2] = -1),
        dense(|nodes| nodes.id = vec![i64::MAX; nodes.id.len()]),
        dense(|nodes| nodes.denseinfo.mut_or_insert_default().visible = vec![true]),
        way(|way| way.keys[0] = 999),
        way(|way| way.vals.truncate(1)),
        way(|way| way.refs = vec![i64::MIN, -1]),
        relation(|relation| relation.types.truncate(1)),
        relation(|relation| relation.roles_sid[0] = -1),
        relation(|relation| relation.types[0] = protobuf::EnumOrUnknown::from_i32(7)),
        plain(|node| node.keys = vec![1]),
        changed(Columns::Dense, |blocks| {
            blocks[1].stringtable.mut_or_insert_default().s[1] = vec![0xff];
        }),
    ]
    .map(|bytes| message(pbf(&bytes)));
    let mut texts: Vec<_> = texts.into();
    // A block whose only element is empty: neither id nor anything else.
    for field in [1, 3, 4] {
        let empty = stored("OSMData", &[0x12, 2, field << 3 | 2, 0], Packing::Raw);
        let town = Town::small().pbf(Packing::Raw, Columns::Dense);
        texts.push(message(pbf(&[town, empty].concat())));
    }
    insta::assert_snapshot!(texts.join("\n"), @r"
    town.osm.pbf, byte 35: columns of nodes differ in length; fetch the file again
    town.osm.pbf, byte 35: the tags of nodes end too early; fetch the file again
    town.osm.pbf, byte 35: the tags of nodes end too early; fetch the file again
    town.osm.pbf, byte 35: a text that is not in the table of texts; fetch the file again
    town.osm.pbf, byte 35: a number that is too large; fetch the file again
    town.osm.pbf, byte 35: columns of nodes differ in length; fetch the file again
    town.osm.pbf, byte 211: a text that is not in the table of texts; fetch the file again
    town.osm.pbf, byte 211: more keys than values or the reverse; fetch the file again
    town.osm.pbf, byte 211: a number that is too large; fetch the file again
    town.osm.pbf, byte 397: columns of members differ in length; fetch the file again
    town.osm.pbf, byte 397: a text that is not in the table of texts; fetch the file again
    town.osm.pbf, byte 397: a member of an unknown kind; fetch the file again
    town.osm.pbf, byte 35: more keys than values or the reverse; fetch the file again
    town.osm.pbf, byte 211: text that is not UTF-8; fetch the file again
    town.osm.pbf, byte 602: a node without an id or a place; fetch the file again
    town.osm.pbf, byte 602: a way without an id; fetch the file again
    town.osm.pbf, byte 602: a relation without an id; fetch the file again
    ");
}

#[test]
fn what_would_take_much_memory_is_refused_before_it_is_read() {
    // 64 million references would fit into such a block once it is inflated.
    let bomb = stored("OSMData", &vec![0; 4 << 20], Packing::Zlib);
    let long = changed(Columns::Dense, |blocks| {
        blocks[1].primitivegroup[0].ways[0].refs = vec![1; (1 << 20) + 1];
    });
    let many = changed(Columns::Dense, |blocks| {
        blocks[2].primitivegroup[0].relations[0].memids = vec![1; (1 << 20) + 1];
    });
    let header = stored("OSMHeader", b"", Packing::Raw);
    let texts = [[header, bomb].concat(), long, many].map(|bytes| message(pbf(&bytes)));
    insta::assert_snapshot!(texts.join("\n"), @r"
    town.osm.pbf, byte 36: a blob that inflates to more than 64 times its size; fetch the file again
    town.osm.pbf, byte 212: a way or relation of 1048593 bytes, more than one can have; fetch the file again
    town.osm.pbf, byte 398: a way or relation of 1048602 bytes, more than one can have; fetch the file again
    ");
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
fn an_extract_without_streets_says_what_to_fetch() {
    let mut town = Town::small();
    town.ways.drain(..3);
    let expected = "town.osm: no drivable street in it; take an extract with the ways tagged \
                    `highway` and their nodes";
    assert_eq!(message(xml(town.xml().as_bytes())), expected);
    let bytes = town.pbf(Packing::Raw, Columns::Dense);
    assert_eq!(message(pbf(&bytes)), expected.replace(".osm:", ".osm.pbf:"));
    assert!(matches!(pbf(b""), Err(OsmError::Nothing { .. })));
    assert!(matches!(xml(b""), Err(OsmError::Nothing { .. })));
}

#[test]
fn xml_that_is_no_extract_says_what_it_is() {
    let texts = [
        message(xml(b"<osmChange><modify/></osmChange>")),
        message(xml(b"<!DOCTYPE html><html><body>Too many requests</body></html>")),
        message(xml(b"<gpx/>")),
        message(gz(&store(b"{}"))),
        message(gz(&store(b"<gpx/>"))),
        message(gz(&store(&store(b"<osm/>")))),
        message(gz(b"<osm/>")),
    ];
    insta::assert_snapshot!(texts.join("\n"), @r"
    town.osm: holds changes (osmChange), no extract, but its name promises OpenStreetMap XML; apply them with `osmium apply-changes` and give the outcome
    town.osm: holds a web page, but its name promises OpenStreetMap XML; open it in a browser, it may say why no extract was sent
    town.osm: holds XML that is not OpenStreetMap's, but its name promises OpenStreetMap XML; its root element is `gpx`, that of an extract is `osm`
    town.osm.gz: holds JSON, but its name promises gzipped OpenStreetMap XML; decompress it with `gunzip`, then ask for XML, which Overpass calls `[out:xml]`
    town.osm.gz: holds XML that is not OpenStreetMap's, but its name promises gzipped OpenStreetMap XML; its root element is `gpx`, that of an extract is `osm`
    town.osm.gz: holds gzipped data, but its name promises gzipped OpenStreetMap XML; decompress it with `gunzip`, then decompress it with `gunzip`
    town.osm.gz, byte 6: the compressed data is cut off; fetch the file again
    ");
}

#[test]
fn xml_that_is_damaged_says_where() {
    let xml_text = Town::small().xml();
    let with = |from: &str, to: &str| message(xml(xml_text.replacen(from, to, 1).as_bytes()));
    let gz_bytes = store(xml_text.as_bytes());
    let mut flipped = gz_bytes.clone();
    flipped[300] ^= 0x10;
    let texts = [
        message(xml(&xml_text.as_bytes()[..500])),
        with("</osm>", ""),
        with("</osm>", "</osm><osm></osm>"),
        with("</way>", "</weg>"),
        with("v=\"primary\"", "v=\"prim&ary;\""),
        with("k=\"name\"", "k=\"name\" k=\"name\""),
        with("</osm>", "<remark>runtime error: Query timed out</remark></osm>"),
        with("UTF-8", "ISO-8859-1"),
        with("<node", &"<a>".repeat(70)),
        message(xml(&[b"<osm><x y='", &[0xff][..], b"'/></osm>"].concat())),
        message(gz(&gz_bytes[..gz_bytes.len() - 30])),
        message(gz(&[&gz_bytes[..], b"more"].concat())),
        message(gz(&flipped)),
    ];
    insta::assert_snapshot!(texts.join("\n"), @r#"
    town.osm, byte 500: syntax error: attribute value not closed: `"` not found before end of input; fetch the file again
    town.osm, byte 1780: the file ends before `</osm>`; fetch the file again
    town.osm, byte 1790: the file goes on after `</osm>`, as if two were joined; fetch the file again
    town.osm, byte 771: ill-formed document: expected `</way>`, but `</weg>` was found; fetch the file again
    town.osm, byte 696: at 5..8: unrecognized entity `ary`; fetch the file again
    town.osm, byte 752: error while parsing attribute: position 13: duplicated attribute, previous declaration at position 4; fetch the file again
    town.osm, byte 1817: the server gave up: runtime error: Query timed out; fetch the file again
    town.osm, line 1: the text is in ISO-8859-1; convert it to UTF-8 with `iconv`
    town.osm, byte 512: too many elements within each other; fetch the file again
    town.osm, byte 21: cannot decode input using UTF-8: invalid utf-8 sequence of 1 bytes from index 6; fetch the file again
    town.osm.gz, byte 1779: the compressed data is cut off; fetch the file again
    town.osm.gz, byte 1813: the compressed data is cut off; fetch the file again
    town.osm.gz, byte 1809: corrupt gzip stream does not have a matching checksum; fetch the file again
    "#);
}

#[test]
fn xml_elements_without_bounds_are_damage() {
    let way = |parts: &str| message(xml(format!("<osm><way id='1'>{parts}").as_bytes()));
    let nodes = way(&"<nd ref='1'/>".repeat(1_000_000));
    assert!(nodes.contains("Way 1 is larger than it can be"), "{nodes}");
    let text = way(&format!("<tag k='name' v='{}'/>", "x".repeat(17_000_000)));
    assert!(text.contains("a tag or text of more than 16777216 bytes"), "{text}");
    let attributes: String = (0..1_000_000).map(|i| format!(" a{i}=''")).collect();
    let attributes = way(&format!("<tag{attributes}/>"));
    assert!(attributes.contains("more than 100 attributes"), "{attributes}");
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
fn a_byte_order_mark_changes_nothing() {
    let marked = ["\u{feff}", &Town::small().xml()].concat();
    assert_eq!(xml(marked.as_bytes()).unwrap(), xml(&marked.as_bytes()[3..]).unwrap());
}

#[test]
fn blobs_and_features_that_may_be_skipped_are_skipped() {
    let town = Town::small().pbf(Packing::Zlib, Columns::Dense);
    let optional = [0x2a, 15].into_iter().chain(*b"LocationsOnWays").collect::<Vec<_>>();
    let header = stored("OSMHeader", &optional, Packing::Zlib);
    let bytes = [&header[..], &stored("Other", b"?", Packing::Raw), &town].concat();
    assert_eq!(pbf(&bytes).unwrap(), pbf(&town).unwrap());
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
    assert_eq!(extract.nodes.place(0).unwrap().latitude_e7, 5);
    assert_eq!(extract.restrictions.len(), 1);
    assert_eq!(extract.oddities.iter().filter(|(r, _)| r.starts_with("two ")).count(), 4);
    assert_eq!(pbf(&town.pbf(Packing::Zlib, Columns::Plain)).unwrap(), extract);
}

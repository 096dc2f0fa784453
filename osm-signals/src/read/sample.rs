//! A small town for the tests, written as PBF and XML.

use std::fmt::Write as _;
use std::io::Write as _;

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use osmpbfreader::fileformat::BlobHeader;
use osmpbfreader::osmformat::relation::MemberType;
use osmpbfreader::osmformat::{
    DenseNodes, HeaderBlock, Node, PrimitiveBlock, PrimitiveGroup, Relation, Way,
};
use protobuf::{Enum, EnumOrUnknown, Message};

/// Tags with their owners.
pub(super) type Text = Vec<(String, String)>;

/// An element's members: type, id, role.
pub(super) type Members = Vec<(MemberType, i64, String)>;

#[derive(Debug, Clone, Default)]
pub(super) struct Town {
    /// Id, latitude and longitude in 1e-7 degrees, tags.
    pub(super) nodes: Vec<(i64, i64, i64, Text)>,
    /// Id, nodes, tags.
    pub(super) ways: Vec<(i64, Vec<i64>, Text)>,
    /// Id, members, tags.
    pub(super) relations: Vec<(i64, Members, Text)>,
}

#[derive(Debug, Clone, Copy)]
pub(super) enum Packing {
    Raw,
    Zlib,
}

#[derive(Debug, Clone, Copy)]
pub(super) enum Columns {
    Dense,
    Plain,
}

pub(super) fn text(tags: &[(&str, &str)]) -> Text {
    tags.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect()
}

impl Town {
    /// Returns two streets that cross at a signal, a signal elsewhere, a path and a restriction.
    pub(super) fn small() -> Self {
        let mut nodes: Vec<_> = (0..5)
            .map(|i| (10 + i, 407_600_000 + 1000 * i, -1_118_900_000 - 1000 * i, Text::new()))
            .collect();
        nodes[2].3 = text(&[("highway", "traffic_signals"), ("crossing", "marked")]);
        nodes.push((-7, -335_000_000, 1_512_000_000, text(&[("highway", "traffic_signals")])));
        nodes.push((90, 1, 1, text(&[("amenity", "café & \"bar\" <1>")])));
        let main = text(&[("highway", "primary"), ("name", "State St & \"Main\""), ("lanes", "5")]);
        let ways = vec![
            (100, vec![10, 12], main.clone()),
            (101, vec![12, 11], main),
            (102, vec![13, 12, 14], text(&[("highway", "residential"), ("maxspeed", "25 mph")])),
            (103, vec![13, 90], text(&[("highway", "footway")])),
        ];
        let member = |kind, id, role: &str| (kind, id, role.to_owned());
        let turn = |to| {
            vec![
                member(MemberType::WAY, 100, "from"),
                member(MemberType::NODE, 12, "via"),
                member(MemberType::WAY, to, "to"),
            ]
        };
        let no_left = text(&[("type", "restriction"), ("restriction", "no_left_turn")]);
        let relations = vec![
            (200, turn(101), no_left.clone()),
            (201, turn(103), no_left),
            (202, turn(101), text(&[("type", "route"), ("route", "bus")])),
        ];
        Self { nodes, ways, relations }
    }

    /// Returns the file as PBF, every kind of element in a blob of its own.
    pub(super) fn pbf(&self, packing: Packing, columns: Columns) -> Vec<u8> {
        let header = HeaderBlock {
            required_features: vec!["OsmSchema-V0.6".to_owned(), "DenseNodes".to_owned()],
            ..HeaderBlock::new()
        };
        let mut file = stored("OSMHeader", &header.write_to_bytes().unwrap(), packing);
        for block in self.blocks(columns) {
            file.extend(stored("OSMData", &block.write_to_bytes().unwrap(), packing));
        }
        file
    }

    pub(super) fn blocks(&self, columns: Columns) -> Vec<PrimitiveBlock> {
        let mut blocks = Vec::new();
        let mut strings = Strings::default();
        let group = match columns {
            Columns::Dense => self.dense(&mut strings),
            Columns::Plain => PrimitiveGroup {
                nodes: self
                    .nodes
                    .iter()
                    .map(|(id, lat, lon, tags)| {
                        let (keys, vals) = strings.tags(tags);
                        let (id, lat, lon) = (Some(*id), Some(*lat), Some(*lon));
                        Node { id, lat, lon, keys, vals, ..Node::new() }
                    })
                    .collect(),
                ..PrimitiveGroup::new()
            },
        };
        blocks.push(strings.block(group));
        let mut strings = Strings::default();
        let mut group = PrimitiveGroup::new();
        for (id, refs, tags) in &self.ways {
            let (keys, vals) = strings.tags(tags);
            let refs = differences(refs.iter().copied());
            group.ways.push(Way { id: Some(*id), keys, vals, refs, ..Way::new() });
        }
        blocks.push(strings.block(group));
        let mut strings = Strings::default();
        let mut group = PrimitiveGroup::new();
        for (id, members, tags) in &self.relations {
            let (keys, vals) = strings.tags(tags);
            group.relations.push(Relation {
                id: Some(*id),
                keys,
                vals,
                memids: differences(members.iter().map(|(_, id, _)| *id)),
                types: members.iter().map(|(kind, ..)| EnumOrUnknown::new(*kind)).collect(),
                roles_sid: members.iter().map(|(.., role)| strings.index(role) as i32).collect(),
                ..Relation::new()
            });
        }
        blocks.push(strings.block(group));
        blocks
    }

    fn dense(&self, strings: &mut Strings) -> PrimitiveGroup {
        let mut keys_vals = Vec::new();
        for (.., tags) in &self.nodes {
            let (keys, vals) = strings.tags(tags);
            keys_vals.extend(keys.iter().zip(&vals).flat_map(|(k, v)| [*k as i32, *v as i32]));
            keys_vals.push(0);
        }
        let dense = DenseNodes {
            id: differences(self.nodes.iter().map(|n| n.0)),
            lat: differences(self.nodes.iter().map(|n| n.1)),
            lon: differences(self.nodes.iter().map(|n| n.2)),
            keys_vals,
            ..DenseNodes::new()
        };
        PrimitiveGroup { dense: Some(dense).into(), ..PrimitiveGroup::new() }
    }

    pub(super) fn xml(&self) -> String {
        let mut out =
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<osm version=\"0.6\">\n".to_owned();
        for (id, lat, lon, tags) in &self.nodes {
            let (lat, lon) = (*lat as f64 / 1e7, *lon as f64 / 1e7);
            let tags = xml_tags(tags);
            writeln!(out, "<node id='{id}' lat='{lat:.7}' lon='{lon:.7}'>{tags}</node>").unwrap();
        }
        for (id, refs, tags) in &self.ways {
            let refs: String = refs.iter().map(|node| format!("<nd ref='{node}'/>")).collect();
            writeln!(out, "<way id='{id}'>{refs}{}</way>", xml_tags(tags)).unwrap();
        }
        for (id, members, tags) in &self.relations {
            write!(out, "<relation id='{id}'>").unwrap();
            for (kind, id, role) in members {
                let kind = ["node", "way", "relation"][kind.value() as usize];
                write!(out, "<member type='{kind}' ref='{id}' role='{role}'/>").unwrap();
            }
            writeln!(out, "{}</relation>", xml_tags(tags)).unwrap();
        }
        out + "</osm>\n"
    }

    /// Returns the file as gzipped XML in two members.
    pub(super) fn gz(&self) -> Vec<u8> {
        let xml = self.xml();
        let (head, tail) = xml.as_bytes().split_at(xml.len() / 2);
        [gzip(head, Compression::fast()), gzip(tail, Compression::fast())].concat()
    }
}

fn xml_tags(tags: &Text) -> String {
    let escape = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&#34;");
    tags.iter().map(|(k, v)| format!("<tag k=\"{}\" v=\"{}\"/>", escape(k), escape(v))).collect()
}

pub(super) fn gzip(bytes: &[u8], level: Compression) -> Vec<u8> {
    let mut gz = GzEncoder::new(Vec::new(), level);
    gz.write_all(bytes).unwrap();
    gz.finish().unwrap()
}

fn differences(values: impl Iterator<Item = i64>) -> Vec<i64> {
    let mut last = 0;
    values.map(|value| value - std::mem::replace(&mut last, value)).collect()
}

/// The table of strings of a block; the first is empty, by the specification.
#[derive(Default)]
struct Strings(Vec<String>);

impl Strings {
    fn index(&mut self, text: &str) -> u32 {
        if self.0.is_empty() {
            self.0.push(String::new());
        }
        let known = self.0.iter().skip(1).position(|known| known == text);
        known.map_or_else(
            || {
                self.0.push(text.to_owned());
                self.0.len() - 1
            },
            |index| index + 1,
        ) as u32
    }

    fn tags(&mut self, tags: &Text) -> (Vec<u32>, Vec<u32>) {
        tags.iter().map(|(k, v)| (self.index(k), self.index(v))).unzip()
    }

    fn block(self, group: PrimitiveGroup) -> PrimitiveBlock {
        let mut block = PrimitiveBlock::new();
        block.stringtable.mut_or_insert_default().s =
            self.0.into_iter().map(String::into_bytes).collect();
        block.primitivegroup.push(group);
        block
    }
}

pub(super) fn stored(kind: &str, content: &[u8], packing: Packing) -> Vec<u8> {
    let mut blob = osmpbfreader::fileformat::Blob::new();
    match packing {
        Packing::Raw => blob.raw = Some(content.to_vec()),
        Packing::Zlib => {
            let mut zlib = ZlibEncoder::new(Vec::new(), Compression::fast());
            zlib.write_all(content).unwrap();
            blob.zlib_data = Some(zlib.finish().unwrap());
            blob.raw_size = Some(content.len() as i32);
        }
    }
    framed(kind, &blob.write_to_bytes().unwrap())
}

pub(super) fn framed(kind: &str, blob: &[u8]) -> Vec<u8> {
    let mut header = BlobHeader::new();
    header.set_type(kind.to_owned());
    header.set_datasize(blob.len() as i32);
    let header = header.write_to_bytes().unwrap();
    [&(header.len() as u32).to_be_bytes()[..], &header, blob].concat()
}

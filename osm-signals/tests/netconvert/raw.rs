//! All ways of an extract with their tags, read without the product's own readers, and written as the OSM XML
//! that netconvert gets.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;
use osmpbfreader::{OsmId, OsmObj, OsmPbfReader};
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

type Tags = Vec<(String, String)>;

/// Kind, id, role.
type Member = (&'static str, i64, String);

/// Ways with their nodes, and turn restrictions.
#[derive(Debug, Default)]
pub(crate) struct Raw {
    /// Latitude, longitude, tags.
    pub(crate) nodes: BTreeMap<i64, (f64, f64, Tags)>,
    ways: BTreeMap<i64, (Vec<i64>, Tags)>,
    relations: BTreeMap<i64, (Vec<Member>, Tags)>,
}

impl Raw {
    /// Reads a file.
    pub(crate) fn read(path: &Path) -> Self {
        let mut raw = Self::default();
        if path.extension().is_some_and(|e| e == "pbf") {
            raw.read_pbf(path);
        } else {
            let mut text = String::new();
            let file = File::open(path).unwrap();
            match path.extension().is_some_and(|e| e == "gz") {
                true => MultiGzDecoder::new(file).read_to_string(&mut text).unwrap(),
                false => BufReader::new(file).read_to_string(&mut text).unwrap(),
            };
            raw.read_xml(&text);
        }
        raw.relations.retain(|_, (_, tags)| tags.iter().any(|(k, _)| k == "restriction"));
        raw
    }

    fn read_pbf(&mut self, path: &Path) {
        let owned = |tags: &osmpbfreader::Tags| {
            tags.iter().map(|(k, v)| (k.to_string(), v.to_string())).collect()
        };
        for object in OsmPbfReader::new(BufReader::new(File::open(path).unwrap())).iter() {
            match object.unwrap() {
                OsmObj::Node(n) => {
                    self.nodes.insert(n.id.0, (n.lat(), n.lon(), owned(&n.tags)));
                }
                OsmObj::Way(w) => {
                    let refs = w.nodes.iter().map(|n| n.0).collect();
                    self.ways.insert(w.id.0, (refs, owned(&w.tags)));
                }
                OsmObj::Relation(r) => {
                    let members = r.refs.iter().map(|m| {
                        let (kind, id) = match m.member {
                            OsmId::Node(n) => ("node", n.0),
                            OsmId::Way(w) => ("way", w.0),
                            OsmId::Relation(r) => ("relation", r.0),
                        };
                        (kind, id, m.role.to_string())
                    });
                    self.relations.insert(r.id.0, (members.collect(), owned(&r.tags)));
                }
            }
        }
    }

    fn read_xml(&mut self, text: &str) {
        let mut reader = Reader::from_str(text);
        let mut owner = (String::new(), 0);
        loop {
            let event = reader.read_event().unwrap();
            let (Event::Start(tag) | Event::Empty(tag)) = &event else {
                if event == Event::Eof {
                    return;
                }
                continue;
            };
            let (name, values) = attributes(tag);
            let number = |key: &str| values[key].parse::<i64>().unwrap();
            match (name.as_str(), owner.0.as_str()) {
                ("node", _) => {
                    let degrees = |key: &str| values[key].parse::<f64>().unwrap();
                    let node = (degrees("lat"), degrees("lon"), Tags::new());
                    self.nodes.insert(number("id"), node);
                }
                ("way", _) => {
                    self.ways.insert(number("id"), (Vec::new(), Tags::new()));
                }
                ("relation", _) => {
                    self.relations.insert(number("id"), (Vec::new(), Tags::new()));
                }
                ("nd", _) => self.ways.get_mut(&owner.1).unwrap().0.push(number("ref")),
                ("member", _) => {
                    let kinds = ["node", "way", "relation"];
                    let kind = kinds.into_iter().find(|k| *k == values["type"]).unwrap();
                    let member = (kind, number("ref"), values["role"].clone());
                    self.relations.get_mut(&owner.1).unwrap().0.push(member);
                }
                ("tag", kind) => {
                    let tags = match kind {
                        "node" => self.nodes.get_mut(&owner.1).map(|n| &mut n.2),
                        "way" => self.ways.get_mut(&owner.1).map(|w| &mut w.1),
                        _ => self.relations.get_mut(&owner.1).map(|r| &mut r.1),
                    };
                    tags.unwrap().push((values["k"].clone(), values["v"].clone()));
                }
                _ => {}
            }
            if ["node", "way", "relation"].contains(&name.as_str()) {
                owner = (name, number("id"));
            }
        }
    }

    /// Returns the ways that are closed to the public's motor vehicles, or reserved for parking.
    pub(crate) fn closed(&self) -> BTreeSet<i64> {
        let keys = ["access", "vehicle", "motor_vehicle", "motorcar"];
        let closed = |(key, value): &(String, String)| {
            (keys.contains(&&**key) && ["no", "private"].contains(&&**value)) || key == "service"
        };
        self.ways.iter().filter(|(_, way)| way.1.iter().any(closed)).map(|(id, _)| *id).collect()
    }

    /// Returns OSM XML.
    pub(crate) fn xml(&self) -> String {
        let mut xml = String::from("<osm version=\"0.6\">\n");
        let mut nodes: Vec<i64> = self.ways.values().flat_map(|w| w.0.iter().copied()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        for id in nodes {
            if let Some((lat, lon, tags)) = self.nodes.get(&id) {
                write!(xml, "<node id=\"{id}\" lat=\"{lat:.7}\" lon=\"{lon:.7}\">").unwrap();
                close(&mut xml, tags, "node");
            }
        }
        for (id, (refs, tags)) in &self.ways {
            write!(xml, "<way id=\"{id}\">").unwrap();
            for node in refs.iter().filter(|n| self.nodes.contains_key(n)) {
                write!(xml, "<nd ref=\"{node}\"/>").unwrap();
            }
            close(&mut xml, tags, "way");
        }
        for (id, (members, tags)) in &self.relations {
            write!(xml, "<relation id=\"{id}\">").unwrap();
            for (kind, id, role) in members {
                write!(xml, "<member type=\"{kind}\" ref=\"{id}\" role=\"{role}\"/>").unwrap();
            }
            close(&mut xml, tags, "relation");
        }
        xml + "</osm>\n"
    }
}

fn close(xml: &mut String, tags: &Tags, element: &str) {
    use quick_xml::escape::escape;
    for (key, value) in tags {
        let (key, value) = (escape(key.as_str()), escape(value.as_str()));
        write!(xml, "<tag k=\"{key}\" v=\"{value}\"/>").unwrap();
    }
    writeln!(xml, "</{element}>").unwrap();
}

/// Returns the name and the attributes of an element.
pub(crate) fn attributes(tag: &BytesStart<'_>) -> (String, BTreeMap<String, String>) {
    let name = tag.name().as_ref().to_string();
    let values = tag.attributes().map(|attribute| {
        let attribute = attribute.unwrap();
        let value = attribute.normalized_value(quick_xml::XmlVersion::Implicit1_0).unwrap();
        (attribute.key.as_ref().to_string(), value.into_owned())
    });
    (name, values.collect())
}

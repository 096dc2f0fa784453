//! The blocks of a PBF file: strings and groups of nodes, ways and relations.
//!
//! Everything here is checked: positions in the table of strings, sums of differences, lengths of
//! columns that belong together.

use osmpbfreader::osmformat::{DenseNodes, Info, Node, Relation, Way};
use protobuf::{Message, MessageField};

use super::Fault;
use super::collect::{Places, Streets};
use super::turns::{Kind, Member};
use super::wire::{Fields, Value};
use crate::extract::{Nodes, Place};

/// Units of coordinates per degree.
const NANODEGREES: f64 = 1e9;

/// Most bytes of a way or a relation. OpenStreetMap takes ways of 2,000 nodes and relations of 32,000 members, which are
/// a tenth of it.
const MOST_BYTES: usize = 1 << 20;

/// Fields of a group.
const NODE: u32 = 1;
const DENSE_NODES: u32 = 2;
const WAY: u32 = 3;
const RELATION: u32 = 4;

/// A block of data, of which only the frame is decoded.
pub(super) struct Block<'a> {
    bytes: &'a [u8],
    strings: &'a [u8],
    granularity: i64,
    latitude_offset: i64,
    longitude_offset: i64,
}

impl<'a> Block<'a> {
    /// Returns a block of an inflated blob.
    pub(super) fn parse(bytes: &'a [u8]) -> Result<Self, Fault> {
        let mut block = Self {
            bytes,
            strings: &[],
            // By the specification, in nanodegrees.
            granularity: 100,
            latitude_offset: 0,
            longitude_offset: 0,
        };
        for field in Fields::of(bytes) {
            match field? {
                (1, Value::Bytes(strings)) => block.strings = strings,
                (17, Value::Number(n)) => block.granularity = n as i64,
                (19, Value::Number(n)) => block.latitude_offset = n as i64,
                (20, Value::Number(n)) => block.longitude_offset = n as i64,
                _ => {}
            }
        }
        Ok(block)
    }

    /// Returns what the first pass keeps, and whether there are nodes for the second one.
    pub(super) fn streets(&self) -> Result<(Streets, bool), Fault> {
        let mut streets = Streets::default();
        let (mut way, mut relation) = (Way::new(), Relation::new());
        let (mut tags, mut refs, mut members) = (Vec::new(), Vec::new(), Vec::new());
        let (mut strings, mut nodes) = (None, false);
        self.elements(|field, bytes| {
            if matches!(field, NODE | DENSE_NODES) {
                nodes = true;
            }
            if !matches!(field, WAY | RELATION) {
                return Ok(());
            }
            // Blocks of nodes alone, most of a file, need no strings here.
            let strings = match &strings {
                Some(strings) => strings,
                None => strings.insert(self.strings()?),
            };
            if bytes.len() > MOST_BYTES {
                let size = bytes.len();
                let reason = format!("a way or relation of {size} bytes, more than one can have");
                return Err(Fault::Damaged(reason));
            }
            if field == WAY {
                way.clear();
                way.merge_from_bytes(bytes)?;
                let id = way.id.ok_or("a way without an id")?;
                if visible(&way.info) {
                    strings.tags(&way.keys, &way.vals, &mut tags)?;
                    sums(&way.refs, &mut refs)?;
                    streets.way(id, &tags, &refs);
                }
            } else {
                relation.clear();
                relation.merge_from_bytes(bytes)?;
                let id = relation.id.ok_or("a relation without an id")?;
                if visible(&relation.info) {
                    strings.tags(&relation.keys, &relation.vals, &mut tags)?;
                    sums(&relation.memids, &mut refs)?;
                    strings.members(&relation, &refs, &mut members)?;
                    streets.relation(id, &tags, &members);
                }
            }
            Ok(())
        })?;
        Ok((streets, nodes))
    }

    /// Returns what the second pass keeps.
    pub(super) fn places(&self, wanted: &Nodes) -> Result<Places, Fault> {
        let mut places = Places::default();
        let strings = self.strings()?;
        let (mut dense, mut node, mut tags) = (DenseNodes::new(), Node::new(), Vec::new());
        self.elements(|field, bytes| {
            match field {
                NODE => {
                    node.clear();
                    node.merge_from_bytes(bytes)?;
                    let (Some(id), Some(lat), Some(lon)) = (node.id, node.lat, node.lon) else {
                        return Err("a node without an id or a place".into());
                    };
                    if visible(&node.info) {
                        strings.tags(&node.keys, &node.vals, &mut tags)?;
                        places.node(wanted, id, &tags, || self.place(lat, lon));
                    }
                }
                DENSE_NODES => {
                    dense.clear();
                    dense.merge_from_bytes(bytes)?;
                    self.dense(&dense, &strings, wanted, &mut places)?;
                }
                _ => {}
            }
            Ok(())
        })?;
        Ok(places)
    }

    /// Goes through columns of nodes, each a column of differences.
    fn dense(
        &self,
        dense: &DenseNodes,
        strings: &Strings<'a>,
        wanted: &Nodes,
        places: &mut Places,
    ) -> Result<(), Fault> {
        let rows = dense.id.len();
        let visible = &dense.denseinfo.visible;
        if dense.lat.len() != rows
            || dense.lon.len() != rows
            || !(visible.is_empty() || visible.len() == rows)
        {
            return Err("columns of nodes differ in length".into());
        }
        let (mut id, mut lat, mut lon) = (0, 0, 0);
        let mut texts = dense.keys_vals.iter();
        let mut tags = Vec::new();
        for row in 0..rows {
            id = sum(id, dense.id[row])?;
            lat = sum(lat, dense.lat[row])?;
            lon = sum(lon, dense.lon[row])?;
            tags.clear();
            // No texts at all stand for nodes without tags.
            while !dense.keys_vals.is_empty() {
                match texts.next().ok_or("the tags of nodes end too early")? {
                    0 => break,
                    key => {
                        let value = texts.next().ok_or("the tags of nodes end too early")?;
                        tags.push((strings.get(*key)?, strings.get(*value)?));
                    }
                }
            }
            if visible.get(row) != Some(&false) {
                places.node(wanted, id, &tags, || self.place(lat, lon));
            }
        }
        Ok(())
    }

    /// Calls `act` with the field and the bytes of every element of every group.
    fn elements(
        &self,
        mut act: impl FnMut(u32, &'a [u8]) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        for field in Fields::of(self.bytes) {
            let (2, Value::Bytes(group)) = field? else { continue };
            for element in Fields::of(group) {
                if let (field, Value::Bytes(bytes)) = element? {
                    act(field, bytes)?;
                }
            }
        }
        Ok(())
    }

    fn strings(&self) -> Result<Strings<'a>, Fault> {
        let mut strings = Vec::new();
        for field in Fields::of(self.strings) {
            if let (1, Value::Bytes(text)) = field? {
                strings.push(str::from_utf8(text).map_err(|_| "text that is not UTF-8")?);
            }
        }
        Ok(Strings(strings))
    }

    /// Returns a place; `None` if it is not on Earth.
    fn place(&self, lat: i64, lon: i64) -> Option<Place> {
        let degrees = |offset: i64, value: i64| {
            let nanodegrees = value.checked_mul(self.granularity)?.checked_add(offset)?;
            Some(nanodegrees as f64 / NANODEGREES)
        };
        let latitude = degrees(self.latitude_offset, lat)?;
        Place::from_degrees(latitude, degrees(self.longitude_offset, lon)?)
    }
}

/// The texts of a block.
struct Strings<'a>(Vec<&'a str>);

impl<'a> Strings<'a> {
    fn get(&self, index: impl TryInto<usize>) -> Result<&'a str, Fault> {
        let text = index.try_into().ok().and_then(|index| self.0.get(index));
        Ok(text.ok_or("a text that is not in the table of texts")?)
    }

    fn tags(
        &self,
        keys: &[u32],
        values: &[u32],
        tags: &mut Vec<(&'a str, &'a str)>,
    ) -> Result<(), Fault> {
        tags.clear();
        if keys.len() != values.len() {
            return Err("more keys than values or the reverse".into());
        }
        for (key, value) in keys.iter().zip(values) {
            tags.push((self.get(*key)?, self.get(*value)?));
        }
        Ok(())
    }

    fn members(
        &self,
        relation: &Relation,
        ids: &[i64],
        members: &mut Vec<Member<'a>>,
    ) -> Result<(), Fault> {
        members.clear();
        if relation.roles_sid.len() != ids.len() || relation.types.len() != ids.len() {
            return Err("columns of members differ in length".into());
        }
        for (i, id) in ids.iter().enumerate() {
            let kind = match relation.types[i].value() {
                0 => Kind::Node,
                1 => Kind::Way,
                2 => Kind::Relation,
                _ => return Err("a member of an unknown kind".into()),
            };
            members.push(Member { kind, id: *id, role: self.get(relation.roles_sid[i])? });
        }
        Ok(())
    }
}

/// Returns whether an element is not deleted.
fn visible(info: &MessageField<Info>) -> bool {
    info.visible != Some(false)
}

/// Sums differences up.
fn sums(differences: &[i64], sums: &mut Vec<i64>) -> Result<(), Fault> {
    sums.clear();
    let mut last = 0;
    for difference in differences {
        last = sum(last, *difference)?;
        sums.push(last);
    }
    Ok(())
}

fn sum(last: i64, difference: i64) -> Result<i64, Fault> {
    Ok(last.checked_add(difference).ok_or("a number that is too large")?)
}

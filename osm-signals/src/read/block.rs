//! The blocks of a PBF file: strings and groups of nodes, ways and relations.
//!
//! Everything here is checked: positions in the table of strings, sums of differences, lengths of
//! columns that belong together.

use osmpbfreader::osmformat::{DenseNodes, PrimitiveBlock, Relation};
use protobuf::Message;

use super::Fault;
use super::collect::{Places, Streets};
use super::turns::{Kind, Member};
use crate::extract::{Nodes, Place};

/// Units of coordinates per degree.
const NANODEGREES: f64 = 1e9;

/// Most nodes of a way and members of a relation; OpenStreetMap takes 2,000 and 32,000.
const MOST_REFS: usize = 1 << 20;

/// A block of data.
pub(super) struct Block(PrimitiveBlock);

impl Block {
    /// Returns a block of an inflated blob.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, Fault> {
        Ok(Self(PrimitiveBlock::parse_from_bytes(bytes).map_err(|e| e.to_string())?))
    }

    /// Returns what the first pass keeps, and whether there are nodes for the second one.
    pub(super) fn streets(&self) -> Result<(Streets, bool), Fault> {
        let (mut streets, mut nodes) = (Streets::default(), false);
        for group in &self.0.primitivegroup {
            nodes |= !group.nodes.is_empty() || group.dense.is_some();
            for way in group.ways.iter().filter(|way| way.info.visible != Some(false)) {
                let refs = sums(&way.refs)?;
                streets.way(way.id(), &self.tags(&way.keys, &way.vals)?, &refs);
            }
            for relation in group.relations.iter().filter(|r| r.info.visible != Some(false)) {
                let tags = self.tags(&relation.keys, &relation.vals)?;
                streets.relation(relation.id(), &tags, &self.members(relation)?);
            }
        }
        Ok((streets, nodes))
    }

    /// Returns what the second pass keeps.
    pub(super) fn places(&self, wanted: &Nodes) -> Result<Places, Fault> {
        let mut places = Places::default();
        for group in &self.0.primitivegroup {
            for node in group.nodes.iter().filter(|node| node.info.visible != Some(false)) {
                let tags = self.tags(&node.keys, &node.vals)?;
                places.node(wanted, node.id(), &tags, || self.place(node.lat(), node.lon()));
            }
            self.dense(&group.dense, wanted, &mut places)?;
        }
        Ok(places)
    }

    /// Goes through columns of nodes, each a column of differences.
    fn dense(&self, dense: &DenseNodes, wanted: &Nodes, to: &mut Places) -> Result<(), Fault> {
        let (rows, visible) = (dense.id.len(), &dense.denseinfo.visible);
        let as_long = visible.is_empty() || visible.len() == rows;
        if dense.lat.len() != rows || dense.lon.len() != rows || !as_long {
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
                let key = texts.next().ok_or("the tags of nodes end too early")?;
                if *key == 0 {
                    break;
                }
                let value = texts.next().ok_or("the tags of nodes end too early")?;
                tags.push((self.text(*key)?, self.text(*value)?));
            }
            if visible.get(row) != Some(&false) {
                to.node(wanted, id, &tags, || self.place(lat, lon));
            }
        }
        Ok(())
    }

    /// Returns a place; `None` if it is not on Earth.
    fn place(&self, lat: i64, lon: i64) -> Option<Place> {
        let degrees = |offset: i64, value: i64| {
            let scaled = value.checked_mul(i64::from(self.0.granularity()))?;
            Some(scaled.checked_add(offset)? as f64 / NANODEGREES)
        };
        Place::from_degrees(degrees(self.0.lat_offset(), lat)?, degrees(self.0.lon_offset(), lon)?)
    }

    fn text(&self, index: impl TryInto<usize>) -> Result<&str, Fault> {
        let text = index.try_into().ok().and_then(|index| self.0.stringtable.s.get(index));
        let text = text.ok_or("a text that is not in the table of texts")?;
        Ok(str::from_utf8(text).map_err(|_| "text that is not UTF-8")?)
    }

    fn tags(&self, keys: &[u32], values: &[u32]) -> Result<Vec<(&str, &str)>, Fault> {
        if keys.len() != values.len() {
            return Err("more keys than values or the reverse".into());
        }
        keys.iter().zip(values).map(|(k, v)| Ok((self.text(*k)?, self.text(*v)?))).collect()
    }

    fn members(&self, relation: &Relation) -> Result<Vec<Member<'_>>, Fault> {
        let Relation { roles_sid, types, .. } = relation;
        let ids = sums(&relation.memids)?;
        if roles_sid.len() != ids.len() || types.len() != ids.len() {
            return Err("columns of members differ in length".into());
        }
        let member = |((id, role), kind): ((i64, &i32), &protobuf::EnumOrUnknown<_>)| {
            let kind = match kind.value() {
                0 => Kind::Node,
                1 => Kind::Way,
                2 => Kind::Relation,
                _ => return Err("a member of an unknown kind".into()),
            };
            Ok(Member { kind, id, role: self.text(*role)? })
        };
        ids.into_iter().zip(roles_sid).zip(types).map(member).collect()
    }
}

/// Sums differences up.
fn sums(differences: &[i64]) -> Result<Vec<i64>, Fault> {
    if differences.len() > MOST_REFS {
        return Err("a way or relation of more nodes or members than one can have".into());
    }
    let mut last = 0;
    let add = |difference: &i64| {
        last = sum(last, *difference)?;
        Ok(last)
    };
    differences.iter().map(add).collect()
}

fn sum(last: i64, difference: i64) -> Result<i64, Fault> {
    Ok(last.checked_add(difference).ok_or("a number that is too large")?)
}

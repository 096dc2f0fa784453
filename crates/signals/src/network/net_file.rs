//! What the generator reads back from a network that netconvert wrote.

use std::collections::{BTreeMap, BTreeSet};

use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use super::phases::ProgramPhase;
use super::plain::{PLAIN, TURN_ON_RED};

/// A lane of an edge that is not within a junction.
#[derive(Debug, Clone, PartialEq)]
pub struct NetLane {
    /// Edge that it belongs to.
    pub edge: String,
    /// Length, metres.
    pub length_m: f64,
    /// Speed limit, metres per second.
    pub speed_mps: f64,
}

/// A connection that a signal controls.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NetLink {
    /// Incoming edge.
    pub from: String,
    /// Outgoing edge.
    pub to: String,
    /// Lane of the incoming edge, counted from the right.
    pub from_lane: u32,
    /// Lane of the outgoing edge, counted from the right.
    pub to_lane: u32,
    /// Signal.
    pub signal: String,
    /// Place in the signal's state.
    pub link: usize,
    /// Row of the junction's right-of-way matrix.
    pub request: usize,
}

/// One row of a junction's right-of-way matrix.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Request {
    /// Per row whether the two paths meet.
    pub foes: Vec<bool>,
    /// Per row whether this one yields to it.
    pub yields_to: Vec<bool>,
}

/// The parts of a network that decide how traffic flows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NetFile {
    /// Lanes outside junctions.
    pub lanes: Vec<NetLane>,
    /// Links of signals, in file order.
    pub links: Vec<NetLink>,
    /// Programs in file order: signal, program id, phases.
    pub programs: Vec<(String, String, Vec<ProgramPhase>)>,
    /// Right-of-way matrices of the junctions with a signal, by row.
    pub requests: BTreeMap<usize, Request>,
    /// Lanes within the junction with a signal, in the order of the matrix.
    inner_lanes: Vec<String>,
    /// Per connection with a `via`: where it comes from, and the lane within the junction.
    via: Vec<(String, u32, String)>,
}

impl NetFile {
    /// Parses a network with one signal.
    ///
    /// # Errors
    ///
    /// What is wrong, in words, if it is not well-formed XML or lacks an attribute.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut net = Self::default();
        let mut reader = Reader::from_str(text);
        let (mut edge, mut at_signal) = (String::new(), false);
        let mut pending = Vec::new();
        let mut complete = false;
        loop {
            let event = reader
                .read_event()
                .map_err(|e| format!("not well-formed at byte {}: {e}", reader.error_position()))?;
            let tag = match &event {
                Event::Eof => break,
                Event::End(tag) if tag.name().as_ref() == "net" => {
                    complete = true;
                    continue;
                }
                Event::Start(tag) | Event::Empty(tag) => Tag::read(tag)?,
                _ => continue,
            };
            match tag.name.as_str() {
                "edge" => edge = tag.text("id")?,
                "lane" if !edge.starts_with(':') => net.lanes.push(NetLane {
                    edge: edge.clone(),
                    length_m: tag.number("length")?,
                    speed_mps: tag.number("speed")?,
                }),
                "junction" => {
                    let kind = tag.attributes.get("type").map(String::as_str);
                    at_signal = kind.is_some_and(|kind| [PLAIN, TURN_ON_RED].contains(&kind));
                    if at_signal {
                        let lanes = tag.text("intLanes")?;
                        net.inner_lanes = lanes.split_whitespace().map(str::to_owned).collect();
                    }
                }
                "request" if at_signal => {
                    let bits = |name| {
                        Ok::<_, String>(tag.text(name)?.bytes().rev().map(|b| b == b'1').collect())
                    };
                    let request = Request { foes: bits("foes")?, yields_to: bits("response")? };
                    net.requests.insert(tag.number("index")?, request);
                }
                "tlLogic" => {
                    net.programs.push((tag.text("id")?, tag.text("programID")?, Vec::new()));
                }
                "phase" => {
                    let phase = ProgramPhase {
                        duration_s: tag.number("duration")?,
                        state: tag.text("state")?,
                    };
                    let program = net.programs.last_mut().ok_or("a phase outside a tlLogic")?;
                    program.2.push(phase);
                }
                "connection" => net.connection(&tag, &mut pending)?,
                _ => {}
            }
        }
        if !complete {
            return Err("cut off: it ends before `</net>`".to_owned());
        }
        for (mut link, via) in pending {
            link.request = net.request_of(&via).ok_or_else(|| {
                format!("connection {} to {} is not in the junction's matrix", link.from, link.to)
            })?;
            net.links.push(link);
        }
        Ok(net)
    }

    fn connection(
        &mut self,
        tag: &Tag,
        pending: &mut Vec<(NetLink, String)>,
    ) -> Result<(), String> {
        let (from, from_lane) = (tag.text("from")?, tag.number("fromLane")?);
        let via = tag.attributes.get("via");
        if tag.attributes.contains_key("tl") {
            let via = via.ok_or_else(|| format!("no lane within the junction from {from}"))?;
            let link = NetLink {
                to: tag.text("to")?,
                to_lane: tag.number("toLane")?,
                signal: tag.text("tl")?,
                link: tag.number("linkIndex")?,
                request: 0,
                from,
                from_lane,
            };
            pending.push((link, via.clone()));
        } else if let Some(via) = via {
            self.via.push((from, from_lane, via.clone()));
        }
        Ok(())
    }

    /// Returns the row of a lane within the junction; where vehicles wait within the junction, the
    /// matrix counts the lane behind that place.
    fn request_of(&self, lane: &str) -> Option<usize> {
        self.inner_lanes.iter().position(|l| l == lane).or_else(|| {
            let (edge, index) = lane.rsplit_once('_')?;
            let next = self.via.iter().find(|(e, i, _)| e == edge && index == i.to_string())?;
            self.inner_lanes.iter().position(|l| *l == next.2)
        })
    }

    /// Returns whether the paths of two links meet within the junction.
    pub fn meet(&self, a: &NetLink, b: &NetLink) -> bool {
        let foe = |a: &NetLink, b: &NetLink| self.bit(a, b, |row| &row.foes);
        foe(a, b) || foe(b, a)
    }

    /// Returns whether one link yields to another when it is green only permissively.
    pub fn yields(&self, link: &NetLink, to: &NetLink) -> bool {
        self.bit(link, to, |row| &row.yields_to)
    }

    fn bit(&self, a: &NetLink, b: &NetLink, bits: impl Fn(&Request) -> &[bool]) -> bool {
        let row = self.requests.get(&a.request);
        row.and_then(|row| bits(row).get(b.request).copied()).unwrap_or(false)
    }

    /// Returns whether a program shows one green only, so that there is nothing to decide.
    pub fn has_one_green(&self, program: &str) -> bool {
        let is_green =
            |p: &&ProgramPhase| p.state.contains(['g', 'G']) && !p.state.contains(['y', 'Y']);
        let phases = self.program(program).unwrap_or_default();
        let greens: BTreeSet<&str> =
            phases.iter().filter(is_green).map(|p| p.state.as_str()).collect();
        greens.len() == 1
    }

    /// Returns a program's phases.
    pub fn program(&self, id: &str) -> Option<&[ProgramPhase]> {
        self.programs.iter().find(|(_, program, _)| program == id).map(|p| p.2.as_slice())
    }
}

/// An element's name and attributes.
struct Tag {
    name: String,
    attributes: BTreeMap<String, String>,
}

impl Tag {
    fn read(start: &BytesStart<'_>) -> Result<Self, String> {
        let mut attributes = BTreeMap::new();
        for attribute in start.attributes() {
            let attribute = attribute.map_err(|e| e.to_string())?;
            let value = attribute.normalized_value(quick_xml::XmlVersion::Implicit1_0);
            let value = value.map_err(|e| e.to_string())?.into_owned();
            attributes.insert(attribute.key.into_inner().to_owned(), value);
        }
        Ok(Self { name: start.name().into_inner().to_owned(), attributes })
    }

    fn text(&self, name: &str) -> Result<String, String> {
        let value = self.attributes.get(name).cloned();
        value.ok_or_else(|| format!("<{}> without {name}", self.name))
    }

    fn number<T: std::str::FromStr>(&self, name: &str) -> Result<T, String> {
        let text = self.text(name)?;
        text.parse().map_err(|_| format!("<{}> has {name}={text:?}: not a number", self.name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NET: &str = r#"<net><edge id=":c_0"><lane id=":c_0_0" length="4" speed="8"/></edge>
        <edge id="in0"><lane id="in0_0" length="200.00" speed="13.41"/></edge>
        <tlLogic id="c" type="static" programID="0" offset="0">
            <phase duration="42" state="Gg"/></tlLogic>
        <junction id="c" type="traffic_light" incLanes="in0_0" intLanes=":c_1_0 :c_9_0">
            <request index="0" response="00" foes="10" cont="0"/>
            <request index="1" response="01" foes="01" cont="1"/></junction>
        <connection from="in0" to="out1" fromLane="0" toLane="1" via=":c_0_0" tl="c" linkIndex="1"/>
        <connection from="in0" to="out2" fromLane="0" toLane="0" via=":c_1_0" tl="c" linkIndex="0"/>
        <connection from=":c_0" to="out1" fromLane="0" toLane="1" via=":c_9_0"/></net>"#;

    #[test]
    fn lanes_within_the_junction_are_left_out() {
        let net = NetFile::parse(NET).unwrap();
        assert_eq!(net.lanes.len(), 1);
        assert_eq!((net.lanes[0].edge.as_str(), net.lanes[0].length_m), ("in0", 200.0));
    }

    #[test]
    fn a_link_that_waits_within_the_junction_finds_its_row() {
        let net = NetFile::parse(NET).unwrap();
        let rows: Vec<_> = net.links.iter().map(|l| (l.link, l.request)).collect();
        assert_eq!(rows, [(1, 1), (0, 0)]);
    }

    #[test]
    fn the_matrix_reads_from_the_right() {
        let net = NetFile::parse(NET).unwrap();
        assert_eq!(net.requests[&1].yields_to, [true, false]);
        assert_eq!(net.requests[&0].foes, [false, true]);
    }

    #[test]
    fn programs_keep_their_phases() {
        let net = NetFile::parse(NET).unwrap();
        assert_eq!(net.program("0").unwrap()[0].state, "Gg");
        assert!(net.program("1").is_none());
    }

    #[test]
    fn truncated_xml_is_an_error() {
        assert!(NetFile::parse("<net><edge id=\"a").is_err());
        let cut = NET.trim_end().strip_suffix("</net>").unwrap();
        assert_eq!(NetFile::parse(cut).unwrap_err(), "cut off: it ends before `</net>`");
    }

    #[test]
    fn a_missing_attribute_is_named() {
        assert_eq!(NetFile::parse("<net><edge/></net>").unwrap_err(), "<edge> without id");
    }
}

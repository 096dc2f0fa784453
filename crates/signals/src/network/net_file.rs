//! What the generator reads back from a network that netconvert wrote.

use std::collections::{BTreeMap, BTreeSet};

use roxmltree::{Document, Node};

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
}

impl NetFile {
    /// Parses a network with one signal.
    ///
    /// # Errors
    ///
    /// What is wrong, in words, if it is not well-formed XML or lacks an attribute.
    pub fn parse(text: &str) -> Result<Self, String> {
        if !text.trim_end().ends_with("</net>") {
            return Err("cut off: it ends before `</net>`".to_owned());
        }
        let document = Document::parse(text).map_err(|e| format!("not well-formed: {e}"))?;
        let all = |name| document.descendants().filter(move |node| node.has_tag_name(name));
        let mut net = Self::default();
        for edge in all("edge") {
            let id = attribute(edge, "id")?;
            let lanes = edge.children().filter(|node| node.has_tag_name("lane"));
            for lane in lanes.filter(|_| !id.starts_with(':')) {
                let (length_m, speed_mps) = (number(lane, "length")?, number(lane, "speed")?);
                net.lanes.push(NetLane { edge: id.to_owned(), length_m, speed_mps });
            }
        }
        let is_signal = |node: &Node<'_, '_>| {
            node.attribute("type").is_some_and(|kind| [PLAIN, TURN_ON_RED].contains(&kind))
        };
        let mut inner_lanes = Vec::new();
        for junction in all("junction").filter(is_signal) {
            inner_lanes = attribute(junction, "intLanes")?.split_whitespace().collect();
            for row in junction.children().filter(|node| node.has_tag_name("request")) {
                let bits = |name| {
                    Ok::<_, String>(
                        attribute(row, name)?.bytes().rev().map(|b| b == b'1').collect(),
                    )
                };
                let request = Request { foes: bits("foes")?, yields_to: bits("response")? };
                net.requests.insert(number(row, "index")?, request);
            }
        }
        for program in all("tlLogic") {
            let phases =
                program.children().filter(|node| node.has_tag_name("phase")).map(|phase| {
                    let state = attribute(phase, "state")?.to_owned();
                    Ok(ProgramPhase { duration_s: number(phase, "duration")?, state })
                });
            let (id, name) = (attribute(program, "id")?, attribute(program, "programID")?);
            let phases = phases.collect::<Result<_, String>>()?;
            net.programs.push((id.to_owned(), name.to_owned(), phases));
        }
        // Where vehicles wait within the junction, the matrix counts the lane behind that place.
        let behind = |lane: &str| {
            let (edge, index) = lane.rsplit_once('_')?;
            let is = |c: &Node<'_, '_>| {
                let at = (c.attribute("from"), c.attribute("fromLane"));
                at == (Some(edge), Some(index)) && !c.has_attribute("tl")
            };
            all("connection").filter(is).find_map(|c| c.attribute("via"))
        };
        let row = |lane: &str| inner_lanes.iter().position(|inner| *inner == lane);
        for link in all("connection").filter(|node| node.has_attribute("tl")) {
            let (from, to) = (attribute(link, "from")?, attribute(link, "to")?);
            let via = link.attribute("via");
            let via = via.ok_or_else(|| format!("no lane within the junction from {from}"))?;
            let request = row(via).or_else(|| row(behind(via)?)).ok_or_else(|| {
                format!("connection {from} to {to} is not in the junction's matrix")
            })?;
            net.links.push(NetLink {
                from: from.to_owned(),
                to: to.to_owned(),
                from_lane: number(link, "fromLane")?,
                to_lane: number(link, "toLane")?,
                signal: attribute(link, "tl")?.to_owned(),
                link: number(link, "linkIndex")?,
                request,
            });
        }
        Ok(net)
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

fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Result<&'a str, String> {
    node.attribute(name).ok_or_else(|| format!("<{}> without {name}", node.tag_name().name()))
}

fn number<T: std::str::FromStr>(node: Node<'_, '_>, name: &str) -> Result<T, String> {
    let (text, tag) = (attribute(node, name)?, node.tag_name().name());
    text.parse().map_err(|_| format!("<{tag}> has {name}={text:?}: not a number"))
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

//! SUMO's network files: what the generator reads back of those that netconvert wrote, and what is known of somebody's own.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io::Read;
use std::path::Path;

use roxmltree::{Document, Node};

use super::sources::open;
use super::sumocfg::SumoConfig;
use crate::junction::Conflicts;
use basics::files::FileError;

/// Letters of a state that let vehicles pass and yield.
const MINOR: &[u8] = b"gos";

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
}

/// A phase of a SUMO program.
#[derive(Debug, Clone, PartialEq)]
pub struct ProgramPhase {
    /// Duration, seconds.
    pub duration_s: f64,
    /// SUMO's state, one letter per link.
    pub state: String,
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
    /// Per signal how its links stand to each other, from the junctions' right-of-way matrices.
    pub conflicts: BTreeMap<String, Conflicts>,
    /// Per signal the pairs of links of which each yields to the other.
    mutual: BTreeMap<String, Vec<(usize, usize)>>,
}

impl NetFile {
    /// Reads the first network of a configuration, which may be compressed; where it is none, SUMO says what is wrong with it.
    ///
    /// # Errors
    ///
    /// [`FileError`] when the file cannot be opened.
    pub fn of_scenario(config: &SumoConfig) -> Result<Self, FileError> {
        let Some(network) = config.networks().next() else { return Ok(Self::default()) };
        let mut text = String::new();
        open(network)?.read_to_string(&mut text).map_err(FileError::at("read", network))?;
        Ok(Self::parse(&text).unwrap_or_default())
    }

    /// Parses a network.
    ///
    /// # Errors
    ///
    /// What is wrong, in words, if it is not well-formed XML or lacks an attribute.
    pub fn parse(text: &str) -> Result<Self, String> {
        if !text.trim_end().ends_with("</net>") {
            return Err("cut off: it ends before `</net>`".to_owned());
        }
        let document = Document::parse(text).map_err(|e| format!("not well-formed: {e}"))?;
        let all = |name| document.root_element().children().filter(move |n| n.has_tag_name(name));
        let mut net = Self::default();
        for edge in all("edge") {
            let id = attribute(edge, "id")?;
            let lanes = edge.children().filter(|node| node.has_tag_name("lane"));
            for lane in lanes.filter(|_| !id.starts_with(':')) {
                let (length_m, speed_mps) = (number(lane, "length")?, number(lane, "speed")?);
                net.lanes.push(NetLane { edge: id.to_owned(), length_m, speed_mps });
            }
        }
        for program in all("tlLogic") {
            let phases = program.children().filter(|node| node.has_tag_name("phase"));
            let phases = phases.map(|phase| {
                let state = attribute(phase, "state")?.to_owned();
                Ok(ProgramPhase { duration_s: number(phase, "duration")?, state })
            });
            let (id, name) = (attribute(program, "id")?, attribute(program, "programID")?);
            let phases = phases.collect::<Result<_, String>>()?;
            net.programs.push((id.to_owned(), name.to_owned(), phases));
        }
        let mut of_lane: HashMap<String, Vec<Node<'_, '_>>> = HashMap::new();
        for connection in all("connection") {
            let (from, to) = (attribute(connection, "from")?, attribute(connection, "to")?);
            // Ways out of a junction are no links of it.
            if !from.starts_with(':') || to.starts_with(':') {
                let lane = format!("{from}_{}", attribute(connection, "fromLane")?);
                of_lane.entry(lane).or_default().push(connection);
            }
            if let Some(signal) = connection.attribute("tl").filter(|_| !from.starts_with(':')) {
                net.links.push(NetLink {
                    from: from.to_owned(),
                    to: to.to_owned(),
                    from_lane: number(connection, "fromLane")?,
                    to_lane: number(connection, "toLane")?,
                    signal: signal.to_owned(),
                    link: number(connection, "linkIndex")?,
                });
            }
        }
        for junction in all("junction") {
            net.add_matrix(junction, &of_lane)?;
        }
        Ok(net)
    }

    /// Adds a junction's right-of-way matrix, which has a row per link, in the order of incoming lanes and of the file.
    fn add_matrix(
        &mut self,
        junction: Node<'_, '_>,
        of_lane: &HashMap<String, Vec<Node<'_, '_>>>,
    ) -> Result<(), String> {
        let rows = junction.children().filter(|node| node.has_tag_name("request"));
        // The last letter is of the first link.
        let bits = |row: Node<'_, '_>, name| {
            Ok::<Vec<bool>, String>(
                attribute(row, name)?.bytes().rev().map(|b| b == b'1').collect(),
            )
        };
        let rows = rows.map(|row| Ok([bits(row, "foes")?, bits(row, "response")?]));
        let rows: Vec<[Vec<bool>; 2]> = rows.collect::<Result<_, String>>()?;
        let id = junction.attribute("id").unwrap_or_default();
        let lanes = junction.attribute("incLanes").unwrap_or_default().split_whitespace();
        let own = lanes.filter_map(|lane| of_lane.get(lane)).flatten();
        let own = own.filter(|connection| is_counted(connection, id));
        let signals: Vec<Option<(&str, usize)>> =
            own.map(|c| c.attribute("tl").zip(number(*c, "linkIndex").ok())).collect();
        let bit = |a: usize, b: usize, kind: usize| rows[a][kind].get(b).is_some_and(|bit| *bit);
        let links = || signals.iter().take(rows.len()).enumerate();
        for (a, own) in links() {
            let Some((signal, i)) = *own else { continue };
            let known = self.conflicts.entry(signal.to_owned()).or_default();
            for (b, other) in links() {
                let Some((_, j)) = other.filter(|other| other.0 == signal) else { continue };
                known.add(i, j, bit(a, b, 0), bit(a, b, 1));
                if a < b && bit(a, b, 1) && bit(b, a, 1) {
                    self.mutual.entry(signal.to_owned()).or_default().push((i, j));
                }
            }
        }
        Ok(())
    }

    /// Returns whether the paths of two links meet within the junction.
    pub fn meet(&self, a: &NetLink, b: &NetLink) -> bool {
        let known = self.conflicts.get(&a.signal).filter(|_| a.signal == b.signal);
        known.is_some_and(|known| known.meet(a.link, b.link))
    }

    /// Returns whether one link yields to another when it is green only permissively.
    pub fn yields(&self, link: &NetLink, to: &NetLink) -> bool {
        let known = self.conflicts.get(&link.signal).filter(|_| link.signal == to.signal);
        known.is_some_and(|known| known.yields(link.link, to.link))
    }

    /// Returns two link indices because of which SUMO refuses a program with these states in an additional file, or while it
    /// runs: each yields to the other, and both may have a permissive green, so that their vehicles would wait for each other.
    ///
    /// Netconvert has two links yield to each other where its program never shows both green. SUMO does not check programs of
    /// the network file, and an actuated one may then ask for memory without bounds.
    ///
    /// Source: SUMO 1.15, `MSTrafficLightLogic::init`, and tried.
    pub fn refused<'a>(
        &self,
        signal: &str,
        states: impl IntoIterator<Item = &'a str>,
    ) -> Option<(usize, usize)> {
        let pairs = self.mutual.get(signal)?;
        let is_minor = |state: &str, link: usize| {
            state.as_bytes().get(link).is_some_and(|c| MINOR.contains(c))
        };
        states.into_iter().find_map(|state| {
            pairs.iter().find(|(a, b)| is_minor(state, *a) && is_minor(state, *b)).copied()
        })
    }

    /// Returns whether a program shows one green only, so that there is nothing to decide.
    pub fn has_one_green(&self, program: &str) -> bool {
        let is_green =
            |p: &&ProgramPhase| p.state.contains(['g', 'G']) && !p.state.contains(['y', 'Y']);
        let phases = self.program(program).unwrap_or_default();
        phases.iter().filter(is_green).map(|p| &p.state).collect::<BTreeSet<_>>().len() == 1
    }

    /// Returns a program's phases.
    pub fn program(&self, id: &str) -> Option<&[ProgramPhase]> {
        self.programs.iter().find(|(_, program, _)| program == id).map(|p| p.2.as_slice())
    }
}

/// Returns the number of signals that have a program in the network of a configuration, and one where it cannot be read.
/// Those of foot paths count too, level crossings have no program.
pub fn signals_in(config: &Path) -> u32 {
    let net = SumoConfig::read(config).ok().and_then(|config| NetFile::of_scenario(&config).ok());
    let net = net.unwrap_or_default();
    let ids: BTreeSet<&str> = net.programs.iter().map(|program| program.0.as_str()).collect();
    ids.len().max(1) as u32
}

/// Whether a connection is one of the links that a junction numbers: of those from or to a foot path only crosswalks are.
fn is_counted(connection: &Node<'_, '_>, junction: &str) -> bool {
    let [from, to] = ["from", "to"].map(|name| connection.attribute(name).unwrap_or_default());
    !from.starts_with(':') && !to.starts_with(':') || to.starts_with(&format!(":{junction}_c"))
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

    /// Two left turns that yield to each other, a through lane, and a walking area whose links are not counted.
    const NET: &str = r#"<net><edge id=":c_0"><lane id=":c_0_0" length="4" speed="8"/></edge>
        <edge id="n"><lane id="n_0" length="200.00" speed="13.41"/></edge>
        <tlLogic id="t" type="static" programID="0" offset="0"><phase duration="42" state="Gg"/></tlLogic>
        <junction id="c" type="traffic_light" incLanes="n_0 s_0 :c_w0_0">
            <request index="0" response="010" foes="110"/><request index="1" response="001" foes="001"/>
            <request index="2" response="001" foes="001"/></junction>
        <connection from="n" to=":c_w0" fromLane="0" toLane="0"/>
        <connection from="n" to="e" fromLane="0" toLane="0" tl="t" linkIndex="7"/>
        <connection from="s" to="w" fromLane="0" toLane="0" tl="t" linkIndex="9"/>
        <connection from=":c_w0" to=":c_c0" fromLane="0" toLane="0" tl="t" linkIndex="2"/>
        <connection from=":c_0" to="w" fromLane="0" toLane="1" via=":c_9_0"/></net>"#;

    #[test]
    fn a_network_has_lanes_links_programs_and_who_yields() {
        let net = NetFile::parse(NET).unwrap();
        assert_eq!(net.lanes.len(), 1, "those within the junction are left out");
        assert_eq!((net.lanes[0].edge.as_str(), net.lanes[0].length_m), ("n", 200.0));
        assert_eq!(net.links.iter().map(|l| l.link).collect::<Vec<_>>(), [7, 9]);
        let [a, b] = [&net.links[0], &net.links[1]];
        assert!(net.meet(a, b) && net.yields(a, b) && net.yields(b, a) && !net.yields(a, a));
        assert!(net.conflicts["t"].yields(2, 7) && !net.conflicts["t"].yields(7, 2));
        assert_eq!(net.program("0").unwrap()[0].state, "Gg");
        assert!(net.program("1").is_none() && net.has_one_green("0"));
    }

    #[test]
    fn links_that_yield_to_each_other_may_not_both_be_permissive() {
        let net = NetFile::parse(NET).unwrap();
        assert_eq!(net.refused("t", ["rrrrrrrGrr", "rrrrrrrgrg"]), Some((7, 9)));
        assert_eq!(net.refused("t", ["rrrrrrrGrg", "rrrrrrrgrr"]), None, "one has right of way");
        assert_eq!(net.refused("t", ["rrgrrrrgrr"]), None, "only one of them yields");
        assert_eq!(net.refused("u", ["rrrrrrrgrg"]), None, "another signal");
    }

    #[test]
    fn a_network_that_is_cut_off_or_lacks_something_is_an_error() {
        let cut = NET.trim_end().strip_suffix("</net>").unwrap();
        assert_eq!(NetFile::parse(cut).unwrap_err(), "cut off: it ends before `</net>`");
        assert_eq!(NetFile::parse("<net><edge/></net>").unwrap_err(), "<edge> without id");
    }
}

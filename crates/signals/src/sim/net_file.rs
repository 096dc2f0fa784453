//! SUMO's network files: what the generator reads back of those that netconvert wrote, and what is known of somebody's own.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io::Read;
use std::path::Path;

use roxmltree::{Document, Node};

use super::sources::open;
use super::sumocfg::SumoConfig;
use crate::junction::Conflicts;
use crate::program::ProgramPhase;
use basics::files::FileError;

/// Letters of a state that let vehicles pass and yield.
const MINOR: &[u8] = b"gos";

/// Per signal the pairs of links of which each yields to the other.
pub type Mutual = BTreeMap<String, Vec<(usize, usize)>>;

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
}

impl NetFile {
    /// Parses a network.
    /// The error is what is wrong, in words, if it is not well-formed XML or lacks an attribute.
    pub fn parse(text: &str) -> Result<Self, String> {
        if !text.trim_end().ends_with("</net>") {
            return Err("cut off: it ends before `</net>`".to_owned());
        }
        let document = Document::parse(text).map_err(|e| format!("not well-formed: {e}"))?;
        let all = |name| elements(&document, name);
        let mut net = Self { conflicts: right_of_way(&document).0, ..Self::default() };
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
                Ok(ProgramPhase::fixed(state, number(phase, "duration")?))
            });
            let (id, name) = (attribute(program, "id")?, attribute(program, "programID")?);
            let phases = phases.collect::<Result<_, String>>()?;
            net.programs.push((id.to_owned(), name.to_owned(), phases));
        }
        for connection in all("connection") {
            let (from, to) = (attribute(connection, "from")?, attribute(connection, "to")?);
            let from_lane = number(connection, "fromLane")?;
            if let Some(signal) = connection.attribute("tl").filter(|_| !from.starts_with(':')) {
                net.links.push(NetLink {
                    from: from.to_owned(),
                    to: to.to_owned(),
                    from_lane,
                    to_lane: number(connection, "toLane")?,
                    signal: signal.to_owned(),
                    link: number(connection, "linkIndex")?,
                });
            }
        }
        for request in all("junction").flat_map(requests) {
            attribute(request, "foes")?;
            attribute(request, "response")?;
        }
        Ok(net)
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

/// Reads the pairs of the first network of a configuration, which may be compressed; what is no XML has none.
/// Fails with [`FileError`] when the file cannot be read.
pub fn mutual(config: &SumoConfig) -> Result<Mutual, FileError> {
    let Some(network) = config.networks().next() else { return Ok(Mutual::default()) };
    let text = read(network)?;
    Ok(Document::parse(&text).map_or_else(|_| Mutual::default(), |net| right_of_way(&net).1))
}

/// Returns who meets and who yields at signals, from the junctions' right-of-way matrices. What lacks an attribute is left out:
/// SUMO says what is wrong with it.
fn right_of_way(document: &Document<'_>) -> (BTreeMap<String, Conflicts>, Mutual) {
    let (mut conflicts, mut mutual) = (BTreeMap::<String, Conflicts>::new(), Mutual::default());
    let mut of_lane: HashMap<String, Vec<Node<'_, '_>>> = HashMap::new();
    for connection in elements(document, "connection") {
        let [from, to, lane] = ["from", "to", "fromLane"].map(|name| connection.attribute(name));
        let (Some(from), Some(to), Some(lane)) = (from, to, lane) else { continue };
        // Ways out of a junction are no links of it.
        if !from.starts_with(':') || to.starts_with(':') {
            of_lane.entry(format!("{from}_{lane}")).or_default().push(connection);
        }
    }
    // The last letter is of the first link.
    let bits = |row: Node<'_, '_>, name| {
        let letters = row.attribute(name).unwrap_or_default();
        letters.bytes().rev().map(|b| b == b'1').collect::<Vec<bool>>()
    };
    for junction in elements(document, "junction") {
        let rows: Vec<[Vec<bool>; 2]> =
            requests(junction).map(|row| [bits(row, "foes"), bits(row, "response")]).collect();
        let bit = |a: usize, b: usize, kind: usize| rows[a][kind].get(b).is_some_and(|bit| *bit);
        let id = junction.attribute("id").unwrap_or_default();
        let lanes = junction.attribute("incLanes").unwrap_or_default().split_whitespace();
        let own = lanes.filter_map(|lane| of_lane.get(lane)).flatten();
        // A row per link, in the order of incoming lanes and of the file.
        let own = own.filter(|connection| is_counted(connection, id)).take(rows.len());
        let links: Vec<Option<(&str, usize)>> =
            own.map(|c| c.attribute("tl").zip(number(*c, "linkIndex").ok())).collect();
        for (a, own) in links.iter().enumerate() {
            let Some((signal, i)) = *own else { continue };
            let known = conflicts.entry(signal.to_owned()).or_default();
            for (b, other) in links.iter().enumerate() {
                let Some((_, j)) = other.filter(|other| other.0 == signal) else { continue };
                known.add(i, j, bit(a, b, 0), bit(a, b, 1));
                if a < b && bit(a, b, 1) && bit(b, a, 1) {
                    mutual.entry(signal.to_owned()).or_default().push((i, j));
                }
            }
        }
    }
    (conflicts, mutual)
}

/// Returns two link indices because of which SUMO refuses a program with these states in an additional file, or while it runs:
/// each yields to the other, and both may have a permissive green, so that their vehicles would wait for each other.
///
/// Netconvert has two links yield to each other where its program never shows both green. SUMO does not check programs of the
/// network file, and an actuated one may then ask for memory without bounds.
///
/// Source: SUMO 1.15, `MSTrafficLightLogic::init`, and tried.
pub fn refused<'a>(
    mutual: &Mutual,
    signal: &str,
    states: impl IntoIterator<Item = &'a str>,
) -> Option<(usize, usize)> {
    let pairs = mutual.get(signal)?;
    let is_minor =
        |state: &str, link: usize| state.as_bytes().get(link).is_some_and(|c| MINOR.contains(c));
    states.into_iter().find_map(|state| {
        pairs.iter().find(|(a, b)| is_minor(state, *a) && is_minor(state, *b)).copied()
    })
}

/// Returns the number of signals that have a program in the networks of a configuration, at least one, and one where they
/// cannot be read, which whoever simulates them will say. Those of foot paths count too, level crossings have no program.
pub fn signals_in(config: &Path) -> u32 {
    let count = || {
        let mut ids = BTreeSet::new();
        for network in SumoConfig::read(config).ok()?.networks() {
            let text = read(network).ok()?;
            let document = Document::parse(&text).ok()?;
            let programs = elements(&document, "tlLogic");
            ids.extend(programs.filter_map(|program| program.attribute("id").map(str::to_owned)));
        }
        u32::try_from(ids.len()).ok()
    };
    count().unwrap_or(1).max(1)
}

/// Reads a network, which may be compressed.
fn read(network: &Path) -> Result<String, FileError> {
    let mut text = String::new();
    open(network)?.read_to_string(&mut text).map_err(FileError::at("read", network))?;
    Ok(text)
}

fn elements<'a, 'i>(
    document: &'a Document<'i>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'i>> {
    document.root_element().children().filter(move |node| node.has_tag_name(name))
}

/// Returns the rows of a junction's matrix.
fn requests<'a, 'i>(junction: Node<'a, 'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    junction.children().filter(|node| node.has_tag_name("request"))
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
    use std::fs;

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
        let of = |text: &str, states: &[&str]| {
            refused(&right_of_way(&Document::parse(text).unwrap()).1, "t", states.iter().copied())
        };
        assert_eq!(of(NET, &["rrrrrrrGrr", "rrrrrrrgrg"]), Some((7, 9)));
        assert_eq!(of(NET, &["rrrrrrrGrg", "rrrrrrrgrr"]), None, "one has right of way");
        assert_eq!(of(NET, &["rrgrrrrgrr"]), None, "only one of them yields");
        assert_eq!(of(&NET.replace("\"t\"", "\"u\""), &["rrrrrrrgrg"]), None, "another signal");
        let one_way = NET.replace("\"001\" foes=\"001\"/>\n", "\"000\" foes=\"001\"/>\n");
        assert_eq!(of(&one_way, &["rrrrrrrgrg"]), None);
        let other = NET.replace(" programID=\"0\"", "");
        assert!(NetFile::parse(&other).is_err() && of(&other, &["rrrrrrrgrg"]).is_some());
    }

    #[test]
    fn a_signal_counts_once_however_many_programs_and_networks_there_are() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a.sumocfg"), "<c><net-file value='n.xml,m.xml'/></c>").unwrap();
        assert_eq!(signals_in(&at("a.sumocfg")), 1);
        fs::write(at("n.xml"), "<net><tlLogic id='a'/><tlLogic id='a'/></net>").unwrap();
        fs::write(at("m.xml"), "<net><tlLogic id='b'/></net>").unwrap();
        assert_eq!(signals_in(&at("a.sumocfg")), 2);
    }

    #[test]
    fn a_network_that_is_cut_off_or_lacks_something_is_an_error() {
        let cut = NET.trim_end().strip_suffix("</net>").unwrap();
        assert_eq!(NetFile::parse(cut).unwrap_err(), "cut off: it ends before `</net>`");
        assert_eq!(NetFile::parse("<net><edge/></net>").unwrap_err(), "<edge> without id");
    }
}

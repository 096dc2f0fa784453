//! Links of one signal of which each yields to the other, and programs that SUMO refuses because of them.
//!
//! Netconvert makes two links yield to each other where its program never shows both green. A program that gives both a
//! permissive green (`g`, `o` or `s`) would have their vehicles wait for each other. SUMO checks programs of additional
//! files and those that are installed while it runs, and not those of the network file: it refuses to load the first, and an
//! actuated one of the second may then ask for memory without bounds.
//!
//! Source: SUMO 1.15, `MSTrafficLightLogic::init`, and tried.

use std::collections::HashMap;
use std::io::Read;
use std::path::Path;

use roxmltree::{Document, Node};

use super::sources::open;
use super::sumocfg::SumoConfig;
use basics::files::FileError;

/// Letters of a state that let vehicles pass and yield.
const MINOR: &[u8] = b"gos";

/// Links of a network's signals that yield to each other.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Mutual {
    /// Signal to pairs of its link indices.
    pairs: HashMap<String, Vec<(usize, usize)>>,
}

impl Mutual {
    /// Reads them from a network file, which may be compressed. What is no XML has none beyond that place: SUMO says what is
    /// wrong with it.
    ///
    /// # Errors
    ///
    /// [`FileError`] when the file cannot be opened.
    pub fn read(network: &Path) -> Result<Self, FileError> {
        let mut text = String::new();
        open(network)?.read_to_string(&mut text).map_err(FileError::at("read", network))?;
        Ok(Self::of(&text))
    }

    /// Reads those of the network of a configuration; without a network there are none.
    ///
    /// # Errors
    ///
    /// Those of [`Self::read`].
    pub fn of_scenario(config: &SumoConfig) -> Result<Self, FileError> {
        config.networks().next().map_or_else(|| Ok(Self::default()), Self::read)
    }

    fn of(network: &str) -> Self {
        let mut mutual = Self::default();
        // SUMO says what is wrong with a network that is no XML.
        let Ok(document) = Document::parse(network) else { return mutual };
        let elements = |name: &'static str| {
            document.root_element().children().filter(move |node| node.has_tag_name(name))
        };
        let mut links: HashMap<String, Vec<Connection>> = HashMap::new();
        for (lane, connection) in elements("connection").filter_map(Connection::of) {
            links.entry(lane).or_default().push(connection);
        }
        elements("junction").for_each(|junction| mutual.add(junction, &links));
        mutual
    }

    fn add(&mut self, junction: Node<'_, '_>, links: &HashMap<String, Vec<Connection<'_>>>) {
        let of = |name: &str| junction.attribute(name).unwrap_or_default();
        let own = of("incLanes").split_whitespace().flat_map(|lane| links.get(lane)).flatten();
        let own: Vec<&Connection<'_>> = own.filter(|c| c.is_counted(of("id"))).collect();
        // The last letter of a response is of the first link.
        let responses = junction.children().filter_map(|request| request.attribute("response"));
        let yields: Vec<Vec<bool>> =
            responses.map(|bits| bits.bytes().rev().map(|b| b == b'1').collect()).collect();
        let yields =
            |a: usize, b: usize| yields.get(a).and_then(|row| row.get(b)).is_some_and(|y| *y);
        for (a, first) in own.iter().enumerate() {
            for (b, second) in own.iter().enumerate().skip(a + 1) {
                let (Some((signal, i)), Some((other, j))) = (&first.signal, &second.signal) else {
                    continue;
                };
                if signal == other && yields(a, b) && yields(b, a) {
                    self.pairs.entry((*signal).to_owned()).or_default().push((*i, *j));
                }
            }
        }
    }

    /// Returns two link indices because of which SUMO refuses a program with these states in an additional file; `None` where
    /// it takes it.
    pub fn refused<'a>(
        &self,
        signal: &str,
        states: impl IntoIterator<Item = &'a str>,
    ) -> Option<(usize, usize)> {
        let pairs = self.pairs.get(signal)?;
        let is_minor = |state: &str, link: usize| {
            state.as_bytes().get(link).is_some_and(|letter| MINOR.contains(letter))
        };
        states.into_iter().find_map(|state| {
            pairs.iter().find(|(a, b)| is_minor(state, *a) && is_minor(state, *b)).copied()
        })
    }
}

/// A link of a lane, in the order of the file.
struct Connection<'a> {
    from: &'a str,
    to: &'a str,
    /// Signal and link index.
    signal: Option<(&'a str, usize)>,
}

impl<'a> Connection<'a> {
    /// Returns the lane that it starts on, and the connection.
    fn of(node: Node<'a, '_>) -> Option<(String, Self)> {
        let (from, to) = (node.attribute("from")?, node.attribute("to")?);
        // Ways out of a junction are no links of it.
        if from.starts_with(':') && !to.starts_with(':') {
            return None;
        }
        let lane = format!("{from}_{}", node.attribute("fromLane")?);
        let index = node.attribute("linkIndex").and_then(|index| index.parse().ok());
        Some((lane, Self { from, to, signal: node.attribute("tl").zip(index) }))
    }

    /// Whether it is one of the links that a junction numbers: of those from or to a foot path only crosswalks are.
    fn is_counted(&self, junction: &str) -> bool {
        let is_inner = self.from.starts_with(':') || self.to.starts_with(':');
        !is_inner || self.to.starts_with(&format!(":{junction}_c"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two left turns that yield to each other, and a walking area whose links are not counted.
    const NETWORK: &str = "<net><junction id='c' incLanes='n_0 s_0 :c_w0_0'>\
        <request index='0' response='010' foes='010'/><request index='1' response='001' foes='001'/>\
        <request index='2' response='001' foes='001'/></junction>\
        <connection from='n' to=':c_w0' fromLane='0' toLane='0'/>\
        <connection from='n' to='e' fromLane='0' toLane='0' tl='t' linkIndex='7'/>\
        <connection from='s' to='w' fromLane='0' toLane='0' tl='t' linkIndex='9'/>\
        <connection from=':c_w0' to=':c_c0' fromLane='0' toLane='0' tl='t' linkIndex='2'/></net>";

    #[test]
    fn links_that_yield_to_each_other_may_not_both_be_permissive() {
        let mutual = Mutual::of(NETWORK);
        assert_eq!(mutual.refused("t", ["rrrrrrrGrr", "rrrrrrrgrg"]), Some((7, 9)));
        assert_eq!(mutual.refused("t", ["rrrrrrrGrg", "rrrrrrrgrr"]), None, "one has right of way");
        assert_eq!(mutual.refused("t", ["rrgrrrrgrr"]), None, "only one of them yields");
        assert_eq!(mutual.refused("u", ["rrrrrrrgrg"]), None, "another signal");
        let one_way = NETWORK.replace(
            "response='001' foes='001'/><request index='2'",
            "response='000'/><request index='2'",
        );
        assert_eq!(Mutual::of(&one_way).refused("t", ["rrrrrrrgrg"]), None);
    }
}

//! Links of one signal of which each yields to the other, and programs that SUMO refuses because of them.
//!
//! Netconvert makes two links yield to each other where its program never shows both green. A program that gives both a
//! permissive green (`g`, `o` or `s`) would have their vehicles wait for each other. SUMO checks programs of additional
//! files and those that are installed while it runs, and not those of the network file: it refuses to load the first, and an
//! actuated one of the second may then ask for memory without bounds.
//!
//! Source: SUMO 1.15, `MSTrafficLightLogic::init`, and tried.

use std::collections::HashMap;
use std::io::BufRead;
use std::path::Path;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use super::sources::open;
use super::sumocfg::SumoConfig;
use basics::files::FileError;

/// Letters of a state that let vehicles pass and yield.
const MINOR: &[u8] = b"gos";

/// Attributes of an element.
type Attributes = HashMap<String, String>;

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
        Ok(Self::of(open(network)?))
    }

    /// Reads those of the network of a configuration; without a network there are none.
    ///
    /// # Errors
    ///
    /// Those of [`Self::read`].
    pub fn of_scenario(config: &SumoConfig) -> Result<Self, FileError> {
        config.networks().next().map_or_else(|| Ok(Self::default()), Self::read)
    }

    fn of(network: impl BufRead) -> Self {
        let mut junctions: Vec<Junction> = Vec::new();
        let mut links: HashMap<String, Vec<Connection>> = HashMap::new();
        let mut reader = Reader::from_reader(network);
        let mut buffer = Vec::new();
        loop {
            match reader.read_event_into(&mut buffer) {
                Ok(Event::Start(element) | Event::Empty(element)) => {
                    match element.local_name().as_ref() {
                        "junction" => junctions.extend(Junction::of(&attributes(&element))),
                        "request" => {
                            let response = attributes(&element).remove("response");
                            if let (Some(junction), Some(bits)) = (junctions.last_mut(), response) {
                                // The last letter is of the first link.
                                junction
                                    .yields
                                    .push(bits.bytes().rev().map(|b| b == b'1').collect());
                            }
                        }
                        "connection" => {
                            let mut read = attributes(&element);
                            if let Some((lane, connection)) = Connection::of(&mut read) {
                                links.entry(lane).or_default().push(connection);
                            }
                        }
                        _ => {}
                    }
                }
                Ok(Event::Eof) | Err(_) => break,
                Ok(_) => {}
            }
            buffer.clear();
        }
        let mut mutual = Self::default();
        junctions.iter().for_each(|junction| mutual.add(junction, &links));
        mutual
    }

    fn add(&mut self, junction: &Junction, links: &HashMap<String, Vec<Connection>>) {
        let of_lane = |lane: &String| links.get(lane).into_iter().flatten();
        let own = junction.lanes.iter().flat_map(of_lane);
        let own: Vec<&Connection> = own.filter(|c| c.is_counted(&junction.id)).collect();
        let yields = |a: usize, b: usize| {
            junction.yields.get(a).and_then(|row| row.get(b)).is_some_and(|yields| *yields)
        };
        for (a, first) in own.iter().enumerate() {
            for (b, second) in own.iter().enumerate().skip(a + 1) {
                let (Some((signal, i)), Some((other, j))) = (&first.signal, &second.signal) else {
                    continue;
                };
                if signal == other && yields(a, b) && yields(b, a) {
                    self.pairs.entry(signal.clone()).or_default().push((*i, *j));
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

/// A junction with what its links yield to.
struct Junction {
    id: String,
    lanes: Vec<String>,
    /// Shape `[link, link]`.
    yields: Vec<Vec<bool>>,
}

impl Junction {
    fn of(attributes: &Attributes) -> Option<Self> {
        let lanes = attributes.get("incLanes")?.split_whitespace().map(str::to_owned).collect();
        Some(Self { id: attributes.get("id")?.clone(), lanes, yields: Vec::new() })
    }
}

/// A link of a lane, in the order of the file.
struct Connection {
    from: String,
    to: String,
    /// Signal and link index.
    signal: Option<(String, usize)>,
}

impl Connection {
    /// Returns the lane that it starts on, and the connection.
    fn of(attributes: &mut Attributes) -> Option<(String, Self)> {
        let (from, to) = (attributes.remove("from")?, attributes.remove("to")?);
        // Ways out of a junction are no links of it.
        if from.starts_with(':') && !to.starts_with(':') {
            return None;
        }
        let lane = format!("{from}_{}", attributes.get("fromLane")?);
        let index = attributes.get("linkIndex").and_then(|index| index.parse().ok());
        let signal = attributes.remove("tl").zip(index);
        Some((lane, Self { from, to, signal }))
    }

    /// Whether it is one of the links that a junction numbers: of those from or to a foot path only crosswalks are.
    fn is_counted(&self, junction: &str) -> bool {
        let is_inner = self.from.starts_with(':') || self.to.starts_with(':');
        !is_inner || self.to.starts_with(&format!(":{junction}_c"))
    }
}

/// Returns the attributes of an element that can be read.
fn attributes(element: &BytesStart<'_>) -> Attributes {
    let read = element.attributes().filter_map(|attribute| {
        let attribute = attribute.ok()?;
        let value = attribute.normalized_value(XmlVersion::Implicit1_0).ok()?.into_owned();
        Some((attribute.key.local_name().as_ref().to_owned(), value))
    });
    read.collect()
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
        let mutual = Mutual::of(NETWORK.as_bytes());
        assert_eq!(mutual.refused("t", ["rrrrrrrGrr", "rrrrrrrgrg"]), Some((7, 9)));
        assert_eq!(mutual.refused("t", ["rrrrrrrGrg", "rrrrrrrgrr"]), None, "one has right of way");
        assert_eq!(mutual.refused("t", ["rrgrrrrgrr"]), None, "only one of them yields");
        assert_eq!(mutual.refused("u", ["rrrrrrrgrg"]), None, "another signal");
        let one_way = NETWORK.replace(
            "response='001' foes='001'/><request index='2'",
            "response='000'/><request index='2'",
        );
        assert_eq!(Mutual::of(one_way.as_bytes()).refused("t", ["rrrrrrrgrg"]), None);
    }
}

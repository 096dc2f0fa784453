//! What netconvert makes of an extract: its signals, their arms and incoming lanes.
//!
//! Arms are grouped here by edges and nothing that the product knows: an edge in and an edge out
//! that are the two directions of one way, or that lead to the same junction, are one; so are a
//! one-way edge in and one out of the same street name, or where a name is missing, at a small angle.
//! Two conventions can be asked for (`Conventions`): streets that are closed to the public are no arms, and streets
//! of one name side by side, such as frontage roads, are one.
//! Only lanes that passenger cars may use count.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Command;

use quick_xml::events::Event;
use quick_xml::reader::Reader;

use super::raw::attributes;

/// Options of the run.
///
/// The distances within which netconvert joins are its defaults (SUMO 1.15): 10 m for junctions,
/// 20 m for signals, 25 m from a signal to the junction that it is guessed to be for. Beyond these
/// it makes one signal of neighbouring intersections: with 30 m for signals, 10% fewer of the
/// intersections of Washington can be matched.
const OPTIONS: [&str; 22] = [
    "-X",
    "never",
    "--geometry.remove",
    "true",
    "--ramps.guess",
    "false",
    "--junctions.join",
    "true",
    "--tls.join",
    "true",
    "--tls.guess-signals",
    "true",
    "--tls.discard-simple",
    "true",
    "--output.street-names",
    "true",
    // Ids of clusters name all their nodes, which is how intersections are matched.
    "--max-join-ids",
    "1000",
    "--keep-edges.by-vclass",
    "passenger",
    "--remove-edges.by-type",
    "highway.service,highway.services,highway.track",
];

/// Where along an edge its direction is taken, metres from the junction.
const DIRECTION_AT_M: f64 = 30.0;

/// Largest angle between two edges that are one arm, degrees.
const SAME_ARM_DEG: f64 = 45.0;

/// Largest angle between the carriageways of one street of which one has no name, degrees.
const UNNAMED_DEG: f64 = 30.0;

/// Largest angle between streets of one name side by side, degrees.
const SIDE_BY_SIDE_DEG: f64 = 20.0;

/// Last words of street names that say which part of a city the address is in.
const QUADRANTS: [&str; 4] = ["Northeast", "Northwest", "Southeast", "Southwest"];

/// The vehicle class that a lane has to be open to.
const CAR: &str = "passenger";

/// An arm of a signal.
#[derive(Debug, Clone, Default)]
pub(crate) struct SumoArm {
    /// Direction, degrees clockwise from north.
    pub(crate) bearing_deg: f64,
    /// Lanes for cars towards the signal.
    pub(crate) lanes_in: u32,
    /// Lanes for cars away from it.
    pub(crate) lanes_out: u32,
    /// Ids of its edges.
    pub(crate) edges: Vec<String>,
}

/// A signal.
#[derive(Debug, Clone)]
pub(crate) struct SumoSignal {
    /// Its id.
    pub(crate) id: String,
    /// Ids of the OSM nodes in the names of its junctions.
    pub(crate) nodes: BTreeSet<i64>,
    /// Its arms, by bearing.
    pub(crate) arms: Vec<SumoArm>,
}

#[derive(Debug, Default)]
struct Edge {
    from: String,
    to: String,
    name: Option<String>,
    /// Places in metres; empty for a straight line between the junctions.
    shape: Vec<(f64, f64)>,
    lanes: u32,
}

/// Conventions of this project that netconvert does not have.
#[derive(Debug, Clone, Default)]
pub(crate) struct Conventions {
    /// Ways that are closed to the public.
    pub(crate) closed: BTreeSet<i64>,
    /// Whether streets of one name side by side are one arm.
    pub(crate) side_by_side: bool,
}

/// Returns whether netconvert is there.
pub(crate) fn is_there() -> bool {
    Command::new("netconvert").arg("--version").output().is_ok_and(|o| o.status.success())
}

/// Runs netconvert on an OSM file and returns the network.
pub(crate) fn network(osm: &Path) -> String {
    let net = osm.with_extension("net.xml");
    let mut run = Command::new("netconvert");
    run.args(OPTIONS).arg("--osm-files").arg(osm).arg("-o").arg(&net);
    let output = run.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    fs::read_to_string(net).unwrap()
}

/// Returns the signals of a network.
pub(crate) fn signals(text: &str, conventions: &Conventions) -> Vec<SumoSignal> {
    let mut edges: BTreeMap<String, Edge> = BTreeMap::new();
    let mut junctions: BTreeMap<String, (f64, f64)> = BTreeMap::new();
    let mut controlled: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let mut reader = Reader::from_str(text);
    let mut last = String::new();
    loop {
        let event = reader.read_event().unwrap();
        let (Event::Start(tag) | Event::Empty(tag)) = &event else {
            if event == Event::Eof {
                break;
            }
            continue;
        };
        let (name, mut values) = attributes(tag);
        match name.as_str() {
            "edge" => {
                last = values["id"].clone();
                if !values.contains_key("function") {
                    let edge = Edge {
                        from: values["from"].clone(),
                        to: values["to"].clone(),
                        name: values.remove("name"),
                        shape: values.get("shape").map_or_else(Vec::new, |s| places(s)),
                        lanes: 0,
                    };
                    edges.insert(last.clone(), edge);
                }
            }
            "lane" => {
                let says = |key: &str| values.get(key).map(|v| v.split(' ').any(|c| c == CAR));
                let closed = says("allow") == Some(false)
                    || says("disallow") == Some(true)
                    || values.get("disallow").is_some_and(|v| v == "all");
                if let (Some(edge), false) = (edges.get_mut(&last), closed) {
                    edge.lanes += 1;
                }
            }
            "junction" => {
                let place = |key: &str| values[key].parse().unwrap();
                junctions.insert(values["id"].clone(), (place("x"), place("y")));
            }
            "connection" => {
                if let Some(signal) = values.get("tl") {
                    let junction = edges[&values["from"]].to.clone();
                    controlled.entry(signal.clone()).or_default().insert(junction);
                }
            }
            _ => {}
        }
    }
    for edge in edges.values_mut().filter(|e| e.shape.is_empty()) {
        edge.shape = vec![junctions[&edge.from], junctions[&edge.to]];
    }
    let ids = |junctions: &BTreeSet<String>| {
        junctions.iter().flat_map(|j| j.split('_')).filter_map(|id| id.parse().ok()).collect()
    };
    let signals = controlled.into_iter().map(|(id, junctions)| SumoSignal {
        id,
        nodes: ids(&junctions),
        arms: arms(&edges, &junctions, conventions),
    });
    signals.collect()
}

fn places(shape: &str) -> Vec<(f64, f64)> {
    let numbers = |place: &str| place.split(',').map(|n| n.parse().unwrap()).collect::<Vec<f64>>();
    shape.split(' ').map(numbers).map(|n| (n[0], n[1])).collect()
}

/// Returns the arms around some junctions.
fn arms(
    edges: &BTreeMap<String, Edge>,
    inside: &BTreeSet<String>,
    conventions: &Conventions,
) -> Vec<SumoArm> {
    let around: Vec<(&String, &Edge, bool, f64)> = edges
        .iter()
        .filter(|(_, e)| e.lanes > 0 && inside.contains(&e.from) != inside.contains(&e.to))
        .filter(|(id, _)| !conventions.closed.contains(&way(id)))
        .map(|(id, e)| {
            let inwards = inside.contains(&e.to);
            (id, e, inwards, direction_deg(&e.shape, inwards))
        })
        .collect();
    let mut pairs = Vec::new();
    for (i, (id, a, _, a_deg)) in around.iter().enumerate().filter(|(_, e)| e.2) {
        for (j, (other, b, _, b_deg)) in around.iter().enumerate().filter(|(_, e)| !e.2) {
            let angle = ((a_deg - b_deg + 540.0).rem_euclid(360.0) - 180.0).abs();
            let one_way =
                id.strip_prefix('-') == Some(other) || other.strip_prefix('-') == Some(id);
            let same_ends = a.from == b.to && a.to == b.from && angle <= SAME_ARM_DEG;
            let unnamed = a.name.is_none() || b.name.is_none();
            let rank = match (one_way || same_ends, same_street(a, b)) {
                (true, _) => 0,
                (false, true) if angle <= SAME_ARM_DEG => 1,
                _ if unnamed && angle <= UNNAMED_DEG => 2,
                _ => continue,
            };
            pairs.push((rank, angle, i, j));
        }
    }
    pairs.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut partner: Vec<Option<usize>> = vec![None; around.len()];
    for (_, _, i, j) in pairs {
        if partner[i].is_none() && partner[j].is_none() {
            (partner[i], partner[j]) = (Some(j), Some(i));
        }
    }
    let mut arms: Vec<(SumoArm, &Edge)> = Vec::new();
    for (i, (_, _, inwards, _)) in around.iter().enumerate() {
        if partner[i].is_some() && !inwards {
            continue;
        }
        let beside = |known: &(SumoArm, &Edge)| {
            let angle =
                ((known.0.bearing_deg - around[i].3 + 540.0).rem_euclid(360.0) - 180.0).abs();
            angle <= SIDE_BY_SIDE_DEG && same_street(known.1, around[i].1)
        };
        let known = arms.iter_mut().find(|known| conventions.side_by_side && beside(known));
        let arm = match known {
            Some((arm, _)) => arm,
            None => {
                let arm = SumoArm { bearing_deg: around[i].3, ..SumoArm::default() };
                arms.push((arm, around[i].1));
                &mut arms.last_mut().unwrap().0
            }
        };
        for (id, edge, inwards, _) in [Some(i), partner[i]].into_iter().flatten().map(|k| around[k])
        {
            *if inwards { &mut arm.lanes_in } else { &mut arm.lanes_out } += edge.lanes;
            arm.edges.push(id.clone());
        }
    }
    let mut arms: Vec<SumoArm> = arms.into_iter().map(|(arm, _)| arm).collect();
    arms.sort_by(|a, b| a.bearing_deg.total_cmp(&b.bearing_deg));
    arms
}

/// Returns the way that an edge is on.
fn way(edge: &str) -> i64 {
    let id = edge.trim_start_matches('-').split('#').next().unwrap();
    id.parse().unwrap()
}

/// Returns whether two edges have the same street name; the quadrant of a city, a part of addresses,
/// changes from one side of a street to the other.
fn same_street(a: &Edge, b: &Edge) -> bool {
    let street = |edge: &Edge| {
        let name = edge.name.clone()?;
        let quadrant = QUADRANTS.iter().find_map(|q| name.strip_suffix(q));
        Some(quadrant.unwrap_or(&name).trim_end().to_owned())
    };
    street(a).is_some() && street(a) == street(b)
}

/// Returns the direction of an edge as seen from its junction, degrees clockwise from north.
fn direction_deg(shape: &[(f64, f64)], inwards: bool) -> f64 {
    let mut shape = shape.to_vec();
    if inwards {
        shape.reverse();
    }
    let (start, mut left_m) = (shape[0], DIRECTION_AT_M);
    let mut at = shape[shape.len() - 1];
    for pair in shape.windows(2) {
        let (dx, dy) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
        let metres = dx.hypot(dy);
        if metres >= left_m {
            let share = left_m / metres;
            at = (pair[0].0 + share * dx, pair[0].1 + share * dy);
            break;
        }
        left_m -= metres;
    }
    (at.0 - start.0).atan2(at.1 - start.1).to_degrees().rem_euclid(360.0)
}

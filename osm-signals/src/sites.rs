//! Which junctions a signal controls, and which of them are one intersection.
//!
//! A signal stands at a junction, or before one: then it belongs to the first junction that its
//! traffic reaches. A signal for trains, fire engines or ships controls none. Signalised junctions are one intersection, a *site*, if they are close along a
//! street, or if they are the crossings with the two carriageways of one divided street. Crossings
//! with the other carriageway belong to the site even if nobody mapped a signal there.
//!
//! Deviation: IntersectionZoo chains all signals within 80 m, which makes one intersection of two
//! neighbouring ones in a dense street grid.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap, HashSet};

use super::crossings::crossed_all_around;
use super::extract::SignalNode;
use super::flags::Skip;
use super::geometry::{bearing_deg, distance_m};
use super::graph::{Graph, Step};
use super::near::{adjoining, touch};
use super::settings::IntersectionSettings;
use super::tags::Highway;
use crate::angle::turn_degrees;

/// Largest deviation of two carriageways from opposite headings, degrees.
const OPPOSITE_DEG: f64 = 40.0;

/// Largest deviation from a right angle between a carriageway and the way across the median, degrees.
const ACROSS_DEG: f64 = 50.0;

/// Smallest angle at which one street turns into another at a node where a third one is missing,
/// degrees: a street that only changes its name goes on more or less straight.
const CORNER_DEG: f64 = 45.0;

/// Junctions that are one intersection, and its signals.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Site {
    pub(super) nodes: Vec<u32>,
    /// Positions in [`Extract::signals`](super::extract::Extract::signals), sorted; empty for a
    /// junction that only a signal list names or whose crossings alone have signals.
    pub(super) signals: Vec<usize>,
    pub(super) listed: bool,
    pub(super) together: bool,
    /// Whether ramps are joined in it only because they are near.
    pub(super) ramps: bool,
}

/// `listed` are further junctions with a signal; those of `together` are one intersection, however far apart they are.
pub(super) fn sites(
    graph: &Graph<'_>,
    settings: &IntersectionSettings,
    listed: &[u32],
    together: &[Vec<u32>],
) -> (Vec<Site>, Vec<(usize, Skip)>) {
    let mut anchors: BTreeMap<u32, Vec<usize>> = listed.iter().map(|n| (*n, vec![])).collect();
    let (mut left, mut corners) = (Vec::new(), Vec::new());
    for (signal, index) in graph.extract.signals.iter().zip(0..) {
        match junction_of(graph, settings.signal_reach_m, signal) {
            Ok(node) => {
                anchors.entry(node).or_default().push(index);
                corners.extend(corner(graph, settings.join_m, signal, node).map(|c| (node, c)));
            }
            Err(reason) => left.push((index, reason)),
        }
    }
    left.retain(|(index, reason)| {
        let behind = (*reason == Skip::NoJunction)
            .then(|| junction_behind(graph, settings.join_m, &graph.extract.signals[*index]))
            .flatten();
        match behind.and_then(|node| anchors.get_mut(&node)) {
            Some(signals) => {
                signals.push(*index);
                false
            }
            None => true,
        }
    });
    if settings.from_crossings {
        for node in crossed_all_around(graph, settings.join_m) {
            anchors.entry(node).or_default();
        }
    }
    let groups = group(graph, settings, &anchors, (&corners, together));
    let sites = groups
        .into_iter()
        .map(|Group { nodes, ramps }| {
            let nodes: Vec<u32> = nodes.into_iter().collect();
            let mut signals: Vec<usize> =
                nodes.iter().filter_map(|n| anchors.get(n)).flatten().copied().collect();
            signals.sort_unstable();
            let listed = nodes.iter().any(|n| listed.contains(n));
            let together = together.iter().flatten().any(|n| nodes.binary_search(n).is_ok());
            Site { nodes, signals, listed, together, ramps }
        })
        .collect();
    (sites, left)
}

fn junction_of(graph: &Graph<'_>, reach_m: f64, signal: &SignalNode) -> Result<u32, Skip> {
    let node = graph.extract.nodes.index(signal.id).map(|n| n as u32);
    let Some(node) = node else { return Err(Skip::NotOnStreet) };
    if graph.steps(node).is_empty() {
        // All neighbours are missing.
        return Err(if graph.cut.contains(&node) { Skip::Border } else { Skip::NotOnStreet });
    }
    let none = HashSet::new();
    let at_junction = graph.is_junction(node, &none);
    let on_rails = (signal.tags.on_rails && !at_junction).then_some(Skip::LevelCrossing);
    if let Some(special) = signal.tags.special.or(on_rails) {
        return Err(special);
    }
    if at_junction {
        return Ok(node);
    }
    let nearest = |steps: &mut dyn Iterator<Item = &Step>| {
        let chains = steps.map(|s| graph.chain_within(*s, reach_m));
        let ends = chains
            .filter(|c| graph.is_junction(c.end, &none))
            .map(|c| (graph.length_m(&c.steps), c.end))
            .filter(|(metres, _)| *metres <= reach_m);
        ends.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, end)| end)
    };
    let faces = |s: &&Step| signal.tags.forward.is_none_or(|forward| s.forward == forward);
    let onwards = || graph.steps(node).iter().filter(|s| graph.allowed(**s));
    // A direction that leads to no junction is a mistake of the map.
    let found = nearest(&mut onwards().filter(faces)).or_else(|| nearest(&mut onwards()));
    found.ok_or_else(|| {
        let ends_at_border = graph.steps(node).iter().any(|s| {
            let chain = graph.chain_within(*s, reach_m);
            graph.cut.contains(&chain.end) && graph.length_m(&chain.steps) <= reach_m
        });
        if ends_at_border || graph.cut.contains(&node) {
            Skip::Border
        } else if graph.neighbours(node, &none).len() == 1 {
            Skip::EndOfStreet
        } else {
            Skip::NoJunction
        }
    })
}

/// Returns the node of a signal that is no junction only because a street is left out, such as the
/// crossing with a carriageway that goes on as a motorway: two streets of different names meet there
/// at an angle, next to the junction that the signal controls.
fn corner(graph: &Graph<'_>, join_m: f64, signal: &SignalNode, junction: u32) -> Option<u32> {
    let node = graph.extract.nodes.index(signal.id)? as u32;
    let [a, b] = graph.steps(node) else { return None };
    let name = |step: &Step| graph.way(*step).street.name.as_deref();
    let heading = |step: &Step| graph.direction(*step);
    let bend = 180.0 - turn_degrees(heading(a), heading(b)).abs();
    let named = name(a).is_some() && name(b).is_some() && name(a) != name(b);
    let near = distance_m(graph.place(node), graph.place(junction)) <= join_m;
    (named && near && bend >= CORNER_DEG).then_some(node)
}

/// Such as of a signal at the far side of a crossing.
fn junction_behind(graph: &Graph<'_>, reach_m: f64, signal: &SignalNode) -> Option<u32> {
    let node = graph.extract.nodes.index(signal.id)? as u32;
    let chains = graph.steps(node).iter().map(|s| graph.chain_within(*s, reach_m));
    let near = chains.map(|c| (graph.length_m(&c.steps), c.end)).filter(|c| c.0 <= reach_m);
    near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, end)| end)
}

/// A node within reach of another along the streets: metres to it, and the node before it.
type Reached = (f64, u32);

/// Returns the nodes within a distance along the streets, whichever way traffic goes.
fn within_reach(graph: &Graph<'_>, from: u32, limit_m: f64) -> BTreeMap<u32, Reached> {
    let mut reached = BTreeMap::from([(from, (0.0, from))]);
    // Millimetres, because floating-point numbers have no total order for a heap.
    let mut heap = BinaryHeap::from([(Reverse(0_u64), from)]);
    let mut done = HashSet::new();
    while let Some((_, node)) = heap.pop() {
        if !done.insert(node) {
            continue;
        }
        let base_m = reached[&node].0;
        for step in graph.steps(node) {
            let (to, metres) = (graph.target(*step), base_m + graph.step_m(*step));
            if metres <= limit_m && reached.get(&to).is_none_or(|r| metres < r.0) {
                reached.insert(to, (metres, node));
                heap.push((Reverse((metres * 1000.0) as u64), to));
            }
        }
    }
    reached
}

fn group(
    graph: &Graph<'_>,
    settings: &IntersectionSettings,
    anchors: &BTreeMap<u32, Vec<usize>>,
    (corners, together): (&[(u32, u32)], &[Vec<u32>]),
) -> Vec<Group> {
    let none = HashSet::new();
    let mut groups = Groups::new(graph, settings.max_extent_m, anchors.keys().copied());
    let mut links = Vec::new();
    for a in anchors.keys().copied() {
        let reached = within_reach(graph, a, settings.max_extent_m);
        for (b, (metres, _)) in reached.range(a + 1..).filter(|(b, _)| anchors.contains_key(b)) {
            let sure = *metres <= settings.join_m
                || (*metres <= settings.median_m && opposite(graph, a, *b))
                || touch(graph, a, *b);
            if sure || (*metres <= settings.ramps_m && ramps(graph, a) && ramps(graph, *b)) {
                links.push((!sure, *metres, a, *b, path(&reached, *b)));
            }
        }
    }
    links.sort_by(|x, y| {
        x.0.cmp(&y.0).then(x.1.total_cmp(&y.1)).then_with(|| (x.2, x.3).cmp(&(y.2, y.3)))
    });
    for (guessed, _, a, b, between) in links {
        let junctions = between.into_iter().filter(|n| graph.is_junction(*n, &none));
        groups.join(a, b, junctions.collect(), guessed);
    }
    for nodes in together {
        let mut known = nodes.iter().filter(|n| groups.of.contains_key(n)).copied();
        let Some(first) = known.next() else { continue };
        let others: Vec<u32> = known.collect();
        others.into_iter().for_each(|other| groups.unite(first, other));
    }
    let mut queue: Vec<u32> = groups.of.keys().copied().rev().collect();
    while let Some(a) = queue.pop() {
        let reached = within_reach(graph, a, settings.median_m);
        for b in reached.keys().copied() {
            let new = !groups.of.contains_key(&b) && graph.is_junction(b, &none);
            if new && opposite(graph, a, b) && groups.add(a, b) {
                queue.push(b);
            }
        }
    }
    let members: Vec<u32> = groups.of.keys().copied().collect();
    for a in members {
        for b in adjoining(graph, settings.join_m, &groups.of, a) {
            groups.add(a, b);
        }
    }
    for (junction, corner) in corners {
        if !groups.of.contains_key(corner) {
            groups.add(*junction, *corner);
        }
    }
    groups.members()
}

fn ramps(graph: &Graph<'_>, node: u32) -> bool {
    let class = |s: &Step| graph.way(*s).street.highway;
    graph.steps(node).iter().any(|s| matches!(class(s), Highway::MotorwayLink | Highway::TrunkLink))
}

fn path(reached: &BTreeMap<u32, Reached>, to: u32) -> Vec<u32> {
    let mut nodes = Vec::new();
    let mut node = reached[&to].1;
    while reached[&node].1 != node {
        nodes.push(node);
        node = reached[&node].1;
    }
    nodes
}

/// Returns whether two junctions are the crossings with the two carriageways of one street: both have a one-way street of
/// one name, with opposite headings, and the other carriageway is to the left of each (traffic keeps to the right).
fn opposite(graph: &Graph<'_>, a: u32, b: u32) -> bool {
    let across = bearing_deg(graph.place(a), graph.place(b));
    let carriageways = |node: u32| {
        let one_way = graph.steps(node).iter().filter(|s| graph.is_one_way(**s));
        one_way.map(|s| {
            let travel = if graph.allowed(*s) { *s } else { s.reversed() };
            (graph.direction(travel), &graph.way(*s).street)
        })
    };
    carriageways(a).any(|(heading, street)| {
        let left = (turn_degrees(heading, across) + 90.0).abs() <= ACROSS_DEG;
        left && carriageways(b).any(|(other, other_street)| {
            let turn = turn_degrees(heading, other).abs();
            turn >= 180.0 - OPPOSITE_DEG
                && street.name == other_street.name
                && street.highway == other_street.highway
        })
    })
}

#[derive(Debug, Clone, Default)]
struct Group {
    nodes: BTreeSet<u32>,
    /// Whether ramps are joined in it only because they are near.
    ramps: bool,
}

/// Disjoint groups of nodes of limited extent.
struct Groups<'g, 'a> {
    graph: &'g Graph<'a>,
    max_extent_m: f64,
    of: BTreeMap<u32, usize>,
    groups: Vec<Group>,
}

impl<'g, 'a> Groups<'g, 'a> {
    fn new(graph: &'g Graph<'a>, max_extent_m: f64, nodes: impl Iterator<Item = u32>) -> Self {
        let mut of = BTreeMap::new();
        let mut groups = Vec::new();
        for (node, i) in nodes.zip(0..) {
            of.insert(node, i);
            groups.push(Group { nodes: BTreeSet::from([node]), ramps: false });
        }
        Self { graph, max_extent_m, of, groups }
    }

    fn fits(&self, a: usize, others: &BTreeSet<u32>) -> bool {
        self.groups[a].nodes.iter().all(|x| {
            others.iter().all(|y| {
                distance_m(self.graph.place(*x), self.graph.place(*y)) <= self.max_extent_m
            })
        })
    }

    /// Joins the groups of two nodes and takes in the nodes between them, unless that is too wide.
    fn join(&mut self, a: u32, b: u32, between: BTreeSet<u32>, guessed: bool) {
        let (i, j) = (self.of[&a], self.of[&b]);
        let free = between.into_iter().filter(|n| !self.of.contains_key(n));
        let mut others: BTreeSet<u32> = free.collect();
        if i != j {
            others.extend(&self.groups[j].nodes);
        } else if guessed {
            return;
        }
        if self.fits(i, &others) {
            self.take(i, j, others);
            self.groups[i].ramps |= guessed;
        }
    }

    fn unite(&mut self, a: u32, b: u32) {
        let (i, j) = (self.of[&a], self.of[&b]);
        if i != j {
            let others = self.groups[j].nodes.clone();
            self.take(i, j, others);
        }
    }

    /// Puts nodes into a group, those of another group among them, which is empty then.
    fn take(&mut self, i: usize, j: usize, nodes: BTreeSet<u32>) {
        if i != j {
            let other = std::mem::take(&mut self.groups[j]);
            self.groups[i].ramps |= other.ramps;
        }
        self.of.extend(nodes.iter().map(|n| (*n, i)));
        self.groups[i].nodes.extend(nodes);
    }

    fn add(&mut self, a: u32, node: u32) -> bool {
        let group = self.of[&a];
        let fits = self.fits(group, &BTreeSet::from([node]));
        if fits {
            self.groups[group].nodes.insert(node);
            self.of.insert(node, group);
        }
        fits
    }

    fn members(self) -> Vec<Group> {
        self.groups.into_iter().filter(|group| !group.nodes.is_empty()).collect()
    }
}

//! A count along its street: what was counted on one block stands for the next ones too.
//!
//! Traffic changes little along a street until it meets a larger one. So an approach without a count of its own takes that
//! of the nearest counted block of the same street (one name, or one ref where it has no name), outwards or across its own
//! junction, up to a distance ([`CountSettings::spread_m`](super::counts::CountSettings::spread_m)) along the street. The
//! walk ends where a signalised intersection has an arm of another street of a higher class, where the street turns by more
//! than 60 degrees, and for a one-way approach where the street goes both ways.
//!
//! Source: this project's rule.

use std::collections::{HashMap, HashSet};

use super::arms::Arm;
use super::counts::Counts;
use super::extract::Place;
use super::graph::{Graph, Step};
use super::intersections::Intersection;
use super::tags::Highway;
use crate::angle::turn_degrees;

/// Largest turn within one street, degrees.
const STRAIGHT_DEG: f64 = 60.0;

/// Name and rank of a street.
type Named = (Option<Box<str>>, u8);

/// A count elsewhere on a street: vehicles per day, of both directions unless the street is one-way, and the distance
/// of the counted block from the junction, metres along the street.
pub(super) type SpreadCount = (f64, f64);

#[derive(Debug)]
pub(super) struct Spread<'a> {
    graph: &'a Graph<'a>,
    /// Nodes of the graph by where they are.
    node_at: HashMap<(i32, i32), u32>,
    /// Names and classes of the arms of the intersection that a node belongs to.
    arms_at: HashMap<u32, Vec<Named>>,
    limit_m: f64,
}

impl<'a> Spread<'a> {
    pub(super) fn new(graph: &'a Graph<'a>, intersections: &[Intersection], limit_m: f64) -> Self {
        let nodes = &graph.extract.nodes;
        let node_at = (0..nodes.ids.len())
            .filter_map(|node| nodes.places[node].map(|place| (key(place), node as u32)))
            .collect();
        let mut arms_at = HashMap::new();
        for intersection in intersections {
            let arms: Vec<_> = (intersection.arms.iter())
                .map(|a| (a.name.as_deref().map(Box::from), rank(a.highway)))
                .collect();
            let of_graph = intersection.nodes.iter().filter_map(|id| nodes.index(*id));
            arms_at.extend(of_graph.map(|node| (node as u32, arms.clone())));
        }
        Self { graph, node_at, arms_at, limit_m }
    }

    pub(super) fn find(&self, arm: &Arm, counts: &Counts) -> Option<SpreadCount> {
        if self.limit_m <= 0.0 {
            return None;
        }
        let (name, [start, next]) = (arm.name.as_deref()?, arm.places.first_chunk()?);
        let (start, next) = (*self.node_at.get(&key(*start))?, *self.node_at.get(&key(*next))?);
        let same = |s: &&Step| self.graph.target(**s) == next && self.name(**s) == Some(name);
        let first = *self.graph.steps(start).iter().find(same)?;
        let outwards = self.walk(arm, first, counts);
        let across = (!self.ends(start, Some(name), rank(self.graph.way(first).street.highway)))
            .then(|| self.onward(arm, first.reversed(), &HashSet::new()))
            .flatten()
            .and_then(|step| self.walk(arm, step, counts));
        match (outwards, across) {
            (Some(a), Some(b)) => Some(if a.1 <= b.1 { a } else { b }),
            (a, b) => a.or(b),
        }
    }

    fn walk(&self, arm: &Arm, first: Step, counts: &Counts) -> Option<SpreadCount> {
        let graph = self.graph;
        let none = HashSet::new();
        let mut used = HashSet::from([first.piece]);
        let (mut step, mut metres, mut along_m) = (first, 0.0, 0.0);
        let mut block = vec![graph.place(graph.source(first))];
        loop {
            let node = graph.target(step);
            block.push(graph.place(node));
            metres += graph.step_m(step);
            let next = self.onward(arm, step, &used);
            if graph.is_junction(node, &none) || next.is_none() {
                if let Some(found) = counts.along(&block, arm.lanes_in + arm.lanes_out) {
                    return Some((found.aadt_veh_per_day, along_m));
                }
                (block, along_m) = (vec![graph.place(node)], metres);
            }
            let class = rank(graph.way(step).street.highway);
            if along_m > self.limit_m || self.ends(node, arm.name.as_deref(), class) {
                return None;
            }
            step = next?;
            used.insert(step.piece);
        }
    }

    /// Returns the step with which a street goes on: of those of its name the straightest.
    fn onward(&self, arm: &Arm, step: Step, used: &HashSet<u32>) -> Option<Step> {
        let graph = self.graph;
        let node = graph.target(step);
        let turn = |s: &Step| turn_degrees(graph.direction(step), graph.direction(*s)).abs();
        let on = graph.steps(node).iter().copied().filter(|s| {
            s.piece != step.piece
                && !used.contains(&s.piece)
                && self.name(*s) == arm.name.as_deref()
                && (arm.lanes_out > 0 || graph.is_one_way(*s))
                && turn(s) <= STRAIGHT_DEG
        });
        on.min_by(|a, b| turn(a).total_cmp(&turn(b)).then(a.cmp(b)))
    }

    /// Returns whether a signalised intersection with another street of a higher class is at a node.
    fn ends(&self, node: u32, name: Option<&str>, class: u8) -> bool {
        let higher = |(other, rank): &Named| *rank < class && other.as_deref() != name;
        self.arms_at.get(&node).is_some_and(|arms| arms.iter().any(higher))
    }

    fn name(&self, step: Step) -> Option<&str> {
        self.graph.way(step).street.name.as_deref()
    }
}

fn key(place: Place) -> (i32, i32) {
    (place.latitude_e7, place.longitude_e7)
}

/// Returns the rank of a class of street, 0 the highest; a link has that of its class.
fn rank(highway: Highway) -> u8 {
    match highway {
        Highway::Trunk | Highway::TrunkLink => 0,
        Highway::Primary | Highway::PrimaryLink => 1,
        Highway::Secondary | Highway::SecondaryLink => 2,
        Highway::Tertiary | Highway::TertiaryLink => 3,
        _ => 4,
    }
}

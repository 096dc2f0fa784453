//! Which junctions belong together although they are several nodes of the map: those before which no vehicle
//! can wait, staggered crossings, and those that a turning roadway joins.

use std::collections::{BTreeMap, HashSet};

use super::geometry::distance_m;
use super::graph::{Chain, Graph, Step};
use crate::angle::turn_degrees;

/// Shortest distance between two junctions at which a vehicle can wait between them, metres: half a
/// street of four lanes (7 m), the stop line before it (3 m) and a car (5 m).
pub(super) const ROOM_TO_WAIT_M: f64 = 15.0;

/// Farthest that the two halves of a staggered crossing may be apart, metres: the widths of two streets of
/// two lanes and a stop line on the far side of each.
const STAGGER_M: f64 = 25.0;

/// Longest roadway for turns between two signals of one intersection, metres: the left turns of a single-point interchange.
const TURNING_M: f64 = 70.0;

/// Distance between nodes that are one intersection whatever lies between them, metres (OSMnx
/// consolidates connected nodes within it).
const TOUCHING_M: f64 = 20.0;

/// Largest deviation of a street that goes on from a straight line, degrees.
const STRAIGHT_DEG: f64 = 45.0;

/// Returns the junctions without a signal next to a node of an intersection that belong to it: no vehicle can wait before
/// them, or two-way streets from two of its nodes lead there, which encloses a triangle, or the node is half of a staggered
/// crossing and they are the other half. Where links begin or end is no such junction.
pub(super) fn adjoining(
    graph: &Graph<'_>,
    join_m: f64,
    of: &BTreeMap<u32, usize>,
    a: u32,
) -> Vec<u32> {
    let group = of[&a];
    let leads_to_group = |chain: &Chain, metres: f64| {
        chain.end != a && metres <= join_m && of.get(&chain.end) == Some(&group)
    };
    let found = chains(graph, a).filter(|(chain, metres)| {
        let b = chain.end;
        let two_way = is_two_way(graph, chain);
        let triangle = || {
            let mut others = chains(graph, b).filter(|(c, _)| is_two_way(graph, c));
            two_way && others.any(|(c, metres)| leads_to_group(&c, metres))
        };
        *metres <= join_m
            && !of.contains_key(&b)
            && is_plain_junction(graph, b)
            && (*metres <= ROOM_TO_WAIT_M
                || triangle()
                || (*metres <= STAGGER_M && staggered(graph, chain)))
    });
    found.map(|(chain, _)| chain.end).collect()
}

/// Returns whether two signalised junctions are one intersection, however far apart they are along the
/// streets: they touch, or a turning roadway leads from one to the other.
pub(super) fn touch(graph: &Graph<'_>, a: u32, b: u32) -> bool {
    distance_m(graph.place(a), graph.place(b)) <= TOUCHING_M || turning(graph, a, b)
}

fn turning(graph: &Graph<'_>, a: u32, b: u32) -> bool {
    let leads = |from: u32, to: u32| {
        let links = graph.steps(from).iter().filter(|s| is_link(graph, **s) && graph.allowed(**s));
        let mut chains = links.map(|s| graph.chain(*s, &HashSet::new(), &|n| n == to));
        chains.any(|chain| {
            chain.end == to
                && graph.length_m(&chain.steps) <= TURNING_M
                && chain.steps.iter().all(|s| is_link(graph, *s) && graph.is_one_way(*s))
        })
    };
    leads(a, b) || leads(b, a)
}

fn is_link(graph: &Graph<'_>, step: Step) -> bool {
    graph.way(step).street.highway.is_link()
}

fn chains<'a>(graph: &'a Graph<'_>, from: u32) -> impl Iterator<Item = (Chain, f64)> + 'a {
    graph.steps(from).iter().map(|step| {
        let chain = graph.chain(*step, &HashSet::new(), &|_| false);
        let metres = graph.length_m(&chain.steps);
        (chain, metres)
    })
}

fn is_two_way(graph: &Graph<'_>, chain: &Chain) -> bool {
    let back: Vec<Step> = chain.steps.iter().map(|s| s.reversed()).collect();
    graph.all_allowed(&chain.steps) && graph.all_allowed(&back)
}

/// Returns whether streets meet at a node that are no links, and none of which is part of a roundabout.
fn is_plain_junction(graph: &Graph<'_>, node: u32) -> bool {
    let steps = graph.steps(node);
    let links = steps.iter().filter(|s| is_link(graph, **s)).map(|s| s.piece).collect();
    graph.is_junction(node, &links) && !steps.iter().any(|s| graph.way(*s).street.roundabout)
}

/// Returns whether a street joins the halves of a staggered crossing: at either end one street goes off, to
/// opposite sides, and this one goes straight on.
fn staggered(graph: &Graph<'_>, between: &Chain) -> bool {
    let first = between.steps[0];
    let last = between.steps[between.steps.len() - 1].reversed();
    match (side(graph, between.start, first), side(graph, between.end, last)) {
        // Seen from either end towards the other, both go off to the same hand.
        (Some(a), Some(b)) => a == b,
        _ => false,
    }
}

/// Returns whether the side street of a T junction goes off to the right, seen along a street that
/// leaves it and goes straight on at its other side; `None` if it is no such junction.
fn side(graph: &Graph<'_>, node: u32, along: Step) -> Option<bool> {
    let heading = |step: &Step| graph.direction(*step);
    let others =
        graph.steps(node).iter().filter(|s| s.piece != along.piece && !is_link(graph, **s));
    let others: Vec<f64> = others.map(heading).collect();
    let [a, b] = others[..] else { return None };
    let turn = |other: f64| turn_degrees(heading(&along), other);
    let straight = |other: f64| turn(other).abs() >= 180.0 - STRAIGHT_DEG;
    let side = match (straight(a), straight(b)) {
        (true, false) => turn(b),
        (false, true) => turn(a),
        _ => return None,
    };
    (side.abs() >= STRAIGHT_DEG).then_some(side > 0.0)
}

//! Which turns exist across a site: what one-way streets and turn restrictions leave.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::arms::Arm;
use super::extract::{Extract, Restriction, Via};
use super::graph::{Graph, Step};
use super::legs::{SlipKind, Surroundings};
use crate::angle::turn_degrees;

/// Most steps that a search for ways across one site takes.
const MAX_STEPS: usize = 20_000;

#[derive(Debug, Default)]
pub(super) struct Restrictions<'a> {
    by_from: HashMap<i64, Vec<&'a Restriction>>,
}

impl<'a> Restrictions<'a> {
    pub(super) fn new(extract: &'a Extract, time_of_day: f64) -> Self {
        let mut by_from: HashMap<i64, Vec<&Restriction>> = HashMap::new();
        for restriction in extract.restrictions.iter().filter(|r| r.holds(time_of_day)) {
            by_from.entry(restriction.from).or_default().push(restriction);
        }
        Self { by_from }
    }

    /// Consecutive steps on one way are one.
    fn allow(&self, graph: &Graph<'_>, path: &[Step], next: Step) -> bool {
        let last = path[path.len() - 1];
        let node = graph.extract.nodes.ids[graph.source(next) as usize];
        let to = graph.way(next).id;
        let at_node = self.by_from.get(&graph.way(last).id).into_iter().flatten();
        let by_node: Vec<_> = at_node.filter(|r| r.via == Via::Node(node)).collect();
        // Several `only_*` from one way allow each of their ways on.
        let only = by_node.iter().any(|r| r.only);
        let named = by_node.iter().any(|r| r.only && r.to == to);
        if (only && !named) || by_node.iter().any(|r| !r.only && r.to == to) {
            return false;
        }
        let mut ways: Vec<i64> = path.iter().map(|s| graph.way(*s).id).collect();
        ways.dedup();
        (0..ways.len()).all(|start| {
            let from = self.by_from.get(&ways[start]).into_iter().flatten();
            from.filter(|r| matches!(&r.via, Via::Ways(via) if *via == ways[start + 1..]))
                .filter(|_| ways.last() != Some(&to))
                .all(|r| (r.to == to) == r.only)
        })
    }
}

/// A way around the centre of the junction in the wrong sense, such as three left turns instead of
/// a forbidden right turn, does not count.
pub(super) fn crossings(
    graph: &Graph<'_>,
    restrictions: &Restrictions<'_>,
    around: &Surroundings,
    arms: &[Arm],
) -> BTreeSet<(usize, usize)> {
    let inside: HashSet<Step> = around.inside.iter().copied().collect();
    let mut exits: HashMap<Step, usize> = HashMap::new();
    for (index, arm) in arms.iter().enumerate() {
        for leg in arm.legs.iter().map(|l| &around.legs[*l]).filter(|l| l.outbound) {
            exits.insert(leg.first(), index);
        }
    }
    for slip in around.slips.iter().filter(|s| s.kind == SlipKind::Behind) {
        let last = slip.steps[slip.steps.len() - 1];
        if let Some(exit) = merged_into(graph, around, arms, graph.target(last)) {
            exits.insert(slip.steps[0], exit);
        }
    }
    let mut found = BTreeSet::new();
    for (index, arm) in arms.iter().enumerate() {
        let legs = arm.legs.iter().map(|l| &around.legs[*l]).filter(|l| l.inbound);
        let mut entries: Vec<Step> = legs.map(|l| l.first().reversed()).collect();
        for slip in arm.slips.iter().map(|s| &around.slips[*s]) {
            let SlipKind::Before(leaves) = slip.kind else { continue };
            if !restrictions.allow(graph, &[leaves], slip.steps[0]) {
                continue;
            }
            let last = slip.steps[slip.steps.len() - 1];
            match merged_into(graph, around, arms, graph.target(last)) {
                Some(exit) => found.extend([(index, exit)]),
                None => entries.push(last),
            }
        }
        for entry in entries {
            let mut search =
                Search { graph, restrictions, inside: &inside, exits: &exits, budget: MAX_STEPS };
            let mut reached = BTreeSet::new();
            let turned = turned_on(Turned::default(), graph.heading(entry));
            search.visit(&mut vec![entry], turned, &mut reached);
            found.extend(reached.into_iter().map(|exit| (index, exit)));
        }
    }
    found.retain(|(from, to)| from != to);
    found
}

fn merged_into(graph: &Graph<'_>, around: &Surroundings, arms: &[Arm], node: u32) -> Option<usize> {
    arms.iter().position(|arm| {
        arm.legs
            .iter()
            .map(|l| &around.legs[*l])
            .filter(|l| l.outbound)
            .any(|leg| leg.chain.steps.iter().any(|s| graph.target(*s) == node))
    })
}

/// How a path has turned so far: its first and last heading, and the sum of its turns, degrees. Steps that are too short for a
/// direction turn nothing.
type Turned = (Option<(f64, f64)>, f64);

fn turned_on((ends_deg, sum_deg): Turned, heading_deg: Option<f64>) -> Turned {
    let Some(heading_deg) = heading_deg else { return (ends_deg, sum_deg) };
    let (first, last) = ends_deg.unwrap_or((heading_deg, heading_deg));
    (Some((first, heading_deg)), sum_deg + turn_degrees(last, heading_deg))
}

/// Returns whether a path has gone around in the sense in which nobody turns.
fn is_around((ends_deg, sum_deg): Turned) -> bool {
    let straight = ends_deg.map_or(0.0, |(first, last)| turn_degrees(first, last));
    (sum_deg - straight).abs() >= 180.0
}

struct Search<'s, 'g> {
    graph: &'s Graph<'g>,
    restrictions: &'s Restrictions<'g>,
    inside: &'s HashSet<Step>,
    exits: &'s HashMap<Step, usize>,
    budget: usize,
}

impl Search<'_, '_> {
    fn visit(&mut self, path: &mut Vec<Step>, turned: Turned, reached: &mut BTreeSet<usize>) {
        let last = path[path.len() - 1];
        let graph = self.graph;
        for next in graph.steps(graph.target(last)) {
            let known = self.inside.contains(next) || self.exits.contains_key(next);
            if !known
                || next.piece == last.piece
                || !graph.allowed(*next)
                || path.iter().any(|s| graph.source(*s) == graph.target(*next))
                || self.budget == 0
                || !self.restrictions.allow(graph, path, *next)
            {
                continue;
            }
            self.budget -= 1;
            let turned = turned_on(turned, graph.heading(*next));
            match self.exits.get(next) {
                Some(_) if is_around(turned) => {}
                Some(arm) => {
                    reached.insert(*arm);
                }
                None => {
                    path.push(*next);
                    self.visit(path, turned, reached);
                    path.pop();
                }
            }
        }
    }
}

//! The street graph of an extract: pieces of ways between neighbouring nodes, and which nodes are junctions.

use std::collections::HashSet;

use super::extract::{Extract, Place, Way};
use super::geometry::{bearing_deg, distance_m};
use crate::angle::normalise_degrees;

/// Shortest distance between two places that says where a street leads, metres: below it (two nodes at one
/// place, or beside each other on one carriageway) any direction is chance.
const SHORTEST_M: f64 = 2.0;

/// A piece of a way between two neighbouring nodes, in the order of the way's nodes; all are positions in the extract.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Piece {
    pub(super) way: u32,
    pub(super) from: u32,
    pub(super) to: u32,
}

/// A piece and the direction in which it is walked, seen from the node where the walk starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Step {
    pub(super) piece: u32,
    /// Whether the walk goes as the way's nodes go.
    pub(super) forward: bool,
}

impl Step {
    pub(super) fn reversed(self) -> Self {
        Self { forward: !self.forward, ..self }
    }
}

/// A walk along a street from a node to the next junction, or to where the street ends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Chain {
    pub(super) steps: Vec<Step>,
    pub(super) start: u32,
    /// Where it ends: a junction, a dead end, or a node of the given set.
    pub(super) end: u32,
}

#[derive(Debug)]
pub(super) struct Graph<'a> {
    pub(super) extract: &'a Extract,
    pub(super) pieces: Vec<Piece>,
    /// Per node the end of its part of `steps`.
    offsets: Vec<u32>,
    steps: Vec<Step>,
    /// Nodes beside which the extract cuts a way.
    pub(super) cut: HashSet<u32>,
}

impl<'a> Graph<'a> {
    /// Nodes without a place are left out: the ways that refer to them are cut there.
    pub(super) fn new(extract: &'a Extract) -> Self {
        let mut pieces = Vec::with_capacity(extract.refs.len());
        let mut cut = HashSet::new();
        for (way, index) in extract.ways.iter().zip(0..) {
            let mut last: Option<u32> = None;
            let mut missing = false;
            for id in extract.nodes_of(way) {
                let node = extract.nodes.index(*id).filter(|n| extract.nodes.places[*n].is_some());
                let Some(node) = node.map(|n| n as u32) else {
                    cut.extend(last.take());
                    missing = true;
                    continue;
                };
                if std::mem::take(&mut missing) {
                    cut.insert(node);
                }
                if let Some(from) = last.filter(|from| *from != node) {
                    pieces.push(Piece { way: index, from, to: node });
                }
                last = Some(node);
            }
        }
        let (offsets, steps) = index(&pieces, extract.nodes.ids.len());
        let mut graph = Self { extract, pieces, offsets, steps, cut };
        let doubled = graph.doubled();
        if !doubled.is_empty() {
            let mut number = 0..;
            graph.pieces.retain(|_| number.next().is_some_and(|piece| !doubled.contains(&piece)));
            (graph.offsets, graph.steps) = index(&graph.pieces, extract.nodes.ids.len());
        }
        graph
    }

    /// A street that is mapped twice has its lanes once.
    fn doubled(&self) -> HashSet<u32> {
        let covers = |a: Step, b: Step| {
            let back = (a.reversed(), b.reversed());
            (self.allowed(a) || !self.allowed(b)) && (self.allowed(back.0) || !self.allowed(back.1))
        };
        let mut doubled = HashSet::new();
        for node in 0..self.extract.nodes.ids.len() as u32 {
            let steps = self.steps(node);
            for (a, b) in steps.iter().flat_map(|a| steps.iter().map(move |b| (*a, *b))) {
                let one = a.piece != b.piece && self.target(a) == self.target(b);
                if one && covers(a, b) && (a.piece < b.piece || !covers(b, a)) {
                    doubled.insert(b.piece);
                }
            }
        }
        doubled
    }

    /// Returns the steps that leave a node, whether or not traffic may go that way.
    pub(super) fn steps(&self, node: u32) -> &[Step] {
        let node = node as usize;
        &self.steps[self.offsets[node] as usize..self.offsets[node + 1] as usize]
    }

    pub(super) fn target(&self, step: Step) -> u32 {
        let piece = self.pieces[step.piece as usize];
        if step.forward { piece.to } else { piece.from }
    }

    pub(super) fn source(&self, step: Step) -> u32 {
        self.target(step.reversed())
    }

    pub(super) fn way(&self, step: Step) -> &'a Way {
        &self.extract.ways[self.pieces[step.piece as usize].way as usize]
    }

    pub(super) fn allowed(&self, step: Step) -> bool {
        self.way(step).street.direction.allows(step.forward)
    }

    pub(super) fn is_one_way(&self, step: Step) -> bool {
        self.allowed(step) != self.allowed(step.reversed())
    }

    pub(super) fn place(&self, node: u32) -> Place {
        self.extract.nodes.places[node as usize].expect("nodes of pieces have a place")
    }

    pub(super) fn step_m(&self, step: Step) -> f64 {
        distance_m(self.place(self.source(step)), self.place(self.target(step)))
    }

    /// Returns the direction of a step, degrees; of one that is too short for a direction that in which its street
    /// goes on, or else comes from; `None` for one between two junctions.
    pub(super) fn heading(&self, step: Step) -> Option<f64> {
        let towards = |step: Step| {
            let from = self.place(self.source(step));
            let far = |node: u32| distance_m(from, self.place(node)) >= SHORTEST_M;
            let end = self.chain(step, &HashSet::new(), &far).end;
            far(end).then(|| bearing_deg(from, self.place(end)))
        };
        let back = || towards(step.reversed()).map(|deg| normalise_degrees(deg + 180.0));
        towards(step).or_else(back)
    }

    /// Returns its heading, or where it has none the direction from node to node, degrees.
    pub(super) fn direction(&self, step: Step) -> f64 {
        let nodes = || bearing_deg(self.place(self.source(step)), self.place(self.target(step)));
        self.heading(step).unwrap_or_else(nodes)
    }

    /// Returns whether traffic can only leave a node or only come to it, on two or more pieces: it comes from or
    /// goes to a street that the extract does not have, such as where a street forks at the border.
    pub(super) fn is_open_fork(&self, node: u32) -> bool {
        let steps = self.steps(node);
        steps.len() > 1
            && steps.iter().all(|s| self.is_one_way(*s))
            && steps.windows(2).all(|pair| self.allowed(pair[0]) == self.allowed(pair[1]))
    }

    pub(super) fn neighbours(&self, node: u32, ignored: &HashSet<u32>) -> Vec<u32> {
        let steps = self.steps(node).iter().filter(|s| !ignored.contains(&s.piece));
        let mut nodes: Vec<u32> = steps.map(|s| self.target(*s)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Returns whether streets meet at a node: it has three or more neighbours.
    pub(super) fn is_junction(&self, node: u32, ignored: &HashSet<u32>) -> bool {
        self.steps(node).len() > 2 && self.neighbours(node, ignored).len() > 2
    }

    /// Walks from the start of a step to the next junction, to a node for which `stop` holds, to a
    /// dead end, or around a closed loop back to its start.
    pub(super) fn chain(
        &self,
        first: Step,
        ignored: &HashSet<u32>,
        stop: &dyn Fn(u32) -> bool,
    ) -> Chain {
        self.walk(first, ignored, stop, f64::INFINITY)
    }

    /// Walks as [`Self::chain`] does, with every street, but ends soon after a distance, metres.
    pub(super) fn chain_within(&self, first: Step, limit_m: f64) -> Chain {
        self.walk(first, &HashSet::new(), &|_| false, limit_m)
    }

    fn walk(
        &self,
        first: Step,
        ignored: &HashSet<u32>,
        stop: &dyn Fn(u32) -> bool,
        limit_m: f64,
    ) -> Chain {
        let start = self.source(first);
        let mut steps = vec![first];
        let mut end = self.target(first);
        let mut metres = 0.0;
        while end != start && !stop(end) && !self.is_junction(end, ignored) {
            let last = steps[steps.len() - 1];
            if limit_m.is_finite() {
                metres += self.step_m(last);
            }
            let came_from = self.source(last);
            let mut on = self.steps(end).iter().filter(|s| !ignored.contains(&s.piece));
            let next = on.find(|s| self.target(**s) != came_from);
            let Some(next) = next.filter(|_| metres <= limit_m) else { break };
            steps.push(*next);
            end = self.target(*next);
        }
        Chain { steps, start, end }
    }

    pub(super) fn places(&self, chain: &Chain) -> Vec<Place> {
        let start = std::iter::once(self.place(chain.start));
        start.chain(chain.steps.iter().map(|s| self.place(self.target(*s)))).collect()
    }

    pub(super) fn length_m(&self, steps: &[Step]) -> f64 {
        steps.iter().map(|s| self.step_m(*s)).sum()
    }

    pub(super) fn all_allowed(&self, steps: &[Step]) -> bool {
        steps.iter().all(|s| self.allowed(*s))
    }
}

fn index(pieces: &[Piece], nodes: usize) -> (Vec<u32>, Vec<Step>) {
    let mut offsets = vec![0_u32; nodes + 1];
    for piece in pieces {
        offsets[piece.from as usize + 1] += 1;
        offsets[piece.to as usize + 1] += 1;
    }
    for i in 1..offsets.len() {
        offsets[i] += offsets[i - 1];
    }
    let mut next = offsets.clone();
    let none = Step { piece: 0, forward: true };
    let mut steps = vec![none; 2 * pieces.len()];
    for (piece, index) in pieces.iter().zip(0..) {
        for (node, forward) in [(piece.from, true), (piece.to, false)] {
            steps[next[node as usize] as usize] = Step { piece: index, forward };
            next[node as usize] += 1;
        }
    }
    (offsets, steps)
}

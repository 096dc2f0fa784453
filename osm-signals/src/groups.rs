//! Nodes that are one intersection, gathered step by step.

use std::collections::{BTreeMap, BTreeSet};

use super::geometry::distance_m;
use super::graph::Graph;

/// The nodes of one intersection.
#[derive(Debug, Clone, Default)]
pub(super) struct Group {
    /// The nodes.
    pub(super) nodes: BTreeSet<u32>,
    /// Whether ramps are joined in it only because they are near.
    pub(super) ramps: bool,
}

/// Disjoint groups of nodes of limited extent.
pub(super) struct Groups<'g, 'a> {
    graph: &'g Graph<'a>,
    max_extent_m: f64,
    /// Position of the group of each node.
    pub(super) of: BTreeMap<u32, usize>,
    groups: Vec<Group>,
}

impl<'g, 'a> Groups<'g, 'a> {
    /// Returns a group for each node.
    pub(super) fn new(
        graph: &'g Graph<'a>,
        max_extent_m: f64,
        nodes: impl Iterator<Item = u32>,
    ) -> Self {
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
    pub(super) fn join(&mut self, a: u32, b: u32, between: BTreeSet<u32>, guessed: bool) {
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

    /// Joins the groups of two nodes, however wide that is.
    pub(super) fn unite(&mut self, a: u32, b: u32) {
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

    /// Adds a node to the group of another, unless that is too wide; returns whether it did.
    pub(super) fn add(&mut self, a: u32, node: u32) -> bool {
        let group = self.of[&a];
        let fits = self.fits(group, &BTreeSet::from([node]));
        if fits {
            self.groups[group].nodes.insert(node);
            self.of.insert(node, group);
        }
        fits
    }

    /// Returns the groups.
    pub(super) fn members(self) -> Vec<Group> {
        self.groups.into_iter().filter(|group| !group.nodes.is_empty()).collect()
    }
}

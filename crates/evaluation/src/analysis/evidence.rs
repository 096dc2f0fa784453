//! What methods are summarised from.

use super::episodes::Episodes;
use super::estimator::Chosen;
use super::measures::Measures;
use super::points::{PointSummary, TaskScore};
use super::reference::Reference;
use crate::sample::{Design, Sampling};
use crate::store::manifest::Identity;

/// What methods are summarised from; all of a run, or the part of it that some methods have in common.
#[derive(Clone, Copy)]
pub(super) struct Evidence<'a> {
    /// What the run was.
    pub(super) identity: &'a Identity,
    /// What scores are divided by.
    pub(super) reference: &'a Reference,
    /// What the domain measures.
    pub(super) measures: &'a dyn Measures,
    /// The point MDPs that count.
    pub(super) points: &'a [PointSummary],
    /// How these came to be in the sample, in their order.
    pub(super) chosen: &'a [Chosen],
    /// The tasks that count.
    pub(super) tasks: &'a [TaskScore],
    /// All evaluation episodes.
    pub(super) episodes: &'a Episodes,
    /// The most that a score can be; infinite where that is not known.
    pub(super) most: f64,
    /// Of every method, whether it learned, once on each point MDP.
    pub(super) learned_once: &'a [bool],
    /// What is known of the whole family.
    pub(super) design: Option<&'a Design>,
}

impl<'a> Evidence<'a> {
    /// Returns what says how alike point MDPs are, for the estimator that takes it.
    pub(super) fn given(&self) -> Option<&'a Design> {
        self.design.filter(|_| self.identity.sample.sampling == Sampling::BayesianQuadrature)
    }
}

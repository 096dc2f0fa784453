//! What a domain knows of its records that evaluation does not: classes of its point MDPs, and what else
//! happened in an episode than the objective says.

use std::collections::BTreeMap;

use crate::store::record::Metrics;

/// A class of point MDPs, of which every method has a score of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Regime {
    /// Name of its columns, such as `at_f`.
    pub name: &'static str,
    /// Heading of its column in a terminal, such as `at F`.
    pub short: &'static str,
    /// Heading of its column on the page, two lines.
    pub heading: [&'static str; 2],
}

/// A share that is known of every evaluation episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Share {
    /// Name of its column, such as `gridlock_share`.
    pub name: &'static str,
    /// What an episode is that has it, such as `gridlocked`, when it is 0 or 1 in every episode.
    pub event: Option<&'static str>,
    /// Heading of its column in a terminal, such as `gridlock`.
    pub short: &'static str,
    /// Heading of its column on the page: what, and of what it is a share.
    pub heading: [&'static str; 2],
}

/// What a domain adds to an analysis of its records; without any of it everything else is still there.
pub trait Measures: Sync {
    /// Returns the most that the objective can be; `None` where nobody has said.
    fn most(&self, objective: &str) -> Option<f64> {
        let _ = objective;
        None
    }

    /// Returns the regimes into which point MDPs fall by what the objective says of them.
    fn regimes(&self, objective: &str) -> &'static [Regime] {
        let _ = objective;
        &[]
    }

    /// Returns the position of a point MDP's regime in [`Measures::regimes`]; `None` where that is not known.
    ///
    /// # Arguments
    ///
    /// * `baseline` — means of the baseline there, whatever scores are divided by.
    fn regime(&self, objective: &str, baseline: &Metrics) -> Option<usize> {
        let _ = (objective, baseline);
        None
    }

    /// Returns the shares that are known of an evaluation episode.
    fn shares(&self) -> &'static [Share] {
        &[]
    }

    /// Returns the shares of an evaluation episode, in the order of [`Measures::shares`], each from 0 to 1;
    /// `None` where one is not known.
    ///
    /// # Arguments
    ///
    /// * `baseline` — means of the baseline on the same point MDP and seed, where it has any.
    fn shares_of(&self, metrics: &Metrics, baseline: Option<&Metrics>) -> Vec<Option<f64>> {
        let _ = (metrics, baseline);
        Vec::new()
    }

    /// Returns whether a method that tunes itself kept what tuning started from, by the details of its record; `None` where
    /// nothing was tuned or that is not known.
    fn kept_start(&self, details: &BTreeMap<String, String>) -> Option<bool> {
        let _ = details;
        None
    }
}

/// Nothing beside the objective.
impl Measures for () {}

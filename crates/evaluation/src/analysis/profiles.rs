//! Performance profiles of the methods that are ranked.

use super::evidence::Evidence;
use super::method::Summarised;
use crate::stats::profile::steps;

/// The performance profile of a method over the point MDPs of the ranking.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Position of the method in [`super::Analysis::methods`].
    pub method: usize,
    /// Every score in ascending order, with the share of the family, by importance, that is better than a threshold
    /// just beyond it.
    pub steps: Vec<(f64, f64)>,
}

/// Returns the profiles of the methods that are ranked, in their order.
pub(super) fn profiles(evidence: Evidence<'_>, estimates: &[Summarised]) -> Vec<Profile> {
    let ranked = estimates.iter().take_while(|(m, _)| m.rank.is_some()).enumerate();
    let profile = |(method, (m, _)): (usize, &Summarised)| {
        let objectives = evidence.points.iter().filter_map(|p| {
            let objectives = p.results[m.index].as_ref()?.objectives.as_ref()?;
            Some((objectives.weight, objectives.score().ok()?))
        });
        Profile { method, steps: steps(objectives, evidence.identity.direction) }
    };
    ranked.map(profile).collect()
}

//! How sure the ranking is: methods two at a time, the probability of every place, and performance profiles.

use super::evidence::Evidence;
use super::method::Summarised;
use super::pairs::{Pair, pairs};
use super::profiles::{Profile, RankedProfiles};
use crate::stats::ranks::rank_probabilities;

/// How methods compare beyond their order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Comparison {
    /// Every two methods that have results on a point MDP in common, in the order of the ranking.
    pub pairs: Vec<Pair>,
    /// The probability of every place for every method that is ranked, shape `[ranked, ranked]`, both in the order of
    /// the ranking; `None` where nothing was resampled, as of one seed on a whole family.
    pub ranks: Option<Vec<Vec<f64>>>,
    /// The profiles of the methods that are ranked, in their order.
    pub profiles: Vec<Profile>,
}

/// Compares methods; `estimates` are in the order of the ranking, those that are not ranked last.
pub(super) fn compare(evidence: Evidence<'_>, estimates: &[Summarised]) -> Comparison {
    let profiles = RankedProfiles::of(evidence, estimates);
    let ranked = estimates.iter().take_while(|(m, _)| m.rank.is_some());
    let resamples: Option<Vec<&[f64]>> =
        ranked.map(|(_, e)| Some(e.as_ref()?.resamples.as_slice())).collect();
    let ranks = resamples.and_then(|r| rank_probabilities(&r, evidence.identity.direction));
    Comparison {
        pairs: pairs(evidence, estimates, &profiles),
        ranks: ranks.filter(|ranks| ranks.len() > 1),
        profiles: profiles.profiles,
    }
}

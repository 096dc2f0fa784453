//! How sure the ranking is: methods two at a time, the probability of every place, and performance profiles.
//!
//! Places are made of the resamples that intervals have. All methods get the same factors for few seeds, those of the pair
//! with the fewest degrees of freedom: unequal ones would add to differences what methods have in common.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::estimator::Estimate;
use super::evidence::Evidence;
use super::method::Summarised;
use super::pairs::{Pair, pairs};
use crate::stats::Bootstrap;
use crate::stats::profile::steps;
use crate::stats::ranks::rank_probabilities;
use crate::stats::resampling::factors;
use basics::seed::derive;

/// Fewest evaluation seeds for probabilities of places: a resample of two seeds has only one of them, so that a method that
/// is the best on average but on no single seed would never be first.
pub const FEWEST_SEEDS_FOR_PLACES: usize = 3;

/// How methods compare beyond their order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Comparison {
    /// Every two methods that have results on a point MDP in common, in the order of the ranking.
    pub pairs: Vec<Pair>,
    /// The probability of every place for every method that is ranked, shape `[ranked, ranked]`, both in the order of
    /// the ranking; `None` with fewer than [`FEWEST_SEEDS_FOR_PLACES`] evaluation seeds, and where nothing was resampled.
    pub ranks: Option<Vec<Vec<f64>>>,
    /// The profiles of the methods that are ranked, in their order.
    pub profiles: Vec<Profile>,
}

/// Compares methods; `estimates` are in the order of the ranking, those that are not ranked last.
pub(super) fn compare(evidence: Evidence<'_>, estimates: &[Summarised]) -> Comparison {
    let pairs = pairs(evidence, estimates);
    let ranks = places(evidence, estimates, &pairs);
    Comparison { pairs, ranks, profiles: profiles(evidence, estimates) }
}

fn places(
    evidence: Evidence<'_>,
    estimates: &[Summarised],
    pairs: &[Pair],
) -> Option<Vec<Vec<f64>>> {
    let identity = evidence.identity;
    let ranked = estimates.iter().take_while(|(m, _)| m.rank.is_some());
    let ranked: Vec<&Estimate> = ranked.map(|(_, e)| e.as_ref()).collect::<Option<_>>()?;
    if identity.evaluation_seeds.len() < FEWEST_SEEDS_FOR_PLACES || ranked.len() < 2 {
        return None;
    }
    let of_ranked = pairs.iter().filter(|pair| pair.second < ranked.len());
    let fewest = of_ranked.filter_map(|pair| pair.degrees).min_by(f64::total_cmp);
    let mut rng = ChaCha8Rng::seed_from_u64(derive(identity.base_seed, &["report", "few seeds"]));
    let factors = factors(fewest, ranked[0].resamples.len(), &mut rng);
    let stretched = |e: &&Estimate| {
        let bootstrap = Bootstrap { estimate: e.centre, resamples: e.resamples.clone() };
        bootstrap.stretched(&factors).resamples
    };
    let resamples: Vec<Vec<f64>> = ranked.iter().map(stretched).collect();
    let resamples: Vec<&[f64]> = resamples.iter().map(Vec::as_slice).collect();
    rank_probabilities(&resamples, identity.direction)
}

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
fn profiles(evidence: Evidence<'_>, estimates: &[Summarised]) -> Vec<Profile> {
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

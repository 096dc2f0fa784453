//! Performance profiles of the methods that are ranked, with bands, and which of two dominates.

use rayon::prelude::*;

use super::estimator::{Estimate, Estimator, Sample};
use super::evidence::Evidence;
use super::method::{Summarised, paired};
use super::points::PointSummary;
use super::summaries::{Estimated, shifted};
use crate::stats::beyond::SharesBeyond;
use crate::stats::dominance::{Dominance, dominance};
use crate::stats::profile::{extremes, steps, thresholds};
use crate::stats::weighted_quantile::is_coarse;
use crate::stats::{Direction, PointObjectives};

/// Most thresholds at which a band is computed, beside those where two methods are furthest apart.
const THRESHOLDS: usize = 64;

/// By how much rounding may part equal shares.
const ROUNDING: f64 = 1e-12;

/// The performance profile of a method over the point MDPs of the ranking.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Position of the method in [`super::Analysis::methods`].
    pub method: usize,
    /// Every score in ascending order, with the share of the family that is better than a threshold just beyond it.
    pub steps: Vec<(f64, f64)>,
    /// At each threshold the share of the family, by importance, with a better score.
    pub bands: Vec<(f64, Estimated)>,
}

/// Profiles with what they were estimated from.
pub(super) struct RankedProfiles {
    /// One per ranked method, in their order.
    pub(super) profiles: Vec<Profile>,
    /// Per method and threshold the resampled shares, shape `[methods, thresholds, resamples]`.
    resamples: Vec<Vec<Vec<f64>>>,
    /// Per method weight and score of every point MDP.
    scores: Vec<Vec<(f64, f64)>>,
}

impl RankedProfiles {
    /// Returns the profiles of the methods that are ranked.
    pub(super) fn of(evidence: Evidence<'_>, estimates: &[Summarised]) -> Self {
        let ranked: Vec<usize> = (estimates.iter().take_while(|(m, _)| m.rank.is_some()))
            .map(|(m, _)| m.index)
            .collect();
        let objectives: Vec<Vec<PointObjectives>> =
            ranked.iter().map(|index| objectives_of(evidence, *index)).collect();
        let scores: Vec<Vec<(f64, f64)>> = objectives
            .iter()
            .map(|o| o.iter().filter_map(|o| Some((o.weight, o.score().ok()?))).collect())
            .collect();
        // All scores of the reference are 1, which is a threshold worth having whoever else scores so.
        let others =
            ranked.iter().zip(&scores).filter(|(i, _)| Some(**i) != evidence.reference.index);
        let mut at = thresholds(others.flat_map(|(_, s)| s.iter().map(|p| p.1)), THRESHOLDS);
        at.extend((!evidence.reference.is_none()).then_some(1.0));
        at.extend(furthest_apart(&scores, evidence.identity.direction));
        let at = thresholds(at, usize::MAX);
        let of_method = |(method, index): (usize, usize)| {
            let shares = shares(evidence, index, &objectives[method], &at);
            let banded = at.iter().zip(&shares);
            let coarse = is_coarse(scores[method].iter().map(|s| s.0));
            let profile = Profile {
                method,
                steps: steps(scores[method].iter().copied(), evidence.identity.direction),
                bands: banded.filter_map(|(t, e)| Some((*t, share(e.as_ref()?, coarse)))).collect(),
            };
            let resamples = shares.into_iter().map(|e| e.map_or_else(Vec::new, |e| e.resamples));
            (profile, resamples.collect())
        };
        let ranked: Vec<(usize, usize)> = ranked.into_iter().enumerate().collect();
        let (profiles, resamples) = ranked.into_par_iter().map(of_method).unzip();
        Self { profiles, resamples, scores }
    }

    /// Returns what the profiles of two methods say; `None` where one of them is not ranked.
    pub(super) fn dominance(
        &self,
        evidence: Evidence<'_>,
        first: usize,
        second: usize,
    ) -> Option<Dominance> {
        let (a, b) = (self.scores.get(first)?, self.scores.get(second)?);
        let (_, a, b) = extremes(a, b, evidence.identity.direction);
        let bands = self.profiles[first].bands.iter().zip(&self.profiles[second].bands);
        let resamples = self.resamples[first].iter().zip(&self.resamples[second]);
        let tested = bands.zip(resamples).map(|((p, q), (a, b))| {
            let paired = !a.is_empty() && a.len() == b.len();
            let distances = || a.iter().zip(b).map(|(a, b)| a - b).collect();
            paired.then(|| (p.1.value - q.1.value, distances()))
        });
        let tested: Vec<(f64, Vec<f64>)> = tested.collect::<Option<_>>().unwrap_or_default();
        Some(dominance(&a, &b, &tested, evidence.identity.sample.alpha()))
    }
}

/// Returns for every two methods where either is furthest ahead, which is where dominance is decided.
fn furthest_apart(scores: &[Vec<(f64, f64)>], direction: Direction) -> Vec<f64> {
    let of_two = |(i, j): (usize, usize)| {
        let (at, a, b) = extremes(&scores[i], &scores[j], direction);
        let distances = || at.iter().zip(a.iter().zip(&b).map(|(a, b)| a - b));
        let most = distances().max_by(|x, y| x.1.total_cmp(&y.1));
        let least = distances().min_by(|x, y| x.1.total_cmp(&y.1));
        let most = most.filter(|d| d.1 > ROUNDING).map(|d| *d.0);
        [most, least.filter(|d| d.1 < -ROUNDING).map(|d| *d.0)]
    };
    let pairs: Vec<(usize, usize)> =
        (0..scores.len()).flat_map(|i| (0..i).map(move |j| (i, j))).collect();
    let found: Vec<[Option<f64>; 2]> = pairs.into_par_iter().map(of_two).collect();
    found.into_iter().flatten().flatten().collect()
}

fn objectives_on(point: &PointSummary, index: usize) -> Option<&PointObjectives> {
    point.results[index].as_ref()?.objectives.as_ref()
}

fn objectives_of(evidence: Evidence<'_>, index: usize) -> Vec<PointObjectives> {
    evidence.points.iter().filter_map(|p| objectives_on(p, index).cloned()).collect()
}

/// Estimates the share with a better score at each threshold, from the same draws for every method.
fn shares(
    evidence: Evidence<'_>,
    index: usize,
    objectives: &[PointObjectives],
    thresholds: &[f64],
) -> Vec<Option<Estimate>> {
    let direction = evidence.identity.direction;
    let statistics = SharesBeyond::new(thresholds, direction);
    let points: Vec<&PointSummary> =
        evidence.points.iter().filter(|p| objectives_on(p, index).is_some()).collect();
    let all = paired(evidence, index, &points, |estimator, sample, rng| {
        // A model predicts no profile; what says how alike point MDPs are says how far one may be off.
        let design = sample.design.filter(|_| estimator == Estimator::BayesianQuadrature);
        estimator.estimate_all(Sample { design, ..sample }, objectives, &statistics, rng)
    });
    all.unwrap_or_else(|_| vec![None; thresholds.len()])
}

/// Returns a share with its band, which contains it and stays between 0 and 1.
fn share(e: &Estimate, coarse: bool) -> Estimated {
    let within = |(low, high): (f64, f64)| (low.max(0.0), high.min(1.0));
    let band = shifted(e, coarse);
    Estimated { interval: band.interval.map(within), ..band }
}

//! How sure the ranking is: methods two at a time, the probability of every place, and performance profiles.
//!
//! Differences and wins are taken point MDP by point MDP and seed by seed, and the estimator is asked for their mean. So they
//! have an interval whatever the estimator makes it of, and two methods that lack different point MDPs are compared where both
//! have results. Places are made of the resamples that intervals have. All methods get the same factors for few seeds, those of the pair
//! with the fewest degrees of freedom: unequal ones would add to differences what methods have in common.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::choice::weights;
use super::estimator::{Estimate, Estimator, Sample, estimator_of};
use super::method::{MethodSummary, Summarised, paired};
use super::points::{Evidence, PointResult, PointSummary};
use super::summaries::Estimated;
use crate::stats::improvement::{self, placements};
use crate::stats::profile::steps;
use crate::stats::ranks::rank_probabilities;
use crate::stats::resampling::factors;
use crate::stats::{Bootstrap, Direction, PointObjectives, degrees};
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
    /// The performance profiles of the methods that are ranked, in their order: every score in ascending order, with the share
    /// of the family, by importance, that is better than a threshold just beyond it.
    pub profiles: Vec<Vec<(f64, f64)>>,
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

/// Returns the profiles of the methods that are ranked, in their order.
fn profiles(evidence: Evidence<'_>, estimates: &[Summarised]) -> Vec<Vec<(f64, f64)>> {
    let ranked = estimates.iter().take_while(|(m, _)| m.rank.is_some());
    let profile = |(m, _): &Summarised| {
        let objectives = evidence.points.iter().filter_map(|p| {
            let objectives = p.results[m.index].as_ref()?.objectives.as_ref()?;
            Some((objectives.weight, objectives.score().ok()?))
        });
        steps(objectives, evidence.identity.direction)
    };
    ranked.map(profile).collect()
}

/// Point MDPs without which the lead of a method that was trained once has to stand.
const INFLUENTIAL: usize = 5;

/// Times as many that both must have: of fewer these are a large part.
const LEAST: usize = 4;

/// Two methods compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// Position in [`super::Analysis::methods`] of the one that is named first there.
    pub first: usize,
    /// Position of the other.
    pub second: usize,
    /// Point MDPs on which both have results, and which alone count here.
    pub points: usize,
    /// By how much the first one's overall performance is ahead; negative where it is behind.
    pub ahead: Estimated,
    /// Degrees of freedom of this lead over seeds, where these alone make its spread.
    pub degrees: Option<f64>,
    /// Probability that a run of the first is better than one of the second on the same point MDP.
    pub improvement: Estimated,
    /// The point MDPs that matter most, as positions in [`super::Analysis::points`], where the lead of a method that was
    /// trained once vanishes without them; then the lead is not decided.
    pub fragile: Vec<usize>,
}

/// What the interval of a difference says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decided {
    /// The first is better.
    First,
    /// The second is better.
    Second,
    /// The interval contains 0.
    Open,
    /// There is no interval.
    Unknown,
}

impl Pair {
    /// Returns what the interval of the difference says.
    pub fn decided(&self) -> Decided {
        match self.ahead.interval {
            None => Decided::Unknown,
            Some(_) if !self.fragile.is_empty() => Decided::Open,
            Some((low, _)) if low > 0.0 => Decided::First,
            Some((_, high)) if high < 0.0 => Decided::Second,
            Some(_) => Decided::Open,
        }
    }
}

/// A point MDP with the objectives of both methods on the same seeds.
type OnPoint<'a> = (&'a PointSummary, &'a PointObjectives, &'a PointObjectives);

/// Compares all methods that have an estimate, two at a time, in the order of the ranking.
fn pairs(evidence: Evidence<'_>, estimates: &[Summarised]) -> Vec<Pair> {
    let n = estimates.len();
    let of_first = |first: usize| (first + 1..n).map(move |second| (first, second));
    let pair = |(first, second): (usize, usize)| compared(evidence, estimates, first, second);
    let all: Vec<(usize, usize)> = (0..n).flat_map(of_first).collect();
    all.into_par_iter().filter_map(pair).collect()
}

/// Compares two methods where both have results; `None` where nothing can be estimated of them.
fn compared(
    evidence: Evidence<'_>,
    estimates: &[Summarised],
    first: usize,
    second: usize,
) -> Option<Pair> {
    let direction = evidence.identity.direction;
    let ((a, of_a), (b, of_b)) = (&estimates[first], &estimates[second]);
    let shared = shared(evidence.points, a, b);
    let ahead = |(point, x, y): &OnPoint<'_>| PointObjectives {
        weight: point.weight,
        method: improvement::ahead(&x.method, &y.method, direction),
        ..(*x).clone()
    };
    let wins = |(point, x, _): &OnPoint<'_>| PointObjectives {
        weight: point.weight,
        method: placements(runs(point, a), runs(point, b), direction),
        baseline: vec![1.0; x.baseline.len()],
        draws: x.draws,
    };
    let points: Vec<&PointSummary> = shared.iter().map(|on| on.0).collect();
    let weights = weights(evidence.identity, &points);
    let mean = |of: &dyn Fn(&OnPoint<'_>) -> PointObjectives| {
        let objectives: Vec<PointObjectives> = (shared.iter().zip(&weights))
            .map(|(on, weight)| PointObjectives { weight: *weight, ..of(on) })
            .collect();
        let mean = paired(evidence, a.index, &points, |estimator, sample, rng| {
            let learned_once = [a, b].iter().any(|m| evidence.learned_once[m.index]);
            let name = &format!("{} {}", a.method, b.method);
            estimator.estimate(Sample { name, learned_once, ..sample }, &objectives, rng)
        });
        mean.ok()
    };
    let difference = match both_over(&shared, (a, of_a), (b, of_b)) {
        Some((of_a, of_b)) if apart(&shared) => of_a.ahead(of_b, direction),
        // The same mean of differences, without drawing the seeds once more.
        Some((of_a, of_b)) if only_seeds(evidence, &shared, [a.index, b.index]) => {
            let differences: Vec<PointObjectives> = shared.iter().map(ahead).collect();
            of_a.ahead(of_b, direction).with_degrees(degrees(&differences))
        }
        _ => mean(&ahead)?,
    };
    let improvement = mean(&wins)?;
    let leader = if difference.value > 0.0 { a } else { b };
    let fragile = match evidence.learned_once[leader.index] {
        true => fragile(&shared, &weights, direction, difference.value),
        false => Vec::new(),
    };
    Some(Pair {
        first,
        second,
        fragile,
        points: shared.len(),
        ahead: Estimated { value: difference.value, interval: difference.interval },
        degrees: difference.degrees,
        improvement: Estimated { value: improvement.value, interval: improvement.interval }
            .cut((0.0, 1.0)),
    })
}

fn fragile(shared: &[OnPoint<'_>], weights: &[f64], direction: Direction, lead: f64) -> Vec<usize> {
    let part = |((point, x, y), weight): (&OnPoint<'_>, &f64)| {
        let ahead = direction.ahead(x.score().ok()?, y.score().ok()?);
        Some((weight * ahead * lead.signum(), point.index))
    };
    let mut parts: Vec<(f64, usize)> = shared.iter().zip(weights).filter_map(part).collect();
    parts.sort_by(|a, b| b.0.total_cmp(&a.0));
    let rest: f64 = parts.iter().skip(INFLUENTIAL).map(|part| part.0).sum();
    let vanishes = parts.len() >= LEAST * INFLUENTIAL && rest <= 0.0;
    parts.into_iter().take(if vanishes { INFLUENTIAL } else { 0 }).map(|part| part.1).collect()
}

fn shared<'a>(
    points: &'a [PointSummary],
    a: &MethodSummary,
    b: &MethodSummary,
) -> Vec<OnPoint<'a>> {
    let objectives =
        |p: &'a PointSummary, m: &MethodSummary| p.results[m.index].as_ref()?.objectives.as_ref();
    let on_point = |p: &'a PointSummary| {
        let (x, y) = (objectives(p, a)?, objectives(p, b)?);
        (x.baseline == y.baseline).then_some((p, x, y))
    };
    points.iter().filter_map(on_point).collect()
}

/// Returns what a method measured on a point MDP, shape `[replicates, seeds]`.
fn runs<'a>(point: &'a PointSummary, method: &MethodSummary) -> &'a [Vec<f64>] {
    point.results[method.index].as_ref().map_or(&[], PointResult::runs)
}

fn both_over<'a>(
    shared: &[OnPoint<'_>],
    (a, of_a): (&MethodSummary, &'a Option<Estimate>),
    (b, of_b): (&MethodSummary, &'a Option<Estimate>),
) -> Option<(&'a Estimate, &'a Estimate)> {
    let same = [a.points, b.points] == [shared.len(); 2];
    let (of_a, of_b) = of_a.as_ref().zip(of_b.as_ref())?;
    let resampled = !of_a.resamples.is_empty() && of_a.resamples.len() == of_b.resamples.len();
    (same && resampled).then_some((of_a, of_b))
}

/// Whether the resamples of two estimates say more than those of differences do: both methods were trained several
/// times, each on its own.
fn apart(shared: &[OnPoint<'_>]) -> bool {
    let several = |o: &PointObjectives| o.method.len() > 1;
    shared.iter().any(|(_, x, y)| several(x) && several(y))
}

/// Whether resamples of these point MDPs differ by evaluation seeds alone, the same for both methods.
fn only_seeds(evidence: Evidence<'_>, shared: &[OnPoint<'_>], methods: [usize; 2]) -> bool {
    let sample = &evidence.identity.sample;
    let once = |o: &PointObjectives| o.method.len() == 1;
    estimator_of(sample) == Estimator::Whole
        && shared.len() == sample.family_size
        && methods.iter().all(|method| !evidence.learned_once[*method])
        && shared.iter().all(|(_, x, y)| once(x) && once(y))
}

//! Two methods on the same point MDPs and seeds: by how much one is ahead, how sure that is, and how often it is better.
//!
//! Differences and wins are taken point MDP by point MDP and seed by seed, and the estimator is asked for their mean. So
//! they have an interval whatever the estimator makes it of, and two methods that lack different point MDPs are compared
//! where both have results.

use std::ops::Range;

use rayon::prelude::*;

use super::estimator::{Estimate, Sample};
use super::evidence::Evidence;
use super::method::{MethodSummary, Summarised, paired};
use super::points::PointSummary;
use super::profiles::RankedProfiles;
use super::summaries::Estimated;
use crate::sample::Design;
use crate::stats::improvement::{self, placements};
use crate::stats::{Dominance, PointObjectives, Verdict};

/// Most comparisons with one method that are made at once, and point MDPs in them: what they are computed from is in
/// memory then.
const PAIRS_AT_ONCE: usize = 8;
const POINTS_AT_ONCE: usize = 100_000;

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
    /// Probability that a run of the first is better than one of the second on the same point MDP.
    pub improvement: Estimated,
    /// What the profiles of the two say; `None` where one of them is not ranked.
    pub dominance: Option<Dominance>,
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
            Some((low, _)) if low > 0.0 => Decided::First,
            Some((_, high)) if high < 0.0 => Decided::Second,
            Some(_) => Decided::Open,
        }
    }
}

/// A point MDP with the objectives of both methods on the same seeds.
type OnPoint<'a> = (&'a PointSummary, &'a PointObjectives, &'a PointObjectives);

/// Compares all methods that have an estimate, two at a time, in the order of the ranking.
pub(super) fn pairs(
    evidence: Evidence<'_>,
    estimates: &[Summarised],
    profiles: &RankedProfiles,
) -> Vec<Pair> {
    let n = estimates.len();
    let at_once = (POINTS_AT_ONCE / evidence.points.len().max(1)).clamp(1, PAIRS_AT_ONCE);
    let of_first = |first: usize| {
        (first + 1..n).step_by(at_once).map(move |second| (first, second..n.min(second + at_once)))
    };
    let parts: Vec<(usize, Range<usize>)> = (0..n).flat_map(of_first).collect();
    let of_part = |(first, seconds): (usize, Range<usize>)| {
        let pair = |found: Pair| {
            let dominance = profiles.dominance(evidence, first, found.second);
            Pair { dominance: dominance.map(|d| agreed(d, &found)), ..found }
        };
        compared(evidence, estimates, first, seconds).into_iter().map(pair).collect::<Vec<_>>()
    };
    parts.into_par_iter().flat_map_iter(of_part).collect()
}

/// Leaves open what cannot be: whoever dominates has the better mean.
fn agreed(dominance: Dominance, pair: &Pair) -> Dominance {
    let ahead = pair.ahead.value;
    let verdict = match dominance.verdict {
        Verdict::First if ahead < 0.0 => Verdict::Open,
        Verdict::Second if ahead > 0.0 => Verdict::Open,
        verdict => verdict,
    };
    Dominance { verdict, ..dominance }
}

/// Two methods where both have results, before anything is estimated.
struct Match<'a> {
    second: usize,
    shared: Vec<OnPoint<'a>>,
    /// By how much the first is ahead, where the estimates of the two say so.
    difference: Option<Estimate>,
}

/// Compares a method with some that come after it.
///
/// Equal seeds and replicates are drawn for all of them, so that they are estimated together.
fn compared(
    evidence: Evidence<'_>,
    estimates: &[Summarised],
    first: usize,
    seconds: Range<usize>,
) -> Vec<Pair> {
    let direction = evidence.identity.direction;
    let (a, of_a) = &estimates[first];
    let design = evidence.assisting();
    let matched = |second: usize| {
        let (b, of_b) = &estimates[second];
        let shared = shared(evidence.points, a, b);
        let difference =
            apart(&shared, design, (a, of_a), (b, of_b)).map(|(a, b)| a.ahead(b, direction));
        Match { second, shared, difference }
    };
    let matches: Vec<Match<'_>> = seconds.map(matched).collect();
    let ahead = |(point, x, y): &OnPoint<'_>| PointObjectives {
        weight: point.weight,
        method: improvement::ahead(&x.method, &y.method, direction),
        ..(*x).clone()
    };
    let wins = |(point, x, y): &OnPoint<'_>| PointObjectives {
        weight: point.weight,
        method: placements(&x.method, &y.method, direction),
        baseline: vec![1.0; x.baseline.len()],
        draws: x.draws,
    };
    let each = |of: &dyn Fn(&OnPoint<'_>) -> PointObjectives, of_which: &[&Match<'_>]| {
        let objectives = of_which.iter().map(|m| m.shared.iter().map(of).collect());
        let objectives: Vec<Vec<PointObjectives>> = objectives.collect();
        estimated(evidence, a.index, of_which, &objectives)
    };
    let without: Vec<&Match<'_>> = matches.iter().filter(|m| m.difference.is_none()).collect();
    let mut differences = each(&ahead, &without).into_iter();
    let improvements = each(&wins, &matches.iter().collect::<Vec<_>>());
    let share = |(low, high): (f64, f64)| (low.max(0.0), high.min(1.0));
    let pair = |(found, improvement): (&Match<'_>, Option<Estimate>)| {
        let difference = found.difference.clone().or_else(|| differences.next().flatten());
        let (difference, improvement) = difference.zip(improvement)?;
        Some(Pair {
            first,
            second: found.second,
            points: found.shared.len(),
            ahead: Estimated { value: difference.value, interval: difference.interval },
            improvement: Estimated {
                value: improvement.value,
                interval: improvement.interval.map(share),
            },
            dominance: None,
        })
    };
    matches.iter().zip(improvements).filter_map(pair).collect()
}

/// Estimates the mean of objectives of each match; those on the same point MDPs together.
fn estimated(
    evidence: Evidence<'_>,
    index: usize,
    matches: &[&Match<'_>],
    objectives: &[Vec<PointObjectives>],
) -> Vec<Option<Estimate>> {
    let place = |on: &OnPoint<'_>| on.0.index;
    let is_same =
        |a: &&Match<'_>, b: &&Match<'_>| a.shared.iter().map(place).eq(b.shared.iter().map(place));
    let mut rest = objectives;
    let mut found = Vec::with_capacity(matches.len());
    for same in matches.chunk_by(is_same) {
        let own;
        (own, rest) = rest.split_at(same.len());
        let own: Vec<&[PointObjectives]> = own.iter().map(Vec::as_slice).collect();
        let points: Vec<&PointSummary> = same[0].shared.iter().map(|on| on.0).collect();
        found.extend(paired(evidence, index, &points, |estimator, sample, rng| {
            // No method has such scores, which a model could know.
            estimator.estimate_each(Sample { name: "", ..sample }, &own, rng)
        }));
    }
    found.into_iter().map(Result::ok).collect()
}

/// Returns the point MDPs on which both methods have a score over the same seeds.
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

/// Returns the two estimates where their resamples say more than differences do: both methods were trained several times,
/// each on its own, or a model assists, whose mean of differences would be another than the difference of the two means
/// that are shown; and both estimates are over just these point MDPs.
fn apart<'a>(
    shared: &[OnPoint<'_>],
    design: Option<&Design>,
    (a, of_a): (&MethodSummary, &'a Option<Estimate>),
    (b, of_b): (&MethodSummary, &'a Option<Estimate>),
) -> Option<(&'a Estimate, &'a Estimate)> {
    let both = shared.iter().any(|(_, x, y)| x.method.len() > 1 && y.method.len() > 1);
    let both = both || design.is_some();
    let same = [a.points, b.points] == [shared.len(); 2];
    let (of_a, of_b) = of_a.as_ref().zip(of_b.as_ref())?;
    let resampled = !of_a.resamples.is_empty() && of_a.resamples.len() == of_b.resamples.len();
    (both && same && resampled).then_some((of_a, of_b))
}

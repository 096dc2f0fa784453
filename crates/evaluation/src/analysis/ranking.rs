//! Ranks methods, and compares those that lack point MDPs with the others where all have results.
//!
//! What a method lacks may be what is hard, so it is not ranked against methods that have it.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::choice::choice;
use super::evidence::Evidence;
use super::method::{MethodSummary, Summarised, summarise_method};
use super::points::{PointSummary, TaskScore};

/// All methods with results on the point MDPs that every one of them finished.
#[derive(Debug, Clone, PartialEq)]
pub struct OnCommonPoints {
    /// Number of these point MDPs.
    pub points: usize,
    /// One summary per method, best first, over these point MDPs only.
    pub methods: Vec<MethodSummary>,
}

fn scored(points: &[PointSummary], method: usize) -> BTreeSet<usize> {
    let has_score =
        |p: &PointSummary| p.results[method].as_ref().is_some_and(|r| r.score.is_some());
    points.iter().enumerate().filter(|(_, p)| has_score(p)).map(|(i, _)| i).collect()
}

/// Returns the estimates of all methods, best first; those that lack point MDPs come last and without a rank, whatever
/// the others have. Where what scores are divided by lacks one, nobody has a score there, and nobody lacks it for that.
pub(super) fn rank(evidence: Evidence<'_>) -> Vec<Summarised> {
    let points = evidence.points;
    let methods = 0..evidence.identity.methods.len();
    let mut estimates: Vec<Summarised> =
        methods.into_par_iter().map(|index| summarise_method(evidence, index)).collect();
    let ranked = |m: &MethodSummary| {
        m.overall.is_some() && points.iter().all(|point| point.results[m.index].is_some())
    };
    estimates.sort_by(|(a, _), (b, _)| {
        let order = match (a.overall, b.overall) {
            (Some(a), Some(b)) => evidence.identity.direction.compare(a, b),
            (a, b) => b.is_some().cmp(&a.is_some()),
        };
        ranked(b).cmp(&ranked(a)).then(order).then(a.index.cmp(&b.index))
    });
    for (i, (summary, _)) in estimates.iter_mut().enumerate() {
        summary.rank = ranked(summary).then_some(i + 1);
    }
    estimates
}

/// Compares all methods with results where all of them have some; `None` when they are all ranked
/// anyway, or have nothing in common.
pub(super) fn on_common_points(
    evidence: Evidence<'_>,
    estimates: &[Summarised],
) -> Option<OnCommonPoints> {
    let with_results = || estimates.iter().filter(|(m, _)| m.overall.is_some());
    if with_results().all(|(m, _)| m.rank.is_some()) {
        return None;
    }
    let sets = with_results().map(|(m, _)| scored(evidence.points, m.index));
    let shared = sets.reduce(|a, b| &a & &b).filter(|shared| !shared.is_empty())?;
    let points: Vec<PointSummary> = shared.iter().map(|i| evidence.points[*i].clone()).collect();
    let tasks: Vec<TaskScore> =
        evidence.tasks.iter().filter(|r| shared.contains(&r.point)).cloned().collect();
    let chosen = choice(evidence.identity, evidence.design, &points);
    let on_shared = Evidence { points: &points, chosen: &chosen, tasks: &tasks, ..evidence };
    let methods = rank(on_shared).into_iter().map(|(m, _)| m);
    let methods = methods.filter(|m| m.overall.is_some()).collect();
    Some(OnCommonPoints { points: points.len(), methods })
}

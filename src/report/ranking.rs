//! Ranks methods, and compares those that lack point MDPs with the others where all have results.
//!
//! What a method lacks may be what is hard, so it is not ranked against methods that have it.

use std::collections::BTreeSet;

use super::data::{MethodSummary, ScoreRow, Study, summarise_method};
use super::points::PointSummary;
use crate::stats::Bootstrap;

/// A method with what its estimate could have been.
pub(super) type Estimate = (MethodSummary, Option<Bootstrap>);

/// All methods with results on the point MDPs that every one of them finished.
#[derive(Debug, Clone, PartialEq)]
pub struct Common {
    /// Number of these point MDPs.
    pub points: usize,
    /// One summary per method, best first, over these point MDPs only.
    pub methods: Vec<MethodSummary>,
}

/// Returns the point MDPs in a method's estimate, as positions.
fn scored(points: &[PointSummary], method: usize) -> BTreeSet<usize> {
    let has_score =
        |p: &PointSummary| p.results[method].as_ref().is_some_and(|r| r.score.is_some());
    points.iter().enumerate().filter(|(_, p)| has_score(p)).map(|(i, _)| i).collect()
}

/// Returns the estimates of all methods, best first; those that lack point MDPs which another one
/// has come last and without a rank.
pub(super) fn rank(study: Study<'_>) -> Vec<Estimate> {
    let all: Vec<BTreeSet<usize>> =
        (0..study.manifest.identity.methods.len()).map(|m| scored(study.points, m)).collect();
    let mut estimates: Vec<Estimate> =
        (0..all.len()).map(|index| summarise_method(study, index)).collect();
    let others = estimates.iter().filter(|(m, _)| !m.is_reference).map(|(m, _)| &all[m.index]);
    // Of equally many the first, as the manifest has them.
    let most = others.rev().max_by_key(|points| points.len());
    let ranked = |m: &MethodSummary| {
        m.overall.is_some() && (m.is_reference || most.is_none_or(|most| all[m.index] == *most))
    };
    estimates.sort_by(|(a, _), (b, _)| {
        let key = |m: &MethodSummary| m.overall.unwrap_or(f64::INFINITY);
        let order = ranked(b).cmp(&ranked(a)).then(key(a).total_cmp(&key(b)));
        order.then(a.index.cmp(&b.index))
    });
    for (i, (summary, _)) in estimates.iter_mut().enumerate() {
        summary.rank = ranked(summary).then_some(i + 1);
    }
    estimates
}

/// Compares all methods with results where all of them have some; `None` when they are all ranked
/// anyway, or have nothing in common.
pub(super) fn common(study: Study<'_>, estimates: &[Estimate]) -> Option<Common> {
    let with_results = || estimates.iter().filter(|(m, _)| m.overall.is_some());
    if with_results().all(|(m, _)| m.rank.is_some()) {
        return None;
    }
    let sets = with_results().map(|(m, _)| scored(study.points, m.index));
    let shared = sets.reduce(|a, b| &a & &b).filter(|shared| !shared.is_empty())?;
    let points: Vec<PointSummary> = shared.iter().map(|i| study.points[*i].clone()).collect();
    let rows: Vec<ScoreRow> =
        study.rows.iter().filter(|r| shared.contains(&r.point)).cloned().collect();
    let on_shared = Study { points: &points, rows: &rows, ..study };
    let methods = rank(on_shared).into_iter().map(|(m, _)| m);
    let methods = methods.filter(|m| m.overall.is_some()).collect();
    Some(Common { points: points.len(), methods })
}

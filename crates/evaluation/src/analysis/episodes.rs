//! The evaluation episodes of a run, and what those of a method have in common: how far they lie apart, and the shares
//! that the domain measures.

use std::collections::{BTreeMap, HashMap};

use rayon::prelude::*;

use super::measures::Measures;
use super::reference::Reference;
use crate::stats::Direction;
use crate::stats::score::weighted_mean;
use crate::stats::summary::weighted_median;
use crate::store::record::{Metrics, Record};
use crate::store::results::Results;

/// Point MDPs whose episodes are made at once.
const AT_ONCE: usize = 1024;

/// One evaluation episode; there may be millions, so that what is not known of one is no number.
#[derive(Debug, Clone, Copy)]
struct Episode {
    /// Position of the method in the manifest.
    method: u32,
    /// Position of the point MDP among the chosen ones.
    point: u32,
    objective: f64,
    /// Objective relative to the reference's on the same seed.
    relative: f64,
}

/// All evaluation episodes, in the order of the plan.
#[derive(Debug, Clone, Default)]
pub(super) struct Episodes {
    all: Vec<Episode>,
    /// How many shares the domain measures.
    shares: usize,
    /// What the domain measures of every episode, in the order of [`Measures::shares`].
    measured: Vec<f64>,
    /// Where the episodes of each task begin in [`Self::all`]; one more for the end.
    begin: Vec<u32>,
}

impl Episodes {
    /// Returns the positions of a method's episodes.
    pub(super) fn of_method(&self, method: usize) -> Vec<u32> {
        let own = |at: &u32| self.all[*at as usize].method as usize == method;
        (0..self.all.len() as u32).filter(own).collect()
    }

    /// Returns the positions of a task's episodes.
    pub(super) fn of_task(&self, task: usize) -> Vec<u32> {
        (self.begin[task]..self.begin[task + 1]).collect()
    }

    fn share(&self, at: u32, share: usize) -> Option<f64> {
        known(self.measured[at as usize * self.shares + share])
    }
}

/// Returns a number, if it is one.
fn known(value: f64) -> Option<f64> {
    (!value.is_nan()).then_some(value)
}

/// The evaluation episodes of a method or of one of its trainings. Shares and medians weigh point MDPs
/// as the score does and the episodes of a point MDP equally.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EpisodeSummary {
    /// Number of evaluation episodes.
    pub episodes: usize,
    /// Means of what the domain measures, in the order of [`Measures::shares`]; `None` when some episode
    /// does not say.
    pub shares: Vec<Option<f64>>,
    /// Median of the episodes' objectives.
    pub median: Option<f64>,
    /// Worst objective of an episode.
    pub worst: Option<f64>,
    /// Median of the objective relative to the reference's on the same seed.
    pub median_relative: Option<f64>,
    /// Worst objective relative to the reference's on the same seed.
    pub worst_relative: Option<f64>,
}

/// Means of the episodes of a method by seed, on one point MDP.
type BySeed = BTreeMap<u64, Metrics>;

/// Returns the evaluation episodes of all records.
pub(super) fn episodes(
    results: &Results,
    reference: &Reference,
    measures: &dyn Measures,
) -> Episodes {
    let identity = &results.manifest.identity;
    let points: HashMap<&str, usize> =
        identity.points.iter().enumerate().map(|(i, p)| (p.point.as_str(), i)).collect();
    let plan = results.plan();
    // Tasks of one point MDP follow one another.
    let mut parts: Vec<(usize, usize)> = Vec::with_capacity(identity.points.len());
    for (at, task) in plan.iter().enumerate() {
        match parts.last_mut() {
            Some((begin, end)) if plan[*begin].point == task.point => *end = at + 1,
            _ => parts.push((at, at + 1)),
        }
    }
    let shares = measures.shares().len();
    let of_part = |&(begin, end): &(usize, usize)| {
        let point = points.get(&*plan[begin].point).copied().unwrap_or_default();
        let part = Part { results, measures, tasks: begin..end, point };
        part.episodes((&reference.name, &identity.baseline), &identity.objective)
    };
    let mut found = Episodes { shares, begin: vec![0], ..Episodes::default() };
    for parts in parts.chunks(AT_ONCE) {
        for (all, measured, counts) in parts.par_iter().map(of_part).collect::<Vec<_>>() {
            found.all.extend(all);
            found.measured.extend(measured);
            for count in counts {
                found.begin.push(found.begin.last().copied().unwrap_or_default() + count);
            }
        }
    }
    found
}

/// The tasks of one point MDP.
struct Part<'a> {
    results: &'a Results,
    measures: &'a dyn Measures,
    tasks: std::ops::Range<usize>,
    point: usize,
}

impl Part<'_> {
    /// Returns the episodes, what is measured of them, and how many each task has.
    fn episodes(
        &self,
        (reference, baseline): (&str, &str),
        objective: &str,
    ) -> (Vec<Episode>, Vec<f64>, Vec<u32>) {
        let identity = &self.results.manifest.identity;
        let of_reference = self.by_seed(reference);
        let other = (baseline != reference).then(|| self.by_seed(baseline));
        let of_baseline = other.as_ref().unwrap_or(&of_reference);
        let (mut all, mut measured, mut counts) = (Vec::new(), Vec::new(), Vec::new());
        for at in self.tasks.clone() {
            let task = &self.results.plan()[at];
            let method = identity.methods.iter().position(|m| *m == task.method);
            let method = method.expect("a plan follows from its manifest");
            let before = all.len();
            for row in self.results.record(at).into_iter().flat_map(Record::evaluations) {
                let value = row.metrics.get(objective).copied().unwrap_or(f64::NAN);
                let unit = of_reference.get(&row.seed).and_then(|m| m.get(objective));
                let unit = unit.filter(|unit| **unit > 0.0);
                let (method, point) = (method as u32, self.point as u32);
                let relative = unit.map_or(f64::NAN, |unit| value / unit);
                all.push(Episode { method, point, objective: value, relative });
                let shares = self.measures.shares_of(&row.metrics, of_baseline.get(&row.seed));
                measured.extend(shares.into_iter().map(|share| share.unwrap_or(f64::NAN)));
            }
            counts.push((all.len() - before) as u32);
        }
        (all, measured, counts)
    }

    /// Returns the means of a method's evaluation episodes.
    fn by_seed(&self, method: &str) -> BySeed {
        let mut found: BTreeMap<u64, Vec<&Metrics>> = BTreeMap::new();
        for at in self.tasks.clone().filter(|at| *self.results.plan()[*at].method == *method) {
            for row in self.results.record(at).into_iter().flat_map(Record::evaluations) {
                found.entry(row.seed).or_default().push(&row.metrics);
            }
        }
        found.into_iter().map(|(seed, all)| (seed, Metrics::means(all))).collect()
    }
}

impl EpisodeSummary {
    /// Summarises evaluation episodes; point MDPs without a weight do not count.
    ///
    /// # Arguments
    ///
    /// * `own` — positions of episodes.
    /// * `weights` — of point MDPs, by their positions.
    pub(super) fn of(
        episodes: &Episodes,
        own: &[u32],
        weights: &HashMap<usize, f64>,
        direction: Direction,
    ) -> Self {
        let of = |at: &u32| &episodes.all[*at as usize];
        let counted: Vec<u32> = own
            .iter()
            .copied()
            .filter(|at| weights.contains_key(&(of(at).point as usize)))
            .collect();
        let mut per_point: HashMap<u32, f64> = HashMap::new();
        for at in &counted {
            *per_point.entry(of(at).point).or_insert(0.0) += 1.0;
        }
        let weight = |point: u32| weights[&(point as usize)] / per_point[&point];
        let weighted = |value: &dyn Fn(u32) -> Option<f64>| -> Option<Vec<(f64, f64)>> {
            counted.iter().map(|at| Some((weight(of(at).point), value(*at)?))).collect()
        };
        let all = |value: &dyn Fn(u32) -> Option<f64>| weighted(value).unwrap_or_default();
        let worst = |pairs: &[(f64, f64)]| direction.worst(pairs.iter().map(|p| p.1));
        let objectives = all(&|at| known(of(&at).objective));
        let relative = all(&|at| known(of(&at).relative));
        let share = |i: usize| weighted(&|at| episodes.share(at, i)).and_then(weighted_mean);
        Self {
            episodes: counted.len(),
            shares: (0..episodes.shares).map(share).collect(),
            median: weighted_median(objectives.iter().copied()),
            worst: worst(&objectives),
            median_relative: weighted_median(relative.iter().copied()),
            worst_relative: worst(&relative),
        }
    }
}

//! Runs that stop before their budget is spent, tried on a family of which everything is known: how much they save, and
//! how often what they say is wrong.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::engine::Setting;
use super::recorded::{Recorded, StudyError};
use super::{Kind, StudyPlan};
use crate::analysis::estimator::Estimate;
use crate::sample::behind::{Compared, behind};
use crate::sample::looks::looks;
use crate::sample::{Design, Growth, SamplePlan, Sampling, Until};
use crate::stats::improvement::ahead;
use crate::stats::quantile::ALPHA;
use crate::stats::{Direction, PointObjectives};
use basics::seed::derive;

/// What came of many runs that may stop early.
#[derive(Debug, Clone, PartialEq)]
pub struct Stopped {
    /// The estimator.
    pub kind: Kind,
    /// Whether alpha was spent over the looks, as runs do it; otherwise every look has 95% intervals.
    pub is_spent: bool,
    /// Number of runs.
    pub repeats: usize,
    /// Mean number of point MDPs at the end.
    pub points: f64,
    /// Share of runs that stopped before the last look.
    pub early: f64,
    /// Share of runs that had what was asked for at the end.
    pub enough: f64,
    /// Share of intervals at the end that hold the truth: of the overall performance of methods, and where pairs are asked
    /// about of their differences. In the order of what is judged.
    pub coverage: Vec<(String, Option<f64>)>,
    /// Share of runs that call the worse of two methods the better one, in any pair; `None` where no pairs are asked about.
    pub wrong: Option<f64>,
    /// Mean time of the tasks, CPU-hours; `None` where it is not known.
    pub cpu_hours: Option<f64>,
}

/// What is judged: a method or the lead of one on another.
struct Judged {
    name: String,
    /// Positions among the recorded methods.
    of: (usize, Option<usize>),
    truth: f64,
}

/// One run at its end, with what is judged.
struct Run {
    points: usize,
    is_early: bool,
    is_enough: bool,
    intervals: Vec<Option<(f64, f64)>>,
    cost_s: Option<f64>,
}

/// Tries runs that stop early; an entry per estimator, with alpha spent and without.
///
/// # Arguments
///
/// * `plan` — its budgets are the looks; of its estimators those count whose samples can grow.
/// * `done` — called with the number of runs that were finished since the last call, from any thread.
///
/// # Errors
///
/// [`StudyError`] for looks that the family does not allow, and a score that is undefined.
pub fn grow(
    recorded: &Recorded,
    plan: &StudyPlan,
    until: &Until,
    done: &(dyn Fn(usize) + Sync),
) -> Result<Vec<Stopped>, StudyError> {
    let judged = judged(recorded, until);
    let kinds = plan.kinds.iter().filter(|kind| kind.grows());
    let mut all = Vec::new();
    for kind in kinds {
        let setting = Setting::new(recorded, design(recorded, *kind, &judged));
        let runs = (0..plan.repeats).into_par_iter().map(|repeat| {
            let run = run(&setting, plan, until, (*kind, repeat), &judged);
            done(1);
            run
        });
        let runs = runs.collect::<Result<Vec<[Run; 2]>, StudyError>>()?;
        for (which, is_spent) in [true, false].into_iter().enumerate() {
            let own: Vec<&Run> = runs.iter().map(|both| &both[which]).collect();
            all.push(put_together((*kind, is_spent), &judged, &own, until));
        }
    }
    Ok(all)
}

/// Returns what intervals are of.
fn judged(recorded: &Recorded, until: &Until) -> Vec<Judged> {
    let methods = &recorded.methods[..];
    let position = |name: &str| methods.iter().position(|m| m.name == name);
    let one = |m: usize| Judged {
        name: methods[m].name.clone(),
        of: (m, None),
        truth: recorded.truth(&methods[m]),
    };
    let every_pair: Vec<(String, String)>;
    let pairs = match until {
        Until::HalfWidth(_) => return (0..methods.len()).map(one).collect(),
        Until::Decided(pairs) => pairs,
        Until::FirstPlace(methods) => {
            let after = |i: usize| methods.iter().skip(i + 1).map(move |b| (i, b));
            let all = (0..methods.len()).flat_map(after);
            every_pair = all.map(|(i, b)| (methods[i].clone(), b.clone())).collect();
            &every_pair
        }
    };
    let of_pair = |(a, b): &(String, String)| {
        let (a, b) = (position(a)?, position(b)?);
        let [first, second] = [one(a), one(b)];
        let truth = match recorded.direction {
            Direction::Lower => second.truth - first.truth,
            Direction::Higher => first.truth - second.truth,
        };
        let name = format!("{} against {}", first.name, second.name);
        Some(Judged { name, of: (a, Some(b)), truth })
    };
    pairs.iter().filter_map(of_pair).collect()
}

/// Returns what a run knows of the whole family: nothing of the methods that are judged.
fn design(recorded: &Recorded, kind: Kind, judged: &[Judged]) -> Design {
    let modelled = |design: Design| match kind.sampling() {
        Sampling::BayesianQuadrature => design.modelled(),
        _ => design,
    };
    if !kind.is_assisted() {
        return modelled(Design::of(&recorded.family));
    }
    let positions = judged.iter().flat_map(Judged::positions);
    let names: Vec<&str> = positions.map(|m| recorded.methods[m].name.as_str()).collect();
    modelled(recorded.design_for(&names))
}

/// Returns one run, with alpha spent over its looks and without.
fn run(
    setting: &Setting<'_>,
    plan: &StudyPlan,
    until: &Until,
    (kind, repeat): (Kind, usize),
    judged: &[Judged],
) -> Result<[Run; 2], StudyError> {
    let seed = derive(plan.seed, &["study", &repeat.to_string()]);
    let largest = plan.budgets.iter().copied().max().unwrap_or_default();
    let chosen = setting.choose(kind, largest, seed)?;
    let looks = looks(&chosen, &setting.design, &plan.budgets)?;
    let chosen = SamplePlan { growth: Some(Growth { until: until.clone(), looks }), ..chosen };
    let mut ends: [Option<Run>; 2] = [None, None];
    let mut rests = [Rest::default(), Rest::default()];
    let mut samples: Vec<SamplePlan> = Vec::new();
    for k in 0..plan.budgets.len() {
        let Some(sample) = chosen.at_look(k) else { break };
        let estimates = estimates(setting, &sample, judged, plan.resamples, seed)?;
        samples.push(sample);
        let alphas = [samples[k].alpha(), ALPHA];
        for ((end, rest), alpha) in ends.iter_mut().zip(&mut rests).zip(alphas) {
            if end.is_some() {
                continue;
            }
            let own = |(j, e): (usize, &Estimate)| {
                rest.closed.get(&j).copied().unwrap_or_else(|| e.about(alpha))
            };
            let intervals: Vec<Option<(f64, f64)>> =
                estimates.iter().enumerate().map(own).collect();
            let is_last = k + 1 == plan.budgets.len();
            let is_enough = rest.is_enough(until, judged, &intervals);
            if is_enough || is_last {
                let methods: BTreeSet<usize> = judged.iter().flat_map(Judged::positions).collect();
                let until_when = |m: &usize| rest.dropped.get(m).copied().unwrap_or(k);
                let cost_s =
                    methods.iter().map(|m| setting.cost_s(&samples[until_when(m)], *m)).sum();
                let (points, is_early) = (samples[k].draws.len(), !is_last);
                *end = Some(Run { points, is_early, is_enough, intervals, cost_s });
            } else {
                rest.drop(until, judged, &intervals, k);
            }
        }
    }
    Ok(ends.map(|end| end.expect("a run ends at its last look")))
}

/// What a run has settled before its end.
#[derive(Default)]
struct Rest {
    /// Methods that dropped out, each with its last look.
    dropped: BTreeMap<usize, usize>,
    /// The intervals of pairs of which one method has dropped out, as they were then.
    closed: BTreeMap<usize, Option<(f64, f64)>>,
}

impl Rest {
    /// Whether what is asked for is known.
    fn is_enough(&self, until: &Until, judged: &[Judged], all: &[Option<(f64, f64)>]) -> bool {
        match until {
            Until::HalfWidth(most) => {
                all.iter().all(|i| i.is_some_and(|(low, high)| (high - low) / 2.0 <= *most))
            }
            Until::Decided(_) => {
                let compared = judged.iter().zip(all).filter_map(|(j, i)| j.compared(*i));
                compared.map(|pair| pair.ahead).all(|ahead| ahead.is_some())
            }
            Until::FirstPlace(_) => {
                let open = self.compared(judged, all);
                let stay: BTreeSet<usize> = open.iter().flat_map(|pair| pair.methods).collect();
                let wins = |m: &usize| {
                    let mut own = open.iter().filter(|pair| pair.methods.contains(m));
                    own.all(|pair| pair.ahead == Some(*m))
                };
                stay.is_empty() || stay.iter().any(wins)
            }
        }
    }

    /// Returns the pairs of which no method has dropped out.
    fn compared(&self, judged: &[Judged], all: &[Option<(f64, f64)>]) -> Vec<Compared<usize>> {
        let open = judged.iter().zip(all).enumerate().filter(|(j, _)| !self.closed.contains_key(j));
        open.filter_map(|(_, (judged, interval))| judged.compared(*interval)).collect()
    }

    /// Drops methods as a run does after a look, counted from 0.
    fn drop(&mut self, until: &Until, judged: &[Judged], all: &[Option<(f64, f64)>], look: usize) {
        for (m, _) in behind(until, &self.compared(judged, all)) {
            self.dropped.insert(m, look);
            for j in (0..judged.len()).filter(|j| judged[*j].positions().any(|of| of == m)) {
                self.closed.entry(j).or_insert(all[j]);
            }
        }
    }
}

impl Judged {
    /// Returns the two methods, with the one that is ahead by more than chance, if one is; `None` for a single method.
    fn compared(&self, interval: Option<(f64, f64)>) -> Option<Compared<usize>> {
        let methods = [self.of.0, self.of.1?];
        let ahead = match interval {
            Some((low, _)) if low > 0.0 => Some(methods[0]),
            Some((_, high)) if high < 0.0 => Some(methods[1]),
            _ => None,
        };
        Some(Compared { methods, ahead })
    }

    fn positions(&self) -> impl Iterator<Item = usize> {
        std::iter::once(self.of.0).chain(self.of.1)
    }
}

/// Estimates what is judged from a sample, in its order, as a report would.
fn estimates(
    setting: &Setting<'_>,
    sample: &SamplePlan,
    judged: &[Judged],
    resamples: usize,
    seed: u64,
) -> Result<Vec<Estimate>, StudyError> {
    let methods = &setting.recorded.methods[..];
    let direction = setting.recorded.direction;
    // Each score once: a method is in several pairs.
    let mut scores = BTreeMap::new();
    let is_of_scores = |judged: &&Judged| judged.of.1.is_none() || sample.assisted;
    for m in judged.iter().filter(is_of_scores).flat_map(Judged::positions) {
        if let Entry::Vacant(place) = scores.entry(m) {
            let objectives = |row: usize| methods[m].objectives[row].clone();
            let of = (m, methods[m].name.as_str());
            place.insert(setting.estimate(sample, of, &objectives, resamples, seed)?);
        }
    }
    let estimate = |judged: &Judged| match judged.of {
        (m, None) => Ok(scores[&m].clone()),
        (a, Some(b)) if sample.assisted => Ok(scores[&a].ahead(&scores[&b], direction)),
        (a, Some(b)) => {
            let objectives = |row: usize| {
                let (a, b) = (&methods[a].objectives[row], &methods[b].objectives[row]);
                PointObjectives { method: ahead(&a.method, &b.method, direction), ..a.clone() }
            };
            Ok(setting.estimate(sample, (a, ""), &objectives, resamples, seed)?)
        }
    };
    judged.iter().map(estimate).collect()
}

fn put_together(
    (kind, is_spent): (Kind, bool),
    judged: &[Judged],
    runs: &[&Run],
    until: &Until,
) -> Stopped {
    let n = runs.len() as f64;
    let share = |of: &dyn Fn(&Run) -> bool| runs.iter().filter(|run| of(run)).count() as f64 / n;
    let coverage = |k: usize, judged: &Judged| {
        let intervals: Vec<(f64, f64)> = runs.iter().filter_map(|r| r.intervals[k]).collect();
        let holds = |i: &&(f64, f64)| i.0 <= judged.truth && judged.truth <= i.1;
        let held = intervals.iter().filter(holds).count() as f64;
        (!intervals.is_empty()).then(|| held / intervals.len() as f64)
    };
    let is_wrong = |run: &Run| {
        judged.iter().zip(&run.intervals).any(|(j, interval)| match interval {
            Some((low, high)) => (*low > 0.0 && j.truth < 0.0) || (*high < 0.0 && j.truth > 0.0),
            None => false,
        })
    };
    let costs: Option<f64> = runs.iter().map(|run| run.cost_s).sum();
    Stopped {
        kind,
        is_spent,
        repeats: runs.len(),
        points: runs.iter().map(|run| run.points as f64).sum::<f64>() / n,
        early: share(&|run| run.is_early),
        enough: share(&|run| run.is_enough),
        coverage: judged
            .iter()
            .enumerate()
            .map(|(k, j)| (j.name.clone(), coverage(k, j)))
            .collect(),
        wrong: (!matches!(until, Until::HalfWidth(_))).then(|| share(&is_wrong)),
        cpu_hours: costs.map(|s| s / n / 3600.0),
    }
}

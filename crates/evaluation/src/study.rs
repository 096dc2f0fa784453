//! How well estimators do on a family whose every point MDP was evaluated: samples are drawn again and again, and what
//! they say is held against the whole family.
//!
//! Source: Jayawardana et al. (NeurIPS 2022), section "Evaluate DRL methods on a family of MDPs" and appendix.

use std::collections::HashMap;

use clap::ValueEnum;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::analysis::estimator::{Chosen, Estimate, Sample, estimator_of};
use crate::analysis::{Analysis, PointSummary};
use crate::family::{FamilyError, MdpFamily, PointMdp};
use crate::sample::design::{Input, Measure};
use crate::sample::{Design, SampleError, SamplePlan, Sampling, choose_over};
use crate::stats::{Direction, PointObjectives, StatsError};
use basics::seed::derive;

/// Relative difference that is rounding.
const EXACT: f64 = 1e-9;

/// A sampling with its estimator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, ValueEnum)]
pub enum Kind {
    /// M1, with replacement
    M1,
    /// M2, without replacement
    M2,
    /// M3, k-means
    M3,
    /// balanced over the features
    Balanced,
    /// Bayesian quadrature, features
    BqFeatures,
    /// Bayesian quadrature over features and the scores of cheap methods
    Bq,
}

impl Kind {
    /// Returns its name on the command line and in files.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    fn sampling(self) -> Sampling {
        match self {
            Self::M1 => Sampling::WithReplacement,
            Self::M2 => Sampling::WithoutReplacement,
            Self::M3 => Sampling::KMeans,
            Self::Balanced => Sampling::Balanced,
            Self::BqFeatures | Self::Bq => Sampling::BayesianQuadrature,
        }
    }
}

/// What is studied.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyPlan {
    /// Sizes of samples.
    pub budgets: Vec<usize>,
    /// Samples per estimator and budget.
    pub repeats: usize,
    /// Estimators.
    pub kinds: Vec<Kind>,
    /// Seed of the samples.
    pub seed: u64,
    /// Resamples of an interval; 0 leaves intervals out.
    pub resamples: usize,
}

/// What came of many samples: how far the estimates of one estimator, method and budget were off.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// The estimator.
    pub kind: Kind,
    /// Name of the method.
    pub method: String,
    /// Number of point MDPs in a sample.
    pub budget: usize,
    /// Overall performance of the whole family.
    pub truth: f64,
    /// Number of samples.
    pub repeats: usize,
    /// Mean of the estimates.
    pub mean: f64,
    /// Standard deviation of the estimates.
    pub deviation: f64,
    /// Root-mean-square error.
    pub error: f64,
    /// Share of the 95% intervals that hold the truth; `None` without intervals.
    pub coverage: Option<f64>,
    /// Mean half-width of the intervals.
    pub half_width: Option<f64>,
    /// Mean time that the tasks of a sample take, CPU-hours, those of cheap methods on all point MDPs not counted; `None`
    /// where that is not known.
    pub cpu_hours: Option<f64>,
}

/// One estimate, its interval, and the seconds that its tasks took.
type Trial = (f64, Option<(f64, f64)>, Option<f64>);

impl Cell {
    fn of((kind, budget): (Kind, usize), method: &str, truth: f64, trials: &[Trial]) -> Self {
        let n = trials.len() as f64;
        // A sample that is the whole family gives its performance but for rounding.
        let exact = |x: f64| if (x - truth).abs() <= EXACT * truth.abs() { truth } else { x };
        let values: Vec<f64> = trials.iter().map(|t| exact(t.0)).collect();
        let mean = values.iter().sum::<f64>() / n;
        let squares = |from: f64| values.iter().map(|v| (v - from).powi(2)).sum::<f64>() / n;
        let intervals: Vec<(f64, f64)> = trials
            .iter()
            .filter_map(|t| t.1.map(|(low, high)| (exact(low), exact(high))))
            .collect();
        let share = |f: &dyn Fn(&(f64, f64)) -> f64| {
            let sum: f64 = intervals.iter().map(f).sum();
            (!intervals.is_empty()).then(|| sum / intervals.len() as f64)
        };
        let holds = |i: &(f64, f64)| f64::from(u8::from(i.0 <= truth && truth <= i.1));
        let costs: Option<Vec<f64>> = trials.iter().map(|t| t.2).collect();
        Self {
            kind,
            method: method.to_owned(),
            budget,
            truth,
            repeats: trials.len(),
            mean,
            deviation: squares(mean).sqrt(),
            error: squares(truth).sqrt(),
            coverage: share(&holds),
            half_width: share(&|i| (i.1 - i.0) / 2.0),
            cpu_hours: costs.map(|c| c.iter().sum::<f64>() / n / 3600.0),
        }
    }
}

/// Draws samples and estimates from them; a cell per estimator, budget and method, in this order.
///
/// The same plan gives the same cells, whatever the number of threads.
///
/// # Arguments
///
/// * `done` — called with the number of samples that were finished since the last call, from any thread.
///
/// # Errors
///
/// [`StudyError`] for a budget above the size of the family or a score that is undefined.
pub fn study(
    recorded: &Recorded,
    plan: &StudyPlan,
    done: &(dyn Fn(usize) + Sync),
) -> Result<Vec<Cell>, StudyError> {
    // A design with its process serves balanced samples as well.
    let modelled = |design: Design, kind: Kind| match plan.kinds.contains(&kind) {
        true => design.modelled(),
        false => design,
    };
    let plain = Setting::new(recorded, modelled(Design::of(&recorded.family), Kind::BqFeatures));
    // Neither a method nor a near twin of it assists its own estimate.
    let all = recorded.over(&recorded.family);
    let assisted = (recorded.methods.par_iter())
        .map(|m| Setting::new(recorded, modelled(all.without(&[&m.name]), Kind::Bq)));
    let assisted: Vec<Setting<'_>> = assisted.collect();
    let mut cells = Vec::new();
    for kind in &plan.kinds {
        for budget in &plan.budgets {
            let repeats = (0..plan.repeats).into_par_iter();
            let trials = repeats.map(|repeat| {
                let trials = trials(recorded, (&plain, &assisted), plan, (*kind, *budget), repeat);
                done(1);
                trials
            });
            let trials = trials.collect::<Result<Vec<Vec<Trial>>, StudyError>>()?;
            for (k, method) in recorded.methods.iter().enumerate() {
                let own: Vec<Trial> = trials.iter().map(|all| all[k]).collect();
                let truth = recorded.truth(method);
                cells.push(Cell::of((*kind, *budget), &method.name, truth, &own));
            }
        }
    }
    Ok(cells)
}

fn trials(
    recorded: &Recorded,
    (plain, assisted): (&Setting<'_>, &[Setting<'_>]),
    plan: &StudyPlan,
    (kind, budget): (Kind, usize),
    repeat: usize,
) -> Result<Vec<Trial>, StudyError> {
    let seed = derive(plan.seed, &["study", &repeat.to_string()]);
    let mut shared: Option<SamplePlan> = None;
    let mut trials = Vec::with_capacity(recorded.methods.len());
    for (k, method) in recorded.methods.iter().enumerate() {
        let is_assisted = kind == Kind::Bq;
        let setting = if is_assisted { &assisted[k] } else { plain };
        // Only designs that leave a method's own scores out differ between methods.
        let own = is_assisted && !method.learns;
        let chosen = match (&shared, own) {
            (Some(chosen), false) => chosen.clone(),
            _ => choose_over(&recorded.family, &setting.design, kind.sampling(), budget, seed)?,
        };
        let rows: Vec<usize> =
            chosen.draws.iter().filter_map(|d| recorded.family.position(&d.point)).collect();
        let estimate = setting.estimate((&chosen, &rows), (k, method), plan.resamples, seed)?;
        let cost_s = rows.iter().map(|row| method.cost_s[*row]).sum();
        trials.push((estimate.value, estimate.interval, cost_s));
        if !own {
            shared = Some(chosen);
        }
    }
    Ok(trials)
}

/// A design with where its point MDPs lie.
struct Setting<'a> {
    recorded: &'a Recorded,
    design: Design,
    coordinates: Vec<Vec<f64>>,
}

impl<'a> Setting<'a> {
    fn new(recorded: &'a Recorded, design: Design) -> Self {
        let coordinates = design.coordinates();
        Self { recorded, design, coordinates }
    }

    /// Estimates a method from a sample, of which `rows` are the positions in the family.
    fn estimate(
        &self,
        (plan, rows): (&SamplePlan, &[usize]),
        (index, method): (usize, &RecordedMethod),
        resamples: usize,
        seed: u64,
    ) -> Result<Estimate, StatsError> {
        let estimator = estimator_of(plan);
        let family = &self.recorded.family;
        let drawn = || plan.draws.iter().zip(rows);
        let scores: Vec<PointObjectives> = drawn()
            .map(|(draw, row)| PointObjectives {
                weight: draw.weight,
                draws: estimator.draws(draw.count),
                ..method.objectives[*row].clone()
            })
            .collect();
        let points: Vec<Chosen> = drawn()
            .map(|(draw, row)| Chosen {
                count: draw.count,
                inclusion: draw.inclusion,
                importance: family.points[*row].importance,
                row: Some(*row),
                at: self.coordinates[*row].clone(),
            })
            .collect();
        let sample = Sample {
            family_size: family.points.len(),
            chosen: points.len(),
            method: index as u64,
            name: &method.name,
            // The truth is what was recorded, with the luck of its trainings.
            learned_once: false,
            points: &points,
            design: Some(&self.design),
            resamples: plan.resamples(resamples),
            alpha: plan.alpha(),
        };
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        estimator.estimate(sample, &scores, &mut rng)
    }
}

/// How far the importance of the same point MDP may differ.
const TOLERANCE: f64 = 1e-9;

/// A method on every point MDP of a family.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedMethod {
    /// Its name.
    pub name: String,
    /// Whether it learns, so that it is too expensive to run everywhere.
    pub learns: bool,
    /// What was measured, in the order of the family.
    pub objectives: Vec<PointObjectives>,
    /// Its scores, in the order of the family.
    pub scores: Vec<f64>,
    /// Time that its tasks took, seconds, in the order of the family; `None` where that is not known.
    pub cost_s: Vec<Option<f64>>,
}

/// A family with what methods achieved on every point MDP.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// The family.
    pub family: MdpFamily,
    /// Whether lower scores are better.
    pub direction: Direction,
    /// The methods but the one that scores are divided by; those with a score on every point MDP.
    pub methods: Vec<RecordedMethod>,
    /// Methods that lack scores, and on how many point MDPs.
    pub lacking: Vec<(String, usize)>,
    /// What is known everywhere: objective of the baseline and scores of the methods that do not learn.
    pub inputs: Vec<(Input, Vec<f64>)>,
}

/// Why estimators cannot be studied on results.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// Results that do not say what is needed, with the way out.
    #[error("{0}")]
    Results(String),
    /// No family can be made of the point MDPs.
    #[error(transparent)]
    Family(#[from] FamilyError),
    /// A budget that the family does not allow.
    #[error(transparent)]
    Sample(#[from] SampleError),
    /// A score that is none.
    #[error(transparent)]
    Stats(#[from] StatsError),
}

fn refused<T>(reason: String) -> Result<T, StudyError> {
    Err(StudyError::Results(reason))
}

/// Seconds that tasks took, by method and point MDP; `None` where that is not known.
type Costs<'a> = HashMap<(&'a str, &'a str), Option<f64>>;

impl Recorded {
    /// Returns what an analysis of a whole family says.
    ///
    /// # Arguments
    ///
    /// * `dir` — the results directory, for errors.
    ///
    /// # Errors
    ///
    /// [`StudyError`] for results on a sample, and when no method is complete.
    pub fn of(analysis: &Analysis, dir: &str) -> Result<Self, StudyError> {
        let identity = &analysis.manifest.identity;
        let (chosen, size) = (identity.points.len(), identity.sample.family_size);
        if chosen != size {
            return refused(format!(
                "{dir} has {chosen} of the {size} point MDPs of {}: what estimators miss is only known where all were \
                 evaluated; run it with --budget all",
                identity.scenario
            ));
        }
        let total: f64 = identity.points.iter().map(|p| p.importance).sum();
        let point = |p: &crate::store::manifest::PointRow| PointMdp {
            id: p.point.clone(),
            title: p.name().to_owned(),
            features: p.features.clone(),
            importance: p.importance / total,
            instances: p.instances,
        };
        let points = identity.points.iter().map(point).collect();
        let family = MdpFamily::new(&identity.scenario, identity.features.clone(), points, dir)?;
        let mut recorded = Self {
            family,
            direction: identity.direction,
            methods: Vec::new(),
            lacking: Vec::new(),
            inputs: Vec::new(),
        };
        let rows = analysis.points.iter().map(|p| (p.row.point.as_str(), p)).collect();
        let mut costs = Costs::new();
        for task in &analysis.tasks {
            let point = analysis.points[task.point].row.point.as_str();
            let cost =
                costs.entry((identity.methods[task.method].as_str(), point)).or_insert(Some(0.0));
            *cost = cost.zip(task.wall_s).map(|(sum, wall_s)| sum + wall_s);
        }
        for (index, name) in identity.methods.iter().enumerate() {
            recorded.add(analysis, (&rows, &costs), index, name);
        }
        if recorded.methods.is_empty() {
            let lacking = recorded.lacking.iter().map(|(m, n)| format!("{m} lacks {n}"));
            let lacking = lacking.collect::<Vec<_>>().join(", ");
            return refused(format!(
                "{dir}: no method has a score on all {size} point MDPs ({lacking}); finish the run first"
            ));
        }
        Ok(recorded)
    }

    fn add(
        &mut self,
        analysis: &Analysis,
        (rows, costs): (&HashMap<&str, &PointSummary>, &Costs<'_>),
        index: usize,
        name: &str,
    ) {
        let results: Vec<_> = (self.family.points.iter())
            .map(|p| rows.get(p.id.as_str()).and_then(|row| row.results[index].as_ref()))
            .collect();
        if Some(index) == analysis.reference.index {
            let objective: Option<Vec<f64>> =
                results.iter().map(|r| r.map(|r| r.objective)).collect();
            let input = Input { method: name.to_owned(), measure: Measure::Objective };
            self.inputs.extend(objective.map(|values| (input, values)));
            return;
        }
        let scored: Vec<Option<(f64, PointObjectives)>> = results
            .iter()
            .map(|r| r.and_then(|r| Some((r.score?, r.objectives.clone()?))))
            .collect();
        let missing = scored.iter().filter(|s| s.is_none()).count();
        if missing > 0 {
            self.lacking.push((name.to_owned(), missing));
            return;
        }
        let (scores, objectives): (Vec<f64>, Vec<PointObjectives>) =
            scored.into_iter().flatten().unzip();
        let learns = analysis.trainings.iter().any(|t| t.method == name);
        if !learns {
            let input = Input { method: name.to_owned(), measure: Measure::Score };
            self.inputs.push((input, scores.clone()));
        }
        let cost = |id: &str| costs.get(&(name, id)).copied().unwrap_or(Some(0.0));
        let cost_s = self.family.points.iter().map(|p| cost(&p.id)).collect();
        let name = name.to_owned();
        self.methods.push(RecordedMethod { name, learns, objectives, scores, cost_s });
    }

    /// Takes the inputs of other results on the same family, instead of its own.
    ///
    /// # Errors
    ///
    /// [`StudyError`] when point MDPs or their importance differ.
    pub fn assisted_by(&mut self, other: &Self, dir: &str, than: &str) -> Result<(), StudyError> {
        let ours = self.family.points.iter().map(|p| (p.id.as_str(), p.importance));
        other.check_points(ours, (dir, than))?;
        self.inputs = other.inputs.clone();
        Ok(())
    }

    /// Returns what a family and the inputs say.
    ///
    /// # Arguments
    ///
    /// * `dir` — the results directory, for errors.
    ///
    /// # Errors
    ///
    /// [`StudyError`] when point MDPs or their importance differ, and when no method without learning was run everywhere.
    pub fn design(&self, family: &MdpFamily, dir: &str) -> Result<Design, StudyError> {
        let points = family.points.iter().map(|p| (p.id.as_str(), p.importance));
        self.check_points(points, (dir, "the scenario"))?;
        if self.inputs.iter().all(|(input, _)| input.measure == Measure::Objective) {
            return refused(format!(
                "{dir} has no method without learning on all point MDPs; run some, or leave --assist out"
            ));
        }
        Ok(self.over(family))
    }

    fn over(&self, family: &MdpFamily) -> Design {
        let mut design = Design::of(family);
        self.inputs.iter().for_each(|(input, values)| design.add_input(input, values));
        design
    }

    /// Checks that others are the point MDPs of this family.
    fn check_points<'a>(
        &self,
        others: impl ExactSizeIterator<Item = (&'a str, f64)>,
        (dir, than): (&str, &str),
    ) -> Result<(), StudyError> {
        let own = self.family.points.iter();
        let same = |(point, (id, importance)): (&PointMdp, (&str, f64))| {
            point.id == id && (point.importance - importance).abs() <= TOLERANCE
        };
        if own.len() == others.len() && own.zip(others).all(same) {
            return Ok(());
        }
        refused(format!(
            "{dir} has another family than {than}: other point MDPs, or another importance; give results of the same scenario"
        ))
    }

    /// Returns the overall performance of a method.
    pub fn truth(&self, method: &RecordedMethod) -> f64 {
        self.family.points.iter().zip(&method.scores).map(|(p, s)| p.importance * s).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_from_the_truth_and_deviations_from_the_mean() {
        let trial = |value: f64| (value, Some((value - 1.5, value + 1.5)), Some(1800.0));
        let cell = Cell::of((Kind::M1, 2), "m", 1.0, &[trial(2.0), trial(4.0)]);
        assert_eq!((cell.mean, cell.deviation, cell.error), (3.0, 1.0, 5f64.sqrt()));
        assert_eq!((cell.coverage, cell.half_width), (Some(0.5), Some(1.5)));
        assert_eq!(cell.cpu_hours, Some(0.5));
        let cell = Cell::of((Kind::M3, 1), "m", 1.0, &[(1.0, None, None)]);
        assert_eq!((cell.coverage, cell.half_width, cell.cpu_hours), (None, None, None));
    }
}

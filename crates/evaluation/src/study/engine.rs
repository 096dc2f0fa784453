//! Draws samples of a recorded family and estimates from them.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::Kind;
use super::cell::{Cell, Trial};
use super::recorded::{Recorded, RecordedMethod, StudyError};
use crate::analysis::estimator::{Chosen, Estimate, Sample, estimator_of};
use crate::sample::{Design, SampleError, SamplePlan, Sampling, choose_over};
use crate::stats::{PointObjectives, StatsError};
use basics::seed::derive;

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
    let needs = |is_assisted: bool| {
        let is_one = |k: &&Kind| k.is_assisted() == is_assisted;
        let mut kinds = plan.kinds.iter().filter(is_one);
        kinds.any(|k| k.sampling() == Sampling::BayesianQuadrature)
    };
    let modelled = |design: Design, needed: bool| if needed { design.modelled() } else { design };
    let plain = modelled(Design::of(&recorded.family), needs(false));
    let plain = Setting::new(recorded, plain);
    let assisted: Vec<Setting<'_>> = recorded
        .methods
        .par_iter()
        .map(|m| {
            let design = recorded.design_for(&[m.name.as_str()]);
            Setting::new(recorded, modelled(design, needs(true)))
        })
        .collect();
    let mut cells = Vec::new();
    for kind in &plan.kinds {
        for budget in &plan.budgets {
            let repeats = (0..plan.repeats).into_par_iter();
            let trials = repeats.map(|repeat| {
                let trial = trials(recorded, (&plain, &assisted), plan, (*kind, *budget), repeat);
                done(1);
                trial
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

/// A design with where its point MDPs lie.
pub(super) struct Setting<'a> {
    pub(super) recorded: &'a Recorded,
    pub(super) design: Design,
    coordinates: Vec<Vec<f64>>,
}

impl<'a> Setting<'a> {
    pub(super) fn new(recorded: &'a Recorded, design: Design) -> Self {
        let coordinates = design.coordinates();
        Self { recorded, design, coordinates }
    }

    pub(super) fn choose(
        &self,
        kind: Kind,
        budget: usize,
        seed: u64,
    ) -> Result<SamplePlan, SampleError> {
        choose_over(&self.recorded.family, &self.design, kind.sampling(), budget, seed)
    }

    /// Estimates one method from a sample.
    fn trial(
        &self,
        plan: &SamplePlan,
        method: (usize, &RecordedMethod),
        resamples: usize,
        seed: u64,
    ) -> Result<Trial, StatsError> {
        let (index, method) = method;
        let objectives = |row: usize| method.objectives[row].clone();
        let estimate = self.estimate(plan, (index, &method.name), &objectives, resamples, seed)?;
        let cost_s = self.cost_s(plan, index);
        Ok(Trial { value: estimate.value, interval: estimate.interval, cost_s })
    }

    /// Returns the positions of a sample in the family.
    pub(super) fn rows(&self, plan: &SamplePlan) -> Vec<usize> {
        let position = |d: &crate::sample::Draw| self.recorded.family.position(&d.point);
        plan.draws.iter().filter_map(position).collect()
    }

    /// Returns the time that the tasks of a method take on a sample, seconds; `None` where it is not known.
    pub(super) fn cost_s(&self, plan: &SamplePlan, method: usize) -> Option<f64> {
        let cost_s = &self.recorded.methods[method].cost_s;
        self.rows(plan).iter().map(|row| cost_s[*row]).sum()
    }

    /// Estimates from a sample.
    ///
    /// # Arguments
    ///
    /// * `method` — position and name of the method.
    /// * `objectives` — what was measured on a point MDP of the family.
    pub(super) fn estimate(
        &self,
        plan: &SamplePlan,
        (index, name): (usize, &str),
        objectives: &dyn Fn(usize) -> PointObjectives,
        resamples: usize,
        seed: u64,
    ) -> Result<Estimate, StatsError> {
        let estimator = estimator_of(plan);
        let family = &self.recorded.family;
        let rows = self.rows(plan);
        let drawn = || plan.draws.iter().zip(&rows);
        let scores: Vec<PointObjectives> = drawn()
            .map(|(draw, row)| PointObjectives {
                weight: draw.weight,
                draws: estimator.draws(draw.count),
                ..objectives(*row)
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
            name,
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

/// Returns the estimates of all methods from one repeat's samples.
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
        let setting = if kind.is_assisted() { &assisted[k] } else { plain };
        // Only designs that leave a method's own scores out differ between methods.
        let own = kind.is_assisted() && !method.learns;
        let chosen = match (&shared, own) {
            (Some(chosen), false) => chosen.clone(),
            _ => setting.choose(kind, budget, seed)?,
        };
        trials.push(setting.trial(&chosen, (k, method), plan.resamples, seed)?);
        if !own {
            shared = Some(chosen);
        }
    }
    Ok(trials)
}

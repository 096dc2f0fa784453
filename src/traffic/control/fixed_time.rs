//! Tuned fixed-time control: the best cycle that a search in simulation finds.
//!
//! For each point MDP, on training seeds only:
//! 1. One episode with the network's own program counts the vehicles per lane.
//! 2. Every set of phases that serves all movements is tried with Webster's cycle and splits.
//! 3. Nelder-Mead (crate `argmin`) searches the greens of the best set, in their logarithms, and
//!    starts again from the best plan so far with a smaller simplex while simulations are left.
//! 4. The two best cycles and the own program are compared on further training seeds only, so that
//!    a plan is not chosen because it happens to suit one arrival pattern.
//!
//! Choices:
//! - **One plan per signal**; with several signals they are tuned one after the other, the others
//!   keeping their best so far, and offsets are not coordinated. Each has as many simulations as a signal
//!   alone, and what earlier ones left over.
//! - **Greens are whole seconds within the signal's limits**, and so is the cycle.
//! - **The own program** is a candidate where it keeps to the limits; that of an imported network may not.
//!
//! Source: Jayawardana et al. (NeurIPS 2022), section 4, "Fine-tuned Fixed time"; the paper does
//! not say how it was tuned.

mod plan;
mod search;
#[cfg(test)]
mod tests;

use std::cell::RefCell;
use std::collections::BTreeMap;

use argmin::core::Executor;
use argmin::solver::neldermead::NelderMead;

pub use self::plan::Plan;
use self::plan::describe;
use self::search::{Search, SearchState};
use super::phase_sets::covering;
use super::webster::{Constants, greens};
use super::{
    ControlError, Controller, Drive, EpisodeOutcome, GreenPhase, Setup, SignalSpec, Trainer,
};
use crate::run::method::{Method, Training};
use crate::settings::setting::settings;

/// The method.
pub const METHOD: Method = Method {
    name: "fixed-time",
    summary: "fixed time, tuned per point MDP in simulation",
    training: Training::Tuned { episodes: "simulations" },
    default: true,
    decision_s: 0.0,
    color: "#0072b2",
    dash: "",
    settings: Config::SETTINGS,
};

settings! {
    /// The tuned fixed-time controller.
    pub struct Config, source "HCM (6th ed.), chapter 19" {
        /// Simulated episodes that tuning may use, for each signal of the network.
        simulations: u32 = 24, in 1.0..=10_000.0, unit "episodes", source "our choice";
        /// Time lost per phase change in Webster's formula.
        lost_time_s: f64 = 4.0, in 0.0..=30.0, unit "s";
        /// Saturation flow in Webster's formula (HCM base 1900).
        saturation_flow_vph: f64 = 1900.0, in 100.0..=5000.0, unit "veh/h per lane";
    }
}

/// Returns fixed time, not yet tuned.
pub fn create(config: &Config, _setup: &Setup) -> Box<dyn Controller> {
    let Config { simulations, lost_time_s, saturation_flow_vph } = *config;
    Box::new(FixedTime::new(Constants { lost_time_s, saturation_flow_vph }, simulations))
}

/// Seed of the episodes that the search compares plans on.
const SEARCH_SEED: u32 = 0;

/// Further seeds for the final comparison.
const FINAL_SEEDS: [u32; 2] = [1, 2];

/// Plans in the final comparison, the own program included.
const FINALISTS: usize = 3;

/// Largest share of the simulations that goes into trying sets of phases.
const SETS_SHARE: f64 = 0.4;

/// Factors between the corners of the simplex, one start after the other; below 1 the corners lie
/// on the other side.
const SIMPLEX_FACTORS: [f64; 4] = [1.4, 0.8, 1.15, 0.9];

/// Tuned fixed-time control.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedTime {
    constants: Constants,
    simulations: u32,
    signals: Vec<SignalSpec>,
    plans: Vec<Plan>,
    used: u32,
}

impl FixedTime {
    /// Returns a controller that tunes itself with at most `simulations` episodes per signal.
    pub fn new(constants: Constants, simulations: u32) -> Self {
        Self { constants, simulations, signals: Vec::new(), plans: Vec::new(), used: 0 }
    }
}

impl Controller for FixedTime {
    fn name(&self) -> &'static str {
        METHOD.name
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        if self.signals != signals {
            self.signals = signals.to_vec();
            self.plans = vec![Plan::Own; signals.len()];
        }
        Ok(self.plans.iter().map(Plan::drive).collect())
    }

    fn train(&mut self, trainer: &mut dyn Trainer) -> Result<(), ControlError> {
        let first = self.run(trainer, SEARCH_SEED)?;
        // Delay on the search seed with the plans chosen so far.
        let mut delay_s = first.delay_s;
        let all = self.simulations.saturating_mul(self.signals.len() as u32);
        for signal in 0..self.signals.len() {
            // Later signals share what earlier ones left over.
            let left = all.saturating_sub(self.used);
            let budget = left / (self.signals.len() - signal) as u32;
            delay_s = self.tune(trainer, signal, budget, &first.lane_flow_vph[signal], delay_s)?;
        }
        Ok(())
    }

    fn details(&self) -> BTreeMap<String, String> {
        let mut details = BTreeMap::from([("simulations".to_owned(), self.used.to_string())]);
        for (signal, plan) in self.signals.iter().zip(&self.plans) {
            details.insert(format!("plan {}", signal.id), describe(signal, plan));
        }
        details
    }
}

impl FixedTime {
    fn run(
        &mut self,
        trainer: &mut dyn Trainer,
        seed: u32,
    ) -> Result<EpisodeOutcome, ControlError> {
        self.used += 1;
        trainer.episode(self, seed)
    }

    /// Finds the plan of a signal and returns its delay on the search seed.
    fn tune(
        &mut self,
        trainer: &mut dyn Trainer,
        signal: usize,
        budget: u32,
        flow_vph: &[f64],
        own_delay_s: f64,
    ) -> Result<f64, ControlError> {
        let finals = (FINALISTS * FINAL_SEEDS.len()) as u32;
        let search = budget.saturating_sub(finals);
        let spec = self.signals[signal].clone();
        let mut tried: Vec<(f64, Plan)> = Vec::new();
        let most_sets = (f64::from(search) * SETS_SHARE).ceil() as usize;
        for set in covering(&spec).into_iter().take(most_sets) {
            let plan = self.webster(&spec, set, flow_vph);
            let delay = self.try_plan(trainer, signal, &plan, SEARCH_SEED)?;
            tried.push((delay, plan));
        }
        for factor in SIMPLEX_FACTORS {
            tried.sort_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, Plan::Cycle(start))) = tried.first().cloned() else { break };
            let left = search.saturating_sub(tried.len() as u32);
            tried = self.search(trainer, signal, &start, factor, left, tried)?;
        }
        if spec.limits.own_program {
            tried.push((own_delay_s, Plan::Own));
        } else if tried.is_empty() {
            // Nothing can be simulated, and the own program is no choice: Webster's plan as it is.
            let set = covering(&spec).swap_remove(0);
            tried.push((own_delay_s, self.webster(&spec, set, flow_vph)));
        }
        let (delay_s, plan) = self.decide(trainer, signal, tried, budget >= finals)?;
        self.plans[signal] = plan;
        Ok(delay_s)
    }

    /// Returns Webster's plan for a set of phases.
    fn webster(&self, spec: &SignalSpec, set: Vec<usize>, flow_vph: &[f64]) -> Plan {
        let greens = greens(spec, &set, flow_vph, &self.constants);
        Plan::Cycle(set.into_iter().map(GreenPhase).zip(greens).collect())
    }

    fn try_plan(
        &mut self,
        trainer: &mut dyn Trainer,
        signal: usize,
        plan: &Plan,
        seed: u32,
    ) -> Result<f64, ControlError> {
        self.plans[signal] = plan.clone();
        Ok(self.run(trainer, seed)?.delay_s)
    }

    /// Searches the greens of a cycle and returns all plans tried, the earlier ones included.
    fn search(
        &mut self,
        trainer: &mut dyn Trainer,
        signal: usize,
        start: &[(GreenPhase, f64)],
        factor: f64,
        simulations: u32,
        tried: Vec<(f64, Plan)>,
    ) -> Result<Vec<(f64, Plan)>, ControlError> {
        let logs: Vec<f64> = start.iter().map(|(_, green)| green.ln()).collect();
        if (simulations as usize) <= logs.len() {
            return Ok(tried);
        }
        // One corner changes the whole cycle, the others one green each against the rest.
        let step = factor.ln();
        let mut simplex = vec![logs.iter().map(|x| x - step).collect::<Vec<_>>()];
        for i in 0..logs.len() {
            let mut corner = logs.clone();
            corner[i] += step;
            simplex.push(corner);
        }
        let spec = self.signals[signal].clone();
        let mut try_plan = |plan: &Plan| self.try_plan(trainer, signal, plan, SEARCH_SEED);
        let problem = Search {
            spec,
            state: RefCell::new(SearchState {
                try_plan: &mut try_plan,
                phases: start.iter().map(|(phase, _)| phase.0).collect(),
                left: simulations,
                tried,
                failure: None,
            }),
        };
        let result = Executor::new(&problem, NelderMead::new(simplex))
            .configure(|state| state.max_iters(u64::from(simulations)))
            .run()
            .map(drop)
            .map_err(|e| e.to_string());
        let SearchState { tried, failure, .. } = problem.state.into_inner();
        match (failure, result) {
            (Some(e), _) => Err(e),
            (None, Err(e)) => Err(ControlError::Search(e)),
            (None, Ok(())) => Ok(tried),
        }
    }

    /// Compares the best cycles, and the own program where it is a choice, on further seeds and returns
    /// the winner with its delay on the search seed; without further seeds that delay decides.
    fn decide(
        &mut self,
        trainer: &mut dyn Trainer,
        signal: usize,
        tried: Vec<(f64, Plan)>,
        with_finals: bool,
    ) -> Result<(f64, Plan), ControlError> {
        let (own, mut cycles): (Vec<_>, Vec<_>) =
            tried.into_iter().partition(|(_, plan)| *plan == Plan::Own);
        cycles.sort_by(|a, b| a.0.total_cmp(&b.0));
        cycles.truncate(FINALISTS - 1);
        let mut best: Option<(f64, (f64, Plan))> = None;
        for (search_delay_s, plan) in own.into_iter().chain(cycles) {
            let mut total_s = search_delay_s;
            if with_finals {
                total_s = 0.0;
                for seed in FINAL_SEEDS {
                    total_s += self.try_plan(trainer, signal, &plan, seed)?;
                }
            }
            if best.as_ref().is_none_or(|(least, _)| total_s < *least) {
                best = Some((total_s, (search_delay_s, plan)));
            }
        }
        Ok(best.expect("there is at least one plan").1)
    }
}

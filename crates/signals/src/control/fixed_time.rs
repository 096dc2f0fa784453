//! Tuned fixed-time control: the best cycle that a search in simulation finds.
//!
//! For each point MDP, on training seeds only:
//! 1. One episode with the network's own program counts the vehicles per lane.
//! 2. Every set of phases that serves all movements is tried with Webster's cycle and splits.
//! 3. The greens of the best set are [searched](evaluation::run::search).
//! 4. The two best cycles and the own program are compared on further training seeds only, so that
//!    a plan is not chosen because it happens to suit one arrival pattern.
//!
//! Several signals are tuned together, with a budget that grows with the root of their number:
//! 1. Webster's plans of all signals are tried at once, set of phases by set of phases.
//! 2. From the best network so far, one signal after the other searches its plan, those with most vehicles first, each
//!    with an equal share of what is left but enough to turn its simplex once.
//! 3. The start, the best network of step 1 and that of step 2 are compared on further training seeds.
//!
//! Choices:
//! - **One plan per signal**; offsets are not coordinated, see [`super::coordinated`].
//! - **Greens are whole seconds within the signal's limits**, and so is the cycle.
//! - **The own program** is a candidate where it keeps to the limits; that of an imported network may not.
//!   Tuning then starts from Webster's plan for the first set of phases.
//! - **Whether tuning improved on its start** is known of every record: the start is what details name as the
//!   network's own program, or what they say under `tuning`.
//!
//! Source: Jayawardana et al. (NeurIPS 2022), section 4, "Fine-tuned Fixed time"; the paper does
//! not say how it was tuned.

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use super::phase_sets::covering;
use super::webster::{Constants, greens, within};
use super::{
    ControlError, Controller, Drive, EpisodeOutcome, GreenPhase, Setup, SignalSpec, Trainer,
};
use evaluation::run::method::{Method, Training};
use evaluation::run::search::{FINALS, SEARCH_SEED, decide, search};
use evaluation::settings::setting::settings;

/// The method.
pub const METHOD: Method = Method {
    summary: "fixed time, tuned per point MDP in simulation",
    default: true,
    settings: Config::SETTINGS,
    ..Method::built_in(
        "fixed-time",
        Training::Tuned { episodes: "fixed_time.simulations" },
        "#0072b2",
    )
};

settings! {
    /// The tuned fixed-time controller.
    pub struct Config, source "HCM (6th ed.), chapter 19" {
        /// Simulated episodes that tuning may use for one signal; for n signals, √n times as many.
        /// Fewer than 8 would evaluate no plan.
        simulations: u32 = 24, in 8.0..=10_000.0, unit "episodes", source "our choice";
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

/// What is said of a plan that is the network's own.
pub const OWN: &str = "the network's own program";

/// Start of the names of details that are plans; the signal follows.
pub const PLAN: &str = "plan ";

/// Start of the names of details that are settings which tuning has chosen; the setting follows.
pub const SETTING: &str = "setting ";

/// Name of the detail that counts the episodes of tuning.
pub(crate) const SIMULATIONS: &str = "simulations";

/// Name of the detail that says what became of tuning, and what it then says.
pub(crate) const TUNING: &str = "tuning";
pub(crate) const KEPT: &str = "kept the plans that it started from";

/// Returns whether tuning kept the plans that it started from, by the details of its record; `None` where nothing was
/// tuned.
pub fn kept_start(details: &BTreeMap<String, String>) -> Option<bool> {
    details.get(SIMULATIONS)?;
    let mut plans = details
        .iter()
        .filter(|(name, _)| name.starts_with(PLAN) || name.starts_with(SETTING))
        .peekable();
    plans.peek()?;
    let says = details.get(TUNING).is_some_and(|text| text == KEPT);
    Some(says || plans.all(|(_, text)| text == OWN))
}

/// Returns a plan in words, with its cycle and the greens of its phases.
fn describe(signal: &SignalSpec, plan: &Drive) -> String {
    let Drive::Cycle(greens) = plan else { return OWN.to_owned() };
    let phases: Vec<usize> = greens.iter().map(|(phase, _)| phase.0).collect();
    let cycle_s = greens.iter().map(|(_, g)| g).sum::<f64>() + signal.limits.lost_s(&phases);
    let greens: Vec<_> = greens
        .iter()
        .map(|(phase, green)| format!("{} {green} s", signal.phases[phase.0].state))
        .collect();
    format!("cycle {cycle_s} s: {}", greens.join(", "))
}

/// Largest share of the simulations that goes into trying sets of phases.
const SETS_SHARE: f64 = 0.4;

/// Episodes that a signal has at least, beyond one for each of its greens: for a corner more and a step of the search.
const LEAST_BEYOND_GREENS: u32 = 3;

/// Returns the most episodes that tuning uses in a network of so many signals.
///
/// The root keeps tuning of a large network affordable: 43 signals have 158 episodes and not 1,032. Signals with much
/// traffic are tuned first, and the final comparison is one of the whole network.
pub fn budget(simulations: u32, signals: u32) -> u32 {
    (f64::from(simulations) * f64::from(signals).sqrt()).ceil() as u32
}

/// Tuned fixed-time control.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedTime {
    constants: Constants,
    simulations: u32,
    signals: Vec<SignalSpec>,
    plans: Vec<Drive>,
    used: u32,
    /// Whether the plans are those that tuning started from.
    kept_start: bool,
}

impl FixedTime {
    /// Returns a controller that tunes itself with at most `simulations` episodes for one signal, and [`budget`] for
    /// several.
    pub fn new(constants: Constants, simulations: u32) -> Self {
        let (signals, plans) = (Vec::new(), Vec::new());
        Self { constants, simulations, signals, plans, used: 0, kept_start: false }
    }
}

impl Controller for FixedTime {
    fn name(&self) -> &'static str {
        METHOD.name
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        if self.signals != signals {
            self.signals = signals.to_vec();
            self.plans = vec![Drive::OwnProgram; signals.len()];
        }
        Ok(self.plans.clone())
    }

    fn train(&mut self, trainer: &mut dyn Trainer) -> Result<(), ControlError> {
        self.used = 1;
        let first = trainer.episode(self, SEARCH_SEED)?;
        let flow_vph = &first.lane_flow_vph;
        let start: Vec<Drive> = (self.signals.iter().zip(flow_vph))
            .map(|(spec, flow_vph)| self.start(spec, flow_vph))
            .collect();
        match flow_vph.as_slice() {
            [flow_vph] => {
                let left = self.simulations.saturating_sub(self.used);
                self.tune(trainer, left, flow_vph, first.delay_s)?;
            }
            _ => self.tune_network(trainer, &start, &first)?,
        }
        self.kept_start = self.plans == start;
        Ok(())
    }

    fn details(&self) -> BTreeMap<String, String> {
        let mut details = BTreeMap::from([(SIMULATIONS.to_owned(), self.used.to_string())]);
        // Where all run their own programs the plans say so.
        if self.kept_start && self.plans.iter().any(|plan| *plan != Drive::OwnProgram) {
            details.insert(TUNING.to_owned(), KEPT.to_owned());
        }
        for (signal, plan) in self.signals.iter().zip(&self.plans) {
            details.insert(format!("{PLAN}{}", signal.id), describe(signal, plan));
        }
        details
    }
}

impl FixedTime {
    fn start(&self, spec: &SignalSpec, flow_vph: &[f64]) -> Drive {
        match spec.limits.own_program {
            true => Drive::OwnProgram,
            false => self.webster(spec, covering(spec).swap_remove(0), flow_vph),
        }
    }

    /// Finds the plan of the only signal.
    fn tune(
        &mut self,
        trainer: &mut dyn Trainer,
        budget: u32,
        flow_vph: &[f64],
        own_delay_s: f64,
    ) -> Result<(), ControlError> {
        let search = budget.saturating_sub(FINALS);
        let spec = self.signals[0].clone();
        let most_sets = (f64::from(search) * SETS_SHARE).ceil() as usize;
        let sets = covering(&spec).into_iter().take(most_sets);
        let plans = sets.map(|set| self.webster(&spec, set, flow_vph)).collect();
        let mut tried = self.explore(trainer, 0, Vec::new(), plans, search)?;
        if spec.limits.own_program {
            tried.push((own_delay_s, Drive::OwnProgram));
        } else if tried.is_empty() {
            // Nothing can be simulated, and the own program is no choice: Webster's plan as it is.
            tried.push((own_delay_s, self.start(&spec, flow_vph)));
        }
        let plan = decide(tried, &Drive::OwnProgram, budget >= FINALS, &mut |plan, seed| {
            self.try_network(trainer, std::slice::from_ref(plan), seed)
        })?;
        self.plans = vec![plan];
        Ok(())
    }

    fn webster(&self, spec: &SignalSpec, set: Vec<usize>, flow_vph: &[f64]) -> Drive {
        let greens = greens(spec, &set, flow_vph, &self.constants);
        Drive::Cycle(set.into_iter().map(GreenPhase).zip(greens).collect())
    }

    /// Tries plans of one signal, searches on from the best cycle with at most so many episodes, and returns all that were
    /// tried, the best first.
    fn explore(
        &mut self,
        trainer: &mut dyn Trainer,
        signal: usize,
        mut tried: Vec<(f64, Drive)>,
        plans: Vec<Drive>,
        budget: u32,
    ) -> Result<Vec<(f64, Drive)>, ControlError> {
        let spec = self.signals[signal].clone();
        let logs = |plan: &Drive| match plan {
            Drive::Cycle(greens) => Some(greens.iter().map(|(_, green)| green.ln()).collect()),
            _ => None,
        };
        let with = |plan: &Drive, logs: &[f64]| {
            let Drive::Cycle(greens) = plan else { return plan.clone() };
            let phases: Vec<usize> = greens.iter().map(|(phase, _)| phase.0).collect();
            let greens: Vec<f64> = logs.iter().map(|x| x.exp()).collect();
            let greens = within(&spec, &phases, &greens);
            Drive::Cycle(phases.into_iter().map(GreenPhase).zip(greens).collect())
        };
        search(&mut tried, (plans, budget), Some((&logs, &with)), &mut |plan| {
            let mut network = self.plans.clone();
            network[signal] = plan.clone();
            self.try_network(trainer, &network, SEARCH_SEED)
        })?;
        Ok(tried)
    }

    /// Finds the plans of several signals.
    /// * `first` — of the episode with the signals' own programs.
    fn tune_network(
        &mut self,
        trainer: &mut dyn Trainer,
        start: &[Drive],
        first: &EpisodeOutcome,
    ) -> Result<(), ControlError> {
        let flow_vph = &first.lane_flow_vph;
        let most = budget(self.simulations, self.signals.len() as u32).saturating_sub(FINALS);
        let start_s = match start.iter().all(|plan| *plan == Drive::OwnProgram) {
            true => first.delay_s,
            false => self.try_network(trainer, start, SEARCH_SEED)?,
        };
        let mut tried = vec![(start_s, start.to_vec())];
        let most_sets =
            (f64::from(self.simulations.saturating_sub(FINALS + 1)) * SETS_SHARE).ceil();
        let joint = self.joint(flow_vph, most_sets as usize);
        let joint = (joint, most.saturating_sub(self.used));
        search(&mut tried, joint, None, &mut |network: &Vec<Drive>| {
            self.try_network(trainer, network, SEARCH_SEED)
        })?;
        let (mut best_s, joint) = tried.swap_remove(0);
        self.plans.clone_from(&joint);
        let busiest = first.busiest();
        for (done, signal) in busiest.iter().enumerate() {
            let left = most.saturating_sub(self.used);
            let share = left / (busiest.len() - done) as u32;
            best_s = self.tune_one(trainer, *signal, (share, left), &flow_vph[*signal], best_s)?;
        }
        let finalists = [start.to_vec(), joint, self.plans.clone()];
        let is_open = finalists.iter().any(|network| network != start);
        let finalists = finalists.into_iter().map(|network| (0.0, network)).collect();
        self.plans = decide(finalists, &start.to_vec(), is_open, &mut |plans, seed| {
            self.try_network(trainer, plans, seed)
        })?;
        Ok(())
    }

    /// Returns networks in which every signal has Webster's plan for its first set of phases, for its second and so on;
    /// one with fewer sets keeps its last.
    fn joint(&self, flow_vph: &[Vec<f64>], most: usize) -> Vec<Vec<Drive>> {
        let sets: Vec<Vec<Vec<usize>>> = self.signals.iter().map(covering).collect();
        let rounds = sets.iter().map(Vec::len).max().unwrap_or(0).min(most);
        let plan = |signal: usize, round: usize| {
            let set = &sets[signal][round.min(sets[signal].len() - 1)];
            self.webster(&self.signals[signal], set.clone(), &flow_vph[signal])
        };
        (0..rounds).map(|round| (0..sets.len()).map(|s| plan(s, round)).collect()).collect()
    }

    /// Finds the plan of one signal while the others keep theirs, and returns the network's delay on the search seed.
    fn tune_one(
        &mut self,
        trainer: &mut dyn Trainer,
        signal: usize,
        (share, left): (u32, u32),
        flow_vph: &[f64],
        best_s: f64,
    ) -> Result<f64, ControlError> {
        let spec = self.signals[signal].clone();
        let sets = covering(&spec);
        let least = sets[0].len() as u32 + LEAST_BEYOND_GREENS;
        let share = share.max(least).min(left);
        let most_sets = (f64::from(share) * SETS_SHARE).ceil() as usize;
        let own = spec.limits.own_program.then_some(Drive::OwnProgram);
        let webster = sets.into_iter().map(|set| self.webster(&spec, set, flow_vph));
        let plans = own.into_iter().chain(webster).take(most_sets).collect();
        let start = vec![(best_s, self.plans[signal].clone())];
        let mut tried = self.explore(trainer, signal, start, plans, share)?;
        let (delay_s, plan) = tried.swap_remove(0);
        self.plans[signal] = plan;
        Ok(delay_s)
    }

    fn try_network(
        &mut self,
        trainer: &mut dyn Trainer,
        plans: &[Drive],
        seed: u32,
    ) -> Result<f64, ControlError> {
        self.plans = plans.to_vec();
        self.used += 1;
        trainer.episode(self, seed).map(|played| played.delay_s)
    }
}

//! Coordinated fixed-time control: a common cycle, splits and offsets for the signals of a street.
//!
//! For each network, on training seeds only:
//! 1. One episode with the network's own programs counts the vehicles per lane.
//! 2. **Splits**: for a common cycle, every signal shares its green by Webster's flow ratios, within its limits. Cycles are
//!    the longest of Webster's cycles of the signals, and those near it with the best bands.
//! 3. **Offsets**: those for which the green bands of all streets in both directions are widest, each weighted by its
//!    vehicles (`bands.rs`). Nothing is simulated for that.
//! 4. **Search in simulation** from the best of these plans: offsets of one signal and of all behind it, splits, and the
//!    cycle move by a step, which is halved when no move is better.
//! 5. The own programs, the best plan of step 3 and that of step 4 are compared on further training seeds.
//!
//! Choices:
//! - **A method beside `fixed-time`**, not what `fixed-time` does with several signals: a common cycle is a constraint, and
//!   where signals are far apart or unequal a cycle of its own for each is better. Both are in the ranking, so that a run
//!   shows what coordination is worth. Records of `fixed-time` stay what they were.
//! - **Every source of randomness has its own seed**: the vehicles of training episodes, those of the final comparison, and
//!   those of evaluation. The search itself draws nothing.
//! - **The order of phases** is that of the network's program; lead and lag do not change.
//! - **All signals have the whole cycle**; none runs half of it.
//! - **One signal, or signals that lead to no other**, is an error: there is nothing to coordinate.
//!
//! Source: J. D. C. Little, M. D. Kelson and N. H. Gartner, "MAXBAND: a program for setting signals on arteries and
//! triangular networks", Transportation Research Record 795 (1981); weights by volume: N. H. Gartner et al., "A multi-band
//! approach to arterial traffic signal optimization", Transportation Research Part B 25 (1991); "Signal Timing
//! Manual" (2nd ed., NCHRP Report 812), chapter 7. Deviation: offsets are whole seconds found by coordinate ascent, not
//! by integer programming.

mod bands;

use std::collections::BTreeMap;

use self::bands::{Timed, ascend, efficiency, weights};
use super::dual_ring::{self, StageCycle};
use super::fixed_time::{KEPT, OWN, PLAN, SIMULATIONS, TUNING, budget};
use super::phase_sets::covering;
use super::streets::{Street, streets};
use super::webster::{Constants, greens, split};
use super::{
    ControlError, Controller, Drive, EpisodeOutcome, GreenPhase, Light, Setup, SignalSpec, Trainer,
};
use evaluation::run::method::{Method, Training};
use evaluation::settings::setting::settings;

/// The method.
pub const METHOD: Method = Method {
    summary: "fixed time with a common cycle and offsets, tuned in simulation",
    settings: Config::SETTINGS,
    ..Method::built_in("coordinated", Training::Tuned { episodes: "simulations" }, "#96b487")
};

settings! {
    /// The coordinated fixed-time controller.
    pub struct Config, source "HCM (6th ed.), chapter 19" {
        /// Simulated episodes that tuning may use for one signal; for n signals, √n times as many.
        simulations: u32 = 24, in 8.0..=10_000.0, unit "episodes", source "our choice";
        /// Time lost per phase change in Webster's formula.
        lost_time_s: f64 = 4.0, in 0.0..=30.0, unit "s";
        /// Saturation flow in Webster's formula (HCM base 1900).
        saturation_flow_vph: f64 = 1900.0, in 100.0..=5000.0, unit "veh/h per lane";
    }
}

/// Returns coordinated fixed time, not yet tuned.
pub fn create(config: &Config, _setup: &Setup) -> Box<dyn Controller> {
    let Config { simulations, lost_time_s, saturation_flow_vph } = *config;
    let constants = Constants { lost_time_s, saturation_flow_vph };
    Box::new(Coordinated::new(METHOD.name, constants, simulations, None))
}

/// Seed of the episodes that the search compares plans on.
const SEARCH_SEED: u32 = 0;

/// Further seeds for the final comparison.
const FINAL_SEEDS: [u32; 2] = [1, 2];

/// Plans in the final comparison.
const FINALISTS: usize = 3;

/// Largest share of the simulations that goes into cycles and sets of phases.
const STARTS_SHARE: f64 = 0.4;

/// Shortest and longest common cycle that is tried, in parts of the longest of Webster's cycles.
const CYCLES: [f64; 2] = [0.75, 1.5];

/// Common cycles that are tried for a set of phases: Webster's, and those with the best bands.
const CYCLES_PER_SET: usize = 3;

/// Step between common cycles, seconds.
const CYCLE_STEP_S: u32 = 5;

/// First step of the search in offsets, in parts of the cycle.
const FIRST_STEP: f64 = 0.125;

/// Least step of the search, seconds.
const LAST_STEP_S: f64 = 1.0;

/// Longest step of splits and cycle, seconds.
const LONGEST_SPLIT_STEP_S: f64 = 6.0;

/// The plans of all signals.
#[derive(Debug, Clone, PartialEq)]
enum Plans {
    /// The network's own programs.
    Own,
    /// Cycles of the same length; `None` where a signal has nothing to decide.
    Common(Vec<Option<Timed>>),
}

/// Coordinated control: of fixed cycles, or of rings within the cycle.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Coordinated {
    method: &'static str,
    constants: Constants,
    simulations: u32,
    /// How two rings run the plans; `None` for fixed cycles.
    rings: Option<dual_ring::Config>,
    signals: Vec<SignalSpec>,
    streets: Vec<Street>,
    /// Vehicles per hour of each street.
    weights: Vec<f64>,
    plans: Plans,
    used: u32,
    kept_start: bool,
}

impl Controller for Coordinated {
    fn name(&self) -> &'static str {
        self.method
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        if self.signals != signals {
            self.signals = signals.to_vec();
            self.streets = streets(signals);
            self.weights = vec![1.0; self.streets.len()];
            self.plans = Plans::Own;
        }
        if self.streets.is_empty() {
            let signal = signals.first().map_or_else(String::new, |signal| signal.id.clone());
            let alone = if self.rings.is_some() { "nema" } else { "fixed-time" };
            let reason = format!(
                "no vehicle that goes straight on comes from one signal to another, so there is nothing to coordinate; run \
                 {alone}"
            );
            return Err(ControlError::Signal { method: self.method, signal, reason });
        }
        Ok(match &self.plans {
            Plans::Own => vec![Drive::OwnProgram; signals.len()],
            Plans::Common(plans) => {
                plans.iter().enumerate().map(|(i, plan)| self.drive(i, plan.as_ref())).collect()
            }
        })
    }

    fn train(&mut self, trainer: &mut dyn Trainer) -> Result<(), ControlError> {
        let first = self.run(trainer, SEARCH_SEED)?;
        let flow_vph = &first.lane_flow_vph;
        self.weights = weights(&self.signals, &self.streets, flow_vph);
        let finals = (FINALISTS * FINAL_SEEDS.len()) as u32;
        let most = budget(self.simulations, self.signals.len() as u32).saturating_sub(finals);
        let starts = self.starts(flow_vph);
        let share = (f64::from(most) * STARTS_SHARE).ceil() as usize;
        let mut tried: Vec<(f64, Vec<Option<Timed>>)> = Vec::new();
        for plans in starts.into_iter().take(share.max(1)) {
            let delay_s = self.attempt(trainer, &Plans::Common(plans.clone()), SEARCH_SEED)?;
            tried.push((delay_s, plans));
        }
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut finalists = Vec::new();
        // An imported program may not keep to the limits, and no two rings run it; then the first plan is what tuning starts
        // from.
        if self.rings.is_none() && self.signals.iter().all(|spec| spec.limits.own_program) {
            finalists.push(Plans::Own);
        }
        if let Some((delay_s, start)) = tried.into_iter().next() {
            let found = self.search(trainer, start.clone(), delay_s, most)?;
            for plans in [start, found] {
                let plans = Plans::Common(plans);
                if !finalists.contains(&plans) {
                    finalists.push(plans);
                }
            }
        }
        if finalists.is_empty() {
            let signal = self.signals[0].id.clone();
            let reason = "no cycle fits the limits of all signals; change the limits of [signal]";
            return Err(ControlError::Signal {
                method: self.method,
                signal,
                reason: reason.into(),
            });
        }
        self.plans = self.decide(trainer, &finalists)?;
        self.kept_start = self.plans == finalists[0];
        Ok(())
    }

    fn details(&self) -> BTreeMap<String, String> {
        let mut details = BTreeMap::from([(SIMULATIONS.to_owned(), self.used.to_string())]);
        if self.kept_start && self.plans != Plans::Own {
            details.insert(TUNING.to_owned(), KEPT.to_owned());
        }
        for (i, signal) in self.signals.iter().enumerate() {
            let plan = match &self.plans {
                Plans::Common(plans) => plans[i].as_ref(),
                Plans::Own => None,
            };
            let text = plan.map_or_else(|| OWN.to_owned(), |plan| plan.describe(signal));
            details.insert(format!("{PLAN}{}", signal.id), text);
        }
        details
    }
}

/// What the search in simulation moves.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Move {
    /// The offset of a signal.
    Offset(usize),
    /// The offsets of a street's signals from a stop on.
    Behind(usize, usize),
    /// Green of a signal from one phase of its cycle to the next.
    Split(usize, usize),
    /// The common cycle.
    Cycle,
}

impl Coordinated {
    /// Returns coordinated control, not yet tuned.
    ///
    /// # Arguments
    ///
    /// * `rings` — how two rings run the plans; `None` for fixed cycles.
    pub(super) fn new(
        method: &'static str,
        constants: Constants,
        simulations: u32,
        rings: Option<dual_ring::Config>,
    ) -> Self {
        Self {
            method,
            constants,
            simulations,
            rings,
            signals: Vec::new(),
            streets: Vec::new(),
            weights: Vec::new(),
            plans: Plans::Own,
            used: 0,
            kept_start: false,
        }
    }

    /// Returns what drives a signal.
    fn drive(&self, signal: usize, plan: Option<&Timed>) -> Drive {
        let Some(plan) = plan else { return Drive::OwnProgram };
        let phases = plan.phases.iter().copied().map(GreenPhase);
        let greens = phases.zip(plan.greens_s.iter().copied()).collect();
        match &self.rings {
            None => Drive::Coordinated(greens, f64::from(plan.offset_s)),
            Some(rings) => {
                let coordinated = self.coordinated_stage(signal, plan);
                let cycle = StageCycle { greens, offset_s: plan.offset_s, coordinated };
                Drive::CoordinatedRings(rings.clone(), cycle)
            }
        }
    }

    /// Returns the stage of a plan in which the busiest street at a signal is green, the longest of several; without a street,
    /// the longest of all.
    fn coordinated_stage(&self, signal: usize, plan: &Timed) -> usize {
        let stops = self.streets.iter().zip(&self.weights).flat_map(|(street, weight)| {
            let here = street.stops.iter().filter(|stop| stop.signal == signal);
            here.map(move |stop| (*weight, stop.movement))
        });
        let busiest = stops.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, movement)| movement);
        let serves = |stage: &usize| {
            let phase = &self.signals[signal].phases[plan.phases[*stage]];
            busiest.is_none_or(|movement| phase.service[movement] != Light::Red)
        };
        let longest = |a: &usize, b: &usize| plan.greens_s[*a].total_cmp(&plan.greens_s[*b]);
        (0..plan.phases.len()).rev().filter(serves).max_by(longest).unwrap_or_default()
    }

    fn run(
        &mut self,
        trainer: &mut dyn Trainer,
        seed: u32,
    ) -> Result<EpisodeOutcome, ControlError> {
        self.used += 1;
        trainer.episode(self, seed)
    }

    fn attempt(
        &mut self,
        trainer: &mut dyn Trainer,
        plans: &Plans,
        seed: u32,
    ) -> Result<f64, ControlError> {
        self.plans = plans.clone();
        Ok(self.run(trainer, seed)?.delay_s)
    }

    /// Returns the plans that are tried first, the most promising ones first: for each set of phases Webster's common
    /// cycle, and those near it with the best bands.
    fn starts(&self, flow_vph: &[Vec<f64>]) -> Vec<Vec<Option<Timed>>> {
        let streets = (self.streets.as_slice(), self.weights.as_slice());
        let sets: Vec<Vec<Vec<usize>>> = self.signals.iter().map(covering).collect();
        let rounds = sets.iter().map(Vec::len).max().unwrap_or(0);
        let mut by_rank: Vec<Vec<Vec<Option<Timed>>>> = vec![Vec::new(); CYCLES_PER_SET];
        for round in 0..rounds {
            let chosen: Vec<&Vec<usize>> =
                sets.iter().map(|sets| &sets[round.min(sets.len() - 1)]).collect();
            let natural_s = (self.signals.iter().zip(&chosen).zip(flow_vph))
                .filter(|((spec, _), _)| decides(spec))
                .map(|((spec, set), flow_vph)| {
                    let greens = greens(spec, set, flow_vph, &self.constants);
                    greens.iter().sum::<f64>() + spec.limits.lost_s(set)
                })
                .fold(0.0, f64::max);
            let whole = natural_s.round() as u32;
            let [low, high] = CYCLES.map(|part| (natural_s * part).round() as u32);
            let mut cycles: Vec<u32> = (low..=high).step_by(CYCLE_STEP_S as usize).collect();
            cycles.insert(0, whole);
            let mut plans: Vec<(f64, Vec<Option<Timed>>)> = (cycles.into_iter().enumerate())
                .filter_map(|(i, cycle_s)| {
                    let mut plans = self.splits(&chosen, flow_vph, cycle_s)?;
                    ascend(&self.signals, streets, &mut plans);
                    let bands = efficiency(&self.signals, streets, &plans);
                    // Webster's own comes first.
                    Some((if i == 0 { f64::INFINITY } else { bands }, plans))
                })
                .collect();
            plans.sort_by(|a, b| b.0.total_cmp(&a.0));
            let mut distinct: Vec<Vec<Option<Timed>>> = Vec::new();
            for (_, plans) in plans {
                if distinct.len() < CYCLES_PER_SET && !distinct.contains(&plans) {
                    distinct.push(plans);
                }
            }
            for (rank, plans) in distinct.into_iter().enumerate() {
                by_rank[rank].push(plans);
            }
        }
        let mut starts: Vec<Vec<Option<Timed>>> = Vec::new();
        for plans in by_rank.into_iter().flatten() {
            if !starts.contains(&plans) {
                starts.push(plans);
            }
        }
        starts
    }

    /// Returns plans of a common cycle without offsets; `None` where it does not fit the limits of a signal.
    fn splits(
        &self,
        sets: &[&Vec<usize>],
        flow_vph: &[Vec<f64>],
        cycle_s: u32,
    ) -> Option<Vec<Option<Timed>>> {
        let each = self.signals.iter().zip(sets).zip(flow_vph);
        each.map(|((spec, set), flow_vph)| {
            if !decides(spec) {
                return Some(None);
            }
            let limits = &spec.limits;
            // The shortest greens may need a longer cycle than the longest.
            let fits = f64::from(cycle_s) >= limits.min_cycle_s
                && f64::from(cycle_s) <= limits.max_cycle_s;
            let greens_s = split(spec, set, flow_vph, &self.constants, f64::from(cycle_s));
            let plan = Timed { phases: (*set).clone(), greens_s, offset_s: 0, cycle_s };
            (fits && plan.is_whole(spec)).then_some(Some(plan))
        })
        .collect()
    }

    /// Moves a plan in simulation until the episodes are used up or no move is better, and returns the best one.
    fn search(
        &mut self,
        trainer: &mut dyn Trainer,
        start: Vec<Option<Timed>>,
        delay_s: f64,
        most: u32,
    ) -> Result<Vec<Option<Timed>>, ControlError> {
        let Some(cycle_s) = start.iter().flatten().map(|plan| plan.cycle_s).next() else {
            return Ok(start);
        };
        let moves = self.moves(&start);
        let (mut best_s, mut best) = (delay_s, start.clone());
        let mut tried = vec![start];
        let mut step_s = (f64::from(cycle_s) * FIRST_STEP).round();
        while step_s >= LAST_STEP_S {
            let mut is_better = false;
            for change in &moves {
                for sign in [1.0, -1.0] {
                    if self.used >= most {
                        return Ok(best);
                    }
                    let Some(plans) = self.moved(&best, *change, sign * step_s) else { continue };
                    if tried.contains(&plans) {
                        continue;
                    }
                    tried.push(plans.clone());
                    let tried_s =
                        self.attempt(trainer, &Plans::Common(plans.clone()), SEARCH_SEED)?;
                    if tried_s < best_s {
                        (best_s, best, is_better) = (tried_s, plans, true);
                        break;
                    }
                }
            }
            if !is_better {
                step_s = (step_s / 2.0).floor();
            }
        }
        Ok(best)
    }

    /// Returns what the search moves, in turn: offsets of the busiest streets first, then the cycle, then splits.
    fn moves(&self, plans: &[Option<Timed>]) -> Vec<Move> {
        let mut streets: Vec<usize> = (0..self.streets.len()).collect();
        streets.sort_by(|a, b| self.weights[*b].total_cmp(&self.weights[*a]));
        let mut moves = Vec::new();
        let mut add = |change: Move| {
            if !moves.contains(&change) {
                moves.push(change);
            }
        };
        for street in streets {
            for stop in 1..self.streets[street].stops.len() {
                add(Move::Behind(street, stop));
            }
            for stop in &self.streets[street].stops {
                add(Move::Offset(stop.signal));
            }
        }
        add(Move::Cycle);
        for (signal, plan) in plans.iter().enumerate() {
            let phases = plan.as_ref().map_or(0, |plan| plan.phases.len());
            (0..phases).for_each(|phase| add(Move::Split(signal, phase)));
        }
        moves
    }

    /// Returns plans after a move by some seconds; `None` where it cannot be made.
    fn moved(
        &self,
        plans: &[Option<Timed>],
        change: Move,
        step_s: f64,
    ) -> Option<Vec<Option<Timed>>> {
        let mut plans = plans.to_vec();
        let shift = |plan: &mut Option<Timed>| {
            if let Some(plan) = plan {
                let offset_s = f64::from(plan.offset_s) + step_s;
                plan.offset_s = offset_s.rem_euclid(f64::from(plan.cycle_s)) as u32;
            }
        };
        let bounded_s = step_s.clamp(-LONGEST_SPLIT_STEP_S, LONGEST_SPLIT_STEP_S);
        match change {
            Move::Offset(signal) => shift(&mut plans[signal]),
            Move::Behind(street, stop) => {
                let behind = &self.streets[street].stops[stop..];
                behind.iter().for_each(|stop| shift(&mut plans[stop.signal]));
            }
            Move::Split(signal, phase) => {
                let plan = plans[signal].as_mut()?;
                let next = (phase + 1) % plan.phases.len();
                if next == phase {
                    return None;
                }
                plan.greens_s[phase] += bounded_s;
                plan.greens_s[next] -= bounded_s;
            }
            Move::Cycle => {
                for (plan, spec) in plans.iter_mut().zip(&self.signals) {
                    let Some(plan) = plan else { continue };
                    let cycle_s = f64::from(plan.cycle_s) + bounded_s;
                    let limits = &spec.limits;
                    if cycle_s < limits.min_cycle_s || cycle_s > limits.max_cycle_s {
                        return None;
                    }
                    // Offsets keep their place in the cycle.
                    let part = f64::from(plan.offset_s) / f64::from(plan.cycle_s);
                    plan.greens_s = plan.filled(spec, cycle_s);
                    plan.cycle_s = cycle_s as u32;
                    plan.offset_s = (part * cycle_s).round().rem_euclid(cycle_s) as u32;
                }
            }
        }
        let fits = |(plan, spec): (&Option<Timed>, &SignalSpec)| {
            plan.as_ref().is_none_or(|plan| plan.is_whole(spec))
        };
        plans.iter().zip(&self.signals).all(fits).then_some(plans)
    }

    /// Returns the plans with the least delay on further seeds, of equal ones the first.
    fn decide(
        &mut self,
        trainer: &mut dyn Trainer,
        finalists: &[Plans],
    ) -> Result<Plans, ControlError> {
        let mut best: Option<(f64, usize)> = None;
        for (i, plans) in finalists.iter().enumerate().filter(|_| finalists.len() > 1) {
            let mut total_s = 0.0;
            for seed in FINAL_SEEDS {
                total_s += self.attempt(trainer, plans, seed)?;
            }
            if best.is_none_or(|(least_s, _)| total_s < least_s) {
                best = Some((total_s, i));
            }
        }
        Ok(finalists[best.map_or(0, |(_, i)| i)].clone())
    }
}

/// Whether there is anything to decide at a signal.
fn decides(spec: &SignalSpec) -> bool {
    spec.phases.len() > 1
}

#[cfg(test)]
mod tests;

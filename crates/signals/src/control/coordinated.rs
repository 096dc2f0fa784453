//! Coordinated-actuated control: the dual rings of [`nema`](super::nema) within a common cycle with offsets.
//!
//! For each network, on training seeds only:
//! 1. One episode with the network's own programs counts the vehicles per lane.
//! 2. **Splits**: for a common cycle, every signal shares its green by Webster's flow ratios, within its limits. Cycles are
//!    the longest of Webster's cycles of the signals, and others near it.
//! 3. **Offsets** are those with which a vehicle at the speed limit meets green along one street; streets that cross it follow
//!    from the signals in common. Nothing is simulated for that.
//! 4. Plans for both directions of the busiest street are simulated, those of Webster's own cycle first; the one with the
//!    least delay stays.
//!
//! Choices:
//! - **Plans run as in a cabinet**: phases are skipped and end when nobody comes, and what they leave goes to the coordinated
//!   phases, the through phases of the busiest street at a signal. What a phase may do at which second of the cycle is in
//!   `env/dual_ring/coordination.rs`.
//! - **Fixed force-offs**: a phase that begins early may last until the end of its split in the cycle.
//! - **Coordinated phases hold their green** until their yield point, whether vehicles come or not.
//! - **The first cycle** of an episode begins with the coordinated phases, which last until their first yield point.
//! - **A signal whose stages two rings cannot follow** runs them as a fixed cycle with the same offset.
//! - **The order of phases** is that of the network's program; lead and lag do not change.
//! - **All signals have the whole cycle**; none runs half of it.
//! - **One signal, or signals that lead to no other**, is an error: there is nothing to coordinate.
//!
//! Deviation: `signal.max_green_s` does not end a coordinated phase, as in a cabinet. All other limits hold.
//!
//! Source: "Signal Timing Manual" (2nd ed., NCHRP Report 812), chapter 7; NEMA TS 2. Deviation: offsets favour one direction at
//! a time, and the simulation decides which, and at which cycle the other one fares best.

use std::collections::BTreeMap;

use super::dual_ring::{self, Recall};
use super::fixed_time::{SIMULATIONS, budget};
use super::phase_sets::covering;
use super::streets::{Stop, Street, streets};
use super::webster::{Constants, greens, split};
use super::{ControlError, Controller, Drive, Light, Limits, Setup, SignalSpec, Trainer};
use crate::program::{ProgramPhase, RingStages};
use evaluation::run::method::{Method, Training};
use evaluation::run::search::{SEARCH_SEED, search};
use evaluation::settings::setting::settings;

/// The method.
pub const METHOD: Method = Method {
    summary: "dual-ring, actuated control within a common cycle with offsets",
    settings: Config::SETTINGS,
    ..Method::built_in(
        "coordinated",
        Training::Tuned { episodes: "coordinated.simulations" },
        "#8787b4",
    )
};

settings! {
    /// Coordinated-actuated control.
    pub struct Config, source "Signal Timing Manual (2nd ed., NCHRP Report 812), chapter 7" {
        /// Simulated episodes that tuning may use for one signal; for n signals, √n times as many.
        simulations: u32 = 24, in 8.0..=10_000.0, unit "episodes", source "our choice";
        /// Time lost per phase change in Webster's formula.
        lost_time_s: f64 = 4.0, in 0.0..=30.0, unit "s";
        /// Saturation flow in Webster's formula (HCM base 1900).
        saturation_flow_vph: f64 = 1900.0, in 100.0..=5000.0, unit "veh/h per lane";
        /// Time without a vehicle on a phase's detectors after which its green may end.
        passage_s: u32 = 2, in 1.0..=30.0, unit "s", source "as for nema";
        /// Length of the detectors, which end at the stop line. If a lane is shorter than the detector, the detector
        /// continues on the street upstream.
        detector_m: f64 = 20.0, in 1.0..=200.0, unit "m", source "as for nema";
        /// The same on lanes for left turns alone.
        left_detector_m: f64 = 10.0, in 1.0..=200.0, unit "m", source "as for nema";
    }
}

/// Shortest and longest cycle that is tried, relative to Webster's.
const CYCLES: [f64; 2] = [0.75, 1.5];

/// Step between the cycles that are tried, seconds.
const CYCLE_STEP_S: usize = 5;

/// Longest green that a phase has of its own, seconds: its split ends it, within the limits.
const UNTIL_FORCE_OFF_S: u32 = 600;

/// Streets, the busiest first, whose progression is tried.
const PROGRESSIONS: usize = 2;

/// A cycle per signal; none where there is nothing to decide.
type Plans = Vec<Option<Timed>>;

/// Returns coordinated-actuated control, not yet tuned.
pub fn create(config: &Config, _setup: &Setup) -> Box<dyn Controller> {
    Box::new(Coordinated { config: config.clone(), ..Coordinated::default() })
}

/// Returns what the rings are told.
pub fn rings(config: &Config) -> dual_ring::Config {
    dual_ring::Config {
        passage_s: config.passage_s,
        detector_m: config.detector_m,
        left_detector_m: config.left_detector_m,
        max_green_s: UNTIL_FORCE_OFF_S,
        left_max_green_s: UNTIL_FORCE_OFF_S,
        recall: Recall::None,
    }
}

#[derive(Debug, Default)]
struct Coordinated {
    config: Config,
    signals: Vec<SignalSpec>,
    /// With the vehicles per hour along each, the busiest first.
    streets: Vec<(f64, Street)>,
    /// What runs in the next episode; the networks' own programs where there is none yet.
    plans: Option<Plans>,
    used: u32,
}

impl Controller for Coordinated {
    fn name(&self) -> &'static str {
        METHOD.name
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        if self.signals != signals {
            self.signals = signals.to_vec();
            self.streets = streets(signals).into_iter().map(|street| (0.0, street)).collect();
            self.plans = None;
        }
        if self.streets.is_empty() {
            return Err(self.fail(
                "no vehicle that goes straight on comes from one signal to another, so there is nothing to coordinate; run nema",
            ));
        }
        let plan = |signal: usize| self.plans.as_ref().and_then(|plans| plans[signal].as_ref());
        Ok((0..signals.len()).map(|signal| self.drive(signal, plan(signal))).collect())
    }

    fn train(&mut self, trainer: &mut dyn Trainer) -> Result<(), ControlError> {
        let flow_vph = trainer.episode(self, SEARCH_SEED)?.lane_flow_vph;
        self.used += 1;
        // Those counted on the lanes of its movements, the mean over its stop lines.
        for (weight, street) in &mut self.streets {
            let at = |stop: &Stop| -> f64 {
                let lanes = &self.signals[stop.signal].movements[stop.movement].lanes;
                lanes.iter().map(|lane| flow_vph[stop.signal][*lane]).sum()
            };
            *weight = street.iter().map(at).sum::<f64>() / street.len() as f64;
        }
        self.streets.sort_by(|a, b| b.0.total_cmp(&a.0));
        let most = budget(self.config.simulations, self.signals.len() as u32) - 1;
        let (candidates, mut tried) = ((self.candidates(&flow_vph), most), Vec::new());
        search(&mut tried, candidates, None, &mut |plans: &Plans| {
            self.plans = Some(plans.clone());
            self.used += 1;
            trainer.episode(self, SEARCH_SEED).map(|played| played.delay_s)
        })?;
        let none = "no cycle fits the limits of all signals; change the limits of [signal]";
        self.plans = Some(tried.into_iter().next().ok_or_else(|| self.fail(none))?.1);
        Ok(())
    }

    fn details(&self) -> BTreeMap<String, String> {
        BTreeMap::from([(SIMULATIONS.to_owned(), self.used.to_string())])
    }
}

impl Coordinated {
    fn fail(&self, reason: &str) -> ControlError {
        let signal = self.signals.first().map_or_else(String::new, |signal| signal.id.clone());
        ControlError::Signal { method: METHOD.name, signal, reason: reason.to_owned() }
    }

    fn drive(&self, signal: usize, plan: Option<&Timed>) -> Drive {
        let Some(plan) = plan else { return Drive::OwnProgram };
        let state = |phase: &usize| &self.signals[signal].phases[*phase].state;
        let greens = plan.phases.iter().map(state).zip(&plan.greens_s);
        let stages = RingStages {
            greens: greens.map(|(state, green_s)| ProgramPhase::fixed(state, *green_s)).collect(),
            offset_s: plan.offset_s,
            coordinated: self.coordinated_stage(signal, plan),
        };
        Drive::CoordinatedRings(rings(&self.config), stages)
    }

    /// Returns the stage with the longest green of the busiest street at a signal.
    fn coordinated_stage(&self, signal: usize, plan: &Timed) -> usize {
        let stops = self.streets.iter().flat_map(|(weight, street)| {
            let here = street.iter().filter(|stop| stop.signal == signal);
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

    /// Returns plans with offsets, those of Webster's cycles first.
    fn candidates(&self, flow_vph: &[Vec<f64>]) -> Vec<Plans> {
        let Config { lost_time_s, saturation_flow_vph, .. } = self.config;
        let constants = Constants { lost_time_s, saturation_flow_vph };
        let sets: Vec<Vec<Vec<usize>>> = self.signals.iter().map(covering).collect();
        let mut found: Vec<(u32, Plans)> = Vec::new();
        for round in 0..sets.iter().map(Vec::len).max().unwrap_or(0) {
            let each = || {
                let chosen = sets.iter().map(|sets| &sets[round.min(sets.len() - 1)]);
                self.signals
                    .iter()
                    .zip(chosen)
                    .zip(flow_vph)
                    .map(|((spec, set), vph)| (spec, set, vph))
            };
            let decided = each().filter(|(spec, ..)| spec.phases.len() > 1);
            let own_cycle_s = |(spec, set, vph): (&SignalSpec, &Vec<usize>, &Vec<f64>)| {
                greens(spec, set, vph, &constants).iter().sum::<f64>() + spec.limits.lost_s(set)
            };
            let natural_s = decided.map(own_cycle_s).fold(0.0, f64::max);
            let [low, natural, high] =
                [CYCLES[0], 1.0, CYCLES[1]].map(|part| (natural_s * part).round() as u32);
            for cycle_s in std::iter::once(natural).chain((low..=high).step_by(CYCLE_STEP_S)) {
                let splits = each().map(|(spec, set, vph)| {
                    if spec.phases.len() < 2 {
                        return Some(None);
                    }
                    let greens_s = split(spec, set, vph, &constants, f64::from(cycle_s));
                    let plan = Timed { phases: set.clone(), greens_s, offset_s: 0, cycle_s };
                    plan.fits(spec).then_some(Some(plan))
                });
                let Some(splits) = splits.collect::<Option<Plans>>() else { continue };
                for (_, street) in self.streets.iter().take(PROGRESSIONS) {
                    let plans = self.progression(splits.clone(), street);
                    if !found.iter().any(|(_, other)| *other == plans) {
                        found.push((cycle_s.abs_diff(natural), plans));
                    }
                }
            }
        }
        found.sort_by_key(|(off_s, _)| *off_s);
        found.into_iter().map(|(_, plans)| plans).collect()
    }

    /// Gives plans the offsets with which a vehicle at the speed limit meets green along a street, and along the others as far
    /// as they are free.
    fn progression(&self, mut plans: Plans, first: &Street) -> Plans {
        let mut known = vec![false; plans.len()];
        for stops in std::iter::once(first).chain(self.streets.iter().map(|(_, stops)| stops)) {
            let begins_s =
                |stop: &Stop, plan: &Timed| plan.begins_s(&self.signals[stop.signal], stop);
            // When a vehicle passes the first stop line, for its green to begin.
            let shared = stops.iter().find(|stop| known[stop.signal]);
            let passes_s = shared.and_then(|stop| {
                let plan = plans[stop.signal].as_ref()?;
                Some(f64::from(plan.offset_s) + begins_s(stop, plan) - stop.after_s)
            });
            for stop in stops {
                let is_known = std::mem::replace(&mut known[stop.signal], true);
                if let Some(plan) = plans[stop.signal].as_mut().filter(|_| !is_known) {
                    let offset_s =
                        passes_s.unwrap_or_default() + stop.after_s - begins_s(stop, plan);
                    plan.offset_s = offset_s.round().rem_euclid(f64::from(plan.cycle_s)) as u32;
                }
            }
        }
        plans
    }
}

/// A fixed cycle with its offset.
#[derive(Debug, Clone, PartialEq)]
struct Timed {
    /// Its phases, in order.
    phases: Vec<usize>,
    /// Their greens, seconds.
    greens_s: Vec<f64>,
    /// When its first green begins, seconds after time 0 and its multiples of the cycle.
    offset_s: u32,
    /// The cycle, seconds.
    cycle_s: u32,
}

impl Timed {
    /// Whether the cycle is within the limits of the signal, and greens, which are within theirs, and changes fill it.
    fn fits(&self, spec: &SignalSpec) -> bool {
        let Limits { min_cycle_s, max_cycle_s, .. } = spec.limits;
        let cycle_s = f64::from(self.cycle_s);
        let total_s = self.greens_s.iter().sum::<f64>() + spec.limits.lost_s(&self.phases);
        (min_cycle_s..=max_cycle_s).contains(&cycle_s) && (total_s - cycle_s).abs() < 1e-6
    }

    /// Returns when the green of a stop line begins, seconds after that of the first phase.
    fn begins_s(&self, spec: &SignalSpec, stop: &Stop) -> f64 {
        let serves = |i: usize| {
            spec.phases[self.phases[i % self.phases.len()]].service[stop.movement] != Light::Red
        };
        let count = self.phases.len();
        let first = (0..count).find(|i| serves(*i) && !serves(i + count - 1)).unwrap_or_default();
        let change_s =
            |i: usize| spec.limits.change_s[self.phases[i]][self.phases[(i + 1) % count]];
        (0..first).map(|i| self.greens_s[i] + change_s(i)).sum()
    }
}

#[cfg(test)]
mod tests;

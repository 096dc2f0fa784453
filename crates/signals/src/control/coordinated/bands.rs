//! Green bands: how much of a cycle lets vehicles drive through all signals of a street without a stop.
//!
//! A street has one direction; the other one is another street ([`streets`](super::super::streets)). A vehicle that passes the first stop line at time `t` comes to the others after the time that it takes at the speed limit.
//! The band is the longest run of seconds `t` of the cycle for which all of them are green then.
//!
//! - **Offsets** are found by coordinate ascent: each signal in turn takes the best of all whole seconds, until none is
//!   better. It starts from no offsets and from the perfect progression of every street, and keeps the best.
//! - **What is largest**: the sum over streets of vehicles times band. Where a band of the whole street does not exist, the
//!   seconds in which neighbours are green one after the other decide, with a tenth of the weight.
//!
//! Source: Little, Kelson and Gartner (1981), MAXBAND.

use super::super::streets::{Stop, Street};
use super::super::webster::fill;
use super::super::{Light, SignalSpec};

/// Weight of what neighbours have in common, relative to the band of the whole street.
const NEIGHBOURS: f64 = 0.1;

/// Most rounds of the ascent; it ends where no signal moves.
const ROUNDS: usize = 20;

/// A fixed cycle with its offset.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Timed {
    /// Its phases, in order.
    pub(super) phases: Vec<usize>,
    /// Their greens, seconds.
    pub(super) greens_s: Vec<f64>,
    /// When its first green begins, seconds after time 0 and its multiples of the cycle.
    pub(super) offset_s: u32,
    /// The cycle, seconds.
    pub(super) cycle_s: u32,
}

/// Returns the vehicles per hour of every street: the mean over its stop lines of those counted on the lanes of its movement.
pub(super) fn weights(
    signals: &[SignalSpec],
    streets: &[Street],
    flow_vph: &[Vec<f64>],
) -> Vec<f64> {
    let at = |stop: &Stop| -> f64 {
        let lanes = &signals[stop.signal].movements[stop.movement].lanes;
        lanes.iter().map(|lane| flow_vph[stop.signal][*lane]).sum()
    };
    let mean =
        |street: &Street| street.stops.iter().map(at).sum::<f64>() / street.stops.len() as f64;
    streets.iter().map(mean).collect()
}

impl Timed {
    /// Whether greens and changes fill the cycle, within the limits of the signal.
    pub(super) fn is_whole(&self, spec: &SignalSpec) -> bool {
        let limits = &spec.limits;
        let total_s = self.greens_s.iter().sum::<f64>() + limits.lost_s(&self.phases);
        let least_s = limits.least_s(&self.phases);
        let within = self.greens_s.iter().zip(&least_s).zip(&self.phases);
        (total_s - f64::from(self.cycle_s)).abs() < 1e-6
            && within.clone().all(|((g, least), p)| g >= least && *g <= limits.max_green_s[*p])
    }

    /// Returns its greens stretched to another cycle, within the limits of the signal.
    pub(super) fn filled(&self, spec: &SignalSpec, cycle_s: f64) -> Vec<f64> {
        let limits = &spec.limits;
        let most_s: Vec<f64> = self.phases.iter().map(|p| limits.max_green_s[*p]).collect();
        let green_s = cycle_s - limits.lost_s(&self.phases);
        fill(&self.greens_s, &limits.least_s(&self.phases), &most_s, green_s)
    }

    /// Returns it in words.
    pub(super) fn describe(&self, spec: &SignalSpec) -> String {
        let greens = self.phases.iter().zip(&self.greens_s);
        let greens: Vec<String> =
            greens.map(|(p, green_s)| format!("{} {green_s} s", spec.phases[*p].state)).collect();
        let (cycle_s, offset_s) = (self.cycle_s, self.offset_s);
        format!("cycle {cycle_s} s, offset {offset_s} s: {}", greens.join(", "))
    }

    /// Returns whether a movement is green, for every second of the cycle from the beginning of its first green on.
    fn greens_of(&self, spec: &SignalSpec, movement: usize) -> Vec<bool> {
        let serves = |p: usize| spec.phases[p].service[movement] != Light::Red;
        let mut seconds = Vec::with_capacity(self.cycle_s as usize);
        for (i, (phase, green_s)) in self.phases.iter().zip(&self.greens_s).enumerate() {
            let next = self.phases[(i + 1) % self.phases.len()];
            let change_s = spec.limits.change_s[*phase][next];
            seconds.extend(std::iter::repeat_n(serves(*phase), *green_s as usize));
            // What is green before and after a change is so in it.
            let stays = serves(*phase) && serves(next);
            seconds.extend(std::iter::repeat_n(stays, change_s as usize));
        }
        seconds
    }
}

/// Green by second of the cycle, by stop of a street.
type Lights = Vec<Vec<bool>>;

/// Returns the lights of every street, at whatever offset; those of signals that do not run the cycle are always green.
fn lights(signals: &[SignalSpec], streets: &[Street], plans: &[Option<Timed>]) -> Vec<Lights> {
    let of = |stop: &Stop| match &plans[stop.signal] {
        Some(plan) => plan.greens_of(&signals[stop.signal], stop.movement),
        None => Vec::new(),
    };
    streets.iter().map(|street| street.stops.iter().map(of).collect()).collect()
}

/// Returns for every second of the cycle whether who passes the first stop line then finds this one green.
fn seen(stop: &Stop, light: &[bool], plans: &[Option<Timed>], cycle_s: u32) -> Vec<bool> {
    let Some(plan) = plans[stop.signal].as_ref().filter(|_| !light.is_empty()) else {
        return vec![true; cycle_s as usize];
    };
    let shift = stop.after_s.round() as i64 - i64::from(plan.offset_s);
    let at = |t: u32| light[(i64::from(t) + shift).rem_euclid(light.len() as i64) as usize];
    (0..cycle_s).map(at).collect()
}

/// Returns the longest run of a circle.
fn longest_run(circle: &[bool]) -> usize {
    if circle.iter().all(|green| *green) {
        return circle.len();
    }
    let (mut longest, mut run) = (0, 0);
    for green in circle.iter().chain(circle) {
        run = if *green { run + 1 } else { 0 };
        longest = longest.max(run);
    }
    longest
}

/// Returns what the ascent makes large, vehicles per hour times seconds.
fn value(
    (street, weight): (&Street, f64),
    lights: &Lights,
    plans: &[Option<Timed>],
    cycle_s: u32,
) -> f64 {
    let mut all = vec![true; cycle_s as usize];
    let mut before: Option<Vec<bool>> = None;
    let mut common = 0;
    for (stop, light) in street.stops.iter().zip(lights) {
        let seen = seen(stop, light, plans, cycle_s);
        all.iter_mut().zip(&seen).for_each(|(all, seen)| *all &= seen);
        if let Some(before) = before {
            common += before.iter().zip(&seen).filter(|(a, b)| **a && **b).count();
        }
        before = Some(seen);
    }
    let neighbours = common as f64 / (street.stops.len() - 1) as f64;
    weight * (longest_run(&all) as f64 + NEIGHBOURS * neighbours)
}

fn total(
    (streets, weights): (&[Street], &[f64]),
    lights: &[Lights],
    plans: &[Option<Timed>],
    of: &[usize],
    cycle_s: u32,
) -> f64 {
    let of = of.iter().map(|i| value((&streets[*i], weights[*i]), &lights[*i], plans, cycle_s));
    of.sum()
}

fn common_cycle_s(plans: &[Option<Timed>]) -> u32 {
    plans.iter().flatten().map(|plan| plan.cycle_s).next().unwrap_or(0)
}

/// Returns the part of the cycle that is in bands, a mean over streets weighted by vehicles.
pub(super) fn efficiency(
    signals: &[SignalSpec],
    (streets, weights): (&[Street], &[f64]),
    plans: &[Option<Timed>],
) -> f64 {
    let cycle_s = common_cycle_s(plans);
    let lights = lights(signals, streets, plans);
    let all: Vec<usize> = (0..streets.len()).collect();
    let most = weights.iter().sum::<f64>() * f64::from(cycle_s);
    total((streets, weights), &lights, plans, &all, cycle_s) / most.max(1e-9)
}

/// Gives plans of one cycle the offsets with the widest bands.
pub(super) fn ascend(
    signals: &[SignalSpec],
    (streets, weights): (&[Street], &[f64]),
    plans: &mut Vec<Option<Timed>>,
) {
    let cycle_s = common_cycle_s(plans);
    let lights = lights(signals, streets, plans);
    let all: Vec<usize> = (0..streets.len()).collect();
    let of_signal: Vec<Vec<usize>> = (0..signals.len())
        .map(|signal| {
            let passes = |i: &usize| streets[*i].stops.iter().any(|stop| stop.signal == signal);
            all.iter().copied().filter(passes).collect()
        })
        .collect();
    let mut begins: Vec<Vec<Option<Timed>>> = vec![plans.clone()];
    for street in streets {
        let mut progression = plans.clone();
        for stop in &street.stops {
            if let Some(plan) = &mut progression[stop.signal] {
                plan.offset_s = (stop.after_s.round() as u32) % cycle_s.max(1);
            }
        }
        begins.push(progression);
    }
    let mut best: Option<(f64, Vec<Option<Timed>>)> = None;
    for mut plans in begins {
        for _ in 0..ROUNDS {
            let mut moves = false;
            for (signal, of) in of_signal.iter().enumerate().filter(|(_, of)| !of.is_empty()) {
                let Some(first_s) = plans[signal].as_ref().map(|plan| plan.offset_s) else {
                    continue;
                };
                let mut most = (total((streets, weights), &lights, &plans, of, cycle_s), first_s);
                for offset_s in 0..cycle_s {
                    if let Some(plan) = &mut plans[signal] {
                        plan.offset_s = offset_s;
                    }
                    let value = total((streets, weights), &lights, &plans, of, cycle_s);
                    if value > most.0 + 1e-9 {
                        (most, moves) = ((value, offset_s), true);
                    }
                }
                if let Some(plan) = &mut plans[signal] {
                    plan.offset_s = most.1;
                }
            }
            if !moves {
                break;
            }
        }
        let value = total((streets, weights), &lights, &plans, &all, cycle_s);
        if best.as_ref().is_none_or(|(most, _)| value > *most + 1e-9) {
            best = Some((value, plans));
        }
    }
    if let Some((_, found)) = best {
        *plans = found;
    }
}

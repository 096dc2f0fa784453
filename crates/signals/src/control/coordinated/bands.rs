//! Green bands: how much of a cycle lets vehicles drive through all signals of a street without a stop.
//!
//! A street has one direction; the other one is another street ([`streets`](super::super::streets)). A vehicle that passes the
//! first stop line at time `t` comes to the others after the time that it takes at the speed limit. The band is the longest run
//! of seconds `t` of the cycle for which all of them are green then.
//!
//! - **Offsets** are found by coordinate ascent from the perfect progression of the busiest street: each signal in turn takes
//!   the best of all whole seconds, until none is better.
//! - **What is largest**: the sum over streets of vehicles times band. Where a band of the whole street does not exist, the
//!   seconds in which neighbours are green one after the other decide, with a tenth of the weight.
//!
//! Source: Little, Kelson and Gartner (1981), MAXBAND.

use super::super::streets::{Stop, Street};
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
    /// Whether it is within the limits of the signal, and its greens and changes fill the cycle.
    pub(super) fn fits(&self, spec: &SignalSpec) -> bool {
        let limits = &spec.limits;
        let cycle_s = f64::from(self.cycle_s);
        let total_s = self.greens_s.iter().sum::<f64>() + limits.lost_s(&self.phases);
        let least_s = limits.least_s(&self.phases);
        let mut greens = self.greens_s.iter().zip(&least_s).zip(&self.phases);
        // The shortest greens may need a longer cycle than the longest.
        (limits.min_cycle_s..=limits.max_cycle_s).contains(&cycle_s)
            && (total_s - cycle_s).abs() < 1e-6
            && greens.all(|((g, least), p)| g >= least && *g <= limits.max_green_s[*p])
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

/// The streets of plans of one cycle, at whatever offsets.
pub(super) struct Bands<'a> {
    streets: &'a [Street],
    weights: &'a [f64],
    /// Green by street, stop and second of the cycle; empty for a signal that does not run the cycle and counts as green.
    lights: Vec<Vec<Vec<bool>>>,
    cycle_s: usize,
}

impl<'a> Bands<'a> {
    pub(super) fn new(
        signals: &[SignalSpec],
        (streets, weights): (&'a [Street], &'a [f64]),
        plans: &[Option<Timed>],
    ) -> Self {
        let of = |stop: &Stop| match &plans[stop.signal] {
            Some(plan) => plan.greens_of(&signals[stop.signal], stop.movement),
            None => Vec::new(),
        };
        let lights = streets.iter().map(|street| street.stops.iter().map(of).collect()).collect();
        let cycle_s = plans.iter().flatten().map(|plan| plan.cycle_s as usize).next();
        Self { streets, weights, lights, cycle_s: cycle_s.unwrap_or_default() }
    }

    /// Returns what the ascent makes large, vehicles per hour times seconds.
    pub(super) fn value(&self, plans: &[Option<Timed>]) -> f64 {
        let all = self.streets.iter().zip(self.weights).zip(&self.lights);
        let value = |((street, weight), lights): ((&Street, &f64), &Vec<Vec<bool>>)| {
            // Whether who passes the first stop line then finds this one green.
            let seen = |(stop, light): (&Stop, &Vec<bool>)| -> Vec<bool> {
                let offset_s = plans[stop.signal].as_ref().map_or(0, |plan| plan.offset_s);
                let shift = stop.after_s.round() as i64 - i64::from(offset_s);
                let at = |t: i64| light[(t + shift).rem_euclid(light.len() as i64) as usize];
                (0..self.cycle_s as i64).map(|t| light.is_empty() || at(t)).collect()
            };
            let seen: Vec<Vec<bool>> = street.stops.iter().zip(lights).map(seen).collect();
            let passes: Vec<bool> = (0..self.cycle_s).map(|t| seen.iter().all(|s| s[t])).collect();
            let both = |pair: &[Vec<bool>]| {
                pair[0].iter().zip(&pair[1]).filter(|(a, b)| **a && **b).count()
            };
            let neighbours =
                seen.windows(2).map(both).sum::<usize>() as f64 / (seen.len() - 1) as f64;
            weight * (longest_run(&passes) as f64 + NEIGHBOURS * neighbours)
        };
        all.map(value).sum()
    }

    /// Gives plans the offsets with the widest bands.
    pub(super) fn ascend(&self, plans: &mut [Option<Timed>]) {
        let busiest = (0..self.streets.len())
            .max_by(|a, b| self.weights[*a].total_cmp(&self.weights[*b]).then(b.cmp(a)));
        for stop in busiest.iter().flat_map(|street| &self.streets[*street].stops) {
            if let Some(plan) = &mut plans[stop.signal] {
                plan.offset_s = stop.after_s.round() as u32 % plan.cycle_s;
            }
        }
        let stops = || self.streets.iter().flat_map(|street| &street.stops);
        for _ in 0..ROUNDS {
            let mut moves = false;
            for signal in (0..plans.len()).filter(|i| stops().any(|stop| stop.signal == *i)) {
                let Some(first_s) = plans[signal].as_ref().map(|plan| plan.offset_s) else {
                    continue;
                };
                let mut set = |offset_s: u32| {
                    plans[signal].as_mut().into_iter().for_each(|plan| plan.offset_s = offset_s);
                    self.value(plans)
                };
                let mut most = (set(first_s), first_s);
                for offset_s in 0..self.cycle_s as u32 {
                    let value = set(offset_s);
                    if value > most.0 + 1e-9 {
                        (most, moves) = ((value, offset_s), true);
                    }
                }
                set(most.1);
            }
            if !moves {
                break;
            }
        }
    }
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

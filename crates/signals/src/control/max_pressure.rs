//! Max-pressure control (Varaiya, 2013).
//!
//! At every decision, the phase with the largest sum, over the movements that it serves, of saturation
//! flow times pressure: vehicles queued for the movement minus vehicles queued downstream of it. Needs
//! no forecast of demand and no training.
//!
//! Choices where implementations differ:
//! - **A vehicle is queued once.** The queue of a lane is divided between the movements that share the
//!   lane, by turning share, and so is the lane's flow; a lane of its own gives a movement more pressure
//!   than a shared one with as many vehicles, because it lets them go faster. The shares are those of
//!   the demand where they are known, else those of the vehicles seen so far in the episode.
//! - **Saturation flow** is counted in lanes: a lane that movements share gives each its part of one,
//!   and turns take the HCM's factors for protected turns. The flow of a lane itself is the same for
//!   all and leaves the order of phases alone.
//! - **Permissive left turns** have a share of it ([`Config::permissive_share`]), because they wait for
//!   gaps. With their whole flow, a phase for left turns alone could never win against the through
//!   phase in which they may turn as well.
//! - **A shared lane counts for the phases that serve the most of it**, by turning shares: those that serve all of its
//!   movements where there are any. A phase that serves some of them alone lets vehicles go until the first one that it
//!   does not serve, and then nothing moves on the lane. One that has stood through a whole green makes none of the
//!   movements that had it, and until it leaves the lane is divided among the others (`heads.rs`). Varaiya's
//!   movements have lanes of their own. (Without this, a phase for left turns alone would be kept for ever when the
//!   first vehicle of a lane for left and through goes straight on: nothing moves, so no pressure changes.)
//! - **A movement with more vehicles ahead of it than behind has no pressure**, so that it keeps no other movement
//!   of its phase from green. Deviation: Varaiya's has one below zero. (With pressures below zero a phase that
//!   nobody can use wins where all others lead into longer queues.)
//! - **A signal over several nodes** is one signal. A vehicle that passes two of its stop lines counts at the first one.
//!   A phase that also lets it pass the second lets it through, whatever stands between the two. Under a phase that does
//!   not, it gets no further than the lane between, and once that is full nothing moves on the lane that it comes from.
//!   (Otherwise the phase of the longest queue is kept for ever while its vehicles stand before a red light 12 m ahead.)
//! - **Queues** are the observation's: vehicles that have halted within the detection distance.
//! - **Ties** keep the current phase, which saves yellow.
//! - **No least green of its own**; the limits of the signal hold.
//!
//! Deviation: the queue downstream is the mean of the lanes there, for as many lanes as the movement has,
//! instead of the queues of all movements there weighted by their turning shares, which the next signal
//! knows and this one does not. So a movement has no pressure when a lane ahead has as long a queue as a
//! lane of its own, however many lanes the next street has. (With the sum over all lanes, every right turn
//! counts against its phase, and on a grid of nine signals the mean delay was five times that of RESCO's
//! rule.)
//!
//! Source: P. Varaiya, "Max pressure control of a network of signalized intersections",
//! Transportation Research Part C 36 (2013), 177-195; HCM (6th ed.), chapter 19, adjustment factors.

use std::collections::{BTreeMap, BTreeSet};

use osm_signals::Turn;

use super::heads::Heads;
use super::{
    ControlError, Controller, Drive, GreenPhase, Light, Movement, Observation, Phase, Setup,
    SignalSpec,
};
use evaluation::run::method::{Method, Training};
use evaluation::settings::setting::settings;

/// The method.
pub const METHOD: Method = Method {
    summary: "the phase that relieves the most pressure (Varaiya), at every decision",
    default: true,
    settings: Config::SETTINGS,
    tunes: &[("signal.delta_time_s", &[5.0, 10.0, 15.0, 20.0, 30.0])],
    ..Method::built_in("max-pressure", Training::None, "#d55e00")
};

/// Vehicles that a prior of equal shares per lane counts for, before vehicles have been seen.
const PRIOR_VEH: f64 = 10.0;

/// Street that a standing vehicle takes: SUMO's default length and gap, metres.
const VEHICLE_M: f64 = 7.5;

/// Saturation flow of a protected left turn, relative to a through lane (HCM).
const LEFT_FACTOR: f64 = 0.95;

/// Saturation flow of a protected right turn, relative to a through lane (HCM).
const RIGHT_FACTOR: f64 = 0.85;

settings! {
    /// Constants of max pressure.
    pub struct Config, source "HCM (6th ed.), chapter 19" {
        /// Saturation flow of a left turn that must wait for gaps, relative to one that need not. The default is the
        /// inverse of the HCM's through-car equivalent at about 600 opposing vehicles per hour (3.3).
        permissive_share: f64 = 0.3, in 0.0..=1.0;
    }
}

/// Max-pressure control.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MaxPressure {
    config: Config,
    signals: Vec<SignalSpec>,
    /// Seconds from one decision to the next.
    decision_s: f64,
    /// Per signal and movement the street that it comes from, numbered.
    streets: Vec<Vec<usize>>,
    /// Per signal what is known of the first vehicles of its lanes.
    heads: Vec<Heads>,
}

/// Returns max pressure.
pub fn create(config: &Config, setup: &Setup) -> Box<dyn Controller> {
    Box::new(MaxPressure::new(config.clone(), f64::from(setup.decision_s)))
}

impl MaxPressure {
    /// Returns a controller with these constants that decides every so many seconds.
    pub fn new(config: Config, decision_s: f64) -> Self {
        Self { config, decision_s, ..Self::default() }
    }
}

impl Controller for MaxPressure {
    fn name(&self) -> &'static str {
        METHOD.name
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        if self.signals != signals {
            self.signals = signals.to_vec();
            self.streets = signals.iter().map(streets).collect();
        }
        self.heads = signals.iter().map(Heads::new).collect();
        Ok(vec![Drive::Decisions; signals.len()])
    }

    fn act(
        &mut self,
        observations: &[Observation],
        phases: &mut [GreenPhase],
    ) -> Result<(), ControlError> {
        let told = observations.iter().zip(phases.iter_mut());
        let signals = self.signals.iter().zip(&self.streets).zip(&mut self.heads);
        for (((signal, streets), heads), (observation, phase)) in signals.zip(told) {
            heads.update(signal, observation, self.decision_s);
            let mut parts = lane_parts(signal, &shares(signal, streets, observation));
            heads.divide(signal, &mut parts);
            let stopping = queues(signal, &parts, observation, false);
            let passing = queues(signal, &parts, observation, true);
            let mut claims = claims(signal, &parts);
            let onward = onward(signal, &parts, observation, &mut claims);
            let pressure = |i: usize| -> f64 {
                let service = signal.phases[i].service.iter().zip(&signal.movements);
                let queues =
                    (0..parts.len()).map(|m| if onward[i][m] { passing[m] } else { stopping[m] });
                let service = service.zip(parts.iter().zip(queues));
                service
                    .map(|((service, movement), (parts, queue))| {
                        let lanes = movement.lanes.iter().zip(parts);
                        let flow: f64 = lanes.filter(|(l, _)| claims[i][**l]).map(|(_, p)| p).sum();
                        let weight = factor(movement.turn) * flow * queue;
                        match service {
                            Light::Red => 0.0,
                            Light::Permissive if movement.turn == Turn::Left => {
                                self.config.permissive_share * weight
                            }
                            _ => weight,
                        }
                    })
                    .sum()
            };
            // The current phase stays unless another one has more.
            let current = observation.phase.min(signal.phases.len().saturating_sub(1));
            let mut best = (current, pressure(current));
            for i in 0..signal.phases.len() {
                let pressure = pressure(i);
                if pressure > best.1 {
                    best = (i, pressure);
                }
            }
            *phase = GreenPhase(best.0);
        }
        Ok(())
    }
}

/// Returns the saturation flow of a turn with right of way, relative to going straight on.
fn factor(turn: Turn) -> f64 {
    match turn {
        Turn::Left => LEFT_FACTOR,
        Turn::Through => 1.0,
        Turn::Right => RIGHT_FACTOR,
    }
}

/// Returns the pressure of every movement, vehicles: those queued for it less those queued ahead, if there are more.
///
/// # Arguments
///
/// * `passing` — whether vehicles pass all stop lines of the signal, so that those between two of them are not ahead.
fn queues(signal: &SignalSpec, parts: &[Vec<f64>], seen: &Observation, passing: bool) -> Vec<f64> {
    signal
        .movements
        .iter()
        .zip(parts)
        .map(|(movement, parts)| {
            // Lanes that are the movement's own, in parts.
            let own: f64 = parts.iter().sum();
            let upstream: f64 =
                movement.lanes.iter().zip(parts).map(|(l, part)| part * seen.lanes[*l].queue).sum();
            let inner: &[usize] = if passing { &movement.inner } else { &[] };
            let lanes = (movement.downstream.len() - inner.len()).max(1) as f64;
            let ahead = movement.downstream.iter().map(|l| seen.downstream_queue[*l]).sum::<f64>()
                - inner.iter().map(|l| seen.lanes[*l].queue).sum::<f64>();
            (upstream - own * ahead / lanes).max(0.0)
        })
        .collect()
}

/// Returns, per phase and lane, whether no other phase serves more of the lane.
fn claims(signal: &SignalSpec, parts: &[Vec<f64>]) -> Vec<Vec<bool>> {
    let served: Vec<Vec<f64>> = signal.phases.iter().map(|p| served(signal, parts, p)).collect();
    let most = |lane: usize| served.iter().map(|lanes| lanes[lane]).fold(0.0, f64::max);
    let most: Vec<f64> = (0..signal.lanes.len()).map(most).collect();
    let claims = |lanes: &Vec<f64>| lanes.iter().zip(&most).map(|(s, most)| s >= most).collect();
    served.iter().map(claims).collect()
}

/// Returns, per phase and movement, whether the phase lets its vehicles also pass the signal's next stop line, if there is
/// one; and takes back the claims on lanes that stand before a full lane which the phase does not clear.
fn onward(
    signal: &SignalSpec,
    parts: &[Vec<f64>],
    seen: &Observation,
    claims: &mut [Vec<bool>],
) -> Vec<Vec<bool>> {
    let is_full = |lane: &usize| {
        let on_it = seen.lanes[*lane].queue + seen.lanes[*lane].approach;
        on_it >= (signal.lanes[*lane].length_m / VEHICLE_M).floor().max(1.0)
    };
    // Whether somebody on the lane, as far as is known of its first vehicle, may go.
    let clears = |phase: &Phase, lane: &usize| {
        signal.movements.iter().zip(parts).zip(&phase.service).any(|((m, parts), service)| {
            let mut of_lane = m.lanes.iter().zip(parts);
            *service != Light::Red && of_lane.any(|(l, part)| l == lane && *part > 0.0)
        })
    };
    let phases = signal.phases.iter().zip(claims);
    let of_phase = |(phase, claims): (&Phase, &mut Vec<bool>)| {
        let of_movement = |(m, parts): (&Movement, &Vec<f64>)| {
            let passes = m.inner.is_empty() || m.inner.iter().any(|lane| clears(phase, lane));
            if !passes && m.inner.iter().all(is_full) {
                let stuck = m.lanes.iter().zip(parts).filter(|(_, part)| **part > 0.0);
                stuck.for_each(|(lane, _)| claims[*lane] = false);
            }
            passes
        };
        signal.movements.iter().zip(parts).map(of_movement).collect()
    };
    phases.map(of_phase).collect()
}

/// Returns the part of each lane that a phase serves: exactly 1 where it serves all movements.
fn served(signal: &SignalSpec, parts: &[Vec<f64>], phase: &Phase) -> Vec<f64> {
    let mut served = vec![1.0; signal.lanes.len()];
    for ((movement, parts), service) in signal.movements.iter().zip(parts).zip(&phase.service) {
        if *service == Light::Red {
            movement.lanes.iter().zip(parts).for_each(|(l, part)| served[*l] -= part);
        }
    }
    served
}

/// Returns the street that each movement comes from, numbered: the edge of its lanes.
fn streets(signal: &SignalSpec) -> Vec<usize> {
    let edge = |m: &Movement| {
        let lane = &signal.lanes[m.lanes[0]].id;
        lane.rsplit_once('_').map_or(lane.as_str(), |(edge, _)| edge)
    };
    let edges: BTreeSet<&str> = signal.movements.iter().map(edge).collect();
    let number: BTreeMap<&str, usize> = edges.into_iter().zip(0..).collect();
    signal.movements.iter().map(|m| number[edge(m)]).collect()
}

/// Returns the turning share of every movement among those of its street.
fn shares(signal: &SignalSpec, streets: &[usize], seen: &Observation) -> Vec<f64> {
    signal
        .movements
        .iter()
        .enumerate()
        .map(|(m, movement)| {
            if let Some(share) = movement.share {
                return share;
            }
            let (mut total, mut lanes) = (0.0, 0.0);
            for ((other, street), seen) in signal.movements.iter().zip(streets).zip(&seen.seen) {
                if *street == streets[m] {
                    total += seen;
                    lanes += other.lanes.len() as f64;
                }
            }
            let prior = PRIOR_VEH * movement.lanes.len() as f64 / lanes;
            (seen.seen[m] + prior) / (total + PRIOR_VEH)
        })
        .collect()
}

/// Returns, per movement and lane of it, the part of the lane's vehicles that make the movement. A
/// movement spreads evenly over its lanes; the parts of a lane sum to 1.
fn lane_parts(signal: &SignalSpec, shares: &[f64]) -> Vec<Vec<f64>> {
    // A movement that nobody makes still has a lane.
    let density = |m: usize| shares[m].max(1e-9) / signal.movements[m].lanes.len() as f64;
    let mut total = vec![0.0; signal.lanes.len()];
    for (m, movement) in signal.movements.iter().enumerate() {
        movement.lanes.iter().for_each(|l| total[*l] += density(m));
    }
    let parts =
        |m: usize| signal.movements[m].lanes.iter().map(|l| density(m) / total[*l]).collect();
    (0..signal.movements.len()).map(parts).collect()
}

#[cfg(test)]
mod tests {
    use super::super::LaneObservation;
    use super::super::testing::{observation, signal_with, two_phase_signal};
    use super::*;

    use Light::{Permissive as g, Protected as G, Red as N};

    fn act(signal: &SignalSpec, seen: &Observation) -> usize {
        let mut controller = MaxPressure::default();
        controller.begin(std::slice::from_ref(signal)).unwrap();
        let mut phases = [GreenPhase(9)];
        controller.act(std::slice::from_ref(seen), &mut phases).unwrap();
        phases[0].0
    }

    fn queues(phase: usize, queues: &[f64]) -> Observation {
        let lane = |queue: &f64| LaneObservation { queue: *queue, ..LaneObservation::default() };
        Observation {
            phase,
            lanes: queues.iter().map(lane).collect(),
            seen: vec![0.0; 4],
            ..Observation::default()
        }
    }

    #[test]
    fn the_longer_queue_is_served_unless_its_exit_is_blocked() {
        let signal = two_phase_signal();
        assert_eq!(act(&signal, &observation([2.0, 3.0], [0.0, 0.0])), 1);
        assert_eq!(act(&signal, &observation([3.0, 9.0], [0.0, 9.0])), 0);
        for phase in [0, 1] {
            let tie = Observation { phase, ..observation([4.0, 4.0], [0.0, 0.0]) };
            assert_eq!(act(&signal, &tie), phase);
        }
    }

    #[test]
    fn queues_as_long_ahead_as_here_leave_no_pressure_however_wide_the_next_street() {
        let mut signal = two_phase_signal();
        signal.movements[0].downstream = vec![0, 1, 2];
        signal.movements[1].downstream = vec![];
        let ahead = |queue| Observation {
            downstream_queue: vec![queue; 3],
            ..observation([6.0, 1.0], [0.0, 0.0])
        };
        assert_eq!(act(&signal, &ahead(6.0)), 1, "6 - 6 against 1");
        assert_eq!(act(&signal, &ahead(4.0)), 0, "6 - 4 against 1");
    }

    #[test]
    fn what_stands_between_two_stop_lines_of_a_signal_holds_up_only_phases_that_do_not_clear_it() {
        // A street of two stop lines, 0 and 1; phase 0 lets it pass the first, phase 1 both, phase 2 serves another.
        let mut signal = signal_with(&[[G, N, N], [G, G, N], [N, N, G]]);
        signal.movements[0].downstream = vec![0];
        signal.movements[0].inner = vec![1];
        signal.lanes[1].length_m = 16.0;
        let seen = |between: f64, other: f64| Observation {
            downstream_queue: vec![between],
            seen: vec![0.0; 3],
            ..queues(2, &[9.0, between, other])
        };
        assert_eq!(act(&signal, &seen(0.0, 8.0)), 0, "9 against 9 and 8");
        assert_eq!(act(&signal, &seen(1.0, 9.0)), 1, "8 against 9 + 1 and 9");
        assert_eq!(act(&signal, &seen(2.0, 10.0)), 1, "nothing against 9 + 2 and 10");
        // Without phase 1: nothing moves in phase 0 while two vehicles fill the 16 m.
        signal.phases[1].service = vec![N, G, N];
        assert_eq!(act(&signal, &seen(2.0, 0.0)), 1);
        assert_eq!(act(&signal, &seen(1.0, 0.0)), 0);
    }

    #[test]
    fn a_vehicle_on_a_shared_lane_counts_once() {
        // Phase 0 serves through and left of one shared lane, phase 1 two lanes of another approach.
        let mut signal = signal_with(&[[G, G, N, N], [N, N, G, G]]);
        signal.movements[1].lanes = vec![0];
        let shares = shares(&signal, &streets(&signal), &queues(0, &[5.0, 0.0, 2.0, 2.0]));
        let parts = lane_parts(&signal, &shares);
        assert!((parts[0][0] + parts[1][0] - 1.0).abs() < 1e-12);
        assert_eq!(parts[2], [1.0]);
        // Five vehicles in one lane of halves against four in two lanes.
        assert_eq!(act(&signal, &queues(0, &[5.0, 0.0, 2.0, 2.0])), 1);
    }

    #[test]
    fn all_movements_of_a_phase_count_with_their_lanes() {
        // Movement 0 has two lanes with 6 vehicles, movement 1 one lane with 8: 2 * 6 against 8.
        let mut signal = signal_with(&[[G, N], [N, G]]);
        signal.lanes.push(signal.lanes[0].clone());
        signal.movements[0].lanes = vec![0, 2];
        assert_eq!(act(&signal, &queues(1, &[3.0, 8.0, 3.0])), 0);
        // A left turn that has to wait for gaps counts less.
        let mut signal = signal_with(&[[G, g], [N, G]]);
        signal.movements[1].turn = Turn::Left;
        assert_eq!(act(&signal, &queues(0, &[5.0, 4.0])), 0);
        assert_eq!(act(&signal, &queues(0, &[5.0, 9.0])), 1);
    }

    #[test]
    fn a_phase_for_some_turns_of_a_shared_lane_does_not_count_it_where_another_serves_all() {
        // One lane for through and left, mostly left; phase 1 serves left alone, phase 2 another lane.
        let mut signal = signal_with(&[[G, g, N], [N, G, N], [N, N, G]]);
        signal.movements[1].turn = Turn::Left;
        signal.movements[1].lanes = vec![0];
        signal.movements[0].share = Some(0.1);
        signal.movements[1].share = Some(0.9);
        let seen = |other| Observation { seen: vec![0.0; 3], ..queues(1, &[9.0, 0.0, other]) };
        assert_eq!(act(&signal, &seen(0.0)), 0);
        assert_eq!(act(&signal, &seen(8.0)), 2);
    }

    #[test]
    fn where_no_phase_serves_all_of_a_lane_one_whose_first_vehicle_stands_gives_way() {
        let mut signal = signal_with(&[[G, N], [N, G]]);
        signal.movements[1].turn = Turn::Left;
        signal.movements[1].lanes = vec![0];
        signal.lanes.truncate(1);
        let seen = |phase, max_wait_s| {
            let lane = LaneObservation { queue: 5.0, max_wait_s, ..LaneObservation::default() };
            Observation { lanes: vec![lane], ..queues(phase, &[]) }
        };
        let mut controller = MaxPressure::new(Config::default(), 10.0);
        controller.begin(std::slice::from_ref(&signal)).unwrap();
        let mut choice = |seen: Observation| {
            let mut phases = [GreenPhase(9)];
            controller.act(&[seen], &mut phases).unwrap();
            phases[0].0
        };
        // Equal shares, so that through, the faster turn, goes first until nothing has moved in its green.
        assert_eq!([choice(seen(0, 3.0)), choice(seen(0, 13.0))], [0, 1]);
        assert_eq!(choice(seen(1, 23.0)), 1, "the first vehicle has had no whole green yet");
        assert_eq!(choice(seen(1, 8.0)), 0, "another one is first now");
    }

    #[test]
    fn shares_follow_the_vehicles_seen_unless_the_demand_says_them() {
        let mut signal = signal_with(&[[G, G]]);
        signal.lanes[1].id = "l0_1".into();
        let streets = streets(&signal);
        assert_eq!(streets, [0, 0]);
        let mut seen = queues(0, &[0.0, 0.0]);
        assert_eq!(shares(&signal, &streets, &seen), [0.5, 0.5]);
        seen.seen = vec![80.0, 10.0];
        assert_eq!(shares(&signal, &streets, &seen), [0.85, 0.15]);
        signal.movements[0].share = Some(0.8);
        assert_eq!(shares(&signal, &streets, &seen)[0], 0.8);
    }
}

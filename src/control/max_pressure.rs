//! Max-pressure control (Varaiya, 2013), as RESCO runs it.
//!
//! Serves the phase whose two movements have the largest *pressure*: vehicles queued upstream
//! minus vehicles queued downstream. Needs no demand forecast and no training.
//!
//! Choices where implementations differ (all RESCO's):
//! - **Counts** vehicles that have halted within 200 m, not all vehicles on the lane.
//! - **Two movements per phase** count, even if the phase also serves right turns or permissive
//!   lefts.
//! - **A lane that both movements share counts twice.** So without left-turn lanes a phase that
//!   serves one approach alone outbids the pair of opposing approaches and halves the capacity.
//!   On RESCO's own maps the movements of a pair have lanes of their own; over a family of
//!   intersections this is what makes max pressure lose on narrow streets. The setting
//!   `max_pressure.count_shared_lanes_once` takes each lane once. So does a signal whose phases are
//!   named by all movements that they serve, which RESCO's never are: there a lane would count as
//!   often as it has turns.
//! - **Ties** go to the first phase; an empty intersection gets phase 0.
//! - **No hysteresis** and no minimum green beyond the decision interval.
//!
//! Source: P. Varaiya, "Max pressure control of a network of signalized intersections",
//! Transportation Research Part C 36 (2013), 177-195; RESCO, agents/maxpressure.py.

use super::{
    ControlError, Controller, Drive, GreenPhase, Movement, Observation, Phase, SignalSpec,
};

/// Movements that name a phase of RESCO's.
const RESCO_MOVEMENTS: usize = 2;

/// Max-pressure control.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MaxPressure {
    count_shared_lanes_once: bool,
    signals: Vec<SignalSpec>,
    /// Movements whose lanes count, per signal and phase, merged where lanes are shared.
    phases: Vec<Vec<Vec<Movement>>>,
}

impl MaxPressure {
    /// Name of the method.
    pub const NAME: &'static str = "max-pressure";

    /// Returns a controller that counts a lane once or, as RESCO does, twice where both movements of
    /// a phase share it.
    pub fn new(count_shared_lanes_once: bool) -> Self {
        Self { count_shared_lanes_once, ..Self::default() }
    }
}

impl Controller for MaxPressure {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        if self.signals != signals {
            self.signals = signals.to_vec();
            let counted = |s: &SignalSpec| {
                let many = s.phases.iter().any(|p| p.pair.len() > RESCO_MOVEMENTS);
                let merge = self.count_shared_lanes_once || many;
                s.phases.iter().map(|p| counted(s, p, merge)).collect()
            };
            self.phases = signals.iter().map(counted).collect();
        }
        Ok(vec![Drive::Decisions; signals.len()])
    }

    fn act(&mut self, observations: &[Observation], phases: &mut [GreenPhase]) {
        for ((candidates, observation), phase) in
            self.phases.iter().zip(observations).zip(phases.iter_mut())
        {
            let mut best = f64::NEG_INFINITY;
            for (i, counted) in candidates.iter().enumerate() {
                let pressure: f64 = counted.iter().map(|m| observation.pressure(m)).sum();
                if pressure > best {
                    best = pressure;
                    *phase = GreenPhase(i);
                }
            }
        }
    }
}

/// Returns the movements that count for a phase; with `merge` as one movement with every lane once.
fn counted(signal: &SignalSpec, phase: &Phase, merge: bool) -> Vec<Movement> {
    let mut movements: Vec<Movement> =
        phase.pair.iter().map(|m| signal.movements[*m].clone()).collect();
    if merge && let Some(mut first) = movements.pop() {
        for other in movements.drain(..) {
            first.lanes.extend(other.lanes);
            first.downstream.extend(other.downstream);
        }
        for lanes in [&mut first.lanes, &mut first.downstream] {
            lanes.sort_unstable();
            lanes.dedup();
        }
        movements.push(first);
    }
    movements
}

#[cfg(test)]
mod tests {
    use super::super::testing::{observation, two_phase_signal};
    use super::super::{LaneObservation, Service};
    use super::*;

    fn choice(queues: [f64; 2], downstream: [f64; 2]) -> GreenPhase {
        let mut controller = MaxPressure::default();
        controller.begin(&[two_phase_signal()]).unwrap();
        let mut phases = [GreenPhase(9)];
        controller.act(&[observation(queues, downstream)], &mut phases);
        phases[0]
    }

    #[test]
    fn the_longer_queue_is_served() {
        assert_eq!(choice([2.0, 3.0], [0.0, 0.0]), GreenPhase(1));
    }

    #[test]
    fn a_long_queue_whose_exit_is_blocked_is_skipped() {
        assert_eq!(choice([3.0, 9.0], [0.0, 9.0]), GreenPhase(0));
    }

    #[test]
    fn a_shared_lane_counts_twice_unless_told_otherwise() {
        // Phase 0 has two movements of one lane, phase 1 two movements with lanes of their own.
        let mut signal = super::super::testing::signal_with(&[
            [Service::Protected, Service::Protected, Service::None, Service::None],
            [Service::None, Service::None, Service::Protected, Service::Protected],
        ]);
        signal.movements[1].lanes = vec![0];
        let mut seen = observation([5.0, 0.0], [0.0, 0.0]);
        let four = |queue| LaneObservation { queue, ..LaneObservation::default() };
        seen.lanes.extend([four(4.0), four(3.0)]);
        for (count_shared_lanes_once, expected) in [(false, 0), (true, 1)] {
            let mut controller = MaxPressure::new(count_shared_lanes_once);
            controller.begin(std::slice::from_ref(&signal)).unwrap();
            let mut phases = [GreenPhase(9)];
            controller.act(std::slice::from_ref(&seen), &mut phases);
            assert_eq!(phases[0], GreenPhase(expected));
        }
    }

    #[test]
    fn a_lane_counts_once_where_phases_are_named_by_all_that_they_serve() {
        // Phase 0 serves three turns of one lane, phase 1 two lanes.
        let mut signal = super::super::testing::signal_with(&[
            [Service::Protected, Service::Protected, Service::Protected, Service::None],
            [Service::None, Service::None, Service::None, Service::Protected],
        ]);
        signal.phases[0].pair = vec![0, 1, 2];
        signal.movements[1].lanes = vec![0];
        signal.movements[2].lanes = vec![0];
        signal.movements[3].lanes = vec![1];
        let mut controller = MaxPressure::default();
        controller.begin(std::slice::from_ref(&signal)).unwrap();
        let mut phases = [GreenPhase(9)];
        controller.act(&[observation([3.0, 4.0], [0.0, 0.0])], &mut phases);
        assert_eq!(phases[0], GreenPhase(1));
    }

    #[test]
    fn ties_and_an_empty_intersection_go_to_the_first_phase() {
        assert_eq!(choice([0.0, 0.0], [0.0, 0.0]), GreenPhase(0));
        assert_eq!(choice([4.0, 4.0], [0.0, 0.0]), GreenPhase(0));
    }
}

//! Max pressure as RESCO computes it.
//!
//! Every `delta_time_s`, the phase whose pair of movements has the largest pressure: vehicles queued on
//! their lanes minus vehicles queued on the lanes that they lead to.
//!
//! Choices where implementations differ, all of them RESCO's:
//! - **Only the pair counts**, even if the phase serves more movements.
//! - **A lane that both movements of the pair share counts twice**, which happens in three of RESCO's
//!   scenarios: where a phase serves one approach alone, from a lane for through and left, it looks
//!   twice as urgent as it is.
//!   A signal whose phases are named by all movements that they serve, which RESCO's never are, counts
//!   each lane once: else a lane would count as often as it has turns.
//! - **Queues are not weighted** by saturation flow or turning share; compare
//!   [`max_pressure`](super::max_pressure).
//! - **Ties** go to the first phase; an empty intersection gets phase 0.
//! - **No hysteresis** and no least green of its own; the limits of the signal hold.
//!
//! Source: RESCO, agents/maxpressure.py.

use super::{
    ControlError, Controller, Drive, GreenPhase, Movement, Observation, Phase, Setup, SignalSpec,
};
use evaluation::run::method::{Method, Training};
use evaluation::settings::setting::NoSettings;

/// The method.
pub const METHOD: Method = Method {
    summary: "the phase whose two main movements have the longest queues (RESCO)",
    ..Method::built_in("max-pressure-resco", Training::None, "#0011dd")
};

/// Returns max pressure with RESCO's rule.
pub fn create(_config: &NoSettings, _setup: &Setup) -> Box<dyn Controller> {
    Box::new(MaxPressureResco::default())
}

/// Movements that name a phase in RESCO.
const RESCO_MOVEMENTS: usize = 2;

/// Max pressure with RESCO's rule.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MaxPressureResco {
    signals: Vec<SignalSpec>,
    /// Movements whose lanes count, per signal and phase, merged where a lane is to count once.
    phases: Vec<Vec<Vec<Movement>>>,
}

impl Controller for MaxPressureResco {
    fn name(&self) -> &'static str {
        METHOD.name
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        if self.signals != signals {
            self.signals = signals.to_vec();
            let counted = |s: &SignalSpec| {
                let merge = s.phases.iter().any(|p| p.pair.len() > RESCO_MOVEMENTS);
                s.phases.iter().map(|p| counted(s, p, merge)).collect()
            };
            self.phases = signals.iter().map(counted).collect();
        }
        Ok(vec![Drive::Decisions; signals.len()])
    }

    fn act(
        &mut self,
        observations: &[Observation],
        phases: &mut [GreenPhase],
    ) -> Result<(), ControlError> {
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
        Ok(())
    }
}

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
    use super::super::testing::{observation, signal_with, two_phase_signal};
    use super::super::{LaneObservation, Light};
    use super::*;

    fn choice(queues: [f64; 2], downstream: [f64; 2]) -> GreenPhase {
        let mut controller = MaxPressureResco::default();
        controller.begin(&[two_phase_signal()]).unwrap();
        let mut phases = [GreenPhase(9)];
        controller.act(&[observation(queues, downstream)], &mut phases).unwrap();
        phases[0]
    }

    #[test]
    fn the_longer_queue_is_served_unless_its_exit_is_blocked_and_ties_go_to_the_first_phase() {
        for (queues, downstream, phase) in [
            ([2.0, 3.0], [0.0, 0.0], 1),
            ([3.0, 9.0], [0.0, 9.0], 0),
            ([0.0, 0.0], [0.0, 0.0], 0),
            ([4.0, 4.0], [0.0, 0.0], 0),
        ] {
            assert_eq!(choice(queues, downstream), GreenPhase(phase), "{queues:?}");
        }
    }

    #[test]
    fn a_shared_lane_counts_twice() {
        // Phase 0 has two movements of one lane, phase 1 two movements with lanes of their own.
        let mut signal = signal_with(&[
            [Light::Protected, Light::Protected, Light::Red, Light::Red],
            [Light::Red, Light::Red, Light::Protected, Light::Protected],
        ]);
        signal.movements[1].lanes = vec![0];
        let mut seen = observation([5.0, 0.0], [0.0, 0.0]);
        let lane = |queue| LaneObservation { queue, ..LaneObservation::default() };
        seen.lanes.extend([lane(4.0), lane(3.0)]);
        let mut controller = MaxPressureResco::default();
        controller.begin(std::slice::from_ref(&signal)).unwrap();
        let mut phases = [GreenPhase(9)];
        controller.act(std::slice::from_ref(&seen), &mut phases).unwrap();
        assert_eq!(phases[0], GreenPhase(0), "10 against 7");
    }

    #[test]
    fn a_lane_counts_once_where_phases_are_named_by_all_that_they_serve() {
        // Phase 0 serves three turns of one lane, phase 1 two lanes.
        let mut signal = signal_with(&[
            [Light::Protected, Light::Protected, Light::Protected, Light::Red],
            [Light::Red, Light::Red, Light::Red, Light::Protected],
        ]);
        signal.phases[0].pair = vec![0, 1, 2];
        signal.movements[1].lanes = vec![0];
        signal.movements[2].lanes = vec![0];
        signal.movements[3].lanes = vec![1];
        let mut controller = MaxPressureResco::default();
        controller.begin(std::slice::from_ref(&signal)).unwrap();
        let mut phases = [GreenPhase(9)];
        controller.act(&[observation([3.0, 4.0], [0.0, 0.0])], &mut phases).unwrap();
        assert_eq!(phases[0], GreenPhase(1));
    }
}

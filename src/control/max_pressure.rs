//! Max-pressure control (Varaiya, 2013), as RESCO runs it.
//!
//! Serves the phase whose two movements have the largest *pressure*: vehicles queued upstream
//! minus vehicles queued downstream. Needs no demand forecast and no training.
//!
//! Choices where implementations differ (all RESCO's):
//! - **Counts** vehicles that have halted within 200 m, not all vehicles on the lane.
//! - **Two movements per phase** count, even if the phase also serves right turns or permissive
//!   lefts.
//! - **Ties** go to the first phase; an empty intersection gets phase 0.
//! - **No hysteresis** and no minimum green beyond the decision interval.
//!
//! Source: P. Varaiya, "Max pressure control of a network of signalized intersections",
//! Transportation Research Part C 36 (2013), 177-195; RESCO, agents/maxpressure.py.

use super::{ControlError, Controller, Drive, GreenPhase, Observation, SignalSpec};

/// Max-pressure control.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MaxPressure {
    signals: Vec<SignalSpec>,
}

impl MaxPressure {
    /// Name of the method.
    pub const NAME: &'static str = "max-pressure";
}

impl Controller for MaxPressure {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        if self.signals != signals {
            self.signals = signals.to_vec();
        }
        Ok(vec![Drive::Decisions; signals.len()])
    }

    fn act(&mut self, observations: &[Observation], phases: &mut [GreenPhase]) {
        for ((signal, observation), phase) in
            self.signals.iter().zip(observations).zip(phases.iter_mut())
        {
            let mut best = f64::NEG_INFINITY;
            for (i, candidate) in signal.phases.iter().enumerate() {
                let pressure: f64 = candidate
                    .pair
                    .iter()
                    .map(|m| observation.pressure(&signal.movements[*m]))
                    .sum();
                if pressure > best {
                    best = pressure;
                    *phase = GreenPhase(i);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{observation, two_phase_signal};
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
    fn ties_and_an_empty_intersection_go_to_the_first_phase() {
        assert_eq!(choice([0.0, 0.0], [0.0, 0.0]), GreenPhase(0));
        assert_eq!(choice([4.0, 4.0], [0.0, 0.0]), GreenPhase(0));
    }
}

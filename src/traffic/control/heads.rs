//! What is known of the first vehicle on each lane of a signal: which movements it does not make.
//!
//! Movements that share a lane leave it one vehicle after the other. A phase that serves some of them alone
//! lets vehicles go until the first one that it does not serve; then nothing moves on that lane, however long its
//! queue is and however long the phase lasts. Nobody sees where the first vehicle wants to go, but one that has stood
//! through a whole interval of green makes none of the movements that had it.

use super::{LaneObservation, Light, Observation, SignalSpec};

/// Least by which waiting grows between two decisions if the vehicle that has waited longest is still there, as a
/// part of the interval; it grows by all of it or by less than a second less.
const SAME_VEHICLE: f64 = 0.95;

/// What is known of the first vehicles of a signal's lanes.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Heads {
    /// What the last decision saw: the phase and the lanes.
    last: Option<(usize, Vec<LaneObservation>)>,
    /// Whether the first vehicle of a lane (row) is known not to make a movement (column).
    excluded: Vec<Vec<bool>>,
}

impl Heads {
    /// Returns what is known before anything was seen.
    pub(super) fn new(signal: &SignalSpec) -> Self {
        Self { last: None, excluded: vec![vec![false; signal.movements.len()]; signal.lanes.len()] }
    }

    /// Takes in what was seen at a decision, `decision_s` after the one before.
    pub(super) fn update(&mut self, signal: &SignalSpec, seen: &Observation, decision_s: f64) {
        let last = self.last.replace((seen.phase, seen.lanes.clone()));
        let Some((phase, lanes)) = last else { return };
        for (lane, excluded) in self.excluded.iter_mut().enumerate() {
            let waited = seen.lanes[lane].max_wait_s - lanes[lane].max_wait_s;
            if lanes[lane].max_wait_s <= 0.0 || waited < SAME_VEHICLE * decision_s {
                excluded.fill(false);
            } else if phase == seen.phase {
                // Green from the first second to the last, with right of way.
                let mut of_lane = Vec::new();
                for (m, movement) in signal.movements.iter().enumerate() {
                    if movement.lanes.contains(&lane) {
                        excluded[m] |= signal.phases[phase].service[m] == Light::Protected;
                        of_lane.push(m);
                    }
                }
                // It is the exit that is blocked, and nothing is known of the vehicle.
                if of_lane.iter().all(|m| excluded[*m]) {
                    excluded.fill(false);
                }
            }
        }
    }

    /// Whether the first vehicle of a lane makes none of the movements that a phase serves there.
    pub(super) fn stands(&self, signal: &SignalSpec, phase: usize, lane: usize) -> bool {
        let service = signal.phases[phase].service.iter();
        let mut served = signal.movements.iter().zip(service).zip(&self.excluded[lane]).filter(
            |((movement, light), _)| **light != Light::Red && movement.lanes.contains(&lane),
        );
        served.all(|(_, excluded)| *excluded)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::signal_with;
    use super::*;

    use Light::{Protected as G, Red as N};

    /// One lane for through (phase 0) and left (both phases), and what is seen of it.
    fn shared() -> SignalSpec {
        let mut signal = signal_with(&[[G, G], [N, G]]);
        signal.movements[1].lanes = vec![0];
        signal.lanes.truncate(1);
        signal
    }

    fn seen(phase: usize, max_wait_s: f64) -> Observation {
        let lane = LaneObservation { queue: 3.0, max_wait_s, ..LaneObservation::default() };
        Observation { phase, lanes: vec![lane], seen: vec![0.0; 2], ..Observation::default() }
    }

    /// Whether the first vehicle stands in either phase after these phases and longest waits.
    fn after(steps: &[(usize, f64)]) -> [bool; 2] {
        let signal = shared();
        let mut heads = Heads::new(&signal);
        steps.iter().for_each(|(p, w)| heads.update(&signal, &seen(*p, *w), 10.0));
        [0, 1].map(|phase| heads.stands(&signal, phase, 0))
    }

    #[test]
    fn a_vehicle_that_stood_through_a_whole_green_makes_another_movement() {
        assert_eq!(after(&[(1, 5.0), (1, 15.0)]), [false, true]);
    }

    #[test]
    fn nothing_is_known_before_the_first_interval_or_when_the_green_has_just_begun() {
        assert_eq!(after(&[(1, 5.0)]), [false, false]);
        assert_eq!(after(&[(0, 5.0), (1, 15.0)]), [false, false]);
        assert_eq!(after(&[(1, 0.0), (1, 3.0)]), [false, false]);
    }

    #[test]
    fn it_is_remembered_through_other_phases_until_the_vehicle_leaves() {
        let mut signal = shared();
        signal.phases[0].service = vec![N, N];
        let mut heads = Heads::new(&signal);
        for (phase, wait) in [(1, 5.0), (1, 15.0), (0, 25.0), (1, 35.0)] {
            heads.update(&signal, &seen(phase, wait), 10.0);
        }
        assert!(heads.stands(&signal, 1, 0));
        heads.update(&signal, &seen(1, 41.0), 10.0);
        assert!(!heads.stands(&signal, 1, 0), "it grew by 6 s in 10, so another one waits longest");
    }

    #[test]
    fn where_every_movement_had_green_and_nothing_moved_the_exit_is_blocked() {
        assert_eq!(after(&[(0, 5.0), (0, 15.0)]), [false, false]);
    }
}

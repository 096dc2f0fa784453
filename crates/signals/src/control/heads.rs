//! What is known of the first vehicle on each lane of a signal: which movements it does not make.
//!
//! Movements that share a lane leave it one vehicle after the other. A phase that serves some of them alone
//! lets vehicles go until the first one that it does not serve; then nothing moves on that lane, however long its
//! queue is and however long the phase lasts. Nobody sees where the first vehicle wants to go, but one that has stood
//! through a whole interval of green makes none of the movements that had it. The phase that is seen is the one that
//! was asked for, also during the change to it, so an interval is one of green only once the change is over.

use super::{LaneObservation, Light, Observation, Phase, SignalSpec};

/// Least by which waiting grows between two decisions if the vehicle that has waited longest is still there, as a
/// part of the interval; it grows by all of it or by less than a second less.
const SAME_VEHICLE: f64 = 0.95;

/// What is known of the first vehicles of a signal's lanes.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Heads {
    /// What the last decision saw: the phase and the lanes.
    last: Option<(usize, Vec<LaneObservation>)>,
    /// Time since the decision for the phase that is seen, seconds.
    asked_s: f64,
    /// Time that the change to it takes, seconds.
    change_s: f64,
    /// Whether the first vehicle of a lane (row) is known not to make a movement (column).
    excluded: Vec<Vec<bool>>,
}

impl Heads {
    /// Returns what is known before anything was seen.
    pub(super) fn new(signal: &SignalSpec) -> Self {
        let excluded = vec![vec![false; signal.movements.len()]; signal.lanes.len()];
        Self { excluded, ..Self::default() }
    }

    /// Takes in what was seen at a decision, `decision_s` after the one before.
    pub(super) fn update(&mut self, signal: &SignalSpec, seen: &Observation, decision_s: f64) {
        let last = self.last.replace((seen.phase, seen.lanes.clone()));
        let Some((phase, lanes)) = last else { return };
        if phase == seen.phase {
            self.asked_s += decision_s;
        } else {
            self.asked_s = decision_s;
            self.change_s = signal.limits.change_s[phase][seen.phase];
        }
        let was_green = phase == seen.phase && self.asked_s >= self.change_s + decision_s;
        let green = |phase: &Phase, m: usize| phase.service[m] != Light::Red;
        for (lane, excluded) in self.excluded.iter_mut().enumerate() {
            let waited = seen.lanes[lane].max_wait_s - lanes[lane].max_wait_s;
            if lanes[lane].max_wait_s <= 0.0 || waited < SAME_VEHICLE * decision_s {
                excluded.fill(false);
            } else if was_green {
                // Green from the first second to the last. A vehicle that only had to wait for a gap is taken for one of
                // another movement, which costs it a green.
                let of_lane = |m: &usize| signal.movements[*m].lanes.contains(&lane);
                let of_lane = (0..signal.movements.len()).filter(of_lane);
                of_lane.clone().for_each(|m| excluded[m] |= green(&signal.phases[phase], m));
                // None is left that ever has green: the exit is blocked, and nothing is known of the vehicle.
                let mut left = of_lane.filter(|m| !excluded[*m]);
                if !left.any(|m| signal.phases.iter().any(|phase| green(phase, m))) {
                    excluded.fill(false);
                }
            }
        }
    }

    /// Divides lanes anew, as parts per movement and lane of it: among the movements that the first vehicle may make.
    pub(super) fn divide(&self, signal: &SignalSpec, parts: &mut [Vec<f64>]) {
        for (lane, excluded) in self.excluded.iter().enumerate().filter(|(_, e)| e.contains(&true))
        {
            let mut of_lane = Vec::new();
            for ((movement, parts), excluded) in
                signal.movements.iter().zip(&mut *parts).zip(excluded)
            {
                if let Some(i) = movement.lanes.iter().position(|l| *l == lane) {
                    if *excluded {
                        parts[i] = 0.0;
                    }
                    of_lane.push(&mut parts[i]);
                }
            }
            let total: f64 = of_lane.iter().map(|part| **part).sum();
            of_lane.into_iter().for_each(|part| *part /= total);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::signal_with;
    use super::*;

    use Light::{Protected as G, Red as N};

    /// One lane for through (phase 0), left (phases 0 and 1) and a movement that never has green.
    fn shared() -> SignalSpec {
        let mut signal = signal_with(&[[G, G, N], [N, G, N], [N, N, N]]);
        signal.movements.iter_mut().for_each(|m| m.lanes = vec![0]);
        signal.lanes.truncate(1);
        signal
    }

    fn seen(phase: usize, max_wait_s: f64) -> Observation {
        let lane = LaneObservation { queue: 3.0, max_wait_s, ..LaneObservation::default() };
        Observation { phase, lanes: vec![lane], seen: vec![0.0; 3], ..Observation::default() }
    }

    /// How a lane of 0.5, 0.3 and 0.2 is divided after these phases and longest waits.
    fn after(steps: &[(usize, f64)]) -> [f64; 3] {
        let signal = shared();
        let mut heads = Heads::new(&signal);
        steps.iter().for_each(|(p, w)| heads.update(&signal, &seen(*p, *w), 10.0));
        let mut parts = [0.5, 0.3, 0.2].map(|part| vec![part]);
        heads.divide(&signal, &mut parts);
        parts.map(|part| (part[0] * 1e6).round() / 1e6)
    }

    const NOTHING: [f64; 3] = [0.5, 0.3, 0.2];
    const NOT_LEFT: [f64; 3] = [0.714286, 0.0, 0.285714];

    #[test]
    fn a_vehicle_that_stood_through_a_whole_green_makes_another_movement() {
        assert_eq!(after(&[(1, 5.0), (1, 15.0)]), NOT_LEFT);
    }

    #[test]
    fn nothing_is_known_before_the_first_interval_or_when_the_green_has_just_begun() {
        assert_eq!(after(&[(1, 5.0)]), NOTHING);
        assert_eq!(after(&[(0, 5.0), (1, 15.0)]), NOTHING);
        assert_eq!(after(&[(1, 0.0), (1, 3.0)]), NOTHING);
    }

    #[test]
    fn with_decisions_faster_than_changes_nothing_is_known_before_the_first_second_of_green() {
        let mut signal = shared();
        signal.limits.change_s[2][1] = 4.0;
        let mut heads = Heads::new(&signal);
        heads.update(&signal, &seen(2, 5.0), 1.0);
        // Asked for at second 0, green from 4 s on.
        for second in 1..5 {
            heads.update(&signal, &seen(1, 5.0 + f64::from(second)), 1.0);
            assert!(!heads.excluded[0].contains(&true), "{second} s");
        }
        heads.update(&signal, &seen(1, 10.0), 1.0);
        assert_eq!(heads.excluded[0], [false, true, false]);
    }

    #[test]
    fn it_is_remembered_through_other_phases_until_the_vehicle_leaves() {
        let stood = [(1, 5.0), (1, 15.0), (2, 25.0), (1, 35.0)];
        assert_eq!(after(&stood), NOT_LEFT);
        // It grew by 6 s in 10, so another one waits longest.
        assert_eq!(after(&[&stood[..], &[(1, 41.0)]].concat()), NOTHING);
    }

    #[test]
    fn where_every_movement_had_green_that_ever_has_and_nothing_moved_the_exit_is_blocked() {
        assert_eq!(after(&[(0, 5.0), (0, 15.0)]), NOTHING);
    }
}

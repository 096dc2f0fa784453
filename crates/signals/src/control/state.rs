//! What learners see and what they are paid for.
//!
//! Source: RESCO, states.py and rewards.py.

use super::{Observation, SignalSpec};

/// Divisor of vehicle counts and waiting times in a state.
const SCALE: f64 = 28.0;

/// Divisor of speeds in a state, metres per second, before [`SCALE`].
const SPEED_SCALE_MPS: f64 = 20.0;

/// Divisor of the waiting time in a reward, seconds.
const WAIT_REWARD_SCALE_S: f64 = 224.0;

/// Largest size of the reward for waiting.
const WAIT_REWARD_LIMIT: f64 = 4.0;

/// Numbers per lane of [`lanes`].
pub const LANE_WIDTH: usize = 5;

/// Fewest lanes of [`lanes`]: the convolution takes two at a time.
const MIN_LANES: usize = 2;

/// Returns the number of rows of [`lanes`]: one per lane, and as many more as there are further phases.
pub fn lane_rows(signal: &SignalSpec) -> usize {
    signal.lanes.len().max(signal.phases.len()).max(MIN_LANES)
}

/// Writes a row per lane: whether the lane's number is that of the current phase, approaching
/// vehicles, waiting time, queue, and speeds, all scaled. RESCO calls it `drq_norm`.
///
/// Deviation: a signal with more phases than lanes gets empty rows that can only mark the phase; in RESCO
/// the mark is lost there. So does one with a single lane get a second row.
pub fn lanes(signal: &SignalSpec, seen: &Observation, state: &mut Vec<f32>) {
    state.clear();
    for (i, lane) in seen.lanes.iter().enumerate() {
        state.extend([
            f32::from(u8::from(i == seen.phase)),
            (lane.approach / SCALE) as f32,
            (lane.total_wait_s / SCALE) as f32,
            (lane.queue / SCALE) as f32,
            (lane.total_speed_mps / SPEED_SCALE_MPS / SCALE) as f32,
        ]);
    }
    state.resize(lane_rows(signal) * LANE_WIDTH, 0.0);
    if seen.phase >= seen.lanes.len() && seen.phase < lane_rows(signal) {
        state[seen.phase * LANE_WIDTH] = 1.0;
    }
}

/// Returns the reward for waiting: the waiting time of all lanes, scaled and cut. RESCO calls it
/// `wait_norm`.
pub fn wait_reward(seen: &Observation) -> f32 {
    let total_s: f64 = seen.lanes.iter().map(|lane| lane.total_wait_s).sum();
    (-total_s / WAIT_REWARD_SCALE_S).clamp(-WAIT_REWARD_LIMIT, WAIT_REWARD_LIMIT) as f32
}

/// Returns the reward for pressure: queues at the signal less queues at the next ones.
pub fn pressure_reward(seen: &Observation) -> f32 {
    let upstream: f64 = seen.lanes.iter().map(|lane| lane.queue).sum();
    let downstream: f64 = seen.downstream_queue.iter().sum();
    (downstream - upstream) as f32
}

/// Returns how many movements a signal's numbering has room for: three per arm, four arms at least.
pub fn movement_slots(signal: &SignalSpec) -> usize {
    let arms = signal.movements.iter().map(|m| m.index / 3 + 1).max().unwrap_or(0);
    3 * arms.max(4)
}

/// Writes the pressure of every movement into `demand`, one number each.
pub fn pressures(signal: &SignalSpec, seen: &Observation, demand: &mut [f32]) {
    for movement in &signal.movements {
        demand[movement.index] = seen.pressure(movement) as f32;
    }
}

/// Numbers per movement of [`full_demand`].
pub const FULL_WIDTH: usize = 4;

/// Writes four numbers per movement into `demand`: pressure, waiting time, speeds and approaching
/// vehicles. RESCO calls it `mplight_full`.
///
/// RESCO adds up speeds anew for every lane, so that only those of a movement's last lane remain;
/// `all_lanes` keeps all of them.
fn full_demand(signal: &SignalSpec, seen: &Observation, all_lanes: bool, demand: &mut [f32]) {
    for movement in &signal.movements {
        let lanes = || movement.lanes.iter().map(|l| &seen.lanes[*l]);
        let skipped = if all_lanes { 0 } else { movement.lanes.len().saturating_sub(1) };
        let speed_mps: f64 = lanes().skip(skipped).map(|l| l.total_speed_mps).sum();
        let wait_s: f64 = lanes().map(|l| l.total_wait_s).sum();
        let approach: f64 = lanes().map(|l| l.approach).sum();
        demand[movement.index * FULL_WIDTH..][..FULL_WIDTH].copy_from_slice(&[
            seen.pressure(movement) as f32,
            (wait_s / SCALE) as f32,
            speed_mps as f32,
            (approach / SCALE) as f32,
        ]);
    }
}

/// What the network sees of movements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Demand {
    /// A number per movement, its pressure.
    Pressure,
    /// Four numbers per movement.
    Full {
        /// Whether speeds of all lanes of a movement count.
        all_lanes: bool,
    },
}

impl Demand {
    /// Numbers that a movement reads.
    pub(super) fn width(self) -> usize {
        match self {
            Self::Pressure => 1,
            Self::Full { .. } => FULL_WIDTH,
        }
    }

    /// Writes the numbers of all movements.
    pub(super) fn write(self, signal: &SignalSpec, seen: &Observation, demand: &mut [f32]) {
        match self {
            Self::Pressure => pressures(signal, seen, demand),
            Self::Full { all_lanes } => full_demand(signal, seen, all_lanes, demand),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::two_phase_signal;
    use osm_signals::Turn;

    use super::super::{LaneObservation, Movement};
    use super::*;

    fn seen() -> Observation {
        let lane = |queue, approach, total_wait_s, total_speed_mps| LaneObservation {
            queue,
            approach,
            total_wait_s,
            max_wait_s: 0.0,
            total_speed_mps,
        };
        Observation {
            phase: 1,
            lanes: vec![lane(2.0, 3.0, 56.0, 40.0), lane(7.0, 0.0, 700.0, 0.0)],
            downstream_queue: vec![1.0, 0.0],
            seen: vec![0.0; 2],
        }
    }

    #[test]
    fn lanes_are_scaled_as_in_resco() {
        let mut state = vec![9.0];
        lanes(&two_phase_signal(), &seen(), &mut state);
        let row = [0.0, 3.0 / 28.0, 2.0, 2.0 / 28.0, 2.0 / 28.0];
        assert_eq!(state, [row, [1.0, 0.0, 25.0, 0.25, 0.0]].concat());
        // A single lane gets an empty second one.
        let (mut signal, mut one) = (two_phase_signal(), Observation { phase: 0, ..seen() });
        signal.lanes.truncate(1);
        one.lanes.truncate(1);
        lanes(&signal, &one, &mut state);
        assert_eq!((state.len(), &state[5..]), (10, &[0.0; 5][..]));
    }

    #[test]
    fn a_phase_beyond_the_lanes_is_marked_in_a_row_of_its_own() {
        let mut signal = two_phase_signal();
        signal.phases = vec![signal.phases[0].clone(); 6];
        let mut state = Vec::new();
        lanes(&signal, &Observation { phase: 4, ..seen() }, &mut state);
        let marks: Vec<f32> = state.iter().step_by(LANE_WIDTH).copied().collect();
        assert_eq!(marks, [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    }

    #[test]
    fn rewards_are_waiting_and_pressure() {
        assert_eq!(wait_reward(&seen()), -3.375);
        let mut long = seen();
        long.lanes[0].total_wait_s = 5000.0;
        assert_eq!(wait_reward(&long), -4.0);
        assert_eq!(pressure_reward(&seen()), -8.0);
    }

    #[test]
    fn demand_is_laid_out_by_resco_s_numbers_of_movements() {
        let mut signal = two_phase_signal();
        // A movement of both lanes: only the last one's speed counts, unless asked otherwise.
        signal.movements.push(Movement {
            index: 11,
            turn: Turn::Left,
            lanes: vec![1, 0],
            downstream: vec![],
            inner: vec![],
            share: None,
        });
        assert_eq!(movement_slots(&signal), 12);
        let mut demand = vec![0.0; 12];
        pressures(&signal, &seen(), &mut demand);
        assert_eq!((demand[1], demand[4], demand[11]), (1.0, 7.0, 9.0));
        let mut demand = vec![0.0; 48];
        full_demand(&signal, &seen(), false, &mut demand);
        assert_eq!(demand[4..8], [1.0, 2.0, 40.0, 3.0 / 28.0]);
        assert_eq!(demand[44..], [9.0, 27.0, 40.0, 3.0 / 28.0]);
        signal.movements[2].lanes = vec![0, 1];
        full_demand(&signal, &seen(), false, &mut demand);
        assert_eq!(demand[46], 0.0);
        full_demand(&signal, &seen(), true, &mut demand);
        assert_eq!(demand[46], 40.0);
    }
}

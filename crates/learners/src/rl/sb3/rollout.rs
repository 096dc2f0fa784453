//! Steps played for one update.

use crate::nn::state::{State, kept};
use crate::rl::environment::{Environment, Step};
use crate::rl::random::Generator;
use crate::rl::sb3::Lanes;
use crate::rl::sb3::actor_critic::ActorCritic;
use crate::rl::spread;

/// States of one forward pass, which bounds the memory of its buffers.
const ROWS: usize = 256;

/// How a step ends: the episode goes on, is over with a state that is worth nothing, or is cut with one that has its value.
const GOES_ON: f32 = 0.0;
const TERMINAL: f32 = 1.0;
const CUT: f32 = 2.0;

/// Steps of all environments, those of one after those of the other, in the order of time.
#[derive(Debug, Clone)]
pub(in crate::rl) struct Rollout {
    width: usize,
    num_steps: usize,
    action_width: usize,
    filled: usize,
    states: Vec<f32>,
    /// Actions as they were drawn, before they were cut to what the environment allows.
    actions: Vec<f32>,
    rewards: Vec<f32>,
    logs: Vec<f32>,
    nexts: Vec<f32>,
    ends: Vec<f32>,
    pub(super) advantages: Vec<f32>,
    /// What the value of each state is to become.
    returns: Vec<f32>,
    /// States after steps that were cut.
    after: Vec<f32>,
}

#[derive(Debug, Clone, Default)]
pub(super) struct Batch {
    pub(super) states: Vec<f32>,
    pub(super) actions: Vec<f32>,
    pub(super) logs: Vec<f32>,
    pub(super) advantages: Vec<f32>,
    pub(super) returns: Vec<f32>,
    pub(super) by_outputs: Vec<f32>,
    pub(super) by_log_std: Vec<f32>,
    pub(super) by_values: Vec<f32>,
}

impl Batch {
    /// Takes the steps at these places, after [`Rollout::estimate`].
    pub(super) fn gather(&mut self, rollout: &Rollout, places: &[usize]) {
        let Self { states, actions, logs, advantages, returns, .. } = self;
        [&mut *states, actions, logs, advantages, returns].into_iter().for_each(Vec::clear);
        for place in places.iter().copied() {
            states.extend_from_slice(rollout.state(place));
            actions.extend_from_slice(
                &rollout.actions[place * rollout.action_width..][..rollout.action_width],
            );
            logs.push(rollout.logs[place]);
            advantages.push(rollout.advantages[place]);
            returns.push(rollout.returns[place]);
        }
    }
}

impl Rollout {
    pub(in crate::rl) fn new(
        lanes: usize,
        num_steps: usize,
        width: usize,
        action_width: usize,
    ) -> Self {
        let count = lanes * num_steps;
        Self {
            width,
            num_steps,
            action_width,
            filled: 0,
            states: vec![0.0; count * width],
            actions: vec![0.0; count * action_width],
            rewards: vec![0.0; count],
            logs: vec![0.0; count],
            nexts: vec![0.0; count * width],
            ends: vec![GOES_ON; count],
            advantages: vec![0.0; count],
            returns: vec![0.0; count],
            after: Vec::new(),
        }
    }

    #[cfg(test)]
    pub(super) fn of([states, actions, logs, advantages, returns]: [Vec<f32>; 5]) -> Self {
        let count = returns.len();
        let (width, action_width) = (states.len() / count, actions.len() / count);
        let new = Self::new(1, count, width, action_width);
        Self { states, actions, logs, advantages, returns, ..new }
    }

    pub(in crate::rl) fn probes(&self) -> Vec<f32> {
        spread(self.filled).flat_map(|place| self.state(place)).copied().collect()
    }

    fn state(&self, place: usize) -> &[f32] {
        &self.states[place * self.width..][..self.width]
    }

    pub(super) fn len(&self) -> usize {
        self.rewards.len()
    }

    pub(super) fn collect<E: Environment>(
        &mut self,
        networks: &mut ActorCritic,
        lanes: &mut Lanes<E>,
        sampling: &mut Generator,
        seeds: &mut dyn FnMut(u32) -> u64,
    ) {
        lanes.begin(seeds);
        let mut next = vec![0.0; self.width];
        let [mut action, mut done] = [vec![0.0; self.action_width], vec![0.0; self.action_width]];
        for time in 0..self.num_steps {
            for lane in 0..lanes.count() {
                let place = lane * self.num_steps + time;
                let state = lanes.observation(lane);
                self.states[place * self.width..][..self.width].copy_from_slice(state);
                let log = networks.draw(state, sampling, &mut action);
                done.copy_from_slice(&action);
                networks.distribution.cut(&mut done);
                let step = lanes.step(lane, &done, &mut next, seeds);
                self.keep(place, &action, log, step, &next);
            }
        }
        self.filled = self.len();
    }

    /// Of a step that somebody else has played; returns whether the steps of an update are complete.
    pub(in crate::rl) fn push(
        &mut self,
        state: &[f32],
        action: &[f32],
        step: Step,
        next: &[f32],
    ) -> bool {
        self.states[self.filled * self.width..][..self.width].copy_from_slice(state);
        self.keep(self.filled, action, 0.0, step, next);
        self.filled += 1;
        self.filled == self.len()
    }

    pub(in crate::rl) fn clear(&mut self) {
        self.filled = 0;
    }

    /// Keeps what was done in a state and came of it; the last step of a lane is cut.
    fn keep(&mut self, place: usize, action: &[f32], log: f32, step: Step, next: &[f32]) {
        self.actions[place * self.action_width..][..self.action_width].copy_from_slice(action);
        self.nexts[place * self.width..][..self.width].copy_from_slice(next);
        self.logs[place] = log;
        self.rewards[place] = step.reward;
        self.ends[place] = match step {
            Step { terminated: true, .. } => TERMINAL,
            Step { truncated: true, .. } => CUT,
            _ if (place + 1).is_multiple_of(self.num_steps) => CUT,
            _ => GOES_ON,
        };
    }

    /// Estimates the advantage of every step (generalised, Schulman et al., 2016), and what the values are to become.
    /// `A_t = sum_k (gamma lambda)^k (r_{t+k} + gamma V_{t+k+1} - V_{t+k})`, the sum ending with the episode or the steps.
    pub(in crate::rl) fn estimate(&mut self, networks: &mut ActorCritic, gamma: f32, lambda: f32) {
        self.returns.clear();
        for rows in self.states.chunks(ROWS * self.width) {
            let place = self.returns.len();
            self.returns.extend_from_slice(networks.values(rows));
            let actions = &self.actions[place * self.action_width..];
            networks.logs(actions, &mut self.logs[place..]);
        }
        let cuts: Vec<usize> = (0..self.len()).filter(|place| self.ends[*place] == CUT).collect();
        let mut values_of_cuts = Vec::with_capacity(cuts.len());
        for places in cuts.chunks(ROWS) {
            let next = |place: &usize| &self.nexts[place * self.width..][..self.width];
            self.after.clear();
            self.after.extend(places.iter().flat_map(next));
            values_of_cuts.extend_from_slice(networks.values(&self.after));
        }
        let mut later = 0.0;
        for place in (0..self.len()).rev() {
            let next_value = match self.ends[place] {
                GOES_ON => self.returns[place + 1],
                CUT => values_of_cuts.pop().expect("a value per cut"),
                _ => 0.0,
            };
            if self.ends[place] != GOES_ON {
                later = 0.0;
            }
            let error = self.rewards[place] + gamma * next_value - self.returns[place];
            later = error + gamma * lambda * later;
            self.advantages[place] = later;
        }
        self.returns.iter_mut().zip(&self.advantages).for_each(|(v, a)| *v += a);
    }
}

impl State for Rollout {
    kept! { State {
        "filled": filled, "states": states, "actions": actions, "rewards": rewards, "nexts": nexts, "ends": ends,
    } }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rl::environment::Actions;

    #[test]
    fn advantages_know_ends_cuts_and_lanes() {
        let mut networks = ActorCritic::new(1, Actions::Numbered(2), 8, 1e-5, 1);
        let states = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6];
        let mut value = |state: f32| networks.values(&[state])[0];
        let v = states.map(&mut value);
        let (cut, next) = (value(0.9), value(0.7));
        let none = Step { reward: 1.0, terminated: false, truncated: false };
        let mut rollout = Rollout::new(2, 3, 1, 1);
        // First lane: a step, then the end, then a step whose episode goes on in 0.7. Second lane: a step that
        // is cut in 0.9, then a step, then an end at the horizon, which is an end.
        let ends = [
            none,
            Step { terminated: true, ..none },
            none,
            Step { truncated: true, ..none },
            none,
            Step { terminated: true, truncated: true, ..none },
        ];
        for (place, step) in ends.into_iter().enumerate() {
            let next = if place == 2 { 0.7 } else { 0.9 };
            rollout.push(&states[place..=place], &[0.0], step, &[next]);
        }
        rollout.estimate(&mut networks, 0.5, 0.5);
        let error = |next: f32, value: f32| 1.0 + 0.5 * next - value;
        let (end, last) = (error(0.0, v[1]), error(0.0, v[5]));
        let expected = [
            error(v[1], v[0]) + 0.25 * end,
            end,
            error(next, v[2]),
            error(cut, v[3]),
            error(v[5], v[4]) + 0.25 * last,
            last,
        ];
        for (place, expected) in expected.into_iter().enumerate() {
            assert!((rollout.advantages[place] - expected).abs() < 1e-6, "{place}");
            assert!((rollout.returns[place] - expected - v[place]).abs() < 1e-6, "{place}");
        }
    }
}

//! Steps played for one update.

use crate::rl::environment::{Environment, Step};
use crate::rl::gae::{self, advantages};
use crate::rl::persist::spread;
use crate::rl::random::Generator;
use crate::rl::sb3::actor_critic::ActorCritic;
use crate::rl::sb3::lanes::Lanes;

/// States of one forward pass, which bounds the memory of its buffers.
const ROWS: usize = 256;

/// Steps of all environments, those of one after those of the other, in the order of time.
#[derive(Debug, Clone)]
pub(super) struct Rollout {
    width: usize,
    num_steps: usize,
    /// Numbers of an action.
    action_width: usize,
    states: Vec<f32>,
    /// Actions as they were drawn, before they were cut to what the environment allows.
    actions: Vec<f32>,
    rewards: Vec<f32>,
    /// Logarithm of the probability that each action had.
    logs: Vec<f32>,
    terminated: Vec<bool>,
    /// Places of steps that were cut, and the states after them.
    cuts: Vec<usize>,
    after: Vec<f32>,
    steps: Vec<gae::Step>,
    advantages: Vec<f32>,
    /// What the value of each state is to become.
    returns: Vec<f32>,
    /// An action as it was drawn, as it was done, and the state after it.
    action: Vec<f32>,
    done: Vec<f32>,
    next: Vec<f32>,
}

/// What learning needs of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample<'a> {
    pub(super) state: &'a [f32],
    pub(super) action: &'a [f32],
    pub(super) log: f32,
    pub(super) advantage: f32,
    pub(super) value: f32,
}

impl Rollout {
    pub(super) fn new(lanes: usize, num_steps: usize, width: usize, action_width: usize) -> Self {
        let count = lanes * num_steps;
        Self {
            width,
            num_steps,
            states: vec![0.0; count * width],
            action_width,
            actions: vec![0.0; count * action_width],
            action: vec![0.0; action_width],
            done: vec![0.0; action_width],
            next: vec![0.0; width],
            rewards: vec![0.0; count],
            logs: vec![0.0; count],
            terminated: vec![false; count],
            cuts: Vec::new(),
            after: Vec::new(),
            steps: Vec::new(),
            advantages: vec![0.0; count],
            returns: vec![0.0; count],
        }
    }

    /// Returns steps whose advantages and returns are known.
    #[cfg(test)]
    pub(super) fn of([states, actions, logs, advantages, returns]: [Vec<f32>; 5]) -> Self {
        let count = returns.len();
        let (width, action_width) = (states.len() / count, actions.len() / count);
        let new = Self::new(1, count, width, action_width);
        Self { states, actions, logs, advantages, returns, ..new }
    }

    /// Returns some states from all over.
    pub(super) fn probes(&self) -> Vec<f32> {
        let state = |place: usize| &self.states[place * self.width..][..self.width];
        spread(self.len()).flat_map(state).copied().collect()
    }

    pub(super) fn len(&self) -> usize {
        self.rewards.len()
    }

    fn place(&self, lane: usize, time: usize) -> usize {
        lane * self.num_steps + time
    }

    /// Plays the steps of an update.
    pub(super) fn collect<E: Environment>(
        &mut self,
        networks: &mut ActorCritic,
        lanes: &mut Lanes<E>,
        sampling: &mut Generator,
        seeds: &mut dyn FnMut(u32) -> u64,
    ) {
        lanes.begin(seeds);
        self.clear();
        let [mut action, mut done, mut next] =
            [&mut self.action, &mut self.done, &mut self.next].map(std::mem::take);
        for time in 0..self.num_steps {
            for lane in 0..lanes.count() {
                let state = lanes.observation(lane);
                let place = self.place(lane, time);
                self.see(place, state);
                let log = networks.draw(state, sampling, &mut action);
                done.copy_from_slice(&action);
                networks.distribution.cut(&mut done);
                let step = lanes.step(lane, &done, &mut next, seeds);
                self.act(place, &action, log, step, &next);
            }
        }
        (self.action, self.done, self.next) = (action, done, next);
        for lane in 0..lanes.count() {
            self.cut(lane, lanes.observation(lane));
        }
    }

    /// Forgets which steps were cut; all else is written anew.
    fn clear(&mut self) {
        self.cuts.clear();
        self.after.clear();
    }

    /// Keeps the state that a step begins in.
    fn see(&mut self, place: usize, state: &[f32]) {
        self.states[place * self.width..][..self.width].copy_from_slice(state);
    }

    /// Keeps what was done in it.
    fn act(&mut self, place: usize, action: &[f32], log: f32, step: Step, after: &[f32]) {
        self.actions[place * self.action_width..][..self.action_width].copy_from_slice(action);
        self.logs[place] = log;
        self.rewards[place] = step.reward;
        self.terminated[place] = step.terminated;
        if step.truncated && !step.terminated {
            self.cuts.push(place);
            self.after.extend_from_slice(after);
        }
    }

    /// Cuts the episode that a lane is in; its next step begins in `state`.
    fn cut(&mut self, lane: usize, state: &[f32]) {
        let place = self.place(lane, self.num_steps - 1);
        if !self.terminated[place] && !self.cuts.contains(&place) {
            self.cuts.push(place);
            self.after.extend_from_slice(state);
        }
    }

    /// Estimates the advantage of every step, and what the values are to become.
    pub(super) fn estimate(&mut self, networks: &mut ActorCritic, gamma: f32, lambda: f32) {
        self.returns.clear();
        for rows in self.states.chunks(ROWS * self.width) {
            self.returns.extend_from_slice(networks.values(rows));
        }
        let values = &self.returns;
        let following = values.iter().skip(1).copied().chain([0.0]);
        self.steps.clear();
        for (place, next_value) in following.enumerate() {
            let last = self.terminated[place];
            let next_value = if last { 0.0 } else { next_value };
            let (reward, value) = (self.rewards[place], values[place]);
            self.steps.push(gae::Step { reward, value, next_value, last });
        }
        for (places, rows) in self.cuts.chunks(ROWS).zip(self.after.chunks(ROWS * self.width)) {
            for (place, value) in places.iter().zip(networks.values(rows)) {
                self.steps[*place].next_value = *value;
                self.steps[*place].last = true;
            }
        }
        advantages(&self.steps, gamma, lambda, &mut self.advantages);
        self.returns.iter_mut().zip(&self.advantages).for_each(|(v, a)| *v += a);
    }

    /// Returns a step after [`Self::estimate`].
    pub(super) fn sample(&self, place: usize) -> Sample<'_> {
        Sample {
            state: &self.states[place * self.width..][..self.width],
            action: &self.actions[place * self.action_width..][..self.action_width],
            log: self.logs[place],
            advantage: self.advantages[place],
            value: self.returns[place],
        }
    }
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
            rollout.see(place, &states[place..=place]);
            rollout.act(place, &[0.0], 0.0, step, &[0.9]);
        }
        rollout.cut(0, &[0.7]);
        rollout.cut(1, &[0.8]);
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
            let sample = rollout.sample(place);
            assert!((sample.advantage - expected).abs() < 1e-6, "{place}");
            assert!((sample.value - expected - v[place]).abs() < 1e-6, "{place}");
        }
    }
}

//! Deep Q-learning (Mnih et al., 2015), as Stable-Baselines3's `DQN`.
//!
//! Choices where implementations differ:
//! - **Loss**: mean Huber loss (delta 1); the gradient is cut to a norm.
//! - **Batches** are drawn with replacement.
//! - **Updates** come in blocks: after every [`Settings::train_frequency`] steps as many as
//!   [`Settings::gradient_steps`] says, but none before [`Settings::learning_starts`] steps, in which actions
//!   are random.
//! - **Target network**: copied every so many steps, before the updates of that step.
//! - **A cut episode** has the value of the state after it.

use basics::setting::settings;

use super::lanes::Lanes;
use super::off_policy::{Followed, network};
use super::{HIDDEN_LAYERS, Progress, Trainer};
use crate::nn::archive::{Archive, ArchiveError};
use crate::nn::{Activation, Network};
use crate::rl::environment::{Actions, Environment};
use crate::rl::persist::{Persist, depends_on_both};
use crate::rl::random::Generator;
use crate::rl::replay::{Replay, Transition};
use crate::rl::schedule::linear_epsilon;
use crate::rl::values::{huber, largest};

settings! {
    /// Hyper-parameters of `dqn`; the defaults are Stable-Baselines3's, which hardly learn this task.
    pub struct Settings, source "Stable-Baselines3 2.9, DQN" {
        /// Steps of the training.
        total_steps: u64 = 100_000, in 1.0..=1e9, unit "steps",
            source "Jayawardana et al., 2022, give none for this task";
        /// Step size of Adam.
        learning_rate: f32 = 1e-4, in 1e-8..=1.0;
        /// Adam's epsilon, added to the root of the second moment.
        adam_epsilon: f32 = 1e-8, in 1e-12..=1.0;
        /// Discount per step.
        gamma: f32 = 0.99, in 0.0..=1.0;
        /// Steps in the replay buffer.
        buffer_size: usize = 1_000_000, in 1.0..=1e8, unit "steps";
        /// Steps per update, drawn with replacement.
        batch_size: usize = 32, in 1.0..=4096.0, unit "steps";
        /// Steps before the first update, in which actions are random.
        learning_starts: u64 = 100, in 0.0..=1e9, unit "steps";
        /// Steps between two blocks of updates.
        train_frequency: u64 = 4, in 1.0..=1e6, unit "steps";
        /// Updates of a block.
        gradient_steps: u32 = 1, in 1.0..=1e6, unit "updates";
        /// Steps between two copies into the target network.
        target_network_frequency: u64 = 10_000, in 1.0..=1e9, unit "steps";
        /// Share of random actions at the beginning.
        start_epsilon: f64 = 1.0, in 0.0..=1.0;
        /// Share of random actions at the end.
        end_epsilon: f64 = 0.05, in 0.0..=1.0;
        /// Share of the training over which the share of random actions falls linearly.
        exploration_fraction: f64 = 0.1, in 0.0..=1.0;
        /// Largest Euclidean norm of the gradient.
        max_grad_norm: f32 = 10.0, in 1e-6..=1e9;
        /// Units of both hidden layers.
        hidden: usize = 64, in 1.0..=1024.0, unit "units";
    }
}

/// A training of action values.
#[derive(Debug, Clone)]
pub struct Dqn<E> {
    settings: Settings,
    learned: Followed,
    replay: Replay,
    lane: Lanes<E>,
    draws: Generator,
    exploration: Generator,
    steps: u64,
    buffers: Buffers,
}

/// Numbers of one update.
#[derive(Debug, Clone, Default)]
struct Buffers {
    places: Vec<usize>,
    states: Vec<f32>,
    nexts: Vec<f32>,
    /// What the values of the actions taken are to become.
    targets: Vec<f32>,
    output_gradient: Vec<f32>,
    before: Vec<f32>,
    after: Vec<f32>,
}

impl<E: Environment> Dqn<E> {
    /// Returns a training that has not begun.
    ///
    /// # Panics
    ///
    /// When actions are not numbered.
    pub fn new(settings: Settings, environment: E, seed: u64) -> Self {
        let lane = Lanes::new(vec![environment]);
        let Actions::Numbered(actions) = lane.actions() else {
            panic!("deep Q-learning needs numbered actions");
        };
        let width = lane.width();
        let Settings { hidden, learning_rate, adam_epsilon, .. } = settings;
        let network = network(width, &[hidden; HIDDEN_LAYERS], actions, Activation::None);
        Self {
            learned: Followed::new(network, learning_rate, adam_epsilon, seed, &["initial"]),
            replay: Replay::new(settings.buffer_size, width),
            draws: Generator::new(seed, &["replay"]),
            exploration: Generator::new(seed, &["exploration"]),
            steps: 0,
            buffers: Buffers {
                before: vec![0.0; width],
                after: vec![0.0; width],
                ..Buffers::default()
            },
            lane,
            settings,
        }
    }

    /// Returns the share of random actions now.
    fn epsilon(&self) -> f64 {
        let Settings { start_epsilon, end_epsilon, .. } = self.settings;
        if self.steps < self.settings.learning_starts {
            return 1.0;
        }
        let span = self.settings.exploration_fraction * self.settings.total_steps as f64;
        linear_epsilon(start_epsilon, end_epsilon, span.round() as u64, self.steps)
    }

    /// Plays one step.
    fn step(&mut self, seeds: &mut dyn FnMut(u32) -> u64) {
        self.lane.begin(seeds);
        let epsilon = self.epsilon();
        let Buffers { before, after, .. } = &mut self.buffers;
        before.copy_from_slice(self.lane.observation(0));
        let action = if self.exploration.unit() < epsilon {
            self.exploration.below(self.learned.network.outputs())
        } else {
            largest(self.learned.values(before))
        };
        let step = self.lane.step(0, &[action as f32], after, seeds);
        self.replay.push(&Transition {
            state: before,
            action,
            reward: step.reward,
            next: after,
            terminal: step.terminated,
        });
        self.steps += 1;
        if self.steps.is_multiple_of(self.settings.target_network_frequency) {
            self.learned.target.copy_from_slice(&self.learned.parameters);
        }
    }

    /// One gradient step on stored steps; returns the loss.
    fn update(&mut self) -> f64 {
        let count = self.settings.batch_size;
        let Buffers { places, states, nexts, targets, output_gradient, .. } = &mut self.buffers;
        let Followed { network, parameters, target, .. } = &mut self.learned;
        places.clear();
        places.extend((0..count).map(|_| self.draws.below(self.replay.len())));
        states.clear();
        nexts.clear();
        for place in places.iter() {
            let transition = self.replay.get(*place);
            states.extend_from_slice(transition.state);
            nexts.extend_from_slice(transition.next);
        }
        let actions = network.outputs();
        targets.clear();
        let values = network.forward(target, nexts);
        for (place, values) in places.iter().zip(values.chunks_exact(actions)) {
            let Transition { reward, terminal, .. } = self.replay.get(*place);
            let next = if terminal { 0.0 } else { values[largest(values)] };
            targets.push(reward + self.settings.gamma * next);
        }
        let values = network.forward(parameters, states);
        output_gradient.clear();
        output_gradient.resize(values.len(), 0.0);
        let share = 1.0 / count as f32;
        let mut loss = 0.0;
        for (row, (place, target)) in places.iter().zip(targets.iter()).enumerate() {
            let at = row * actions + self.replay.get(*place).action;
            let error = values[at] - target;
            loss += f64::from(huber(error) * share);
            output_gradient[at] = error.clamp(-1.0, 1.0) * share;
        }
        self.learned.descend(states, output_gradient, Some(self.settings.max_grad_norm));
        loss
    }
}

impl<E: Environment> Trainer for Dqn<E> {
    fn advance(&mut self, steps: u64, seeds: &mut dyn FnMut(u32) -> u64) -> Progress {
        let (mut loss, mut losses) = (0.0, 0u32);
        while !self.finished() && self.steps < steps {
            for _ in 0..self.settings.train_frequency {
                self.step(seeds);
            }
            if self.steps > self.settings.learning_starts {
                for _ in 0..self.settings.gradient_steps {
                    loss += self.update();
                    losses += 1;
                }
            }
        }
        let loss = (losses > 0).then(|| loss / f64::from(losses));
        let epsilon = Some(self.epsilon());
        Progress { steps: self.steps, loss, epsilon, ..self.lane.report() }
    }

    fn steps(&self) -> u64 {
        self.steps
    }

    fn finished(&self) -> bool {
        self.steps >= self.settings.total_steps
    }

    fn act(&mut self, observation: &[f32], action: &mut [f32]) {
        action[0] = largest(self.learned.values(observation)) as f32;
    }
}

impl<E: Environment> Persist for Dqn<E> {
    fn is_finite(&self) -> bool {
        self.learned.is_finite()
    }

    fn is_alive(&mut self) -> bool {
        let Followed { network, parameters, .. } = &mut self.learned;
        let actions = network.outputs();
        depends_on_both(network.forward(parameters, &self.replay.probes()), actions)
    }

    fn learned(&self, prefix: &str, archive: &mut Archive) {
        self.learned.learned(prefix, archive);
    }

    fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        self.learned.load(prefix, archive)
    }

    fn save(&self, prefix: &str, archive: &mut Archive) {
        archive.put(&format!("{prefix}steps"), self.steps);
        self.learned.save(prefix, archive);
        self.replay.save(prefix, archive);
        self.draws.save(&format!("{prefix}draws"), archive);
        self.exploration.save(&format!("{prefix}exploration"), archive);
        self.lane.save(prefix, archive);
    }

    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        self.learned.restore(prefix, archive)?;
        self.replay.restore(prefix, archive)?;
        self.draws.restore(&format!("{prefix}draws"), archive)?;
        self.exploration.restore(&format!("{prefix}exploration"), archive)?;
        self.steps = archive.get(&format!("{prefix}steps"))?;
        self.lane.restore(prefix, archive)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Corridor, check_trainer, play};
    use super::*;

    fn settings() -> Settings {
        Settings {
            total_steps: 4000,
            learning_rate: 2e-3,
            gamma: 0.9,
            buffer_size: 500,
            learning_starts: 50,
            train_frequency: 8,
            gradient_steps: 8,
            target_network_frequency: 50,
            exploration_fraction: 0.5,
            hidden: 32,
            ..Settings::default()
        }
    }

    #[test]
    fn a_corridor_is_learned_to_its_exact_values() {
        let mut dqn = Dqn::new(settings(), Corridor::default(), 3);
        dqn.advance(u64::MAX, &mut |k| u64::from(k));
        assert_eq!(play(&mut dqn), 4);
        for state in 0..4 {
            let value = dqn.learned.values(&Corridor::one_hot(state))[1];
            let exact = 0.9f32.powi(3 - state as i32);
            assert!((value - exact).abs() < 0.05, "{state}: {value}, {exact}");
        }
    }

    #[test]
    fn a_training_can_stop_after_every_update() {
        check_trainer(&Corridor::default(), |seed| Dqn::new(settings(), Corridor::default(), seed));
    }

    #[test]
    fn updates_come_in_blocks_once_enough_steps_are_done() {
        let mut dqn = Dqn::new(settings(), Corridor::default(), 3);
        // 48 steps are too few, 56 are enough.
        assert_eq!(dqn.advance(48, &mut |k| u64::from(k)).loss, None);
        assert_eq!(dqn.epsilon(), 1.0);
        let progress = dqn.advance(49, &mut |k| u64::from(k));
        assert!(progress.loss.is_some() && progress.steps == 56);
        // From 1 to 0.05 over half of 4000 steps.
        assert!((dqn.epsilon() - (1.0 - 0.95 * 56.0 / 2000.0)).abs() < 1e-12);
    }

    /// A learner with one stored step whose values are `Q(s, a) = w_a s + b_a`.
    fn table(terminal: bool) -> Dqn<Corridor> {
        let settings = Settings { batch_size: 1, gamma: 0.9, ..settings() };
        let mut dqn = Dqn::new(settings, Corridor::default(), 1);
        dqn.learned = Followed::new(network(1, &[], 2, Activation::None), 1e-3, 1e-8, 1, &[]);
        dqn.learned.parameters = vec![1.0, 2.0, 0.0, 0.0];
        dqn.learned.target = vec![5.0, 3.0, 0.0, 0.0];
        dqn.replay = Replay::new(1, 1);
        let (state, next) = (&[2.0], &[3.0]);
        dqn.replay.push(&Transition { state, action: 0, reward: -1.0, next, terminal });
        dqn
    }

    #[test]
    fn loss_and_step_are_those_computed_by_hand() {
        // The target network's best at 3 is 15, so y = -1 + 0.9 * 15 = 12.5; Q(2, 0) = 2: an error of -10.5.
        let mut dqn = table(false);
        assert!((dqn.update() - 10.0).abs() < 1e-6);
        let moved = [1.001, 2.0, 0.001, 0.0];
        dqn.learned.parameters.iter().zip(moved).for_each(|(p, m)| assert!((p - m).abs() < 1e-6));
        // A terminal state is worth nothing: y = -1, an error of 3.
        assert!((table(true).update() - 2.5).abs() < 1e-6);
    }

    #[test]
    fn a_cut_episode_is_not_stored_as_terminal_and_a_finished_one_is() {
        let wait = Settings { learning_starts: 400, ..settings() };
        let mut dqn = Dqn::new(wait, Corridor::default(), 3);
        let episodes = dqn.advance(400, &mut |k| u64::from(k)).episodes;
        let stored: Vec<_> = (0..400).map(|place| dqn.replay.get(place)).collect();
        assert!(stored.iter().all(|t| t.terminal == (t.next == Corridor::one_hot(4))));
        let finished = stored.iter().filter(|t| t.terminal).count() as u32;
        assert!(finished > 0 && finished < episodes, "{finished} of {episodes}");
    }
}

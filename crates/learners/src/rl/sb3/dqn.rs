//! Deep Q-learning (Mnih et al., 2015), as Stable-Baselines3's `DQN`.
//!
//! Choices where implementations differ, beside those of [`crate::rl::dqn`]:
//! - **Updates** come in blocks of [`Settings::gradient_steps`], after every [`Settings::train_frequency`] steps but for
//!   the first [`Settings::learning_starts`], in which actions are random.
//! - **A cut episode** has the value of the state after it.

use super::Lanes;
use super::off_policy::network;
use super::{HIDDEN_LAYERS, Progress, Trainer};
use crate::nn::Activation;
use crate::nn::init::Init;
use crate::nn::sequential::Sequential;
use crate::nn::state::{Learned, State, kept};
use crate::rl::dqn::{self, Flavour};
use crate::rl::environment::{Actions, Environment};
use crate::rl::persist::Persist;
use crate::rl::random::Generator;
use crate::rl::replay::Transition;
use crate::rl::schedule::linear_epsilon;

pub use crate::rl::dqn::Settings;

/// A training of action values.
#[derive(Debug, Clone)]
pub struct Dqn<E> {
    settings: Settings,
    learner: dqn::Dqn<Sequential>,
    lane: Lanes<E>,
    before: Vec<f32>,
    after: Vec<f32>,
}

impl<E: Environment> Dqn<E> {
    /// Returns a training that has not begun; panics when actions are not numbered.
    pub fn new(settings: Settings, environment: E, seed: u64) -> Self {
        let lane = Lanes::new(vec![environment]);
        let Actions::Numbered(actions) = lane.actions() else {
            panic!("deep Q-learning needs numbered actions");
        };
        let width = lane.width();
        let network = network(width, &[settings.hidden; HIDDEN_LAYERS], actions, Activation::None);
        let mut draw = Generator::new(seed, &["initial"]);
        let parameters = network.initial(&|_| Init::Uniform, draw.rng());
        let flavour = Flavour::StableBaselines3;
        Self {
            learner: dqn::Dqn::new(network, parameters, settings.clone(), flavour, seed, &[]),
            before: vec![0.0; width],
            after: vec![0.0; width],
            lane,
            settings,
        }
    }

    fn epsilon(&self) -> f64 {
        let Settings { start_epsilon, end_epsilon, .. } = self.settings;
        if self.steps() < self.settings.learning_starts {
            return 1.0;
        }
        let span = self.settings.exploration_fraction * self.settings.total_steps as f64;
        linear_epsilon(start_epsilon, end_epsilon, span.round() as u64, self.steps())
    }

    fn step(&mut self, seeds: &mut dyn FnMut(u32) -> u64) {
        self.lane.begin(seeds);
        self.before.copy_from_slice(self.lane.observation(0));
        let action =
            self.learner.explore(&self.before, self.lane.actions().outputs(), self.epsilon());
        let step = self.lane.step(0, &[action as f32], &mut self.after, seeds);
        let (state, next, terminal) = (&self.before, &self.after, step.terminated);
        self.learner.store(&Transition { state, action, reward: step.reward, next, terminal });
    }
}

impl<E: Environment> Trainer for Dqn<E> {
    fn advance(&mut self, steps: u64, seeds: &mut dyn FnMut(u32) -> u64) -> Progress {
        while !self.finished() && self.steps() < steps {
            (0..self.settings.train_frequency).for_each(|_| self.step(seeds));
            if self.steps() > self.settings.learning_starts {
                (0..self.settings.gradient_steps).for_each(|_| self.learner.update());
            }
        }
        let (loss, epsilon) = (self.learner.take_loss(), Some(self.epsilon()));
        Progress { steps: self.steps(), loss, epsilon, ..self.lane.report() }
    }

    fn steps(&self) -> u64 {
        self.learner.transitions
    }

    fn finished(&self) -> bool {
        self.steps() >= self.settings.total_steps
    }

    fn act(&mut self, observation: &[f32], action: &mut [f32]) {
        action[0] = self.learner.greedy(observation) as f32;
    }
}

impl<E: Environment> Persist for Dqn<E> {
    fn is_finite(&self) -> bool {
        self.learner.is_finite()
    }

    fn is_alive(&mut self) -> bool {
        self.learner.is_alive()
    }
}

impl<E> Learned for Dqn<E> {
    kept! { Learned { "": learner } }
}

impl<E: Environment> State for Dqn<E> {
    kept! { State { "": learner, "": lane } }
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
            let value = dqn.learner.values(&Corridor::one_hot(state))[1];
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

    #[test]
    fn a_cut_episode_is_not_stored_as_terminal_and_a_finished_one_is() {
        let wait = Settings { learning_starts: 400, ..settings() };
        let mut dqn = Dqn::new(wait, Corridor::default(), 3);
        let episodes = dqn.advance(400, &mut |k| u64::from(k)).episodes;
        let stored: Vec<_> = (0..400).map(|place| dqn.learner.replay.get(place)).collect();
        assert!(stored.iter().all(|t| t.terminal == (t.next == Corridor::one_hot(4))));
        let finished = stored.iter().filter(|t| t.terminal).count() as u32;
        assert!(finished > 0 && finished < episodes, "{finished} of {episodes}");
    }
}

//! Deep Q-learning as RESCO runs it (PFRL's): the agents of IDQN and MPLight.
//!
//! - **Exploration**: random phases, at first always, linearly less until four fifths of the training.
//! - **Counters** of exploration, updates and target copies run per transition. With an agent for several signals that is as
//!   many times as fast as there are signals, and their limits are as many times as large.
//!
//! Deviation: where the limits of timing did not allow the phase that was asked for, what is learned is the
//! value of the one that was shown; RESCO, whose signals obey at once, knows no difference.

use super::learner::{Agent, Curve, Step, TrainingState};
use learners::nn::Network;
use learners::rl::dqn::{Dqn, Flavour, Settings};
use learners::rl::persist::Persist;
use learners::rl::replay::Transition;
use learners::rl::schedule::linear_epsilon;

/// Declares the hyper-parameters of a method, and those that it adds.
macro_rules! deep_q_settings {
    ({ $($head:tt)* } $source:literal $($more:tt)*) => {
        evaluation::settings::setting::settings! {
            $($head)*, source $source {
                /// Step size of Adam.
                learning_rate: f32 = 1e-3, in 1e-8..=1.0;
                /// Adam's epsilon, added to the root of the second moment (PyTorch's default).
                adam_epsilon: f32 = 1e-8, in 1e-12..=1.0;
                /// Discount per decision.
                gamma: f32 = 0.99, in 0.0..=1.0;
                /// Transitions in the replay buffer.
                buffer_size: usize = 10_000, in 1.0..=1e6, unit "transitions";
                /// Transitions per update, drawn uniformly without replacement.
                batch_size: usize = 32, in 1.0..=4096.0, at most buffer_size, unit "transitions";
                /// Transitions stored before the first update; at least one batch.
                learning_starts: usize = 32, in 1.0..=1e6, at most buffer_size, unit "transitions";
                /// Decisions between two updates. Signals that share a network are updated together.
                train_frequency: u32 = 1, in 1.0..=1e6, unit "decisions";
                /// Decisions between two copies into the target network.
                target_network_frequency: u32 = 500, in 1.0..=1e9, unit "decisions";
                /// Share of random actions at the start.
                start_e: f64 = 1.0, in 0.0..=1.0;
                /// Share of random actions at the end.
                end_e: f64 = 0.0, in 0.0..=1.0;
                /// Share of the training's episodes over which exploration falls from start to end, rounded down to
                /// whole episodes.
                exploration_fraction: f64 = 0.8, in 0.0..=1.0;
                /// Whether the last state of an episode gets a value (bootstrapping). RESCO treats the time limit as
                /// the end of the task, although traffic continues.
                bootstrap_at_time_limit: bool = false;
                /// Whether the online network chooses the action that the target network values (Van Hasselt et
                /// al., 2016). Not in RESCO.
                double_dqn: bool = false;
                /// Whether observations are shifted and scaled by their running mean and deviation. Not in RESCO.
                normalise_observations: bool = false;
                /// Whether weights start orthogonal instead of PyTorch's uniform default. Not in RESCO.
                orthogonal_initialisation: bool = false;
            } $($more)*
        }
    };
}
pub(super) use deep_q_settings;

deep_q_settings! { {
    /// Hyper-parameters of deep Q-learning; the defaults are RESCO's.
    pub struct Config
} "RESCO, config/agent_config.py and agents/pfrl_dqn.py" }

/// An agent that learns the values of phases.
#[derive(Debug)]
pub(super) struct DeepQ<N> {
    config: Config,
    pub(super) dqn: Dqn<N>,
    /// Signals that it decides for.
    signals: usize,
}

impl<N: Network> DeepQ<N> {
    /// Returns an agent that starts from these parameters; `seed` and `labels` name its randomness.
    pub(super) fn new(
        config: Config,
        (network, parameters): (N, Vec<f32>),
        signals: usize,
        seed: u64,
        labels: &[&str],
    ) -> Self {
        let settings = Settings {
            learning_rate: config.learning_rate,
            adam_epsilon: config.adam_epsilon,
            gamma: config.gamma,
            buffer_size: config.buffer_size,
            batch_size: config.batch_size,
            learning_starts: config.learning_starts as u64,
            train_frequency: u64::from(config.train_frequency) * signals as u64,
            target_network_frequency: u64::from(config.target_network_frequency) * signals as u64,
            ..Settings::default()
        };
        let flavour = Flavour::Pfrl { double: config.double_dqn };
        let dqn = Dqn::new(network, parameters, settings, flavour, seed, labels);
        Self { config, dqn, signals }
    }

    /// Returns the share of random actions.
    fn epsilon(&self, training: &TrainingState) -> f64 {
        let Config { start_e, end_e, exploration_fraction, .. } = self.config;
        let span = training.exploration_span(exploration_fraction, self.signals);
        linear_epsilon(start_e, end_e, span, self.dqn.transitions())
    }
}

impl<N: Network> Agent for DeepQ<N> {
    fn choose(&mut self, state: &[f32], phases: usize, training: &TrainingState) -> usize {
        match training.active {
            true => self.dqn.explore(state, phases, self.epsilon(training)),
            false => self.dqn.greedy(state),
        }
    }

    fn learn(&mut self, step: &Step<'_>) {
        self.dqn.observe(&Transition {
            state: step.state,
            action: step.shown,
            reward: step.reward,
            next: step.next,
            terminal: step.truncated && !self.config.bootstrap_at_time_limit,
        });
    }

    fn curve(&mut self, training: &TrainingState) -> Curve {
        let epsilon = Some(self.epsilon(training));
        Curve { loss: self.dqn.take_loss(), epsilon, ..Curve::default() }
    }

    fn kept(&self) -> &dyn Persist {
        &self.dqn
    }

    fn kept_mut(&mut self) -> &mut dyn Persist {
        &mut self.dqn
    }
}

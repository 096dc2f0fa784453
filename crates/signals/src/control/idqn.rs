//! IDQN: deep Q-learning, one independent learner per signal, as RESCO runs it.
//!
//! - **State**: a row of five numbers per lane ([`super::state::lanes`]).
//! - **Action**: the next green phase.
//! - **Reward**: the lanes' waiting time, negative ([`super::state::wait_reward`]).
//! - **Network**: a 2 x 2 convolution over lanes and numbers, two hidden layers, a value per phase.
//! - **Exploration**: random phases, at first always, linearly less until four fifths of the training.
//!
//! Deviation: where the limits of timing did not allow the phase that was asked for, what is learned is the
//! value of the one that was shown; RESCO, whose signals obey at once, knows no difference.
//!
//! Signals with a single phase stay green and learn nothing. What goes on around the algorithm is in
//! `independent.rs`.
//!
//! Source: RESCO, agents/pfrl_dqn.py; Ault and Sharon, "Reinforcement learning benchmarks for traffic
//! signal control" (NeurIPS 2021, datasets and benchmarks).

use std::f32::consts::SQRT_2;

use super::independent::{Agent, Independent, Step};
use super::learner::Learning;
use super::senses::View;
use super::training::{Curve, TrainingState};
use super::{Controller, Setup};
use evaluation::run::method::{Method, Training};
use evaluation::settings::setting::settings;
use learners::nn::Activation;
use learners::nn::init::Init;
use learners::nn::sequential::Sequential;
use learners::rl::dqn::{Dqn, Flavour, Settings};
use learners::rl::persist::Persist;
use learners::rl::random::Generator;
use learners::rl::replay::Transition;
use learners::rl::schedule::linear_epsilon;

/// The method.
pub const METHOD: Method = Method {
    summary: "deep Q-learning on lanes, a learner per signal (RESCO)",
    decision_s: 6e-4,
    settings: Config::SETTINGS,
    ..Method::built_in("idqn", Training::Learned, "#4b2e83")
};

settings! {
    /// Hyper-parameters of `idqn`; the defaults are RESCO's.
    pub struct Config, source "RESCO, config/agent_config.py and agents/pfrl_dqn.py" {
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
        /// Decisions between two updates.
        train_frequency: u32 = 1, in 1.0..=1e6, unit "decisions";
        /// Decisions between two copies into the target network.
        target_network_frequency: u32 = 500, in 1.0..=1e9, unit "decisions";
        /// Share of random actions at the start.
        start_e: f64 = 1.0, in 0.0..=1.0;
        /// Share of random actions at the end.
        end_e: f64 = 0.0, in 0.0..=1.0;
        /// Share of the training's episodes over which exploration falls from start to end, rounded down to whole
        /// episodes.
        exploration_fraction: f64 = 0.8, in 0.0..=1.0;
        /// Channels of the convolution and units of both hidden layers.
        hidden: usize = 64, in 1.0..=1024.0, unit "units";
        /// Whether the last state of an episode gets a value (bootstrapping). RESCO treats the time limit as the end of
        /// the task, although traffic continues.
        bootstrap_at_time_limit: bool = false;
        /// Whether the online network chooses the action that the target network values (Van Hasselt et
        /// al., 2016). Not in RESCO.
        double_dqn: bool = false;
        /// Whether observations are shifted and scaled by their running mean and deviation. Not in RESCO.
        normalise_observations: bool = false;
        /// Whether weights start orthogonal instead of PyTorch's uniform default. Not in RESCO.
        orthogonal_initialisation: bool = false;
    }
}

/// Number of the layer that gives the values, which no ReLU follows.
const VALUE_LAYER: usize = 3;

/// Returns IDQN, untrained.
pub fn create(config: &Config, setup: &Setup) -> Box<dyn Controller> {
    let learners: Independent<Idqn> = Independent::new(config.clone(), setup.seed);
    Box::new(Learning::new(learners, setup))
}

/// The algorithm of one signal's learner.
#[derive(Debug)]
struct Idqn {
    config: Config,
    phases: usize,
    dqn: Dqn<Sequential>,
}

impl Idqn {
    /// Returns the share of random actions.
    fn epsilon(&self, training: &TrainingState) -> f64 {
        let config = &self.config;
        let span = training.exploration_span(config.exploration_fraction, 1);
        linear_epsilon(config.start_e, config.end_e, span, self.dqn.transitions())
    }
}

impl Agent for Idqn {
    const NAME: &'static str = METHOD.name;

    type Config = Config;

    fn new(config: &Config, view: View, phases: usize, seed: u64, label: &str) -> Self {
        let network = view.hidden_layers(config.hidden).linear(phases, Activation::None);
        let init = |layer| match (config.orthogonal_initialisation, layer) {
            (false, _) => Init::Uniform,
            (true, VALUE_LAYER) => Init::Orthogonal(1.0),
            (true, _) => Init::Orthogonal(SQRT_2),
        };
        let mut generator = Generator::new(seed, &["initialisation", label]);
        let parameters = network.initial(&init, generator.rng());
        let settings = Settings {
            learning_rate: config.learning_rate,
            adam_epsilon: config.adam_epsilon,
            gamma: config.gamma,
            buffer_size: config.buffer_size,
            batch_size: config.batch_size,
            learning_starts: config.learning_starts as u64,
            train_frequency: u64::from(config.train_frequency),
            target_network_frequency: u64::from(config.target_network_frequency),
            ..Settings::default()
        };
        let flavour = Flavour::Pfrl { double: config.double_dqn };
        let dqn = Dqn::new(network, parameters, settings, flavour, seed, &[label]);
        Self { config: config.clone(), phases, dqn }
    }

    fn normalises(config: &Config) -> bool {
        config.normalise_observations
    }

    fn choose(&mut self, state: &[f32], training: &TrainingState) -> usize {
        match training.active {
            true => self.dqn.explore(state, self.phases, self.epsilon(training)),
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

#[cfg(test)]
mod tests {
    use super::super::state::LANE_WIDTH;
    use super::super::testing::{check_learner, check_shown, two_phase_signal};
    use super::*;

    fn small() -> Config {
        Config { hidden: 16, learning_rate: 3e-3, ..Config::default() }
    }

    fn learner(config: &Config, episodes: u32) -> Box<dyn Controller> {
        create(config, &Setup { seed: 7, episodes, ..Setup::default() })
    }

    #[test]
    fn it_learns_and_goes_on_from_a_checkpoint() {
        check_learner(&|episodes| learner(&small(), episodes));
    }

    #[test]
    fn the_options_learn_too() {
        let config = Config {
            bootstrap_at_time_limit: true,
            double_dqn: true,
            normalise_observations: true,
            orthogonal_initialisation: true,
            ..small()
        };
        check_learner(&|episodes| learner(&config, episodes));
    }

    #[test]
    fn it_learns_of_the_phase_that_was_shown() {
        check_shown(&mut *learner(&small(), 2), "signal0.replay.", 2 * LANE_WIDTH);
    }

    #[test]
    fn a_model_of_another_shape_is_refused() {
        let mut narrow = learner(&small(), 1);
        narrow.begin(&[two_phase_signal()]).unwrap();
        let model = narrow.model().unwrap();
        let mut wide = two_phase_signal();
        wide.phases.push(wide.phases[0].clone());
        let mut other = learner(&small(), 1);
        other.load(model).unwrap();
        let e = other.begin(&[wide]).unwrap_err().to_string();
        let expected = "the model does not fit: it is for signals of 2 lanes and 2 phases, these have \
                        2 lanes and 3 phases";
        assert_eq!(e, expected);
    }
}

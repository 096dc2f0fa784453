//! IDQN: deep Q-learning, one independent learner per signal, as RESCO runs it.
//!
//! - **State**: a row of five numbers per lane ([`super::state::lanes`]).
//! - **Action**: the next green phase.
//! - **Reward**: the lanes' waiting time, negative ([`super::state::wait_reward`]).
//! - **Network**: a 2 x 2 convolution over lanes and numbers, two hidden layers, a value per phase.
//! - **Exploration**: random phases, at first always, linearly less until four fifths of the training.
//!
//! Signals with a single phase stay green and learn nothing.
//!
//! Source: RESCO, agents/pfrl_dqn.py; Ault and Sharon, "Reinforcement learning benchmarks for traffic
//! signal control" (NeurIPS 2021, datasets and benchmarks).

use std::collections::BTreeMap;
use std::f32::consts::SQRT_2;

use super::state::{LANE_WIDTH, lane_rows, lanes, wait_reward};
use super::training::{self, Learner, TrainingState, decides, is_checkpoint, mean};
use super::{ControlError, Controller, Drive, GreenPhase, Observation, Setup, SignalSpec, Trainer};
use crate::nn::Activation;
use crate::nn::archive::Archive;
use crate::nn::init::Init;
use crate::nn::sequential::Sequential;
use crate::rl::dqn::{Dqn, Settings};
use crate::rl::normalise::Normaliser;
use crate::rl::random::Generator;
use crate::rl::replay::Transition;
use crate::rl::schedule::linear_epsilon;
use crate::run::method::{Method, Training};
use crate::settings::setting::settings;

/// The method.
pub const METHOD: Method = Method {
    name: "idqn",
    summary: "deep Q-learning on lanes, a learner per signal (RESCO)",
    training: Training::Learned,
    default: false,
    decision_s: 6e-4,
    color: "#4b2e83",
    dash: "",
    settings: Config::SETTINGS,
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
        /// Transitions stored before the first update, a batch at least.
        learning_starts: usize = 32, in 1.0..=1e6, at most buffer_size, unit "transitions";
        /// Decisions between two updates.
        train_frequency: u32 = 1, in 1.0..=1e6, unit "decisions";
        /// Decisions between two copies into the target network.
        target_network_frequency: u32 = 500, in 1.0..=1e9, unit "decisions";
        /// Share of random actions at the start.
        start_e: f64 = 1.0, in 0.0..=1.0;
        /// Share of random actions at the end.
        end_e: f64 = 0.0, in 0.0..=1.0;
        /// Share of the training's episodes over which exploration falls from start to end; the
        /// product is cut to whole episodes.
        exploration_fraction: f64 = 0.8, in 0.0..=1.0;
        /// Channels of the convolution and units of both hidden layers.
        hidden: usize = 64, in 1.0..=1024.0, unit "units";
        /// Whether the last state of an episode has a value of its own. RESCO takes the time limit for
        /// the end of the world, although traffic goes on.
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

/// Returns the network of a signal with these rows of lanes and phases.
fn network(lanes: usize, phases: usize, hidden: usize) -> Sequential {
    Sequential::new(lanes * LANE_WIDTH)
        .convolution(LANE_WIDTH, hidden, Activation::Relu)
        .linear(hidden, Activation::Relu)
        .linear(hidden, Activation::Relu)
        .linear(phases, Activation::None)
}

/// The learner of one signal.
#[derive(Debug, Clone)]
struct Agent {
    /// Index of the signal.
    signal: usize,
    phases: usize,
    dqn: Dqn<Sequential>,
    normaliser: Option<Normaliser>,
    state: Vec<f32>,
    next: Vec<f32>,
    action: usize,
}

impl Agent {
    fn new(config: &Config, signal: usize, spec: &SignalSpec, seed: u64) -> Self {
        let label = signal.to_string();
        let network = network(lane_rows(spec), spec.phases.len(), config.hidden);
        let init = |layer| match (config.orthogonal_initialisation, layer) {
            (false, _) => Init::Uniform,
            (true, VALUE_LAYER) => Init::Orthogonal(1.0),
            (true, _) => Init::Orthogonal(SQRT_2),
        };
        let mut generator = Generator::new(seed, &["initialisation", &label]);
        let parameters = network.initial(&init, generator.rng());
        let settings = Settings {
            learning_rate: config.learning_rate,
            adam_epsilon: config.adam_epsilon,
            gamma: config.gamma,
            buffer_size: config.buffer_size,
            batch_size: config.batch_size,
            learning_starts: config.learning_starts,
            train_frequency: u64::from(config.train_frequency),
            target_network_frequency: u64::from(config.target_network_frequency),
            double_dqn: config.double_dqn,
        };
        let width = lane_rows(spec) * LANE_WIDTH;
        Self {
            signal,
            phases: spec.phases.len(),
            dqn: Dqn::new(network, parameters, settings, seed, &[&label]),
            normaliser: config.normalise_observations.then(|| Normaliser::new(width)),
            state: Vec::with_capacity(width),
            next: Vec::with_capacity(width),
            action: 0,
        }
    }

    fn prefix(&self) -> String {
        format!("signal{}.", self.signal)
    }
}

/// IDQN.
#[derive(Debug, Clone)]
pub struct Idqn {
    config: Config,
    seed: u64,
    training: TrainingState,
    signals: Vec<SignalSpec>,
    agents: Vec<Agent>,
}

/// Returns IDQN, untrained.
pub fn create(config: &Config, setup: &Setup) -> Box<dyn Controller> {
    Box::new(Idqn::new(config.clone(), setup.episodes, setup.seed))
}

impl Idqn {
    /// Returns an untrained controller; `seed` is for everything random in it.
    pub fn new(config: Config, episodes: u32, seed: u64) -> Self {
        let training = TrainingState::new(episodes);
        Self { config, seed, training, signals: Vec::new(), agents: Vec::new() }
    }

    /// Returns the share of random actions of an agent.
    fn epsilon(&self, agent: &Agent) -> f64 {
        let config = &self.config;
        let span = self.training.exploration_span(config.exploration_fraction, 1);
        linear_epsilon(config.start_e, config.end_e, span, agent.dqn.transitions())
    }

    fn restore(&mut self, archive: &Archive) -> Result<(), ControlError> {
        training::check_shape(archive, &self.signals)?;
        for agent in &mut self.agents {
            let prefix = agent.prefix();
            if is_checkpoint(archive) {
                agent.dqn.restore(&prefix, archive)?;
            } else {
                agent.dqn.load(&prefix, archive)?;
            }
            if let Some(normaliser) = &mut agent.normaliser {
                normaliser.restore(&prefix, archive)?;
            }
        }
        Ok(())
    }
}

impl Controller for Idqn {
    fn name(&self) -> &'static str {
        METHOD.name
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        let changed = self.signals != signals;
        if changed {
            self.signals = signals.to_vec();
            let decide = signals.iter().enumerate().filter(|(_, s)| decides(s));
            self.agents = decide.map(|(i, s)| Agent::new(&self.config, i, s, self.seed)).collect();
        }
        if let Some(archive) = self.training.adopted(changed) {
            self.restore(&archive)?;
        }
        Ok(training::drives(signals))
    }

    fn act(&mut self, observations: &[Observation], phases: &mut [GreenPhase]) {
        for i in 0..self.agents.len() {
            let epsilon = self.training.active.then(|| self.epsilon(&self.agents[i]));
            let agent = &mut self.agents[i];
            lanes(&self.signals[agent.signal], &observations[agent.signal], &mut agent.state);
            if let Some(normaliser) = &mut agent.normaliser {
                normaliser.take_in(&mut agent.state, epsilon.is_some());
            }
            agent.action = match epsilon {
                Some(epsilon) => agent.dqn.explore(&agent.state, agent.phases, epsilon),
                None => agent.dqn.greedy(&agent.state),
            };
            phases[agent.signal] = GreenPhase(agent.action);
        }
    }

    fn observe(&mut self, observations: &[Observation], truncated: bool) {
        if !self.training.active {
            return;
        }
        for agent in &mut self.agents {
            let seen = &observations[agent.signal];
            let reward = wait_reward(seen);
            self.training.curve.reward += f64::from(reward);
            lanes(&self.signals[agent.signal], seen, &mut agent.next);
            if let Some(normaliser) = &agent.normaliser {
                normaliser.apply(&mut agent.next);
            }
            agent.dqn.observe(&Transition {
                state: &agent.state,
                action: agent.action,
                reward,
                next: &agent.next,
                terminal: truncated && !self.config.bootstrap_at_time_limit,
            });
        }
        if truncated {
            let losses: Vec<f64> =
                self.agents.iter_mut().filter_map(|a| a.dqn.take_loss()).collect();
            self.training.curve.loss = mean(&losses);
            self.training.curve.epsilon = self.agents.first().map(|a| self.epsilon(a));
        }
    }

    fn train(&mut self, trainer: &mut dyn Trainer) -> Result<(), ControlError> {
        training::train(self, trainer)
    }

    fn details(&self) -> BTreeMap<String, String> {
        training::remarks(METHOD.name, &self.training, &self.signals)
    }

    fn figures(&self) -> BTreeMap<String, f64> {
        self.training.figures()
    }

    fn model(&self) -> Option<Archive> {
        let mut model = training::model(METHOD.name, &self.signals);
        for agent in &self.agents {
            let prefix = agent.prefix();
            let (network, parameters) = agent.dqn.learned();
            crate::nn::save(network, parameters, &prefix, &mut model);
            if let Some(normaliser) = &agent.normaliser {
                normaliser.save(&prefix, &mut model);
            }
        }
        self.controls().then_some(model)
    }

    fn load(&mut self, model: Archive) -> Result<(), ControlError> {
        self.training.load(METHOD.name, model)
    }
}

impl Learner for Idqn {
    fn training(&mut self) -> &mut TrainingState {
        &mut self.training
    }

    fn controls(&self) -> bool {
        !self.agents.is_empty()
    }

    fn is_finite(&self) -> bool {
        self.agents.iter().all(|agent| agent.dqn.is_finite())
    }

    fn save(&self, archive: &mut Archive) {
        for agent in &self.agents {
            let prefix = agent.prefix();
            agent.dqn.save(&prefix, archive);
            if let Some(normaliser) = &agent.normaliser {
                normaliser.save(&prefix, archive);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{check_learner, two_phase_signal};
    use super::*;

    fn small() -> Config {
        Config { hidden: 16, learning_rate: 3e-3, ..Config::default() }
    }

    #[test]
    fn it_learns_and_goes_on_from_a_checkpoint() {
        check_learner(&|episodes| Box::new(Idqn::new(small(), episodes, 7)));
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
        check_learner(&|episodes| Box::new(Idqn::new(config.clone(), episodes, 7)));
    }

    #[test]
    fn a_model_of_another_shape_is_refused() {
        let mut learner = Idqn::new(small(), 1, 7);
        learner.begin(&[two_phase_signal()]).unwrap();
        let model = learner.model().unwrap();
        let mut wide = two_phase_signal();
        wide.phases.push(wide.phases[0].clone());
        let mut other = Idqn::new(small(), 1, 7);
        other.load(model).unwrap();
        let e = other.begin(&[wide]).unwrap_err().to_string();
        let expected = "the model does not fit: it is for signals of 2 lanes and 2 phases, these have \
                        2 lanes and 3 phases";
        assert_eq!(e, expected);
    }
}

//! IPPO: proximal policy optimisation, one independent learner per signal, as RESCO runs it.
//!
//! State, action and reward are IDQN's. The network is IDQN's too, with a logit per phase and the
//! value of the state at its end. Phases are drawn from the policy, in RESCO also in evaluation.
//!
//! Signals with a single phase stay green and learn nothing.
//!
//! Source: RESCO, agents/pfrl_ppo.py. Its published figures are after 1400 episodes; after 100 it has
//! made 35 updates.

use std::collections::BTreeMap;
use std::f32::consts::SQRT_2;

use super::state::{LANE_WIDTH, lane_rows, lanes, wait_reward};
use super::training::{self, Learner, TrainingState, decides, is_checkpoint, mean};
use super::{ControlError, Controller, Drive, GreenPhase, Observation, Setup, SignalSpec, Trainer};
use crate::nn::archive::Archive;
use crate::nn::init::Init;
use crate::nn::sequential::Sequential;
use crate::nn::{Activation, Network};
use crate::rl::normalise::Normaliser;
use crate::rl::ppo::{End, Ppo, Settings};
use crate::rl::random::Generator;
use crate::run::method::{Method, Training};
use crate::settings::setting::settings;

/// The method.
pub const METHOD: Method = Method {
    name: "ippo",
    summary: "proximal policy optimisation on lanes, a learner per signal (RESCO)",
    training: Training::Learned,
    default: false,
    decision_s: 5e-5,
    color: "#e69f00",
    dash: "9 4",
    settings: Config::SETTINGS,
};

settings! {
    /// Hyper-parameters of `ippo`; the defaults are RESCO's.
    pub struct Config, source "RESCO, config/agent_config.py and agents/pfrl_ppo.py" {
        /// Step size of Adam.
        learning_rate: f32 = 2.5e-4, in 1e-8..=1.0;
        /// Adam's epsilon, added to the root of the second moment.
        adam_epsilon: f32 = 1e-5, in 1e-12..=1.0;
        /// Discount per decision.
        gamma: f32 = 0.99, in 0.0..=1.0;
        /// Discount of later advantages within the generalised advantage estimate.
        gae_lambda: f32 = 0.95, in 0.0..=1.0;
        /// Transitions collected per update.
        num_steps: usize = 1024, in 2.0..=1e6, unit "transitions";
        /// Passes over the collected transitions per update.
        update_epochs: usize = 4, in 1.0..=1000.0, unit "passes";
        /// Transitions per gradient step.
        minibatch_size: usize = 256, in 1.0..=1e6, at most num_steps, unit "transitions";
        /// Largest relative change of an action's probability that pays.
        clip_range: f32 = 0.1, in 1e-6..=10.0;
        /// Weight of the squared error of the value.
        value_coefficient: f32 = 1.0, in 0.0..=1e3;
        /// Weight of the entropy bonus.
        entropy_coefficient: f32 = 0.001, in 0.0..=1e3;
        /// Largest Euclidean norm of the gradient.
        max_grad_norm: f32 = 0.5, in 1e-6..=1e9;
        /// Channels of the convolution and units of both hidden layers.
        hidden: usize = 64, in 1.0..=1024.0, unit "units";
        /// Whether evaluation takes the most probable phase; RESCO draws it as in training.
        evaluate_mode: bool = false;
        /// Whether the last state of an episode has a value of its own. RESCO takes the time limit for
        /// the end of the world, although traffic goes on.
        bootstrap_at_time_limit: bool = false;
        /// Whether observations are shifted and scaled by their running mean and deviation. Not in RESCO.
        normalise_observations: bool = false;
        /// Whether weights start orthogonal instead of normally distributed. Not in RESCO.
        orthogonal_initialisation: bool = false;
    }
}

/// Number of the layer that gives logits and value, which no ReLU follows.
const HEAD_LAYER: usize = 3;

/// Factor on the first weights of the logits, so that the first policy is nearly uniform.
const POLICY_GAIN: f32 = 0.01;

/// Returns the network of a signal with these rows of lanes and phases: a logit per phase, then the
/// value.
fn network(lanes: usize, phases: usize, hidden: usize) -> Sequential {
    Sequential::new(lanes * LANE_WIDTH)
        .convolution(LANE_WIDTH, hidden, Activation::Relu)
        .linear(hidden, Activation::Relu)
        .linear(hidden, Activation::Relu)
        .linear(phases + 1, Activation::None)
}

/// Returns parameters to start from: normal or orthogonal, biases zero, logits close to zero.
fn initial(network: &Sequential, orthogonal: bool, generator: &mut Generator) -> Vec<f32> {
    let init = |layer| match (orthogonal, layer) {
        (false, _) => Init::Normal(1.0),
        (true, HEAD_LAYER) => Init::Orthogonal(1.0),
        (true, _) => Init::Orthogonal(SQRT_2),
    };
    let mut parameters = network.initial(&init, generator.rng());
    let parts = network.parts();
    let last = parts.iter().rfind(|p| p.shape.len() == 2).expect("the last layer has weights");
    for row in parameters[last.range.clone()].chunks_exact_mut(last.shape[1]) {
        let (logits, _) = row.split_at_mut(last.shape[1] - 1);
        logits.iter_mut().for_each(|w| *w *= POLICY_GAIN);
    }
    parameters
}

/// The learner of one signal.
#[derive(Debug, Clone)]
struct Agent {
    /// Index of the signal.
    signal: usize,
    ppo: Ppo<Sequential>,
    /// Draws phases in evaluation, so that training's draws stay as they are.
    evaluation: Generator,
    normaliser: Option<Normaliser>,
    state: Vec<f32>,
    next: Vec<f32>,
    action: usize,
}

impl Agent {
    fn new(config: &Config, signal: usize, spec: &SignalSpec, seed: u64) -> Self {
        let label = signal.to_string();
        let network = network(lane_rows(spec), spec.phases.len(), config.hidden);
        let mut generator = Generator::new(seed, &["initialisation", &label]);
        let parameters = initial(&network, config.orthogonal_initialisation, &mut generator);
        let settings = Settings {
            learning_rate: config.learning_rate,
            adam_epsilon: config.adam_epsilon,
            gamma: config.gamma,
            gae_lambda: config.gae_lambda,
            num_steps: config.num_steps,
            update_epochs: config.update_epochs,
            minibatch_size: config.minibatch_size,
            clip_range: config.clip_range,
            value_coefficient: config.value_coefficient,
            entropy_coefficient: config.entropy_coefficient,
            max_grad_norm: config.max_grad_norm,
        };
        let width = lane_rows(spec) * LANE_WIDTH;
        Self {
            signal,
            ppo: Ppo::new(network, parameters, settings, seed, &[&label]),
            evaluation: Generator::new(seed, &["evaluation", &label]),
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

/// IPPO.
#[derive(Debug, Clone)]
pub struct Ippo {
    config: Config,
    seed: u64,
    training: TrainingState,
    signals: Vec<SignalSpec>,
    agents: Vec<Agent>,
}

/// Returns IPPO, untrained.
pub fn create(config: &Config, setup: &Setup) -> Box<dyn Controller> {
    Box::new(Ippo::new(config.clone(), setup.episodes, setup.seed))
}

impl Ippo {
    /// Returns an untrained controller; `seed` is for everything random in it.
    pub fn new(config: Config, episodes: u32, seed: u64) -> Self {
        let training = TrainingState::new(episodes);
        Self { config, seed, training, signals: Vec::new(), agents: Vec::new() }
    }

    fn restore(&mut self, archive: &Archive) -> Result<(), ControlError> {
        training::check_shape(archive, &self.signals)?;
        for agent in &mut self.agents {
            let prefix = agent.prefix();
            if is_checkpoint(archive) {
                agent.ppo.restore(&prefix, archive)?;
            } else {
                agent.ppo.load(&prefix, archive)?;
            }
            if let Some(normaliser) = &mut agent.normaliser {
                normaliser.restore(&prefix, archive)?;
            }
        }
        Ok(())
    }
}

impl Controller for Ippo {
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
        let (active, mode) = (self.training.active, self.config.evaluate_mode);
        for agent in &mut self.agents {
            lanes(&self.signals[agent.signal], &observations[agent.signal], &mut agent.state);
            if let Some(normaliser) = &mut agent.normaliser {
                normaliser.take_in(&mut agent.state, active);
            }
            agent.action = match (active, mode) {
                (true, _) => agent.ppo.sample(&agent.state, None),
                (false, true) => agent.ppo.mode(&agent.state),
                (false, false) => agent.ppo.sample(&agent.state, Some(&mut agent.evaluation)),
            };
            phases[agent.signal] = GreenPhase(agent.action);
        }
    }

    fn observe(&mut self, observations: &[Observation], truncated: bool) {
        if !self.training.active {
            return;
        }
        let end = match (truncated, self.config.bootstrap_at_time_limit) {
            (false, _) => End::None,
            (true, false) => End::Terminal,
            (true, true) => End::Truncated,
        };
        for agent in &mut self.agents {
            let seen = &observations[agent.signal];
            let reward = wait_reward(seen);
            self.training.curve.reward += f64::from(reward);
            lanes(&self.signals[agent.signal], seen, &mut agent.next);
            if let Some(normaliser) = &agent.normaliser {
                normaliser.apply(&mut agent.next);
            }
            agent.ppo.observe(&agent.state, agent.action, reward, &agent.next, end);
        }
        if truncated {
            let (losses, entropies): (Vec<f64>, Vec<f64>) =
                self.agents.iter_mut().filter_map(|a| a.ppo.take_loss()).unzip();
            self.training.curve.loss = mean(&losses);
            self.training.curve.entropy = mean(&entropies);
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
            let (network, parameters) = agent.ppo.learned();
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

impl Learner for Ippo {
    fn training(&mut self) -> &mut TrainingState {
        &mut self.training
    }

    fn controls(&self) -> bool {
        !self.agents.is_empty()
    }

    fn is_finite(&self) -> bool {
        self.agents.iter().all(|agent| agent.ppo.is_finite())
    }

    fn save(&self, archive: &mut Archive) {
        for agent in &self.agents {
            let prefix = agent.prefix();
            agent.ppo.save(&prefix, archive);
            if let Some(normaliser) = &agent.normaliser {
                normaliser.save(&prefix, archive);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::check_learner;
    use super::*;

    fn small() -> Config {
        Config {
            hidden: 16,
            learning_rate: 5e-3,
            num_steps: 120,
            minibatch_size: 40,
            update_epochs: 10,
            ..Config::default()
        }
    }

    #[test]
    fn it_learns_and_goes_on_from_a_checkpoint() {
        check_learner(&|episodes| Box::new(Ippo::new(small(), episodes, 7)));
    }

    #[test]
    fn the_options_learn_too() {
        let config = Config {
            bootstrap_at_time_limit: true,
            normalise_observations: true,
            orthogonal_initialisation: true,
            evaluate_mode: true,
            ..small()
        };
        check_learner(&|episodes| Box::new(Ippo::new(config.clone(), episodes, 7)));
    }

    #[test]
    fn the_first_policy_is_nearly_uniform_and_values_are_not_small() {
        let network = network(3, 4, 64);
        let parameters = initial(&network, false, &mut Generator::new(1, &[]));
        let deviation = |values: &[f32]| {
            (values.iter().map(|v| v * v).sum::<f32>() / values.len() as f32).sqrt()
        };
        let parts = network.parts();
        let last = &parameters[parts[6].range.clone()];
        let logits: Vec<f32> = last.chunks(5).flat_map(|row| row[..4].to_vec()).collect();
        let values: Vec<f32> = last.chunks(5).map(|row| row[4]).collect();
        // A deviation of 1 over the root of 64 inputs, times the gain.
        assert!((deviation(&logits) - 0.00125).abs() < 2e-4, "{}", deviation(&logits));
        assert!((deviation(&values) - 0.125).abs() < 3e-2, "{}", deviation(&values));
    }
}

//! IPPO: proximal policy optimisation, one independent learner per signal, as RESCO runs it.
//!
//! State, action and reward are IDQN's. The network is IDQN's too, with a logit per phase and the
//! value of the state at its end. Phases are drawn from the policy, in RESCO also in evaluation.
//!
//! Source: RESCO, agents/pfrl_ppo.py. Its published figures are after 1400 episodes; after 100 it has
//! made 35 updates.

use std::f32::consts::SQRT_2;

use super::learner::{Agent, Curve, Learner, Learning, Step, TrainingState};
use super::senses::View;
use super::{Controller, Setup, SignalSpec};
use evaluation::run::method::{Method, Training};
use evaluation::settings::setting::settings;
use learners::nn::init::Init;
use learners::nn::sequential::Sequential;
use learners::nn::{Activation, Network};
use learners::rl::environment::Step as Played;
use learners::rl::normalise::Normaliser;
use learners::rl::persist::Persist;
use learners::rl::ppo::{Ppo, Settings};
use learners::rl::random::Generator;

/// The method.
pub const METHOD: Method = Method {
    summary: "proximal policy optimisation on lanes, a learner per signal (RESCO)",
    decision_s: 5e-5,
    dash: "9 4",
    settings: Config::SETTINGS,
    ..Method::built_in("ippo", Training::Learned, "#e69f00")
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
        /// Largest relative change of an action's probability that an update rewards.
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
        /// Whether the last state of an episode gets a value (bootstrapping). RESCO treats the time limit as the end of
        /// the task, although traffic continues.
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

/// Returns the network of a signal with this view: a logit per phase, then the value.
fn network(view: View, phases: usize, hidden: usize) -> Sequential {
    view.hidden_layers(hidden).linear(phases + 1, Activation::None)
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

/// Returns IPPO, untrained.
pub fn create(config: &Config, setup: &Setup) -> Box<dyn Controller> {
    Box::new(Learning::new(METHOD.name, config.clone(), setup))
}

impl Learner for Config {
    type Agent = Ippo;

    fn agents(
        &mut self,
        signals: &[SignalSpec],
        views: &[(usize, View)],
        _: usize,
        seed: u64,
    ) -> Result<Vec<Ippo>, String> {
        let settings = Settings {
            learning_rate: self.learning_rate,
            adam_epsilon: self.adam_epsilon,
            gamma: self.gamma,
            gae_lambda: self.gae_lambda,
            num_steps: self.num_steps,
            update_epochs: self.update_epochs,
            minibatch_size: self.minibatch_size,
            clip_range: self.clip_range,
            value_coefficient: self.value_coefficient,
            entropy_coefficient: self.entropy_coefficient,
            max_grad_norm: self.max_grad_norm,
            ..Settings::default()
        };
        let agent = |(signal, view): &(usize, View)| {
            let label = signal.to_string();
            let network = network(*view, signals[*signal].phases.len(), self.hidden);
            let generator = |purpose| Generator::new(seed, &[purpose, &label]);
            let orthogonal = self.orthogonal_initialisation;
            let parameters = initial(&network, orthogonal, &mut generator("initialisation"));
            Ippo {
                config: self.clone(),
                ppo: Ppo::new(network, parameters, settings.clone(), seed, &[&label]),
                evaluation: generator("evaluation"),
                validation: generator("validation"),
                seed,
                label,
            }
        };
        Ok(views.iter().map(agent).collect())
    }

    fn normaliser(&self, view: View) -> Option<Normaliser> {
        self.normalise_observations.then(|| Normaliser::new(view.width()))
    }
}

/// The algorithm of one signal's learner.
#[derive(Debug)]
pub(super) struct Ippo {
    config: Config,
    ppo: Ppo,
    /// Draws phases in evaluation, so that training's draws stay as they are.
    evaluation: Generator,
    /// Draws phases in validation.
    validation: Generator,
    seed: u64,
    label: String,
}

impl Agent for Ippo {
    fn choose(&mut self, state: &[f32], _: usize, training: &TrainingState) -> usize {
        match (training.active, self.config.evaluate_mode) {
            (true, _) => self.ppo.sample(state, None),
            (false, true) => self.ppo.mode(state),
            (false, false) if training.validates => {
                self.ppo.sample(state, Some(&mut self.validation))
            }
            (false, false) => self.ppo.sample(state, Some(&mut self.evaluation)),
        }
    }

    fn begin_validation(&mut self) {
        self.validation = Generator::new(self.seed, &["validation", &self.label]);
    }

    /// The update weighs a phase by how likely the policy was to ask for it, so that this one counts, whatever
    /// was shown.
    fn learn(&mut self, step: &Step<'_>) {
        let terminated = step.truncated && !self.config.bootstrap_at_time_limit;
        let played = Played { reward: step.reward, terminated, truncated: step.truncated };
        self.ppo.observe(step.state, step.asked, played, step.next);
    }

    fn curve(&mut self, _: &TrainingState) -> Curve {
        let (loss, entropy) = self.ppo.take_loss().unzip();
        Curve { loss, entropy, ..Curve::default() }
    }

    fn kept(&self) -> &dyn Persist {
        &self.ppo
    }

    fn kept_mut(&mut self) -> &mut dyn Persist {
        &mut self.ppo
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
            normalise_observations: true,
            orthogonal_initialisation: true,
            evaluate_mode: true,
            ..small()
        };
        check_learner(&|episodes| learner(&config, episodes));
    }

    #[test]
    fn the_first_policy_is_nearly_uniform_and_values_are_not_small() {
        let network = network(View::Lanes(3), 4, 64);
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

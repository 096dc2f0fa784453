//! IDQN: deep Q-learning, one independent learner per signal, as RESCO runs it.
//!
//! - **State**: a row of five numbers per lane ([`super::state::lanes`]).
//! - **Action**: the next green phase.
//! - **Reward**: the lanes' waiting time, negative ([`super::state::wait_reward`]).
//! - **Network**: a 2 x 2 convolution over lanes and numbers, two hidden layers, a value per phase.
//!
//! Source: RESCO, agents/pfrl_dqn.py; Ault and Sharon, "Reinforcement learning benchmarks for traffic
//! signal control" (NeurIPS 2021, datasets and benchmarks).

use std::f32::consts::SQRT_2;

use super::deep_q::{self, DeepQ, deep_q_settings};
use super::learner::{Learner, Learning};
use super::senses::View;
use super::{Controller, Setup, SignalSpec};
use evaluation::run::method::{Method, Training};
use learners::nn::Activation;
use learners::nn::init::Init;
use learners::nn::sequential::Sequential;
use learners::rl::normalise::Normaliser;
use learners::rl::random::Generator;

/// The method.
pub const METHOD: Method = Method {
    summary: "deep Q-learning on lanes, a learner per signal (RESCO)",
    decision_s: 6e-4,
    settings: Config::SETTINGS,
    ..Method::built_in("idqn", Training::Learned, "#4b2e83")
};

deep_q_settings! { {
    /// Hyper-parameters of `idqn`; the defaults are RESCO's.
    pub struct Config extends deep_q::Config
} "RESCO, config/agent_config.py and agents/pfrl_dqn.py" and {
    /// Channels of the convolution and units of both hidden layers.
    hidden: usize = 64, in 1.0..=1024.0, unit "units";
} }

/// Number of the layer that gives the values, which no ReLU follows.
const VALUE_LAYER: usize = 3;

/// Returns IDQN, untrained.
pub fn create(config: &Config, setup: &Setup) -> Box<dyn Controller> {
    Box::new(Learning::new(METHOD.name, config.clone(), setup))
}

impl Learner for Config {
    type Agent = DeepQ<Sequential>;

    fn agents(
        &mut self,
        signals: &[SignalSpec],
        views: &[(usize, View)],
        _: usize,
        seed: u64,
    ) -> Result<Vec<Self::Agent>, String> {
        let init = |layer| match (self.orthogonal_initialisation, layer) {
            (false, _) => Init::Uniform,
            (true, VALUE_LAYER) => Init::Orthogonal(1.0),
            (true, _) => Init::Orthogonal(SQRT_2),
        };
        let agent = |(signal, view): &(usize, View)| {
            let phases = signals[*signal].phases.len();
            let network = view.hidden_layers(self.hidden).linear(phases, Activation::None);
            let label = signal.to_string();
            let mut generator = Generator::new(seed, &["initialisation", &label]);
            let parameters = network.initial(&init, generator.rng());
            DeepQ::new((&*self).into(), (network, parameters), 1, seed, &[&label])
        };
        Ok(views.iter().map(agent).collect())
    }

    fn normaliser(&self, view: View) -> Option<Normaliser> {
        self.normalise_observations.then(|| Normaliser::new(view.width()))
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

//! MPLight: deep Q-learning on pressure with the network FRAP, one learner for all signals, as RESCO
//! runs it.
//!
//! - **State**: the current phase, and the pressure of every movement ([`super::state::pressures`]).
//! - **Action**: the next green phase.
//! - **Reward**: the signal's pressure, negative ([`super::state::pressure_reward`]), not scaled.
//! - **Network**: [`learners::nn::frap`], which serves signals of any layout; so all signals of a scenario
//!   share it, the replay buffer and the updates.
//!
//! Source: Chen et al., "Toward a thousand lights: decentralized deep reinforcement learning for
//! large-scale traffic signal control" (AAAI 2020); RESCO, agents/mplight.py.

use std::f32::consts::SQRT_2;

use super::deep_q::{self, DeepQ, deep_q_settings};
use super::learner::{Learner, Learning};
use super::senses::View;
use super::state::{Demand, movement_slots, pressure_reward};
use super::{Controller, Observation, Setup, SignalSpec};
use evaluation::run::method::{Method, Training};
use learners::nn::frap::{Frap, HEAD, PhaseLayout};
use learners::nn::init::Init;
use learners::rl::normalise::Normaliser;
use learners::rl::random::Generator;

/// The method.
pub const METHOD: Method = Method {
    summary: "deep Q-learning on pressure, one FRAP network for all signals (RESCO)",
    decision_s: 6e-4,
    settings: Config::SETTINGS,
    ..Method::built_in("mplight", Training::Learned, "#56b4e9")
};

deep_q_settings! { {
    /// Hyper-parameters of `mplight`; the defaults are RESCO's.
    pub struct Config extends deep_q::Config
} "RESCO, config/agent_config.py and agents/mplight.py" and {} }

/// Returns MPLight, untrained.
pub fn create(config: &Config, setup: &Setup) -> Box<dyn Controller> {
    let learner = MpLight::new(config.into(), Demand::Pressure);
    Box::new(Learning::new(METHOD.name, learner, setup))
}

/// MPLight and its variants.
#[derive(Debug)]
pub(super) struct MpLight {
    config: deep_q::Config,
    demand: Demand,
    /// Numbers of the demand.
    width: usize,
}

impl MpLight {
    /// Returns a learner that sees this of movements.
    pub(super) fn new(config: deep_q::Config, demand: Demand) -> Self {
        Self { config, demand, width: 0 }
    }
}

impl Learner for MpLight {
    type Agent = DeepQ<Frap>;

    const IS_SHARED: bool = true;

    const HEAD: usize = HEAD;

    const REWARD: fn(&Observation) -> f32 = pressure_reward;

    /// FRAP is made of movements and phases, which other numbers do not have.
    fn agents(
        &mut self,
        signals: &[SignalSpec],
        views: &[(usize, View)],
        at_once: usize,
        seed: u64,
    ) -> Result<Vec<Self::Agent>, String> {
        if views.iter().any(|(_, view)| matches!(view, View::Own(_))) {
            return Err("its network is made of movements and phases, so that only its reward can be replaced; leave the \
                        observation as it is, or build on idqn or ippo"
                .to_owned());
        }
        self.width = signals.iter().map(movement_slots).max().unwrap_or(0) * self.demand.width();
        let layout = |(signal, _): &(usize, View)| {
            let SignalSpec { movements, phases, .. } = &signals[*signal];
            let index = |m: &usize| movements[*m].index;
            let pairs: Vec<Vec<usize>> =
                phases.iter().map(|p| p.pair.iter().map(index).collect()).collect();
            PhaseLayout::new(&pairs, self.demand.width())
        };
        let layouts = views.iter().map(layout).collect();
        let network = Frap::new(layouts, self.demand.width(), self.width);
        let orthogonal = self.config.orthogonal_initialisation;
        let init = if orthogonal { Init::Orthogonal(SQRT_2) } else { Init::Uniform };
        let parameters = network.initial(init, Generator::new(seed, &["initialisation"]).rng());
        let config = self.config.clone();
        Ok(vec![DeepQ::new(config, (network, parameters), at_once, seed, &[])])
    }

    fn normaliser(&self, _: View) -> Option<Normaliser> {
        self.config.normalise_observations.then(|| Normaliser::new(self.width))
    }

    fn look(&self, number: usize, signal: &SignalSpec, seen: &Observation, state: &mut Vec<f32>) {
        state.clear();
        state.extend([number as f32, seen.phase as f32]);
        state.resize(HEAD + self.width, 0.0);
        self.demand.write(signal, seen, &mut state[HEAD..]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Trainer;
    use super::super::testing::{
        QueueWorld, check_learner, check_shown, signal_with, two_phase_signal,
    };
    use super::*;
    use crate::vocabulary::Light::{Protected, Red};

    fn learner(config: &Config, episodes: u32) -> Box<dyn Controller> {
        create(config, &Setup { seed: 7, episodes, ..Setup::default() })
    }

    #[test]
    fn it_learns_and_goes_on_from_a_checkpoint() {
        check_learner(&|episodes| learner(&Config::default(), episodes));
    }

    #[test]
    fn the_options_learn_too() {
        let config = Config {
            bootstrap_at_time_limit: true,
            double_dqn: true,
            normalise_observations: true,
            orthogonal_initialisation: true,
            ..Config::default()
        };
        check_learner(&|episodes| learner(&config, episodes));
    }

    #[test]
    fn it_learns_of_the_phase_that_was_shown() {
        check_shown(&mut *learner(&Config::default(), 2), "replay.", HEAD + 12);
    }

    #[test]
    fn signals_of_different_layout_share_what_is_learned() {
        let three =
            signal_with(&[[Protected, Red, Red], [Red, Protected, Red], [Red, Red, Protected]]);
        let signals = vec![two_phase_signal(), three.clone()];
        let mut world = QueueWorld::new(signals.clone());
        let shared = MpLight::new((&Config::default()).into(), Demand::Pressure);
        let setup = Setup { seed: 7, episodes: 60, ..Setup::default() };
        let mut trained = Learning::new("mplight", shared, &setup);
        trained.train(&mut world).unwrap();
        let [(agent, _)] = trained.agents.as_slice() else { panic!("they share one") };
        assert_eq!(agent.dqn.transitions(), 60 * 2 * u64::from(QueueWorld::DECISIONS));
        let together = world.episode(&mut trained, 0).unwrap().delay_s;
        let untrained = world.episode(&mut *learner(&Config::default(), 60), 0).unwrap();
        assert!(together < 0.6 * untrained.delay_s, "{together} {}", untrained.delay_s);
        // What was learned on both serves a third that is like neither.
        let mut other = learner(&Config::default(), 60);
        other.load(trained.model().unwrap()).unwrap();
        let mut alone = QueueWorld::new(vec![three]);
        assert!(alone.episode(&mut *other, 0).unwrap().delay_s < 0.6 * untrained.delay_s);
    }
}

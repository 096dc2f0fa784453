//! MPLight: deep Q-learning on pressure with the network FRAP, one learner for all signals, as RESCO
//! runs it.
//!
//! - **State**: the current phase, and the pressure of every movement ([`super::state::pressures`]).
//! - **Action**: the next green phase.
//! - **Reward**: the signal's pressure, negative ([`super::state::pressure_reward`]), not scaled.
//! - **Network**: [`learners::nn::frap`], which serves signals of any layout; so all signals of a scenario
//!   share it, the replay buffer and the updates.
//! - **Counters** of exploration, updates and target copies run per transition, that is, as many times
//!   as fast as there are signals, and their limits are as many times as large.
//!
//! Deviation: where the limits of timing did not allow the phase that was asked for, what is learned is the
//! value of the one that was shown; RESCO, whose signals obey at once, knows no difference.
//!
//! Signals with a single phase stay green and learn nothing.
//!
//! Source: Chen et al., "Toward a thousand lights: decentralized deep reinforcement learning for
//! large-scale traffic signal control" (AAAI 2020); RESCO, agents/mplight.py.

use std::f32::consts::SQRT_2;

use super::learner::{Learner, Learning};
use super::senses::{Given, View};
use super::state::{Demand, movement_slots, pressure_reward};
use super::training::{TrainingState, decides, is_checkpoint};
use super::{ControlError, Controller, GreenPhase, Observation, Setup, SignalSpec};
use evaluation::run::method::{Method, Training};
use learners::nn::archive::Archive;
use learners::nn::frap::{Frap, HEAD, PhaseLayout};
use learners::nn::init::Init;
use learners::nn::state::{Learned as _, State as _};
use learners::rl::dqn::{Dqn, Flavour, Settings};
use learners::rl::normalise::Normaliser;
use learners::rl::persist::Persist;
use learners::rl::random::Generator;
use learners::rl::replay::Transition;
use learners::rl::schedule::linear_epsilon;

/// The method.
pub const METHOD: Method = Method {
    summary: "deep Q-learning on pressure, one FRAP network for all signals (RESCO)",
    decision_s: 6e-4,
    settings: Config::SETTINGS,
    ..Method::built_in("mplight", Training::Learned, "#56b4e9")
};

/// Declares the hyper-parameters of MPLight, and those that a variant of it adds.
macro_rules! mplight_settings {
    ({ $($head:tt)* } $($more:tt)*) => {
        evaluation::settings::setting::settings! {
            $($head)*, source "RESCO, config/agent_config.py and agents/mplight.py" {
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
                /// Decisions between two updates; one is made for all signals together.
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
pub(super) use mplight_settings;

mplight_settings! { {
    /// Hyper-parameters of `mplight`; the defaults are RESCO's.
    pub struct Config
} }

/// Returns MPLight, untrained.
pub fn create(config: &Config, setup: &Setup) -> Box<dyn Controller> {
    let learner = MpLight::new(METHOD.name, config.clone(), Demand::Pressure, setup.seed);
    Box::new(Learning::new(learner, setup))
}

/// A signal that the learner decides for.
#[derive(Debug)]
struct Controlled {
    /// Index of the signal.
    signal: usize,
    phases: usize,
    state: Vec<f32>,
    next: Vec<f32>,
}

/// What is learned, for all signals.
#[derive(Debug)]
struct Shared {
    dqn: Dqn<Frap>,
    normaliser: Option<Normaliser>,
}

/// MPLight and its variants.
#[derive(Debug)]
pub(super) struct MpLight {
    name: &'static str,
    config: Config,
    demand: Demand,
    seed: u64,
    controlled: Vec<Controlled>,
    shared: Option<Shared>,
    senses: Given,
}

impl MpLight {
    /// Returns a learner that sees this of movements; `seed` is of everything random in it.
    pub(super) fn new(name: &'static str, config: Config, demand: Demand, seed: u64) -> Self {
        let (controlled, shared, senses) = (vec![], None, Given::default());
        Self { name, config, demand, seed, controlled, shared, senses }
    }

    /// Returns the share of random actions.
    fn epsilon(&self, training: &TrainingState) -> f64 {
        let config = &self.config;
        let span = training.exploration_span(config.exploration_fraction, self.controlled.len());
        let seen = self.shared.as_ref().map_or(0, |s| s.dqn.transitions());
        linear_epsilon(config.start_e, config.end_e, span, seen)
    }
}

impl Learner for MpLight {
    fn name(&self) -> &'static str {
        self.name
    }

    fn reseed(&mut self, seed: u64) {
        self.seed = seed;
    }

    fn senses(&mut self) -> &mut Given {
        &mut self.senses
    }

    /// FRAP is made of movements and phases, which other numbers do not have.
    fn meet(&mut self, signals: &[SignalSpec]) -> Result<(), String> {
        let mut views = signals.iter().enumerate().map(|(i, spec)| self.senses.view(i, spec));
        if views.any(|view| matches!(view, View::Own(_))) {
            return Err("its network is made of movements and phases, so that only its reward can be replaced; leave the \
                        observation as it is, or build on idqn or ippo"
                .to_owned());
        }
        let slots = signals.iter().map(movement_slots).max().unwrap_or(0);
        let width = slots * self.demand.width();
        self.controlled.clear();
        let mut layouts = Vec::new();
        for (signal, spec) in signals.iter().enumerate().filter(|(_, s)| decides(s)) {
            let index = |m: &usize| spec.movements[*m].index;
            let pairs: Vec<Vec<usize>> =
                spec.phases.iter().map(|p| p.pair.iter().map(index).collect()).collect();
            let mut state = vec![0.0; HEAD + width];
            state[0] = layouts.len() as f32;
            layouts.push(PhaseLayout::new(&pairs, self.demand.width()));
            let (phases, next) = (spec.phases.len(), state.clone());
            self.controlled.push(Controlled { signal, phases, state, next });
        }
        let config = &self.config;
        let count = self.controlled.len() as u64;
        let network = Frap::new(layouts, self.demand.width(), width);
        let orthogonal = config.orthogonal_initialisation;
        let init = if orthogonal { Init::Orthogonal(SQRT_2) } else { Init::Uniform };
        let mut generator = Generator::new(self.seed, &["initialisation"]);
        let parameters = network.initial(init, generator.rng());
        let settings = Settings {
            learning_rate: config.learning_rate,
            adam_epsilon: config.adam_epsilon,
            gamma: config.gamma,
            buffer_size: config.buffer_size,
            batch_size: config.batch_size,
            learning_starts: config.learning_starts as u64,
            train_frequency: u64::from(config.train_frequency) * count,
            target_network_frequency: u64::from(config.target_network_frequency) * count,
            ..Settings::default()
        };
        let flavour = Flavour::Pfrl { double: config.double_dqn };
        self.shared = (count > 0).then(|| Shared {
            dqn: Dqn::new(network, parameters, settings, flavour, self.seed, &[]),
            normaliser: config.normalise_observations.then(|| Normaliser::new(width)),
        });
        Ok(())
    }

    fn controls(&self) -> bool {
        self.shared.is_some()
    }

    fn act(
        &mut self,
        training: &TrainingState,
        signals: &[SignalSpec],
        observations: &[Observation],
        phases: &mut [GreenPhase],
    ) -> Result<(), String> {
        let epsilon = training.active.then(|| self.epsilon(training));
        let Some(shared) = &mut self.shared else { return Ok(()) };
        for own in &mut self.controlled {
            let seen = &observations[own.signal];
            own.state[1] = seen.phase as f32;
            let demand = &mut own.state[HEAD..];
            demand.fill(0.0);
            self.demand.write(&signals[own.signal], seen, demand);
            if let Some(normaliser) = &mut shared.normaliser {
                normaliser.take_in(demand, epsilon.is_some());
            }
            phases[own.signal] = GreenPhase(match epsilon {
                Some(epsilon) => shared.dqn.explore(&own.state, own.phases, epsilon),
                None => shared.dqn.greedy(&own.state),
            });
        }
        Ok(())
    }

    fn observe(
        &mut self,
        training: &mut TrainingState,
        signals: &[SignalSpec],
        observations: &[Observation],
        truncated: bool,
    ) -> Result<(), String> {
        let Some(shared) = &mut self.shared else { return Ok(()) };
        for own in &mut self.controlled {
            let seen = &observations[own.signal];
            let reward = self.senses.reward(own.signal, seen, pressure_reward)?;
            training.curve.reward += f64::from(reward);
            own.next[1] = seen.phase as f32;
            let demand = &mut own.next[HEAD..];
            demand.fill(0.0);
            self.demand.write(&signals[own.signal], seen, demand);
            if let Some(normaliser) = &shared.normaliser {
                normaliser.apply(demand);
            }
            shared.dqn.observe(&Transition {
                state: &own.state,
                // Not what was asked for where the limits of timing did not allow it.
                action: seen.phase,
                reward,
                next: &own.next,
                terminal: truncated && !self.config.bootstrap_at_time_limit,
            });
        }
        if truncated {
            training.curve.loss = shared.dqn.take_loss();
            training.curve.epsilon = Some(self.epsilon(training));
        }
        Ok(())
    }

    fn is_alive(&mut self) -> bool {
        self.shared.as_mut().is_none_or(|shared| shared.dqn.is_alive())
    }

    fn is_finite(&self) -> bool {
        self.shared.as_ref().is_none_or(|shared| shared.dqn.is_finite())
    }

    fn save(&self, archive: &mut Archive, is_checkpoint: bool) {
        let Some(shared) = &self.shared else { return };
        match is_checkpoint {
            true => shared.dqn.save("", archive),
            false => shared.dqn.learned("", archive),
        }
        if let Some(normaliser) = &shared.normaliser {
            normaliser.save("", archive);
        }
    }

    fn restore(&mut self, _: &[SignalSpec], archive: &Archive) -> Result<(), ControlError> {
        let Some(shared) = &mut self.shared else { return Ok(()) };
        match is_checkpoint(archive) {
            true => shared.dqn.restore("", archive)?,
            false => shared.dqn.load("", archive)?,
        }
        if let Some(normaliser) = &mut shared.normaliser {
            normaliser.restore("", archive)?;
        }
        Ok(())
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
        let shared = MpLight::new("mplight", Config::default(), Demand::Pressure, 7);
        let setup = Setup { seed: 7, episodes: 60, ..Setup::default() };
        let mut trained = Learning::new(shared, &setup);
        trained.train(&mut world).unwrap();
        let shared = trained.learner.shared.as_ref().unwrap();
        assert_eq!(shared.dqn.transitions(), 60 * 2 * u64::from(QueueWorld::DECISIONS));
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

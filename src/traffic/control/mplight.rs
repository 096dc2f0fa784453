//! MPLight: deep Q-learning on pressure with the network FRAP, one learner for all signals, as RESCO
//! runs it.
//!
//! - **State**: the current phase, and the pressure of every movement ([`super::state::pressures`]).
//! - **Action**: the next green phase.
//! - **Reward**: the signal's pressure, negative ([`super::state::pressure_reward`]), not scaled.
//! - **Network**: [`crate::nn::frap`], which serves signals of any layout; so all signals of a scenario
//!   share it, the replay buffer and the updates.
//! - **Counters** of exploration, updates and target copies run per transition, that is, as many times
//!   as fast as there are signals, and their limits are as many times as large.
//!
//! Signals with a single phase stay green and learn nothing.
//!
//! Source: Chen et al., "Toward a thousand lights: decentralized deep reinforcement learning for
//! large-scale traffic signal control" (AAAI 2020); RESCO, agents/mplight.py.

use std::collections::BTreeMap;
use std::f32::consts::SQRT_2;

use super::state::{Demand, movement_slots, pressure_reward};
use super::training::{self, Learner, TrainingState, decides, is_checkpoint};
use super::{ControlError, Controller, Drive, GreenPhase, Observation, Setup, SignalSpec, Trainer};
use crate::nn::archive::Archive;
use crate::nn::frap::{Frap, HEAD, Layout};
use crate::nn::init::Init;
use crate::rl::dqn::{Dqn, Settings};
use crate::rl::normalise::Normaliser;
use crate::rl::random::Generator;
use crate::rl::replay::Transition;
use crate::rl::schedule::linear_epsilon;
use crate::run::method::{Method, Training};

/// The method.
pub const METHOD: Method = Method {
    name: "mplight",
    summary: "deep Q-learning on pressure, one FRAP network for all signals (RESCO)",
    training: Training::Learned,
    default: false,
    decision_s: 6e-4,
    color: "#56b4e9",
    dash: "",
    settings: Config::SETTINGS,
};

/// Declares the hyper-parameters of MPLight, and those that a variant of it adds.
macro_rules! mplight_settings {
    ({ $($head:tt)* } $($more:tt)*) => {
        $crate::settings::setting::settings! {
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
                /// Transitions stored before the first update, a batch at least.
                learning_starts: usize = 32, in 1.0..=1e6, at most buffer_size, unit "transitions";
                /// Decisions between two updates; one is made for all signals together.
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
            } $($more)*
        }
    };
}
pub(super) use mplight_settings;

mplight_settings! { {
    /// Hyper-parameters of `mplight`; the defaults are RESCO's.
    pub struct Config
} }

/// A signal that the learner decides for.
#[derive(Debug, Clone)]
struct Place {
    /// Index of the signal.
    signal: usize,
    phases: usize,
    state: Vec<f32>,
    next: Vec<f32>,
    action: usize,
}

/// What is learned, for all signals.
#[derive(Debug, Clone)]
struct Shared {
    dqn: Dqn<Frap>,
    normaliser: Option<Normaliser>,
}

/// MPLight and its variants.
#[derive(Debug, Clone)]
pub struct MpLight {
    name: &'static str,
    config: Config,
    demand: Demand,
    seed: u64,
    training: TrainingState,
    signals: Vec<SignalSpec>,
    places: Vec<Place>,
    shared: Option<Shared>,
}

/// Returns MPLight, untrained.
pub fn create(config: &Config, setup: &Setup) -> Box<dyn Controller> {
    Box::new(MpLight::new(config.clone(), setup.episodes, setup.seed))
}

impl MpLight {
    /// Returns an untrained controller; `seed` is for everything random in it.
    pub fn new(config: Config, episodes: u32, seed: u64) -> Self {
        Self::variant(METHOD.name, config, Demand::Pressure, episodes, seed)
    }

    /// Returns an untrained variant that sees other things of movements.
    pub(super) fn variant(
        name: &'static str,
        config: Config,
        demand: Demand,
        episodes: u32,
        seed: u64,
    ) -> Self {
        let (training, shared) = (TrainingState::new(episodes), None);
        Self { name, config, demand, seed, training, signals: vec![], places: vec![], shared }
    }

    fn build(&mut self, signals: &[SignalSpec]) {
        self.signals = signals.to_vec();
        let slots = signals.iter().map(movement_slots).max().unwrap_or(0);
        let width = slots * self.demand.width();
        self.places.clear();
        let mut layouts = Vec::new();
        for (signal, spec) in signals.iter().enumerate().filter(|(_, s)| decides(s)) {
            let index = |m: &usize| spec.movements[*m].index;
            let pairs: Vec<Vec<usize>> =
                spec.phases.iter().map(|p| p.pair.iter().map(index).collect()).collect();
            let mut state = vec![0.0; HEAD + width];
            state[0] = layouts.len() as f32;
            layouts.push(Layout::new(&pairs, self.demand.stride()));
            let (phases, next) = (spec.phases.len(), state.clone());
            self.places.push(Place { signal, phases, state, next, action: 0 });
        }
        let config = &self.config;
        let count = self.places.len() as u64;
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
            learning_starts: config.learning_starts,
            train_frequency: u64::from(config.train_frequency) * count,
            target_network_frequency: u64::from(config.target_network_frequency) * count,
            double_dqn: config.double_dqn,
        };
        self.shared = (count > 0).then(|| Shared {
            dqn: Dqn::new(network, parameters, settings, self.seed, &[]),
            normaliser: config.normalise_observations.then(|| Normaliser::new(width)),
        });
    }

    /// Returns the values of the phases of the first signal.
    #[cfg(test)]
    pub(super) fn values(&mut self, seen: &Observation) -> Vec<f32> {
        let place = &mut self.places[0];
        self.demand.write(&self.signals[place.signal], seen, &mut place.state[HEAD..]);
        let shared = self.shared.as_mut().expect("a signal to decide for");
        shared.dqn.values(&place.state).to_vec()
    }

    /// Returns the share of random actions.
    fn epsilon(&self) -> f64 {
        let config = &self.config;
        let count = self.places.len();
        let span = self.training.exploration_span(config.exploration_fraction, count);
        let seen = self.shared.as_ref().map_or(0, |s| s.dqn.transitions());
        linear_epsilon(config.start_e, config.end_e, span, seen)
    }

    fn restore(&mut self, archive: &Archive) -> Result<(), ControlError> {
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

impl Controller for MpLight {
    fn name(&self) -> &'static str {
        self.name
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        let changed = self.signals != signals;
        if changed {
            self.build(signals);
        }
        if let Some(archive) = self.training.adopted(changed) {
            self.restore(&archive)?;
        }
        Ok(training::drives(signals))
    }

    fn act(&mut self, observations: &[Observation], phases: &mut [GreenPhase]) {
        let epsilon = self.training.active.then(|| self.epsilon());
        let Some(shared) = &mut self.shared else { return };
        for place in &mut self.places {
            let seen = &observations[place.signal];
            place.state[1] = seen.phase as f32;
            let demand = &mut place.state[HEAD..];
            demand.fill(0.0);
            self.demand.write(&self.signals[place.signal], seen, demand);
            if let Some(normaliser) = &mut shared.normaliser {
                normaliser.take_in(demand, epsilon.is_some());
            }
            place.action = match epsilon {
                Some(epsilon) => shared.dqn.explore(&place.state, place.phases, epsilon),
                None => shared.dqn.greedy(&place.state),
            };
            phases[place.signal] = GreenPhase(place.action);
        }
    }

    fn observe(&mut self, observations: &[Observation], truncated: bool) {
        let Some(shared) = self.shared.as_mut().filter(|_| self.training.active) else { return };
        for place in &mut self.places {
            let seen = &observations[place.signal];
            let reward = pressure_reward(seen);
            self.training.curve.reward += f64::from(reward);
            place.next[1] = seen.phase as f32;
            let demand = &mut place.next[HEAD..];
            demand.fill(0.0);
            self.demand.write(&self.signals[place.signal], seen, demand);
            if let Some(normaliser) = &shared.normaliser {
                normaliser.apply(demand);
            }
            shared.dqn.observe(&Transition {
                state: &place.state,
                action: place.action,
                reward,
                next: &place.next,
                terminal: truncated && !self.config.bootstrap_at_time_limit,
            });
        }
        if truncated {
            self.training.curve.loss = shared.dqn.take_loss();
            self.training.curve.epsilon = Some(self.epsilon());
        }
    }

    fn train(&mut self, trainer: &mut dyn Trainer) -> Result<(), ControlError> {
        training::train(self, trainer)
    }

    fn details(&self) -> BTreeMap<String, String> {
        training::remarks(self.name(), &self.training, &self.signals)
    }

    fn figures(&self) -> BTreeMap<String, f64> {
        self.training.figures()
    }

    fn model(&self) -> Option<Archive> {
        let shared = self.shared.as_ref()?;
        let mut model = training::model(self.name, &self.signals);
        let (network, parameters) = shared.dqn.learned();
        crate::nn::save(network, parameters, "", &mut model);
        if let Some(normaliser) = &shared.normaliser {
            normaliser.save("", &mut model);
        }
        Some(model)
    }

    fn load(&mut self, model: Archive) -> Result<(), ControlError> {
        self.training.load(self.name, model)
    }
}

impl Learner for MpLight {
    fn training(&mut self) -> &mut TrainingState {
        &mut self.training
    }

    fn controls(&self) -> bool {
        self.shared.is_some()
    }

    fn is_finite(&self) -> bool {
        self.shared.as_ref().is_none_or(|shared| shared.dqn.is_finite())
    }

    fn save(&self, archive: &mut Archive) {
        if let Some(shared) = &self.shared {
            shared.dqn.save("", archive);
            if let Some(normaliser) = &shared.normaliser {
                normaliser.save("", archive);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Service::{None as Red, Protected};
    use super::super::testing::{QueueWorld, check_learner, signal_with, two_phase_signal};
    use super::*;

    #[test]
    fn it_learns_and_goes_on_from_a_checkpoint() {
        check_learner(&|episodes| Box::new(MpLight::new(Config::default(), episodes, 7)));
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
        check_learner(&|episodes| Box::new(MpLight::new(config.clone(), episodes, 7)));
    }

    #[test]
    fn signals_of_different_layout_share_what_is_learned() {
        let three =
            signal_with(&[[Protected, Red, Red], [Red, Protected, Red], [Red, Red, Protected]]);
        let signals = vec![two_phase_signal(), three.clone()];
        let mut world = QueueWorld::new(signals.clone());
        let mut learner = MpLight::new(Config::default(), 60, 7);
        learner.train(&mut world).unwrap();
        let shared = learner.shared.as_ref().unwrap();
        assert_eq!(shared.dqn.transitions(), 60 * 2 * u64::from(QueueWorld::DECISIONS));
        let together = world.episode(&mut learner, 0).unwrap().delay_s;
        let untrained = world.episode(&mut MpLight::new(Config::default(), 60, 7), 0).unwrap();
        assert!(together < 0.6 * untrained.delay_s, "{together} {}", untrained.delay_s);
        // What was learned on both serves a third that is like neither.
        let mut other = MpLight::new(Config::default(), 60, 7);
        other.load(learner.model().unwrap()).unwrap();
        let mut alone = QueueWorld::new(vec![three]);
        assert!(alone.episode(&mut other, 0).unwrap().delay_s < 0.6 * untrained.delay_s);
    }
}

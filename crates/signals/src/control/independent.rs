//! Independent learners, one per signal, that see its lanes and are paid for waiting: all of IDQN and IPPO
//! but the algorithm.
//!
//! Source: RESCO, agents/agent.py (`IndependentAgent`).

use super::learner::Learner;
use super::senses::{Given, View};
use super::state::{lanes, wait_reward};
use super::training::{Curve, TrainingState, check_shape, decides, is_checkpoint, mean};
use super::{ControlError, GreenPhase, Observation, SignalSpec};
use learners::nn::archive::Archive;
use learners::nn::state::State as _;
use learners::rl::normalise::Normaliser;
use learners::rl::persist::Persist;

/// The algorithm of one signal's learner.
pub(super) trait Agent: Sized {
    /// Stable name of the method.
    const NAME: &'static str;

    /// Hyper-parameters.
    type Config;

    /// Returns an agent with a view and this number of phases that has learned nothing yet; `seed` and `label` name its
    /// randomness.
    fn new(config: &Self::Config, view: View, phases: usize, seed: u64, label: &str) -> Self;

    /// Whether observations are shifted and scaled by their running mean and deviation.
    fn normalises(config: &Self::Config) -> bool;

    /// Chooses a phase: as training does in a training episode, else as evaluation does.
    fn choose(&mut self, state: &[f32], training: &TrainingState) -> usize;

    /// Learns from a decision.
    fn learn(&mut self, step: &Step<'_>);

    /// Returns what was measured in the episode that ends.
    fn curve(&mut self, training: &TrainingState) -> Curve;

    /// Begins an episode of validation, in which every policy draws the same random numbers.
    fn begin_validation(&mut self) {}

    fn kept(&self) -> &dyn Persist;

    /// The same, to be replaced.
    fn kept_mut(&mut self) -> &mut dyn Persist;
}

/// A decision and what came of it.
#[derive(Debug)]
pub(super) struct Step<'a> {
    /// What was seen before.
    pub(super) state: &'a [f32],
    /// The phase that was asked for.
    pub(super) asked: usize,
    /// The phase that the lights are at or changing to afterwards: not what was asked for where the limits
    /// of timing did not allow it.
    pub(super) shown: usize,
    pub(super) reward: f32,
    /// What was seen afterwards.
    pub(super) next: &'a [f32],
    /// Whether the episode ends with it.
    pub(super) truncated: bool,
}

/// The learner of one signal.
#[derive(Debug)]
struct OfSignal<A> {
    /// Index of the signal.
    signal: usize,
    agent: A,
    normaliser: Option<Normaliser>,
    state: Vec<f32>,
    next: Vec<f32>,
    asked: usize,
}

impl<A> OfSignal<A> {
    fn prefix(&self) -> String {
        format!("signal{}.", self.signal)
    }
}

/// Learners of all signals that leave something to decide.
#[derive(Debug)]
pub(super) struct Independent<A: Agent> {
    config: A::Config,
    seed: u64,
    learners: Vec<OfSignal<A>>,
    senses: Given,
}

impl<A: Agent> Independent<A> {
    /// Returns learners that have met no signal yet; `seed` is of everything random in them.
    pub(super) fn new(config: A::Config, seed: u64) -> Self {
        Self { config, seed, learners: Vec::new(), senses: Given::default() }
    }
}

impl<A: Agent> Learner for Independent<A> {
    fn name(&self) -> &'static str {
        A::NAME
    }

    fn reseed(&mut self, seed: u64) {
        self.seed = seed;
    }

    fn begin_validation(&mut self) {
        self.learners.iter_mut().for_each(|own| own.agent.begin_validation());
    }

    fn senses(&mut self) -> &mut Given {
        &mut self.senses
    }

    fn meet(&mut self, signals: &[SignalSpec]) -> Result<(), String> {
        let learner = |(signal, spec): (usize, &SignalSpec)| {
            let view = self.senses.view(signal, spec);
            let (width, phases) = (view.width(), spec.phases.len());
            OfSignal {
                signal,
                agent: A::new(&self.config, view, phases, self.seed, &signal.to_string()),
                normaliser: A::normalises(&self.config).then(|| Normaliser::new(width)),
                state: Vec::with_capacity(width),
                next: Vec::with_capacity(width),
                asked: 0,
            }
        };
        self.learners =
            signals.iter().enumerate().filter(|(_, s)| decides(s)).map(learner).collect();
        Ok(())
    }

    fn controls(&self) -> bool {
        !self.learners.is_empty()
    }

    fn act(
        &mut self,
        training: &TrainingState,
        signals: &[SignalSpec],
        observations: &[Observation],
        phases: &mut [GreenPhase],
    ) -> Result<(), String> {
        for own in &mut self.learners {
            let (spec, seen) = (&signals[own.signal], &observations[own.signal]);
            let lanes = |state: &mut Vec<f32>| lanes(spec, seen, state);
            self.senses.observe(own.signal, seen, &mut own.state, lanes)?;
            if let Some(normaliser) = &mut own.normaliser {
                normaliser.take_in(&mut own.state, training.active);
            }
            own.asked = own.agent.choose(&own.state, training);
            phases[own.signal] = GreenPhase(own.asked);
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
        for own in &mut self.learners {
            let (spec, seen) = (&signals[own.signal], &observations[own.signal]);
            let reward = self.senses.reward(own.signal, seen, wait_reward)?;
            training.curve.reward += f64::from(reward);
            let lanes = |state: &mut Vec<f32>| lanes(spec, seen, state);
            self.senses.observe(own.signal, seen, &mut own.next, lanes)?;
            if let Some(normaliser) = &own.normaliser {
                normaliser.apply(&mut own.next);
            }
            own.agent.learn(&Step {
                state: &own.state,
                asked: own.asked,
                shown: seen.phase,
                reward,
                next: &own.next,
                truncated,
            });
        }
        if truncated {
            let curves: Vec<Curve> =
                self.learners.iter_mut().map(|own| own.agent.curve(training)).collect();
            let of = |value: fn(&Curve) -> Option<f64>| -> Vec<f64> {
                curves.iter().filter_map(value).collect()
            };
            training.curve.loss = mean(&of(|c| c.loss));
            training.curve.entropy = mean(&of(|c| c.entropy));
            training.curve.epsilon = curves.first().and_then(|c| c.epsilon);
        }
        Ok(())
    }

    /// With several signals one dead network is enough.
    fn is_alive(&mut self) -> bool {
        self.learners.iter_mut().all(|own| own.agent.kept_mut().is_alive())
    }

    fn is_finite(&self) -> bool {
        self.learners.iter().all(|own| own.agent.kept().is_finite())
    }

    fn save(&self, archive: &mut Archive, is_checkpoint: bool) {
        for own in &self.learners {
            match is_checkpoint {
                true => own.agent.kept().save(&own.prefix(), archive),
                false => own.agent.kept().learned(&own.prefix(), archive),
            }
            if let Some(normaliser) = &own.normaliser {
                normaliser.save(&own.prefix(), archive);
            }
        }
    }

    fn restore(&mut self, signals: &[SignalSpec], archive: &Archive) -> Result<(), ControlError> {
        check_shape(archive, signals)?;
        for own in &mut self.learners {
            let prefix = own.prefix();
            match is_checkpoint(archive) {
                true => own.agent.kept_mut().restore(&prefix, archive)?,
                false => own.agent.kept_mut().load(&prefix, archive)?,
            }
            if let Some(normaliser) = &mut own.normaliser {
                normaliser.restore(&prefix, archive)?;
            }
        }
        Ok(())
    }
}

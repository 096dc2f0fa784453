//! A controller that learns: what it does around its algorithm is the same for every one.

use std::collections::BTreeMap;

use super::senses::{Given, Senses};
use super::training::{self, CHECKPOINT, Curve, TrainingState, remarks};
use super::{ControlError, Controller, Drive, GreenPhase, Observation, Setup, SignalSpec, Trainer};
use basics::seed;
use learners::nn::archive::Archive;

/// What is a learner's own: networks, states, actions, rewards.
pub(super) trait Learner {
    /// Stable name of the method.
    fn name(&self) -> &'static str;

    /// Takes another seed of everything random in it; [`Self::meet`] follows.
    fn reseed(&mut self, seed: u64);

    /// Begins an episode of validation: what is drawn at random in it is the same for every policy.
    fn begin_validation(&mut self) {}

    /// What it sees and is paid for where that is not its own.
    fn senses(&mut self) -> &mut Given;

    /// Prepares for these signals, from the beginning.
    fn meet(&mut self, signals: &[SignalSpec]) -> Result<(), String>;

    /// Whether there is a signal to decide for; known after the first episode has begun.
    fn controls(&self) -> bool;

    /// As [`Controller::act`]; `training` says whether this is a training episode and where it stands.
    fn act(
        &mut self,
        training: &TrainingState,
        signals: &[SignalSpec],
        observations: &[Observation],
        phases: &mut [GreenPhase],
    ) -> Result<(), String>;

    /// As [`Controller::observe`], in training only; adds the rewards to the curve, and at the end of
    /// the episode what was measured in it.
    fn observe(
        &mut self,
        training: &mut TrainingState,
        signals: &[SignalSpec],
        observations: &[Observation],
        truncated: bool,
    ) -> Result<(), String>;

    /// Whether what it has learned depends on state and action; where it does not, the network is dead.
    fn is_alive(&mut self) -> bool;

    fn is_finite(&self) -> bool;

    /// Adds what it has learned; to a checkpoint everything that learning goes on from.
    fn save(&self, archive: &mut Archive, is_checkpoint: bool);

    /// Takes over what [`Self::save`] has added, also for other signals.
    fn restore(&mut self, signals: &[SignalSpec], archive: &Archive) -> Result<(), ControlError>;
}

/// A learner as a controller.
#[derive(Debug)]
pub(super) struct Learning<L> {
    pub(super) learner: L,
    name: &'static str,
    seed: u64,
    training: TrainingState,
    signals: Vec<SignalSpec>,
    /// Why a reward or an observation of somebody's own failed.
    fault: Option<String>,
}

impl<L: Learner> Learning<L> {
    /// Returns an untrained controller of a learner with this seed that is trained for so many episodes.
    pub(super) fn new(learner: L, &Setup { seed, episodes, .. }: &Setup) -> Self {
        let training = TrainingState::new(episodes);
        let name = learner.name();
        Self { learner, name, seed, training, signals: Vec::new(), fault: None }
    }

    /// Returns an error of senses that are somebody's own.
    fn own(&self, reason: String) -> ControlError {
        ControlError::Own { method: self.name, reason }
    }

    /// Validates what has been learned so far.
    fn validate(&mut self, trainer: &mut dyn Trainer) -> Result<(), ControlError> {
        self.training.active = false;
        let validated = trainer.validate(self);
        self.training.active = true;
        validated
    }
}

impl<L: Learner> Controller for Learning<L> {
    fn name(&self) -> &'static str {
        self.name
    }

    /// The learner drives each signal. Where there is a single phase it is that phase, for ever, which
    /// is what RESCO and an equal split do there too: greens that serve no vehicle are none of either.
    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        let changed = self.signals != signals;
        self.learner.senses().begin(signals).map_err(|reason| self.own(reason))?;
        if changed {
            self.signals = signals.to_vec();
            self.learner.meet(signals).map_err(|reason| self.own(reason))?;
        }
        if let Some(archive) = self.training.adopted(changed) {
            self.learner.restore(signals, &archive)?;
        }
        if self.training.validates {
            self.learner.begin_validation();
        }
        Ok(vec![Drive::Decisions; signals.len()])
    }

    fn act(
        &mut self,
        observations: &[Observation],
        phases: &mut [GreenPhase],
    ) -> Result<(), ControlError> {
        let acted = match self.fault.take() {
            Some(reason) => Err(reason),
            None => self.learner.act(&self.training, &self.signals, observations, phases),
        };
        acted.map_err(|reason| self.own(reason))
    }

    fn observe(&mut self, observations: &[Observation], truncated: bool) {
        if self.training.active && self.fault.is_none() {
            let training = &mut self.training;
            self.fault =
                self.learner.observe(training, &self.signals, observations, truncated).err();
        }
    }

    /// Trains, from a checkpoint if there is one.
    fn train(&mut self, trainer: &mut dyn Trainer) -> Result<(), ControlError> {
        self.training.decisions = trainer.decisions_per_episode();
        if let Some(archive) = trainer.saved() {
            self.training.resume(archive)?;
        }
        self.learner.reseed(seed::restart(self.seed, trainer.restarts()));
        self.training.active = true;
        while !trainer.stops() && self.training.done < self.training.episodes {
            let episode = self.training.done;
            self.training.curve = Curve::default();
            trainer.episode(self, episode)?;
            if let Some(reason) = self.fault.take() {
                return Err(self.own(reason));
            }
            if !self.learner.controls() {
                break;
            }
            self.training.done += 1;
            // An episode without an update has no loss.
            let loss = self.training.curve.loss;
            let finite = loss.is_none_or(f64::is_finite);
            if !finite || !self.learner.is_finite() {
                let what = if finite { "a parameter" } else { "the loss" };
                return Err(ControlError::Diverged { episode, what });
            }
            self.training.updated |= loss.is_some();
            if trainer.starts_again(!self.training.updated || self.learner.is_alive()) {
                self.training.start_again();
                self.learner.reseed(seed::restart(self.seed, trainer.restarts()));
                self.learner.meet(&self.signals).map_err(|reason| self.own(reason))?;
                continue;
            }
            self.validate(trainer)?;
            trainer.checkpoint(&|| {
                let mut archive = Archive::default();
                archive.put("kind", CHECKPOINT);
                archive.put("method", self.name());
                archive.put("episodes", self.training.done);
                archive.put("updated", self.training.updated);
                self.learner.save(&mut archive, true);
                archive
            })?;
        }
        self.training.active = false;
        Ok(())
    }

    fn set_senses(
        &mut self,
        name: &'static str,
        senses: Box<dyn Senses>,
    ) -> Result<(), ControlError> {
        self.name = name;
        self.learner.senses().take(senses);
        Ok(())
    }

    fn details(&self) -> BTreeMap<String, String> {
        remarks(self.name(), &self.training, &self.signals)
    }

    fn figures(&self) -> BTreeMap<String, f64> {
        self.training.figures()
    }

    fn model(&self) -> Option<Archive> {
        self.learner.controls().then(|| {
            let mut model = training::model(self.name(), &self.signals);
            self.learner.save(&mut model, false);
            model
        })
    }

    fn set_validation(&mut self, is_validation: bool) {
        self.training.validates = is_validation;
    }

    fn load(&mut self, model: Archive) -> Result<(), ControlError> {
        self.training.load(self.name(), model)
    }
}

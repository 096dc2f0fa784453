//! A learner without a network, for tests of whatever trains and evaluates.

use std::collections::BTreeMap;

use crate::nn::archive::Archive;
use crate::traffic::control::{
    ControlError, Controller, Drive, GreenPhase, Observation, SignalSpec, Trainer,
};

/// Learns nothing, but is never twice the same: its phases follow a state that every decision
/// changes.
#[derive(Clone, Default)]
pub(super) struct Learner {
    pub(super) episodes: u32,
    pub(super) done: u32,
    pub(super) state: u32,
    /// Episode after which training fails as if the process had been killed.
    pub(super) dies_after: Option<u32>,
    /// Episode in which training diverges.
    pub(super) diverges_in: Option<u32>,
    /// A checkpoint that the next episode begins with.
    pub(super) saved: Option<Archive>,
    /// Whether it knows its signals.
    pub(super) begun: bool,
    /// Whether it refuses checkpoints.
    pub(super) stubborn: bool,
}

impl Learner {
    /// Returns one that trains for so many episodes.
    pub(super) fn of(episodes: u32) -> Self {
        Self { episodes, ..Self::default() }
    }

    fn archive(&self) -> Archive {
        let mut archive = Archive::default();
        archive.put("kind", "whatever the learner likes");
        archive.put("done", self.done);
        archive.put_u32("state", &[2], &[self.done, self.state]);
        archive
    }
}

impl Controller for Learner {
    fn name(&self) -> &'static str {
        "idqn"
    }
    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        if let Some(saved) = self.saved.take() {
            let wanted: &[usize] = if self.stubborn { &[9] } else { &[2] };
            self.state = saved.u32("state", wanted)?[1];
        }
        self.begun = true;
        Ok(vec![Drive::Decisions; signals.len()])
    }
    fn act(&mut self, _: &[Observation], phases: &mut [GreenPhase]) {
        self.state = self.state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        phases[0] = GreenPhase((self.state >> 31) as usize);
    }
    fn train(&mut self, trainer: &mut dyn Trainer) -> Result<(), ControlError> {
        if let Some(saved) = trainer.saved() {
            self.done = saved.get("done")?;
            self.saved = Some(saved);
        }
        while self.done < self.episodes {
            let seed = self.done;
            trainer.episode(self, seed)?;
            if self.diverges_in == Some(self.done) {
                let (episode, what) = (self.done, "the loss");
                return Err(ControlError::Diverged { episode, what });
            }
            self.done += 1;
            trainer.checkpoint(&|| self.archive())?;
            if self.dies_after == Some(self.done) {
                return Err(ControlError::Search("killed".into()));
            }
        }
        Ok(())
    }
    fn figures(&self) -> BTreeMap<String, f64> {
        let figures = [("loss", 0.5), ("epsilon", f64::NAN), ("delay_s", -1.0)];
        figures.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
    }
    fn model(&self) -> Option<Archive> {
        self.begun.then(|| self.archive())
    }
}

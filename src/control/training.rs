//! What every learner does around its algorithm: episodes, checkpoints, the learning curve.

use std::collections::BTreeMap;

use crate::nn::archive::{Archive, ArchiveError};

use super::{ControlError, Controller, Drive, SignalSpec, Trainer};

/// Kinds of archives: what a learner has learned, and what a training goes on from.
const MODEL: &str = "model";
const CHECKPOINT: &str = "checkpoint";

/// Phases below which a signal has nothing to decide.
const MIN_PHASES: usize = 2;

/// What the last episode was like.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Curve {
    /// Sum of rewards over decisions and signals.
    pub(super) reward: f64,
    /// Mean loss of the updates.
    pub(super) loss: Option<f64>,
    /// Mean entropy of the policy in the updates.
    pub(super) entropy: Option<f64>,
    /// Share of random actions at the end.
    pub(super) epsilon: Option<f64>,
}

/// Where a training stands.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Training {
    /// Episodes in all.
    pub(super) episodes: u32,
    /// Episodes done.
    pub(super) done: u32,
    /// Whether this is a training episode.
    pub(super) active: bool,
    /// Decisions per episode.
    pub(super) decisions: u32,
    /// A model or checkpoint that the next episode begins with.
    pub(super) pending: Option<Archive>,
    /// The running or last episode.
    pub(super) curve: Curve,
}

impl Training {
    /// Returns a training that has not begun.
    pub(super) fn new(episodes: u32) -> Self {
        Self { episodes, ..Self::default() }
    }

    /// Returns the last episode by name.
    pub(super) fn figures(&self) -> BTreeMap<String, f64> {
        let Curve { reward, loss, entropy, epsilon } = self.curve;
        [("return", Some(reward)), ("loss", loss), ("entropy", entropy), ("epsilon", epsilon)]
            .into_iter()
            .filter_map(|(name, value)| Some((name.to_owned(), value?)))
            .collect()
    }

    /// Takes over a model of this method.
    pub(super) fn load(&mut self, method: &str, model: Archive) -> Result<(), ControlError> {
        let kind: String = model.get("kind")?;
        if kind != MODEL {
            let what = format!("kind {MODEL:?}; it is a {kind}");
            return Err(ArchiveError::Card(what).into());
        }
        let found: String = model.get("method")?;
        if found != method {
            let what = format!("method {method:?}; it is a model of {found}");
            return Err(ArchiveError::Card(what).into());
        }
        self.pending = Some(model);
        Ok(())
    }
}

/// A controller that learns from training episodes.
pub(super) trait Learner: Controller {
    /// Where its training stands.
    fn training(&mut self) -> &mut Training;

    /// Whether there is a signal to decide for; known after the first episode has begun.
    fn controls(&self) -> bool;

    /// Adds everything that learning goes on from.
    fn save(&self, archive: &mut Archive);
}

/// Trains a learner, from a checkpoint if there is one.
pub(super) fn train(
    learner: &mut dyn Learner,
    trainer: &mut dyn Trainer,
) -> Result<(), ControlError> {
    learner.training().decisions = trainer.decisions_per_episode();
    if let Some(archive) = trainer.saved() {
        learner.training().done = archive.get("episodes")?;
        learner.training().pending = Some(archive);
    }
    learner.training().active = true;
    while learner.training().done < learner.training().episodes {
        let episode = learner.training().done;
        learner.training().curve = Curve::default();
        trainer.episode(learner, episode)?;
        if !learner.controls() {
            break;
        }
        learner.training().done += 1;
        let Curve { reward, loss, .. } = learner.training().curve;
        for (what, value) in [("the return", reward), ("the loss", loss.unwrap_or(0.0))] {
            if !value.is_finite() {
                return Err(ControlError::Diverged { episode, what, value });
            }
        }
        let done = learner.training().done;
        let learner = &*learner;
        trainer.checkpoint(&|| {
            let mut archive = Archive::default();
            archive.put("kind", CHECKPOINT);
            archive.put("method", learner.name());
            archive.put("episodes", done);
            learner.save(&mut archive);
            archive
        })?;
    }
    learner.training().active = false;
    Ok(())
}

/// Whether an archive is a checkpoint and not a model.
pub(super) fn is_checkpoint(archive: &Archive) -> bool {
    archive.get::<String>("kind").is_ok_and(|kind| kind == CHECKPOINT)
}

/// Returns an empty model of a method, with the shape of the signals that it was trained on.
pub(super) fn model(method: &str, signals: &[SignalSpec]) -> Archive {
    let mut archive = Archive::default();
    archive.put("kind", MODEL);
    archive.put("method", method);
    let shape =
        |s: &SignalSpec| BTreeMap::from([("lanes", s.lanes.len()), ("phases", s.phases.len())]);
    archive.put("signals", signals.iter().map(shape).collect::<Vec<_>>());
    archive
}

/// Returns what drives each signal: the learner, or, where there is nothing to decide, the network's
/// own program, which is what the baseline runs there too.
pub(super) fn drives(signals: &[SignalSpec]) -> Vec<Drive> {
    let drive = |s: &SignalSpec| if decides(s) { Drive::Decisions } else { Drive::OwnProgram };
    signals.iter().map(drive).collect()
}

/// Whether a signal has more than one phase to choose from.
pub(super) fn decides(signal: &SignalSpec) -> bool {
    signal.phases.len() >= MIN_PHASES
}

/// Returns what to know of the signals: those without a choice, and lanes that no phase serves.
pub(super) fn remarks(signals: &[SignalSpec]) -> BTreeMap<String, String> {
    let mut remarks = BTreeMap::new();
    for signal in signals {
        if !decides(signal) {
            let text = "one phase, so nothing to control: it runs the network's own program";
            remarks.insert(format!("signal {}", signal.id), text.to_owned());
        }
        let unserved = signal.unserved_lanes();
        if !unserved.is_empty() {
            let name = format!("lanes that no phase of {} serves", signal.id);
            remarks.insert(name, unserved.join(", "));
        }
    }
    remarks
}

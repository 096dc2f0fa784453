//! Where the training of a learner stands: episodes, the learning curve, models and what to say of them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use learners::nn::archive::{Archive, ArchiveError};

use super::{ControlError, SignalSpec};

/// Kinds of archives: what a learner has learned, and what a training goes on from.
const MODEL: &str = "model";
pub(super) const CHECKPOINT: &str = "checkpoint";

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
pub(super) struct TrainingState {
    /// Episodes in all.
    pub(super) episodes: u32,
    /// Episodes done.
    pub(super) done: u32,
    /// Whether what has been learned is more than what it began with.
    pub(super) updated: bool,
    /// Whether this is a training episode.
    pub(super) active: bool,
    /// Whether this is an episode of validation.
    pub(super) validates: bool,
    /// Decisions per episode.
    pub(super) decisions: u32,
    /// A model or checkpoint that the next episode begins with.
    pending: Option<Archive>,
    /// The model that signals begin with, however often they change.
    model: Option<Archive>,
    /// The running or last episode.
    pub(super) curve: Curve,
}

impl TrainingState {
    /// Returns a training that has not begun.
    pub(super) fn new(episodes: u32) -> Self {
        Self { episodes, ..Self::default() }
    }

    /// Returns the model or checkpoint that an episode has to begin with; `changed` says that the
    /// signals are others than before.
    pub(super) fn adopted(&mut self, changed: bool) -> Option<Archive> {
        self.pending.take().or_else(|| self.model.clone().filter(|_| changed))
    }

    /// Starts again from the first episode.
    pub(super) fn start_again(&mut self) {
        (self.done, self.updated) = (0, false);
        self.curve = Curve::default();
    }

    /// Goes on from a checkpoint.
    pub(super) fn resume(&mut self, checkpoint: Archive) -> Result<(), ControlError> {
        self.done = checkpoint.get("episodes")?;
        self.updated = checkpoint.get("updated")?;
        self.pending = Some(checkpoint);
        Ok(())
    }

    /// Returns the transitions over which exploration falls: this share of the episodes, cut to whole
    /// ones, with as many transitions per decision as there are signals that learn together.
    pub(super) fn exploration_span(&self, fraction: f64, signals: usize) -> u64 {
        let episodes = (fraction * f64::from(self.episodes)).floor() as u64;
        episodes * u64::from(self.decisions) * signals as u64
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
        self.model = Some(model.clone());
        self.pending = Some(model);
        Ok(())
    }
}

/// Returns the mean, or nothing of nothing.
pub(super) fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

pub(super) fn is_checkpoint(archive: &Archive) -> bool {
    archive.get::<String>("kind").is_ok_and(|kind| kind == CHECKPOINT)
}

/// Returns an empty model of a method, with the shape of the signals that it was trained on.
pub(super) fn model(method: &str, signals: &[SignalSpec]) -> Archive {
    let mut archive = Archive::default();
    archive.put("kind", MODEL);
    archive.put("method", method);
    archive.put("signals", shapes(signals));
    archive
}

/// Checks that a model is for signals of this shape.
pub(super) fn check_shape(archive: &Archive, signals: &[SignalSpec]) -> Result<(), ControlError> {
    if is_checkpoint(archive) {
        return Ok(());
    }
    let found: Vec<Shape> = archive.get("signals")?;
    let wanted = shapes(signals);
    if found == wanted {
        return Ok(());
    }
    let words = |shapes: &[Shape]| {
        let words: Vec<String> =
            shapes.iter().map(|s| format!("{} lanes and {} phases", s.lanes, s.phases)).collect();
        words.join(", ")
    };
    let (found, wanted) = (words(&found), words(&wanted));
    Err(ArchiveError::Unfit(format!("it is for signals of {found}, these have {wanted}")).into())
}

/// Shape of a signal, on which the networks of some learners depend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct Shape {
    lanes: usize,
    phases: usize,
}

fn shapes(signals: &[SignalSpec]) -> Vec<Shape> {
    signals.iter().map(|s| Shape { lanes: s.lanes.len(), phases: s.phases.len() }).collect()
}

/// Whether a signal has more than one phase to choose from.
pub(super) fn decides(signal: &SignalSpec) -> bool {
    signal.phases.len() >= MIN_PHASES
}

/// Returns what to know of a training and its signals: that it was too short to learn anything, signals
/// without a choice, and lanes that no phase serves.
pub(super) fn remarks(
    method: &str,
    training: &TrainingState,
    signals: &[SignalSpec],
) -> BTreeMap<String, String> {
    let mut remarks = BTreeMap::new();
    if training.done > 0 && !training.updated {
        let text = format!(
            "too short for one update ({} episodes of {} decisions), so the model is as it began; \
             train for more episodes",
            training.done, training.decisions
        );
        remarks.insert(format!("training of {method}"), text);
    }
    for signal in signals {
        if !decides(signal) {
            let text = "one phase, so nothing to control: it keeps its own program";
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

#[cfg(test)]
mod tests {
    use super::super::idqn::{Config, create};
    use super::super::state::LANE_WIDTH;
    use super::super::testing::{QueueWorld, remembered, two_phase_signal};
    use super::super::{Controller, Setup};

    fn small() -> Config {
        Config { hidden: 16, ..Config::default() }
    }

    fn learner(config: &Config, episodes: u32) -> Box<dyn Controller> {
        create(config, &Setup { seed: 7, episodes, ..Setup::default() })
    }

    #[test]
    fn the_end_of_an_episode_is_terminal_unless_it_is_asked_not_to_be() {
        let count = QueueWorld::DECISIONS as usize;
        for (bootstrap_at_time_limit, expected) in [(false, vec![count - 1]), (true, vec![])] {
            let mut world = QueueWorld::new(vec![two_phase_signal()]);
            let config = Config { bootstrap_at_time_limit, ..small() };
            learner(&config, 1).train(&mut world).unwrap();
            let state = world.kept.borrow_mut().pop().unwrap();
            let replay = remembered(&state, "signal0.replay.", 2 * LANE_WIDTH);
            let terminals = (0..count).filter(|place| replay.get(*place).terminal);
            assert_eq!(terminals.collect::<Vec<_>>(), expected);
        }
    }

    #[test]
    fn a_training_too_short_for_one_update_says_so_also_when_it_was_continued() {
        let config = Config { learning_starts: 3 * QueueWorld::DECISIONS as usize, ..small() };
        let remark = |episodes| {
            let mut world = QueueWorld::new(vec![two_phase_signal()]);
            let mut whole = learner(&config, episodes);
            whole.train(&mut world).unwrap();
            world.saved = world.kept.borrow_mut().pop();
            let mut continued = learner(&config, episodes);
            continued.train(&mut world).unwrap();
            let [whole, continued] =
                [whole, continued].map(|l| l.details().get("training of idqn").cloned());
            assert_eq!(whole, continued);
            whole
        };
        let expected = format!(
            "too short for one update (2 episodes of {} decisions), so the model is as it began; \
             train for more episodes",
            QueueWorld::DECISIONS
        );
        assert_eq!((remark(2), remark(3)), (Some(expected), None));
    }

    #[test]
    fn exploration_ends_after_four_fifths_of_the_episodes() {
        let mut world = QueueWorld::new(vec![two_phase_signal()]);
        learner(&small(), 10).train(&mut world).unwrap();
        let epsilons: Vec<f64> = world.figures.iter().map(|f| f["epsilon"]).collect();
        let expected = [0.875, 0.75, 0.625, 0.5, 0.375, 0.25, 0.125, 0.0, 0.0, 0.0];
        assert_eq!(epsilons, expected);
    }
}

//! Models: what a learner has learned, with a card that says how, on what, and how well.
//!
//! A model has the tensors of the learner's own archive. The card is written here, with the
//! learner's own card on it: enough to set the learner up again, and to judge the model without
//! running it. Equal trainings give equal bytes, but for `score`, which is absent while the baseline
//! has no record yet.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::files::replace;
use crate::nn::archive::{Archive, ArchiveError};
use crate::run::error::EvalError;
use crate::settings::overrides::Override;
use crate::store::Layout;
use crate::store::manifest::{Identity, Task};
use crate::store::record::{Record, RowKind};
use crate::traffic::control::{ControlError, Controller};
use crate::traffic::controllers::create;
use crate::traffic::settings::check::check;
use crate::traffic::settings::{Preset, Scenario, SignalSettings};

use super::checkpoint::{CHECKPOINT, FORMAT_VERSION, KIND, LEARNER};

/// Value of `kind` on a model's card.
pub const MODEL: &str = "model";

/// What a model's file says of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModelCard {
    /// Always [`MODEL`].
    pub kind: String,
    /// Version of the file.
    pub format_version: u32,
    /// Name of the method.
    pub method: String,
    /// Id of the point MDP that it was trained on.
    pub point: String,
    /// Which of several independent trainings.
    pub replicate: u32,
    /// Seed of the task.
    pub seed: u64,
    /// Episodes of training.
    pub training_episodes: usize,
    /// The method's section of the scenario, defaults included.
    pub settings: Value,
    /// The preset of the scenario.
    #[serde(default)]
    pub preset: Preset,
    /// How signals are timed and what the method sees.
    pub signal: SignalSettings,
    /// Version of tsc-family.
    pub tsc_family: String,
    /// Git revision of the build, or `unknown`.
    pub git: String,
    /// Version of the simulator.
    pub simulator: String,
    /// What came of it on the point MDP it was trained on.
    pub evaluation: Evaluation,
}

/// How good a model is where it was trained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// Seeds of the episodes, as vehicles and simulator got them.
    pub seeds: Vec<u64>,
    /// Mean delay, seconds.
    pub delay_s: f64,
    /// Mean delay divided by the baseline's on the same seeds; absent when that is 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub score: Option<f64>,
}

/// Returns the name that a method's settings have in a scenario.
fn section(method: &str) -> String {
    method.replace('-', "_")
}

/// Writes the model of a task that has been evaluated.
///
/// # Arguments
///
/// * `record` — the task's record, which is not committed yet.
/// * `scenario` — the run's.
/// * `baseline_s` — the baseline's mean delay on the evaluation seeds, seconds.
/// * `model` — what the learner says it has learned.
///
/// # Errors
///
/// [`EvalError::Model`] when something is missing that the card has to say, [`EvalError::Io`] when the
/// results directory cannot be written.
pub(super) fn write(
    layout: &Layout,
    identity: &Identity,
    scenario: &Scenario,
    task: &Task,
    record: &Record,
    baseline_s: Option<f64>,
    mut model: Archive,
) -> Result<(), EvalError> {
    let path = layout.model(task.task);
    let missing = |what: String| EvalError::Model { path: path.clone(), reason: what };
    let all = serde_json::to_value(scenario).expect("a scenario is plain data");
    let settings = all.get(section(&task.method)).cloned().ok_or_else(|| {
        missing(format!("the scenario has no settings of {}, which the card needs", task.method))
    })?;
    let delay_s = record.summary.metrics.get("delay_s").copied();
    let delay_s = delay_s.ok_or_else(|| missing("its evaluation has no delay".to_owned()))?;
    let card = ModelCard {
        kind: MODEL.to_owned(),
        format_version: FORMAT_VERSION,
        method: task.method.clone(),
        point: task.point.clone(),
        replicate: task.replicate,
        seed: task.seed,
        training_episodes: record.rows.iter().filter(|r| r.kind == RowKind::Training).count(),
        settings,
        preset: scenario.preset,
        signal: scenario.signal.clone(),
        tsc_family: env!("CARGO_PKG_VERSION").to_owned(),
        git: env!("TSC_FAMILY_GIT").to_owned(),
        simulator: identity.simulator.clone(),
        evaluation: Evaluation {
            seeds: record.evaluations().map(|row| row.seed).collect(),
            delay_s,
            score: baseline_s.filter(|b| *b > 0.0).map(|baseline_s| delay_s / baseline_s),
        },
    };
    let own = std::mem::take(&mut model.card);
    let Value::Object(card) = serde_json::to_value(card).expect("a card is plain data") else {
        unreachable!("a struct is an object")
    };
    model.card = card;
    model.put(LEARNER, own);
    Ok(replace(&path, &layout.tmp(), &model.to_bytes())?)
}

/// Returns the baseline's mean delay on the point MDP of a task, if it has been recorded; a record
/// that is damaged is for `run` and `report` to name.
pub(super) fn baseline_delay(
    layout: &Layout,
    identity: &Identity,
    task: &Task,
    manifest: &str,
) -> Option<f64> {
    (identity.tasks().iter())
        .filter(|t| t.method == identity.baseline && t.point == task.point)
        .find_map(|t| Record::read(layout, t, manifest).ok().flatten())
        .and_then(|record| record.summary.metrics.get("delay_s").copied())
}

/// A model as it lies on disk.
#[derive(Debug, Clone, PartialEq)]
pub struct SavedModel {
    path: PathBuf,
    /// What it says of itself.
    pub card: ModelCard,
    archive: Archive,
}

impl SavedModel {
    /// Reads a model.
    ///
    /// # Errors
    ///
    /// [`EvalError::Io`] when the file cannot be read, [`EvalError::Model`] when it does not exist or is
    /// no model.
    pub fn read(path: &Path) -> Result<Self, EvalError> {
        let fail = |reason: String| EvalError::Model { path: path.to_path_buf(), reason };
        let advice = "give a file of the folder models/ of a results directory";
        let mut archive = Archive::read(path).map_err(|e| match e {
            ArchiveError::Io(e) if e.reason.kind() == ErrorKind::NotFound => {
                fail(format!("does not exist; {advice}"))
            }
            ArchiveError::Io(e) => EvalError::Io(e),
            ArchiveError::Foreign { reason, .. } => fail(format!("{reason}; {advice}")),
            other => fail(other.to_string()),
        })?;
        match archive.get::<String>(KIND) {
            Ok(kind) if kind == MODEL => {}
            Ok(kind) if kind == CHECKPOINT => {
                return Err(fail(format!("a checkpoint of a training, not a model; {advice}")));
            }
            _ => return Err(fail(format!("not a model; {advice}"))),
        }
        let version: u32 = archive.get("format_version").map_err(|e| fail(e.to_string()))?;
        if version != FORMAT_VERSION {
            let writer: String = archive.get("tsc_family").unwrap_or_else(|_| "unknown".into());
            return Err(fail(format!(
                "a model of format version {version}, but this tsc-family reads {FORMAT_VERSION}; \
                 use version {writer}, which wrote it"
            )));
        }
        let own = archive.get(LEARNER).map_err(|e| fail(e.to_string()))?;
        let card = std::mem::replace(&mut archive.card, own);
        let card: ModelCard = serde_json::from_value(Value::Object(card))
            .map_err(|e| fail(format!("its card is damaged: {e}")))?;
        Ok(Self { path: path.to_path_buf(), card, archive })
    }

    fn fail(&self, reason: String) -> EvalError {
        EvalError::Model { path: self.path.clone(), reason }
    }

    /// Returns a scenario with the method's and the signals' settings of the model, and settings to
    /// replace in that.
    ///
    /// # Errors
    ///
    /// [`EvalError::Model`] when the method is unknown or cannot use the model, or when a setting does
    /// not exist or is out of range.
    pub fn scenario(
        &self,
        scenario: &Scenario,
        overrides: &[Override],
    ) -> Result<Scenario, EvalError> {
        let method = &self.card.method;
        create(method, scenario, false, 0).map_err(|e| self.fail(format!("of an {e}")))?;
        let mut scenario = scenario.clone();
        scenario.signal = self.card.signal.clone();
        let mut settings = serde_json::to_value(&scenario).expect("a scenario is plain data");
        settings[section(method)] = self.card.settings.clone();
        let mut scenario: Scenario = serde_json::from_value(settings)
            .map_err(|e| self.fail(format!("its settings are of another version: {e}")))?;
        for setting in overrides {
            scenario = setting.apply(&scenario)?;
        }
        check(&scenario, "its settings").map_err(|e| self.fail(e.to_string()))?;
        // What makes it unusable on any signal is said before anything is built or simulated.
        self.controller(&scenario, false)?;
        Ok(scenario)
    }

    /// Returns the controller that the model makes, in a scenario with its settings.
    ///
    /// # Errors
    ///
    /// [`EvalError::Model`] when the method cannot use it.
    pub fn controller(
        &self,
        scenario: &Scenario,
        imported: bool,
    ) -> Result<Box<dyn Controller>, EvalError> {
        let mut controller = create(&self.card.method, scenario, imported, self.card.seed)?;
        controller.load(self.archive.clone()).map_err(|e| self.fail(e.to_string()))?;
        Ok(controller)
    }

    /// Returns the error of an evaluation, with the file's name and a way out if the model is the
    /// cause.
    pub fn explain(&self, error: EvalError, point: &str) -> EvalError {
        match error {
            EvalError::Control(ControlError::Model(e)) => self.fail(format!(
                "the model does not fit the signals of {point}: {e}; it was trained on {}, choose an \
                 intersection with as many lanes and phases",
                self.card.point
            )),
            other => other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_of_other_signals_says_where_it_was_trained() {
        let card = ModelCard {
            kind: MODEL.into(),
            format_version: FORMAT_VERSION,
            method: "idqn".into(),
            point: "quiet".into(),
            replicate: 0,
            seed: 1,
            training_episodes: 1,
            settings: Value::Null,
            preset: Preset::default(),
            signal: SignalSettings::default(),
            tsc_family: String::new(),
            git: String::new(),
            simulator: String::new(),
            evaluation: Evaluation { seeds: vec![], delay_s: 0.0, score: None },
        };
        let model = SavedModel { path: "m".into(), card, archive: Archive::default() };
        let shape =
            ArchiveError::Shape { name: "w".into(), found: vec![8, 64], wanted: vec![6, 64] };
        let e = model.explain(EvalError::Control(ControlError::Model(shape)), "busy").to_string();
        assert_eq!(
            e,
            "m: the model does not fit the signals of busy: tensor \"w\" has shape [8, 64], but \
             [6, 64] is needed; it was trained on quiet, choose an intersection with as many lanes \
             and phases"
        );
    }
}

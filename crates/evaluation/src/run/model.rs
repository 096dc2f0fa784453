//! Models: what a learner has learned, with a card that says how, on what, and how well.
//!
//! A model has the tensors of the learner's own archive. The card is written here, with the
//! learner's own card on it: enough to set the learner up again, and to judge the model without
//! running it. Equal trainings give equal bytes, but for `score`, which is absent while the baseline
//! has no objective to compare with.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::checkpoint::{CHECKPOINT, FORMAT_VERSION, KIND, LEARNER};
use super::domain::Domain;
use super::error::RunError;
use super::together::Together;
use crate::store::Layout;
use crate::store::figures::POLICY_ROW;
use crate::store::manifest::{GIT, Identity, Task};
use crate::store::record::{Record, RowKind};
use basics::files::{FileError, replace};
use learners::nn::archive::{Archive, ArchiveError};

/// Value of `kind` on a model's card.
pub const MODEL: &str = "model";

/// Entry of a card with the ids of the point MDPs of a training on several.
pub const TRAINED_ON: &str = "trained_on";

/// Versions of models that are read: the second added a checksum, the third [`ModelCard::policy_row`].
const READABLE: [u32; 3] = [1, 2, FORMAT_VERSION];

/// What a model's file says of it, whatever the domain.
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
    /// Row of training, from 1, after which the policy was taken; models from before there was a choice hold the
    /// last policy and lack it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub policy_row: Option<u32>,
    /// Version of tsc-family.
    pub tsc_family: String,
    /// Git revision of the build, or `unknown`.
    pub git: String,
    /// Version of the simulator.
    pub simulator: String,
    /// What came of it where it was trained: `seeds`, the mean objective by its name, and `score`, the
    /// objective divided by the baseline's; absent when that is 0.
    pub evaluation: Map<String, Value>,
}

/// Returns the card of a task that has been evaluated.
pub(super) fn card(
    domain: &dyn Domain,
    identity: &Identity,
    task: &Task,
    record: &Record,
    baseline: Option<f64>,
) -> Result<Map<String, Value>, String> {
    let name = &identity.objective;
    let objective = record.summary.metrics.get(name).copied();
    let objective = objective.ok_or_else(|| format!("its evaluation has no {name}"))?;
    let seeds: Vec<u64> = record.evaluations().map(|row| row.seed).collect();
    let mut evaluation = Map::new();
    evaluation.insert("seeds".to_owned(), json!(seeds));
    evaluation.insert(name.clone(), json!(objective));
    if let Some(baseline) = baseline.filter(|b| *b > 0.0) {
        evaluation.insert("score".to_owned(), json!(objective / baseline));
    }
    let card = ModelCard {
        kind: MODEL.to_owned(),
        format_version: FORMAT_VERSION,
        method: task.method.to_string(),
        point: task.point.to_string(),
        replicate: task.replicate,
        seed: task.seed,
        training_episodes: record.rows.iter().filter(|r| r.kind == RowKind::Training).count(),
        policy_row: record.summary.metrics.get(POLICY_ROW).map(|row| *row as u32),
        tsc_family: env!("CARGO_PKG_VERSION").to_owned(),
        git: GIT.to_owned(),
        simulator: identity.simulator.clone(),
        evaluation,
    };
    let Value::Object(mut card) = serde_json::to_value(card).expect("a card is plain data") else {
        unreachable!("a struct is an object")
    };
    let point = identity.points.iter().find(|p| p.point == task.point);
    let together = point.map_or(Ok(Together::default()), Together::of)?;
    if together.trained > 0 {
        let trained = together.members[..together.trained].iter().map(|m| m.point.clone());
        card.insert(TRAINED_ON.to_owned(), trained.collect());
    }
    card.extend(domain.card(&identity.settings, &task.method)?);
    Ok(card)
}

pub(super) fn write(
    layout: &Layout,
    task: &Task,
    card: Map<String, Value>,
    mut model: Archive,
) -> Result<(), FileError> {
    let own = std::mem::replace(&mut model.card, card);
    model.put(LEARNER, own);
    replace(layout.root(), &layout.model(task.task), &layout.tmp(), &model.to_bytes())
}

/// The way out of a file that is no model.
const ADVICE: &str = "give a file of the folder models/ of a results directory";

/// A model as it lies on disk.
#[derive(Debug, Clone, PartialEq)]
pub struct SavedModel {
    /// Its file.
    pub path: PathBuf,
    /// What it says of itself.
    pub card: ModelCard,
    /// What its domain says of it beside that.
    pub domain: Map<String, Value>,
    /// What was learned, with the learner's own card.
    pub archive: Archive,
}

impl SavedModel {
    /// Reads a model.
    ///
    /// # Errors
    ///
    /// [`RunError::Io`] when the file cannot be read, [`RunError::Model`] when it does not exist or is
    /// no model.
    pub fn read(path: &Path) -> Result<Self, RunError> {
        let fail = |reason: String| RunError::Model { path: path.to_path_buf(), reason };
        let archive = Archive::read(path).map_err(|e| match e {
            ArchiveError::Io(e) if e.reason.kind() == ErrorKind::NotFound => {
                fail(format!("does not exist; {ADVICE}"))
            }
            ArchiveError::Io(e) => RunError::Io(e),
            ArchiveError::Foreign { reason, .. } => fail(format!("{reason}; {ADVICE}")),
            other => fail(other.to_string()),
        })?;
        Self::of(path, archive)
    }

    /// Returns the model that an archive is; the path is for messages.
    pub fn of(path: &Path, mut archive: Archive) -> Result<Self, RunError> {
        let fail = |reason: String| RunError::Model { path: path.to_path_buf(), reason };
        match archive.get::<String>(KIND) {
            Ok(kind) if kind == MODEL => {}
            Ok(kind) if kind == CHECKPOINT => {
                return Err(fail(format!("a checkpoint of a training, not a model; {ADVICE}")));
            }
            _ => return Err(fail(format!("not a model; {ADVICE}"))),
        }
        let version: u32 = archive.get("format_version").map_err(|e| fail(e.to_string()))?;
        if !READABLE.contains(&version) {
            let writer: String = archive.get("tsc_family").unwrap_or_else(|_| "unknown".into());
            return Err(fail(format!(
                "a model of format version {version}, but this tsc-family reads up to {FORMAT_VERSION}; \
                 train it again, or use the build of version {writer} that wrote it"
            )));
        }
        let own = archive.get(LEARNER).map_err(|e| fail(e.to_string()))?;
        let domain = std::mem::replace(&mut archive.card, own);
        let card: ModelCard = serde_json::from_value(Value::Object(domain.clone()))
            .map_err(|e| fail(format!("its card is damaged: {e}")))?;
        Ok(Self { path: path.to_path_buf(), card, domain, archive })
    }

    /// Returns the error of this file.
    pub fn fail(&self, reason: String) -> RunError {
        RunError::Model { path: self.path.clone(), reason }
    }
}

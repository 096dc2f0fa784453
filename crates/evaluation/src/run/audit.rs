//! Reads what a run has beside its records, and says what is damaged: models, checkpoints, prepared files.

use std::collections::BTreeSet;
use std::path::Path;

use rayon::prelude::*;

use super::checkpoint::{CHECKPOINT, KIND};
use super::domain::{Domain, Spoilt};
use super::error::RunError;
use super::method::{Training, find};
use super::model::SavedModel;
use crate::store::manifest::Task;
use crate::store::results::Results;
use crate::store::{Damage, Layout, Remedy};
use learners::nn::archive::{Archive, ArchiveError};

/// What there is beside the records, and is sound.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Beside {
    /// Models.
    pub models: usize,
    /// Models of finished tasks that are not there.
    pub no_models: usize,
    /// Checkpoints of tasks in progress.
    pub checkpoints: usize,
    /// Point MDPs whose prepared files are as planned.
    pub prepared: usize,
    /// Point MDPs whose prepared files are not there at all.
    pub unprepared: usize,
    /// What is damaged.
    pub damage: Vec<Damage>,
}

impl Beside {
    /// Reads what a run has beside its records.
    ///
    /// # Arguments
    ///
    /// * `results` — all of the run.
    /// * `prepared` — folder of what was prepared.
    pub fn read(
        domain: &dyn Domain,
        layout: &Layout,
        prepared: &Path,
        results: &Results,
    ) -> Result<Self, RunError> {
        let mut beside = Self::default();
        let tasks = results.plan().par_iter();
        let files = tasks.map(|task| Ok((model(layout, task)?, checkpoint(layout, task)?)));
        let files = files.collect::<Result<Vec<_>, RunError>>()?;
        let learns = |task: &Task| {
            find(domain.methods(), &task.method).is_ok_and(|m| m.training == Training::Learned)
        };
        for ((task, record), (model, checkpoint)) in results.rows().zip(files) {
            match model {
                Some(Ok(())) => beside.models += 1,
                Some(Err(damage)) => beside.damage.push(damage),
                None => beside.no_models += usize::from(record.is_some() && learns(task)),
            }
            match checkpoint {
                Some(Err(damage)) => beside.damage.push(damage),
                found => beside.checkpoints += usize::from(found.is_some()),
            }
        }
        // Several point MDPs can share a file.
        let mut named = BTreeSet::new();
        for point in &results.manifest.identity.points {
            let spoilt = domain.spoilt(point, prepared);
            if spoilt.is_empty() {
                beside.prepared += 1;
            } else if spoilt.len() == point.sha256.len()
                && spoilt.iter().all(|s| !s.is_there && s.is_made)
            {
                beside.unprepared += 1;
            } else {
                let new = spoilt.into_iter().filter(|s| named.insert(s.path.clone()));
                beside.damage.extend(new.map(|Spoilt { path, is_there, is_made }| {
                    let what = if is_there { "was altered" } else { "was deleted" };
                    let remedy = if is_made { Remedy::Rebuild } else { Remedy::Restore };
                    Damage { path, reason: format!("it {what} since the run was planned"), remedy }
                }));
            }
        }
        Ok(beside)
    }
}

/// Whether a file is sound, or what is wrong with it; `None` where there is none.
type Found = Option<Result<(), Damage>>;

fn model(layout: &Layout, task: &Task) -> Result<Found, RunError> {
    let path = layout.model(task.task);
    if !path.exists() {
        return Ok(None);
    }
    let reason = match SavedModel::read(&path) {
        Ok(SavedModel { card, .. })
            if (&*card.method, &*card.point, card.replicate, card.seed)
                == (&*task.method, &*task.point, task.replicate, task.seed) =>
        {
            return Ok(Some(Ok(())));
        }
        Ok(SavedModel { card, .. }) => format!("it is of {} on {}", card.method, card.point),
        Err(RunError::Model { reason, .. }) => reason,
        Err(e) => return Err(e),
    };
    Ok(Some(Err(Damage { path, reason, remedy: Remedy::Retrain })))
}

fn checkpoint(layout: &Layout, task: &Task) -> Result<Found, RunError> {
    let path = layout.checkpoint(task.task);
    if !path.exists() {
        return Ok(None);
    }
    let reason = match Archive::read(&path) {
        Ok(archive) if archive.get::<String>(KIND).is_ok_and(|kind| kind == CHECKPOINT) => {
            return Ok(Some(Ok(())));
        }
        Ok(_) => "it is not a checkpoint".to_owned(),
        Err(ArchiveError::Io(e)) => return Err(e.into()),
        Err(ArchiveError::Foreign { reason, .. }) => reason,
        Err(e) => e.to_string(),
    };
    Ok(Some(Err(Damage { path, reason, remedy: Remedy::Discard })))
}

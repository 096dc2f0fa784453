//! Reads what a run has beside its records, and says what is damaged: models, checkpoints, prepared files.

use std::collections::BTreeSet;
use std::path::Path;

use rayon::prelude::*;

use super::checkpoint::{CHECKPOINT, KIND};
use super::domain::{Domain, Spoilt};
use super::error::RunError;
use super::method::{Training, find};
use super::model::SavedModel;
use crate::store::Layout;
use crate::store::audit::{Audit, Damage, Remedy};
use crate::store::manifest::Task;
use learners::nn::archive::{Archive, ArchiveError};

/// What there is beside the records.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Beside {
    /// Sound models.
    pub models: usize,
    /// Models of finished tasks that are not there.
    pub no_models: usize,
    /// Sound checkpoints of tasks in progress.
    pub checkpoints: usize,
    /// Point MDPs whose prepared files are as planned.
    pub prepared: usize,
    /// Point MDPs whose prepared files are not there at all.
    pub unprepared: usize,
}

/// Adds to an audit what is damaged beside the records, and returns what is not.
///
/// # Arguments
///
/// * `prepared` — folder of what was prepared.
///
/// # Errors
///
/// [`RunError::Io`] when the disk is at fault.
pub fn audit_beside(
    domain: &dyn Domain,
    layout: &Layout,
    prepared: &Path,
    audit: &mut Audit,
) -> Result<Beside, RunError> {
    let mut beside = Beside::default();
    let looked = audit.tasks.par_iter().map(|task| looked(layout, task));
    let looked = looked.collect::<Result<Vec<_>, RunError>>()?;
    let mut damage = Vec::new();
    let learns = |task: &Task| {
        find(domain.methods(), &task.method).is_ok_and(|m| m.training == Training::Learned)
    };
    for (task, (model, checkpoint)) in audit.tasks.iter().zip(looked) {
        match model {
            File::Sound => beside.models += 1,
            File::Damaged(found) => damage.push(found),
            File::None if learns(task) && audit.done.contains(&task.task) => beside.no_models += 1,
            File::None => {}
        }
        match checkpoint {
            File::Sound => beside.checkpoints += 1,
            File::Damaged(found) => damage.push(found),
            File::None => {}
        }
    }
    // Several point MDPs can share a file.
    let mut named = BTreeSet::new();
    for point in audit.manifest.iter().flat_map(|manifest| &manifest.identity.points) {
        let spoilt = domain.spoilt(point, prepared);
        if spoilt.is_empty() {
            beside.prepared += 1;
        } else if spoilt.len() == point.sha256.len()
            && spoilt.iter().all(|s| !s.is_there && s.is_made)
        {
            beside.unprepared += 1;
        } else {
            let new = spoilt.into_iter().filter(|s| named.insert(s.path.clone()));
            damage.extend(new.map(|Spoilt { path, is_there, is_made }| {
                let what = if is_there { "was altered" } else { "was deleted" };
                let remedy = if is_made { Remedy::Rebuild } else { Remedy::Restore };
                Damage { path, reason: format!("it {what} since the run was planned"), remedy }
            }));
        }
    }
    audit.damage.extend(damage);
    Ok(beside)
}

/// What was found of a file.
enum File {
    None,
    Sound,
    Damaged(Damage),
}

/// Returns what was found of a task's model and checkpoint.
fn looked(layout: &Layout, task: &Task) -> Result<(File, File), RunError> {
    let path = layout.model(task.task);
    let model = if path.exists() {
        match SavedModel::read(&path) {
            Ok(SavedModel { card, .. })
                if (&*card.method, &*card.point, card.replicate, card.seed)
                    != (&*task.method, &*task.point, task.replicate, task.seed) =>
            {
                let reason = format!("it is of {} on {}", card.method, card.point);
                File::Damaged(Damage { path, reason, remedy: Remedy::Repeat(task.task) })
            }
            Ok(_) => File::Sound,
            Err(RunError::Model { reason, .. }) => {
                File::Damaged(Damage { path, reason, remedy: Remedy::Repeat(task.task) })
            }
            Err(e) => return Err(e),
        }
    } else {
        File::None
    };
    let path = layout.checkpoint(task.task);
    let checkpoint = if path.exists() {
        let damaged =
            |reason| File::Damaged(Damage { path: path.clone(), reason, remedy: Remedy::Discard });
        match Archive::read(&path) {
            Ok(archive) if archive.get::<String>(KIND).is_ok_and(|kind| kind == CHECKPOINT) => {
                File::Sound
            }
            Ok(_) => damaged("it is not a checkpoint".to_owned()),
            Err(ArchiveError::Io(e)) => return Err(e.into()),
            Err(ArchiveError::Foreign { reason, .. }) => damaged(reason),
            Err(e) => damaged(e.to_string()),
        }
    } else {
        File::None
    };
    Ok((model, checkpoint))
}

//! What a worker process does: one task of a results directory.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::domain::{Domain, domain_of};
use super::error::RunError;
use super::progress::News;
use super::stop::Stop;
use super::work::{Workplace, do_task};
use crate::store::manifest::{Identity, Manifest, Task};
use crate::store::record::Record;
use crate::store::scratch::Scratch;
use crate::store::{Layout, Remedy, StoreError};

/// Which task, and how.
#[derive(Debug, Clone)]
pub struct Errand {
    /// Row of the plan.
    pub task: usize,
    /// sha256 of the manifest as the run has it; `None` where nobody knows.
    pub manifest: Option<String>,
    /// Folder of what was prepared; `None` for the manifest's.
    pub prepared: Option<PathBuf>,
    /// Which attempt at the task this is, from 1.
    pub attempt: u32,
    /// Least wall time between two checkpoints of a training.
    pub checkpoint_every: Duration,
    /// Says whether the task is to stop.
    pub stop: Stop,
}

/// Does a task of a results directory.
///
/// # Arguments
///
/// * `domains` — those that the directory may be of.
pub fn serve(
    domains: &[&dyn Domain],
    dir: &Path,
    errand: &Errand,
    news: &mut dyn FnMut(News),
) -> Result<Record, RunError> {
    let layout = Layout::new(dir);
    let manifest = Manifest::read(&layout)?;
    if errand.manifest.as_ref().is_some_and(|sha256| *sha256 != manifest.sha256()) {
        let reason = "it is another one than when the run began";
        return Err(StoreError::damaged(layout.manifest(), reason, Remedy::Begin).into());
    }
    let domain = domain_of(domains, &layout, &manifest.identity)?;
    let task = task_of(dir, &manifest.identity, errand.task)?;
    check_own(domain, &layout, &manifest.identity, &task.method)?;
    let scratch = Scratch::new(&layout, task.task)?;
    let prepared = errand.prepared.clone();
    let workplace = Workplace {
        layout,
        prepared: prepared.unwrap_or_else(|| PathBuf::from(&manifest.provenance.networks)),
        scratch: scratch.path().to_path_buf(),
        attempt: errand.attempt,
        checkpoint_every: errand.checkpoint_every,
        stop: errand.stop.clone(),
    };
    do_task(domain, &manifest, &task, &workplace, news)
}

/// Checks that a method of somebody's own is the one that was planned.
///
/// # Errors
///
/// [`RunError::Controller`] naming what differs.
pub fn check_own(
    domain: &dyn Domain,
    layout: &Layout,
    identity: &Identity,
    method: &str,
) -> Result<(), RunError> {
    let Some(planned) = identity.controller(method) else { return Ok(()) };
    let now = domain.own(method)?;
    let given = now.is_some();
    let difference = match now {
        None => Some(format!(
            "controller {method} ({}) was not given; give it as the run had it, with --controller",
            planned.source
        )),
        Some(now) => planned.difference(&now),
    };
    let Some(difference) = difference else { return Ok(()) };
    Err(RunError::Controller { path: layout.manifest(), difference, given })
}

/// Returns a task of a run by its row of the plan.
///
/// # Errors
///
/// [`RunError::NoTask`] for a row that the plan does not have.
pub fn task_of(dir: &Path, identity: &Identity, row: usize) -> Result<Task, RunError> {
    identity.tasks_of(|task, _| task == row).pop().ok_or_else(|| RunError::NoTask {
        path: dir.to_path_buf(),
        task: row,
        count: identity.tasks().len(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::plan::{Change, establish};
    use crate::run::progress::{Failure, Fault};
    use crate::run::testing::{Counting, Toy, planned};

    #[test]
    fn a_manifest_that_is_exchanged_while_a_run_goes_on_fails_no_task() {
        let dir = tempfile::tempdir().unwrap();
        let (manifest, tasks) = planned(2);
        let layout = Layout::new(dir.path());
        layout.make().unwrap();
        let manifest =
            establish(&layout, manifest, &tasks, None, Change::default()).unwrap().manifest;
        let serve = |manifest: Option<String>| {
            let every = Duration::from_secs(60);
            let prepared = Some("prepared".into());
            let errand = Errand {
                task: 0,
                manifest,
                prepared,
                attempt: 1,
                checkpoint_every: every,
                stop: Stop::default(),
            };
            serve(&[&Toy { learner: Counting::of(1) }], dir.path(), &errand, &mut |_| {})
        };
        let e = serve(Some("another".to_owned())).unwrap_err();
        assert_eq!(Failure::of(&e).fault, Fault::Machine);
        assert!(e.to_string().contains("manifest.json: it is another one than when the run began"));
        assert!(!layout.record(0).exists());
        serve(Some(manifest.sha256())).unwrap();
    }
}

//! What a worker process does: one task of a results directory.

use std::path::{Path, PathBuf};

use super::domain::{Domain, domain_of};
use super::error::RunError;
use super::progress::News;
use super::work::{Workplace, do_task};
use crate::store::manifest::{Identity, Manifest, Task};
use crate::store::record::Record;
use crate::store::scratch::Scratch;
use crate::store::{Layout, Remedy, StoreError};

/// Does a task of a results directory.
///
/// # Arguments
///
/// * `domains` — those that the directory may be of.
/// * `expected` — sha256 of the manifest as the run has it; `None` where nobody knows.
/// * `workplace` — without a folder for files of episodes, and where the manifest says it without that of what was prepared.
pub fn serve(
    domains: &[&dyn Domain],
    row: usize,
    expected: Option<&str>,
    mut workplace: Workplace,
    news: &mut dyn FnMut(News),
) -> Result<Record, RunError> {
    let layout = workplace.layout.clone();
    let manifest = Manifest::read(&layout)?;
    if expected.is_some_and(|sha256| *sha256 != manifest.sha256()) {
        let reason = "it is another one than when the run began";
        return Err(StoreError::damaged(layout.manifest(), reason, Remedy::Begin).into());
    }
    let domain = domain_of(domains, &layout, &manifest.identity)?;
    let task = task_of(layout.root(), &manifest.identity, row)?;
    check_own(domain, &layout, &manifest.identity, &task.method)?;
    let scratch = Scratch::new(&layout, task.task)?;
    scratch.path().clone_into(&mut workplace.scratch);
    if workplace.prepared.as_os_str().is_empty() {
        workplace.prepared = PathBuf::from(&manifest.provenance.networks);
    }
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
    use std::time::Duration;

    use super::*;
    use crate::run::plan::establish;
    use crate::run::progress::{Failure, Fault};
    use crate::run::testing::{Counting, Toy, planned};

    #[test]
    fn a_manifest_that_is_exchanged_while_a_run_goes_on_fails_no_task() {
        let dir = tempfile::tempdir().unwrap();
        let (manifest, tasks) = planned(2);
        let layout = Layout::new(dir.path());
        layout.make().unwrap();
        let (manifest, _) = establish(&layout, manifest, &tasks, None, (&[], &[])).unwrap();
        let serve = |manifest: Option<&str>| {
            let workplace = Workplace {
                layout: layout.clone(),
                prepared: "prepared".into(),
                scratch: PathBuf::new(),
                attempt: 1,
                checkpoint_every: Duration::from_secs(60),
                stop: Default::default(),
            };
            let domain = Toy { learner: Counting::of(1) };
            serve(&[&domain], 0, manifest, workplace, &mut |_| {})
        };
        let e = serve(Some("another")).unwrap_err();
        assert_eq!(Failure::of(&e).fault, Fault::Machine);
        assert!(e.to_string().contains("manifest.json: it is another one than when the run began"));
        assert!(!layout.record(0).exists());
        serve(Some(&manifest.sha256())).unwrap();
    }
}

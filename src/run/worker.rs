//! What a worker process does: one task of a results directory.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::domain::{Domain, domain_of};
use super::error::RunError;
use super::progress::News;
use super::work::{Workplace, do_task};
use crate::store::Layout;
use crate::store::manifest::{Manifest, read_plan};
use crate::store::record::Record;
use crate::store::scratch::Scratch;

/// Which task, and how.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Errand {
    /// Row of the plan.
    pub task: usize,
    /// Folder of what was prepared; `None` for the manifest's.
    pub prepared: Option<PathBuf>,
    /// Which attempt at the task this is, from 1.
    pub attempt: u32,
    /// Least wall time between two checkpoints of a training.
    pub checkpoint_every: Duration,
}

/// Does a task of a results directory.
///
/// # Arguments
///
/// * `domains` — those that the directory may be of.
///
/// # Errors
///
/// [`RunError`] when the directory cannot be read, and those of [`do_task`].
pub fn serve(
    domains: &[&dyn Domain],
    dir: &Path,
    errand: &Errand,
    news: &mut dyn FnMut(News),
) -> Result<Record, RunError> {
    let layout = Layout::new(dir);
    let manifest = Manifest::read(&layout)?;
    let domain = domain_of(domains, &layout, &manifest.identity)?;
    let plan = read_plan(&layout, &manifest.identity)?;
    let task = plan.get(errand.task).ok_or_else(|| RunError::NoTask {
        path: dir.to_path_buf(),
        task: errand.task,
        count: plan.len(),
    })?;
    let scratch = Scratch::new(&layout, task.task)?;
    let prepared = errand.prepared.clone();
    let workplace = Workplace {
        layout,
        prepared: prepared.unwrap_or_else(|| PathBuf::from(&manifest.provenance.networks)),
        scratch: scratch.path().to_path_buf(),
        attempt: errand.attempt,
        checkpoint_every: errand.checkpoint_every,
    };
    do_task(domain, &manifest, task, &workplace, news)
}

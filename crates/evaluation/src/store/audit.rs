//! Reads everything in a results directory and says what is damaged, all at once.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::Layout;
use super::builds::Builds;
use super::dropped::read_dropped;
use super::manifest::{Manifest, Task};
use super::packed::is_packed;
use super::reach::Reach;
use super::record::{Outcome, Record};
use super::results::{Damaged, all_of_another, read_design, read_records};
use crate::store::error::StoreError;
use basics::files::FileError;

/// A file that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Damage {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub reason: String,
    /// What to do.
    pub remedy: Remedy,
}

/// What to do with a damaged file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Remedy {
    /// Without it, this task is done again, to the same record.
    Repeat(usize),
    /// Nothing but time is lost without it.
    Discard,
    /// The command that began the run writes it again.
    Renew,
    /// The command that began the run builds it again, once it is gone.
    Rebuild,
    /// It comes from a copy, or from the command that began the run once it is away.
    Begin,
    /// It can only come from a copy.
    Restore,
}

/// What is in a results directory.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Audit {
    /// What the run is; `None` where that cannot be read, or is not of the records.
    pub manifest: Option<Arc<Manifest>>,
    /// All tasks, as the manifest has them.
    pub tasks: Vec<Task>,
    /// Those of them that the run is to do, as far as is known yet.
    pub reach: Reach,
    /// Tasks with a sound record.
    pub done: BTreeSet<usize>,
    /// How many of them failed.
    pub failed: usize,
    /// What is damaged.
    pub damage: Vec<Damage>,
    /// Which builds made the records.
    pub builds: Builds,
    /// Files that belong to no task.
    pub strays: Vec<PathBuf>,
}

impl Audit {
    /// Reads the design of the sample and all records.
    ///
    /// # Arguments
    ///
    /// * `manifest` — what reading the manifest gave.
    /// * `begun` — whether something was done on a task without a record, or somebody was asked to do it.
    ///
    /// # Errors
    ///
    /// [`StoreError::NotResults`] and [`StoreError::Version`] where there is nothing to audit, [`StoreError::Io`]
    /// where the disk is at fault.
    pub fn of(
        layout: &Layout,
        manifest: Result<Arc<Manifest>, StoreError>,
        begun: impl Fn(usize) -> bool,
    ) -> Result<Self, StoreError> {
        let mut audit = Self::default();
        let manifest = match manifest {
            Err(StoreError::Manifest { path, reason }) => {
                audit.add(path, reason, Remedy::Begin);
                return Ok(audit);
            }
            manifest => manifest?,
        };
        audit.tasks = manifest.identity.tasks();
        audit.records(layout, &manifest.sha256())?;
        if audit.damage.iter().any(|damage| damage.path == layout.manifest()) {
            // What it says of the other files says nothing of them.
            audit.tasks.clear();
            return Ok(audit);
        }
        match read_design(layout, &manifest).map(drop) {
            Err(StoreError::Design { path, reason }) => audit.add(path, reason, Remedy::Begin),
            read => read?,
        }
        let dropped = match read_dropped(layout, &manifest.identity) {
            Err(StoreError::Malformed { path, reason }) => {
                audit.add(path, reason, Remedy::Renew);
                Vec::new()
            }
            read => read?,
        };
        for folder in ["done", "models", "ckpt", "logs"] {
            audit.strays(&layout.root().join(folder))?;
        }
        let repeated = audit.to_repeat();
        let begun =
            |task: usize| audit.done.contains(&task) || repeated.contains(&task) || begun(task);
        audit.reach = Reach::of(&manifest.identity, &audit.tasks, &dropped, begun);
        audit.manifest = Some(manifest);
        Ok(audit)
    }

    /// Adds a damaged file.
    pub fn add(&mut self, path: PathBuf, reason: String, remedy: Remedy) {
        self.damage.push(Damage { path, reason, remedy });
    }

    /// Returns the tasks that damaged files leave to do again, once these are gone.
    pub fn to_repeat(&self) -> BTreeSet<usize> {
        let task = |damage: &Damage| match damage.remedy {
            Remedy::Repeat(task) => Some(task),
            _ => None,
        };
        self.damage.iter().filter_map(task).collect()
    }

    /// Returns how many tasks have no record, not even a damaged one; of a sample that grows, of those that its looks so
    /// far ask for.
    pub fn missing(&self) -> usize {
        self.reach.count()
            - self.to_repeat().union(&self.done).filter(|t| self.reach.has(**t)).count()
    }

    fn records(&mut self, layout: &Layout, sha256: &str) -> Result<(), StoreError> {
        let (done, failed, builds) = (&mut self.done, &mut self.failed, &mut self.builds);
        let of = |record: Record| record.summary;
        let damaged = read_records(layout, &self.tasks, sha256, &of, &mut |task, summary| {
            let Some(summary) = summary else { return };
            done.insert(task);
            *failed += usize::from(summary.outcome == Outcome::Failed);
            builds.add(&summary.wall);
        })?;
        if let Some(of_another) = all_of_another(self.done.len(), &damaged) {
            let reason = format!(
                "it is not the manifest of the records beside it, {of_another} of which are whole and of another one"
            );
            self.add(layout.manifest(), reason, Remedy::Begin);
            return Ok(());
        }
        let packed = is_packed(layout);
        for Damaged { task, path, reason } in damaged {
            self.add(path, reason, if packed { Remedy::Restore } else { Remedy::Repeat(task) });
        }
        Ok(())
    }

    /// Finds what lies in a folder of numbered files and belongs to no task.
    fn strays(&mut self, folder: &Path) -> Result<(), FileError> {
        for part in entries(folder)? {
            if !part.is_dir() {
                self.strays.push(part);
                continue;
            }
            for path in entries(&part)? {
                let task = path.file_stem().and_then(number);
                if task.is_none_or(|task: usize| task >= self.tasks.len()) {
                    self.strays.push(path);
                }
            }
        }
        Ok(())
    }
}

/// Returns the number that a file is called by; `01` is none, as no task's file is called so.
fn number(stem: &OsStr) -> Option<usize> {
    let text = stem.to_str()?;
    text.parse().ok().filter(|number: &usize| number.to_string() == text)
}

/// Returns what lies in a folder, in order; nothing where there is none.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, FileError> {
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let entries = fs::read_dir(folder).map_err(FileError::at("read", folder))?;
    let paths = entries.map(|entry| entry.map(|e| e.path())).collect::<Result<Vec<_>, _>>();
    let mut paths = paths.map_err(FileError::at("read", folder))?;
    paths.sort();
    Ok(paths)
}

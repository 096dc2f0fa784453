//! A results directory: manifest, and one immutable record per task.
//!
//! ```text
//! DIR/manifest.json               what the run is: everything needed to repeat it
//! DIR/done/KKK/K.jsonl            the record of task K, linked into place when complete
//! DIR/models/KKK/K.safetensors    what the method of task K has learned, if it learns
//! DIR/ckpt/KKK/K.safetensors      how far the training of task K has come, until it has a record
//! DIR/before/KKK/K.jsonl          its record on fewer evaluation seeds, until the model has played those that were added
//! DIR/logs/KKK/K.log              what the worker of task K wrote to standard error
//! DIR/design.json                 what was known of the whole family when a balanced sample was drawn
//! DIR/places.json                 where the intersections of the family are, for maps and tables
//! DIR/run.jsonl.xz                all of a published run but its episodes of training, in place of the files above
//! DIR/jobs/N/                     what was handed over to a batch system
//! DIR/lock.json                   held while a local run goes on
//! DIR/report/                     what `tsc-family report` writes
//! ```
//!
//! KKK is K / 1000, and the tasks follow from the manifest ([`manifest::Identity::tasks`]). The truth is `done/`; everything
//! else follows from it and the manifest.

pub mod assisting;
mod commit;
pub mod difference;
pub mod dropped;
pub mod error;
pub mod figures;
pub mod input_files;
mod links;
pub mod lock;
pub mod manifest;
pub mod most;
pub mod opaque;
pub mod own;
pub mod packed;
pub mod record;
pub mod results;
pub mod scratch;
pub mod wall;

use std::path::{Path, PathBuf};

pub use commit::remove_checkpoint;
pub use error::{Damage, Remedy, StoreError};

/// Version of the files in a results directory; a change of their form raises it.
pub const SCHEMA_VERSION: u32 = 1;

/// Names of the files in a results directory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    root: PathBuf,
}

impl Layout {
    /// Returns the layout of a results directory.
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into() }
    }

    /// The directory itself.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// `manifest.json`.
    pub fn manifest(&self) -> PathBuf {
        self.root.join("manifest.json")
    }

    /// `adding/`: the files of a larger run, before they take the places of the old ones.
    pub fn adding(&self) -> PathBuf {
        self.root.join("adding")
    }

    /// `run.jsonl.xz`: a published run.
    pub fn packed(&self) -> PathBuf {
        self.root.join("run.jsonl.xz")
    }

    /// `dropped.json`: which methods a growing run no longer evaluates.
    pub fn dropped(&self) -> PathBuf {
        self.root.join("dropped.json")
    }

    /// `replaced.json`: methods whose records the last addition to the run computes again.
    pub fn replaced(&self) -> PathBuf {
        self.root.join("replaced.json")
    }

    /// `design.json`.
    pub fn design(&self) -> PathBuf {
        self.root.join("design.json")
    }

    fn lock(&self) -> PathBuf {
        self.root.join("lock.json")
    }

    /// `report/`.
    pub fn report(&self) -> PathBuf {
        self.root.join("report")
    }

    /// `jobs/`: what was handed over to batch systems.
    pub fn jobs(&self) -> PathBuf {
        self.root.join("jobs")
    }

    /// `tmp/`: files that are not complete yet, on the same file system.
    pub fn tmp(&self) -> PathBuf {
        self.root.join("tmp")
    }

    /// The record of a task.
    pub fn record(&self, task: usize) -> PathBuf {
        self.numbered("done", task, "jsonl")
    }

    /// The log of a task.
    pub fn log(&self, task: usize) -> PathBuf {
        self.numbered("logs", task, "log")
    }

    /// The model of a task.
    pub fn model(&self, task: usize) -> PathBuf {
        self.numbered("models", task, "safetensors")
    }

    /// The record that a task had on fewer evaluation seeds, until it has one on all.
    pub fn before(&self, task: usize) -> PathBuf {
        self.numbered("before", task, "jsonl")
    }

    /// The checkpoint of a task in progress.
    pub fn checkpoint(&self, task: usize) -> PathBuf {
        self.numbered("ckpt", task, "safetensors")
    }

    fn numbered(&self, folder: &str, task: usize, extension: &str) -> PathBuf {
        self.root
            .join(folder)
            .join(format!("{:03}", task / 1000))
            .join(format!("{task}.{extension}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thousand_tasks_share_a_folder() {
        let layout = Layout::new("r");
        assert_eq!(layout.record(999), Path::new("r/done/000/999.jsonl"));
        assert_eq!(layout.log(1000), Path::new("r/logs/001/1000.log"));
        assert_eq!(layout.model(1), Path::new("r/models/000/1.safetensors"));
        assert_eq!(layout.checkpoint(1), Path::new("r/ckpt/000/1.safetensors"));
    }
}

//! Controllers in another language, within this process.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::Play;
use evaluation::run::method::Training;

/// Opens controllers that are written in another language, within this process.
pub trait Host: Send + Sync {
    /// Opens a controller.
    /// * `source` — what stands after `NAME=`, such as `mine.py:Mine`.
    ///
    /// The error is why it cannot be used, in words, with the traceback where there is one.
    fn open(&self, source: &str) -> Result<Hosted, String>;

    /// Returns where the controller is just now, for the record of one that hangs; `None` where nobody can say.
    fn stack(&self) -> Option<String>;
}

/// A controller that a [`Host`] has opened.
pub struct Hosted {
    /// A sentence for people; empty where nobody wrote one.
    pub summary: String,
    /// What it does before it is evaluated.
    pub training: Training,
    /// What it consists of, by name.
    pub files: BTreeMap<String, PathBuf>,
    /// Versions of what runs it.
    pub versions: BTreeMap<String, String>,
    /// How it is played: by a controller or by a learner.
    pub play: Play,
}

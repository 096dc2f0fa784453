//! Where tables and pages go that are made of a results directory: into it, or elsewhere with `--out`.

use std::path::{Path, PathBuf};

use rustix::fs::{Access, access};

use super::folder::Kind;
use crate::cli::refused::Refused;
use crate::files::beneath;

/// A folder to write to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Target {
    /// The folder itself or one above it, beneath which nothing is written through links.
    pub(super) root: PathBuf,
    /// The folder.
    pub(super) folder: PathBuf,
    is_given: bool,
}

impl Target {
    /// Returns the usual folder in a results directory, or the one that `--out` gives.
    pub(super) fn new(root: &Path, usual: PathBuf, out: Option<&PathBuf>) -> Self {
        let is_given = out.is_some();
        let folder = out.cloned().unwrap_or(usual);
        let root = if is_given { folder.clone() } else { root.to_path_buf() };
        Self { root, folder, is_given }
    }

    /// Checks, before anything is computed, that the folder can be written, is not reached through a link and holds
    /// nothing else.
    pub(super) fn check(&self, kind: &Kind) -> anyhow::Result<()> {
        if self.is_given {
            kind.check(&self.folder, "--out", None)?;
        }
        beneath(&self.root, &self.folder)?;
        // A results directory that is not there is named by whoever reads it.
        if !self.is_given && !self.root.exists() {
            return Ok(());
        }
        let Err(e) = access(self.there(), Access::WRITE_OK) else {
            return Ok(());
        };
        let reason = std::io::Error::from(e);
        let way_out =
            if self.is_given { "give another folder" } else { "give a folder with --out" };
        let folder = self.folder.display();
        Err(Refused(format!("cannot write to {folder}: {reason}; {way_out}")).into())
    }

    /// Returns the folder, or where it is to be made the nearest one above it that is there.
    pub(super) fn there(&self) -> &Path {
        let there = self.folder.ancestors().find(|folder| folder.exists());
        there.filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
    }
}

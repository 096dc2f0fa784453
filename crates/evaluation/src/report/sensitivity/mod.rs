//! How far the ranking depends on importance, for people: tables, a figure and a self-contained page.

mod cases;
mod csv;
mod figure;
mod json;
mod page;
mod shown;
mod text;

pub use shown::SensitivityReport;

use std::fs;
use std::path::{Path, PathBuf};

use super::error::ReportError;
use crate::store::Layout;
use basics::files::{FileError, make_folder, write_atomically};

/// Returns the folder that a sensitivity is written to, where no other is asked for.
pub fn folder(layout: &Layout) -> PathBuf {
    layout.root().join("sensitivity")
}

impl SensitivityReport<'_> {
    /// Returns the tables for terminals.
    pub fn text(&self) -> String {
        text::tables(self)
    }

    /// Returns what readers of the tables must know.
    pub fn notes(&self) -> Vec<String> {
        text::notes(self)
    }

    /// Returns the lines of `--json`.
    pub fn json(&self) -> Vec<serde_json::Value> {
        json::lines(self)
    }

    /// Writes page, figure and tables to a folder, and returns the page's path.
    ///
    /// # Errors
    ///
    /// [`ReportError::Io`] when the folder cannot be written or the disk is full.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, ReportError> {
        make_folder(folder)?;
        let figure = figure::draw(self);
        let page = page::page(self, &figure)?;
        for (name, text) in csv::tables(self) {
            let path = folder.join(name);
            match text {
                Some(text) => write_atomically(&path, text.as_bytes())?,
                None => remove(&path)?,
            }
        }
        figure.write(folder)?;
        let path = folder.join("index.html");
        write_atomically(&path, page.as_bytes())?;
        Ok(path)
    }
}

/// Removes a table that an earlier call left.
fn remove(path: &Path) -> Result<(), FileError> {
    match fs::remove_file(path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(FileError::at("remove", path)(e)),
        _ => Ok(()),
    }
}

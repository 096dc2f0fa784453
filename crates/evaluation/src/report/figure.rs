//! A drawing as files and on the page.

use std::path::{Path, PathBuf};

use basics::files::{FileError, write_atomically};

/// Width of all figures, pixels.
pub const WIDTH: f64 = 900.0;

/// A figure: its file name without extension, and the drawing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Figure {
    /// File name without extension, also its id in the page.
    pub name: &'static str,
    /// The SVG.
    pub svg: String,
}

impl Figure {
    /// Writes the figure, and returns its file.
    ///
    /// # Errors
    ///
    /// [`FileError`] when the folder cannot be written or the disk is full.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, FileError> {
        let path = folder.join(format!("{}.svg", self.name));
        write_atomically(&path, self.svg.as_bytes())?;
        Ok(path)
    }
}

//! A drawing as files and on the page.

use std::path::{Path, PathBuf};

use basics::files::{FileError, write_atomically};

/// Width of all figures, pixels.
pub const WIDTH: f64 = 900.0;

/// A figure: its file name without extension, and its forms.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Figure {
    /// File name without extension, also its id in the page.
    pub name: &'static str,
    /// The SVG.
    pub svg: String,
    /// The PDF.
    pub pdf: Vec<u8>,
    /// Commands of PGF, for documents in LaTeX.
    pub pgf: String,
}

impl Figure {
    /// Writes the figure in all its forms, and returns the file of its SVG.
    ///
    /// # Errors
    ///
    /// [`FileError`] when the folder cannot be written or the disk is full.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, FileError> {
        let of = |extension: &str| folder.join(format!("{}.{extension}", self.name));
        write_atomically(&of("svg"), self.svg.as_bytes())?;
        write_atomically(&of("pdf"), &self.pdf)?;
        write_atomically(&of("pgf"), self.pgf.as_bytes())?;
        Ok(of("svg"))
    }
}

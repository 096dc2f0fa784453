//! The files of a report.

use std::path::PathBuf;

/// The files of a report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReportPaths {
    /// `DIR/report/index.html`.
    pub html: PathBuf,
    /// `DIR/report/scores.csv`.
    pub scores: PathBuf,
    /// The other tables, `DIR/report/*.csv`: those of learners where a method learned.
    pub tables: Vec<PathBuf>,
    /// `DIR/report/*.tex`: tables in LaTeX.
    pub latex: Vec<PathBuf>,
    /// What the domain adds.
    pub further: Vec<PathBuf>,
    /// What people should know of that, such as why a file is missing.
    pub notes: Vec<String>,
    /// `DIR/report/*.svg`; beside each are a `.pdf` and a `.pgf`.
    pub figures: Vec<PathBuf>,
}

//! The files of a report.

use std::path::PathBuf;

/// The files of a report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReportPaths {
    /// `DIR/report/index.html`.
    pub html: PathBuf,
    /// `DIR/report/scores.csv`.
    pub scores: PathBuf,
    /// `DIR/report/summary.csv`.
    pub summary: PathBuf,
    /// `DIR/report/episodes.csv`.
    pub episodes: PathBuf,
    /// `DIR/report/pairs.csv`.
    pub pairs: PathBuf,
    /// `DIR/report/ranks.csv`.
    pub ranks: PathBuf,
    /// `DIR/report/profiles.csv`.
    pub profiles: PathBuf,
    /// `DIR/report/training.csv`; there when a method learned.
    pub training: Option<PathBuf>,
    /// `DIR/report/learning.csv`, the learning curves; there when a method learned.
    pub learning: Option<PathBuf>,
    /// `DIR/report/*.tex`: tables in LaTeX.
    pub latex: Vec<PathBuf>,
    /// What the domain adds.
    pub further: Vec<PathBuf>,
    /// What people should know of that, such as why a file is missing.
    pub notes: Vec<String>,
    /// `DIR/report/*.svg`; beside each are a `.pdf` and a `.pgf`.
    pub figures: Vec<PathBuf>,
}

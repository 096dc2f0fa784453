//! What a results directory says, for people: one self-contained page, tables and figures.
//!
//! A report reads `DIR` and writes `DIR/report/`; it runs nothing, and it works with whatever
//! records are there.

mod context;
mod csv;
mod curves;
pub mod data;
mod figures;
mod format;
mod headline;
mod html;
pub mod level_of_service;
mod map;
mod page;
mod palette;
mod points;
pub mod quality;
mod ranking;
mod svg;
pub mod text;
mod training;
mod write;

use std::path::PathBuf;

pub use data::{JsonRow, MethodSummary, ReportData};
pub use points::{PointResult, PointSummary};
pub use ranking::Common;
pub use training::{LearnerSummary, Training};
pub use write::{write, write_data};

use crate::error::{FileError, StoreError};

/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The results cannot be read.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A file of the report cannot be written.
    #[error(transparent)]
    Io(#[from] FileError),
    /// The page's template does not fit its data, which is a mistake in this program.
    #[error("the report's page cannot be rendered: {0}; please report this")]
    Template(String),
}

/// The files of a report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReportPaths {
    /// `DIR/report/index.html`.
    pub html: PathBuf,
    /// `DIR/report/scores.csv`.
    pub scores: PathBuf,
    /// `DIR/report/summary.csv`.
    pub summary: PathBuf,
    /// `DIR/report/training.csv`; there when a method learned.
    pub training: Option<PathBuf>,
    /// `DIR/report/*.svg`.
    pub figures: Vec<PathBuf>,
}

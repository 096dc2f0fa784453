//! What a results directory says, for people: one self-contained page, tables and figures.
//!
//! A report reads `DIR` and writes `DIR/report/`; it runs nothing, and it works with whatever
//! records are there.

mod context;
mod csv;
mod curve;
mod curves;
pub mod data;
mod demand;
mod divisor;
mod figures;
pub(crate) mod format;
mod further;
mod headline;
mod html;
mod intersections;
mod json;
mod map;
mod names;
mod narrow;
mod page;
mod palette;
mod plain_table;
mod plan_values;
pub mod plans;
pub mod quality;
mod signals;
mod svg;
pub mod text;
mod write;

use std::path::PathBuf;

pub use data::ReportData;
pub use plans::TaskPlan;
pub use write::{write, write_data};

use crate::files::FileError;
use crate::store::error::StoreError;

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
    /// `DIR/report/episodes.csv`.
    pub episodes: PathBuf,
    /// `DIR/report/training.csv`; there when a method learned.
    pub training: Option<PathBuf>,
    /// `DIR/report/intersections.csv`; there when coordinates are known.
    pub intersections: Option<PathBuf>,
    /// `DIR/report/results.geojson`; there when coordinates are known.
    pub geojson: Option<PathBuf>,
    /// `DIR/report/plans.csv`.
    pub plans: PathBuf,
    /// Why a file in `DIR/report/plans/` is missing that shows the best method of a point MDP.
    pub plans_missing: Option<String>,
    /// `DIR/report/*.svg`.
    pub figures: Vec<PathBuf>,
}

//! What a results directory says, for people: one self-contained page, tables and figures.
//!
//! A report reads `DIR` and writes `DIR/report/`; it runs nothing, and it works with whatever
//! records are there.

mod context;
mod csv;
mod curves;
pub mod data;
mod demand;
mod episodes;
mod figures;
mod format;
mod further;
mod headline;
mod html;
mod intersections;
mod json;
pub mod level_of_service;
mod map;
mod names;
mod narrow;
mod page;
mod palette;
mod plan_values;
pub mod plans;
mod points;
pub mod quality;
mod ranking;
mod reference;
mod signals;
mod summaries;
mod svg;
pub mod text;
mod training;
mod winners;
mod write;

use std::path::PathBuf;

pub use data::{MethodSummary, ReportData};
pub use episodes::{Episode, EpisodeSummary};
pub use json::JsonRow;
pub use plans::TaskPlan;
pub use points::{PointResult, PointSummary};
pub use ranking::Common;
pub use reference::{Reference, check_name};
pub use summaries::{Estimated, Overloaded, Summaries};
pub use training::{LearnerSummary, Training};
pub use winners::Winner;
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
    /// Scores cannot be divided by a method that the run does not have.
    #[error("no scores against `{method}`, which is not in the run; its methods are {methods}")]
    NotInRun {
        /// The method.
        method: String,
        /// The methods of the run.
        methods: String,
    },
    /// Scores cannot be divided by a method that lacks results.
    #[error(
        "no scores against `{method}`: it has no delay above 0 on {missing} of {points} ({some}); \
         finish the run, or leave --against out"
    )]
    Incomplete {
        /// The method.
        method: String,
        /// Number of point MDPs without a result.
        missing: usize,
        /// Number of chosen point MDPs, in words.
        points: String,
        /// Some of those without a result.
        some: String,
    },
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

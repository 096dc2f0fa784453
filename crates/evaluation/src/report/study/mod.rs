//! What came of a study of estimators: a table, a figure, a page.

mod figure;
mod page;
mod stopping;
mod table;
mod write;

use crate::analysis::Analysis;
use crate::sample::Until;
use crate::study::{Cell, Recorded, Stopped, StudyPlan};

pub use write::write;

/// A study with what it was made of.
#[derive(Debug, Clone, Copy)]
pub struct StudyReport<'a> {
    /// The family with its scores.
    pub recorded: &'a Recorded,
    /// What was studied.
    pub plan: &'a StudyPlan,
    /// What came of it.
    pub cells: &'a [Cell],
    /// What came of runs that stop early, and when they stop.
    pub stopping: Option<(&'a Until, &'a [Stopped])>,
    /// The analysis of the results.
    pub analysis: &'a Analysis,
}

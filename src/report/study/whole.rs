//! A study with what it was made of.

use crate::analysis::Analysis;
use crate::study::{Cell, Recorded, StudyPlan};

/// A study with what it was made of.
#[derive(Debug, Clone, Copy)]
pub struct StudyReport<'a> {
    /// The family with its scores.
    pub recorded: &'a Recorded,
    /// What was studied.
    pub plan: &'a StudyPlan,
    /// What came of it.
    pub cells: &'a [Cell],
    /// The analysis of the results.
    pub analysis: &'a Analysis,
}

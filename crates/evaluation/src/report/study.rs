//! What came of a study of estimators: a table for terminals, what must be known beside it, and `errors.csv`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use basics::files::{make_folder, write_atomically};

use super::error::ReportError;
use super::format;
use super::table::{Cell, Columns, Table};
use crate::study;
use crate::study::{Kind, Recorded, RecordedMethod, StudyPlan};

/// Coverage of a 95% interval below which it is said.
const LEAST_COVERAGE: f64 = 0.92;

/// A study with what it was made of.
#[derive(Debug, Clone, Copy)]
pub struct StudyReport<'a> {
    /// The family with its scores.
    pub recorded: &'a Recorded,
    /// What was studied.
    pub plan: &'a StudyPlan,
    /// What came of it.
    pub cells: &'a [study::Cell],
}

impl StudyReport<'_> {
    /// Returns root-mean-square errors with the coverage of intervals, a row per method and estimator.
    pub fn table(&self) -> String {
        let kinds = || self.plan.kinds.iter().copied();
        let rows = self.recorded.methods.iter().flat_map(|m| kinds().map(move |kind| (m, kind)));
        let mut columns = Columns::new()
            .text("", "method", |(m, _): &(&RecordedMethod, Kind)| m.name.clone())
            .shown("overall", |(m, _)| Cell::number(self.recorded.truth(m), format::score))
            .text("", "estimator", |(_, kind)| kind.title().to_owned());
        for budget in &self.plan.budgets {
            let of = |m: &RecordedMethod, kind: Kind| {
                let is =
                    |c: &&study::Cell| c.kind == kind && c.method == m.name && c.budget == *budget;
                self.cells.iter().find(is)
            };
            columns = columns.shown(format!("N = {budget}"), move |(m, kind)| {
                let cell = of(m, *kind);
                let coverage = cell.and_then(|c| c.coverage).map(|c| format!("{c:.2}"));
                Cell::number(cell.map(|c| c.error), |e| format!("{e:.4}")).above(coverage)
            });
        }
        format!(
            "Root-mean-square error of the overall performance over {} samples, and how often its 95% interval \
             contains it:\n\n{}",
            self.plan.repeats,
            columns.table(rows).plain()
        )
    }

    /// Returns what came of it, a row per estimator, budget and method.
    pub fn errors(&self) -> Table {
        let columns = Columns::new()
            .text("method", "", |c: &&study::Cell| c.method.clone())
            .text("estimator", "", |c| c.kind.name().to_owned())
            .file("budget", |c| Cell::count(c.budget))
            .file("repeats", |c| Cell::count(c.repeats))
            .file("truth", |c| Cell::exact(c.truth))
            .file("mean", |c| Cell::exact(c.mean))
            .file("deviation", |c| Cell::exact(c.deviation))
            .file("rmse", |c| Cell::exact(c.error))
            .file("coverage", |c| Cell::exact(c.coverage))
            .file("half_width", |c| Cell::exact(c.half_width))
            .file("cpu_hours", |c| Cell::exact(c.cpu_hours));
        columns.table(self.cells)
    }

    /// Writes `errors.csv` into a folder and returns its path.
    ///
    /// # Errors
    ///
    /// [`ReportError`] when it cannot be written.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, ReportError> {
        make_folder(folder)?;
        let path = folder.join("errors.csv");
        write_atomically(&path, self.errors().csv().as_bytes())?;
        Ok(path)
    }

    /// Returns what must be known beside the table.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        for (method, lacks) in &self.recorded.lacking {
            let n = format::count(*lacks, "point MDP");
            notes.push(format!("{method} is left out: it has no score on {n}."));
        }
        for kind in &self.plan.kinds {
            let off = || {
                let own = self.cells.iter().filter(|c| c.kind == *kind);
                own.filter(|c| c.coverage.is_some_and(|share| share < LEAST_COVERAGE))
            };
            let Some(least) =
                off().min_by(|a, b| a.coverage.partial_cmp(&b.coverage).expect("shares"))
            else {
                continue;
            };
            let names: BTreeSet<&str> = off().map(|c| c.method.as_str()).collect();
            notes.push(format!(
                "{}: intervals contain the overall performance in less than 92% of samples for {}; the lowest is {} at \
                 N = {}, {}.",
                kind.title(),
                names.into_iter().collect::<Vec<_>>().join(", "),
                least.method,
                least.budget,
                format::percent(least.coverage.unwrap_or(1.0)),
            ));
        }
        if self.plan.kinds.iter().any(|k| k.is_assisted()) {
            notes.push(self.inputs());
        }
        notes
    }

    /// Says what Bayesian quadrature knows.
    fn inputs(&self) -> String {
        let names: Vec<&str> = self.recorded.inputs.iter().map(|(i, _)| &i.method[..]).collect();
        if names.is_empty() {
            return "Bayesian quadrature knows only the features: no method that does not learn has results on all \
            point MDPs; see --assist."
                .to_owned();
        }
        format!(
            "Bayesian quadrature knows the scores of {} on all point MDPs, but never those of the method that is \
             estimated.",
            names.join(", ")
        )
    }
}

//! What came of a study of estimators: a table for terminals, what must be known beside it, and `errors.csv`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use basics::files::{make_folder, write_atomically};

use super::csv::{number, table};
use super::error::ReportError;
use super::format;
use super::plain_table::plain_table;
use crate::study::{Cell, Kind, Recorded, StudyPlan};

/// Coverage of a 95% interval that is called right.
const RIGHT: std::ops::RangeInclusive<f64> = 0.92..=0.98;

/// A study with what it was made of.
#[derive(Debug, Clone, Copy)]
pub struct StudyReport<'a> {
    /// The family with its scores.
    pub recorded: &'a Recorded,
    /// What was studied.
    pub plan: &'a StudyPlan,
    /// What came of it.
    pub cells: &'a [Cell],
}

impl StudyReport<'_> {
    /// Returns root-mean-square errors with the coverage of intervals, a row per method and estimator.
    pub fn table(&self) -> String {
        let mut header = vec!["method".to_owned(), "overall".to_owned(), "estimator".to_owned()];
        header.extend(self.plan.budgets.iter().map(|b| format!("N = {b}")));
        let header: Vec<&str> = header.iter().map(String::as_str).collect();
        let mut rows = Vec::new();
        for method in &self.recorded.methods {
            for kind in &self.plan.kinds {
                let cells = self.cells_of(*kind, &method.name);
                let mut row = vec![
                    method.name.clone(),
                    format::score(self.recorded.truth(method)),
                    kind.title().to_owned(),
                ];
                row.extend(cells.iter().map(|c| cell(c)));
                rows.push(row);
            }
        }
        let right: Vec<usize> = (0..header.len()).filter(|c| ![0, 2].contains(c)).collect();
        format!(
            "Root-mean-square error of the overall performance over {} samples, and how often its 95% interval \
             contains it:\n\n{}",
            self.plan.repeats,
            plain_table(&header, &right, rows)
        )
    }

    /// Returns what must be known beside the table.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        for (method, lacks) in &self.recorded.lacking {
            let n = format::count(*lacks, "point MDP");
            notes.push(format!("{method} is left out: it has no score on {n}."));
        }
        for kind in &self.plan.kinds {
            let off = self.off(*kind);
            let coverage = |c: &&&Cell| c.coverage.unwrap_or(1.0);
            let least = off.iter().min_by(|a, b| coverage(a).total_cmp(&coverage(b)));
            if let Some(cell) = least {
                let names: BTreeSet<&str> = off.iter().map(|c| c.method.as_str()).collect();
                let names: Vec<&str> = names.into_iter().collect();
                notes.push(format!(
                    "{}: intervals contain the overall performance in less than 92% of samples for {}; the lowest is \
                     {} at N = {}, {}.",
                    kind.title(),
                    names.join(", "),
                    cell.method,
                    cell.budget,
                    format::percent(cell.coverage.unwrap_or(1.0)),
                ));
            }
        }
        notes.extend(self.against_representatives());
        if self.plan.kinds.iter().any(|k| k.is_assisted()) {
            notes.push(self.inputs());
        }
        notes
    }

    /// Returns the cells in which an estimator's intervals cover too little.
    fn off(&self, kind: Kind) -> Vec<&Cell> {
        let cells = self.cells.iter().filter(|c| c.kind == kind);
        cells.filter(|c| c.coverage.is_some_and(|share| share < *RIGHT.start())).collect()
    }

    /// Says how large errors are in proportion to those of k-means, in the worst case over methods; `None` without both.
    fn against_representatives(&self) -> Option<String> {
        let ratio = |c: &Cell| {
            let m3 =
                self.cells_of(Kind::M3, &c.method).into_iter().find(|o| o.budget == c.budget)?;
            (m3.error > 0.0).then(|| c.error / m3.error)
        };
        let worst = |kind: Kind, budget: usize| {
            let cells = self.cells.iter().filter(|c| c.kind == kind && c.budget == budget);
            cells.filter_map(ratio).max_by(f64::total_cmp)
        };
        let others = self.plan.kinds.iter().filter(|k| **k != Kind::M3);
        let said: Vec<String> = others
            .filter_map(|kind| {
                let at = |n: &usize| Some(format!("{:.2} at N = {n}", worst(*kind, *n)?));
                let all: Vec<String> = self.plan.budgets.iter().filter_map(at).collect();
                (!all.is_empty()).then(|| format!("{} {}", kind.title(), all.join(", ")))
            })
            .collect();
        let what = "Error in proportion to that of M3, k-means, for the method where it is largest";
        (!said.is_empty()).then(|| format!("{what}: {}.", said.join("; ")))
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

    /// Returns the cells of an estimator and a method, by budget.
    fn cells_of(&self, kind: Kind, method: &str) -> Vec<&Cell> {
        self.cells.iter().filter(|c| c.kind == kind && c.method == method).collect()
    }
}

fn cell(cell: &Cell) -> String {
    let coverage = cell.coverage.map_or_else(String::new, |c| format!(" ({c:.2})"));
    format!("{:.4}{coverage}", cell.error)
}

/// Writes `errors.csv` into a folder, a row per estimator, budget and method; returns the file.
///
/// # Errors
///
/// [`ReportError`] when it cannot be written.
pub fn write(folder: &Path, report: &StudyReport<'_>) -> Result<PathBuf, ReportError> {
    make_folder(folder)?;
    let header = [
        "method", "estimator", "budget", "repeats", "truth", "mean", "deviation", "rmse",
        "coverage", "half_width", "cpu_hours",
    ];
    let rows = report.cells.iter().map(|cell| {
        vec![
            cell.method.clone(),
            cell.kind.name().to_owned(),
            cell.budget.to_string(),
            cell.repeats.to_string(),
            cell.truth.to_string(),
            cell.mean.to_string(),
            cell.deviation.to_string(),
            cell.error.to_string(),
            number(cell.coverage),
            number(cell.half_width),
            number(cell.cpu_hours),
        ]
    });
    let path = folder.join("errors.csv");
    write_atomically(&path, table(&header, rows).as_bytes())?;
    Ok(path)
}

//! `errors.csv`: a row per estimator, budget and method.

use super::whole::StudyReport;
use crate::report::csv::{number, table};

/// Returns `errors.csv`.
pub(super) fn errors(report: &StudyReport<'_>) -> String {
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
    table(&header, rows)
}

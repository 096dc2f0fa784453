//! Writes what came of a study.

use std::path::{Path, PathBuf};

use super::{StudyReport, figure, page, stopping};
use crate::report::csv::{number, table};
use crate::report::error::ReportError;
use basics::files::{make_folder, write_atomically};

/// Writes `index.html`, `errors.csv` and the figure `budget`, and where runs that stop early were tried `stopping.csv`, into a folder; returns the page.
///
/// # Errors
///
/// [`ReportError`] when a file cannot be written.
pub fn write(folder: &Path, report: &StudyReport<'_>) -> Result<PathBuf, ReportError> {
    make_folder(folder)?;
    let figure = figure::by_budget(report);
    figure.write(folder)?;
    write_atomically(&folder.join("errors.csv"), errors(report).as_bytes())?;
    if let Some(csv) = stopping::csv(report) {
        write_atomically(&folder.join("stopping.csv"), csv.as_bytes())?;
    }
    let page = folder.join("index.html");
    write_atomically(&page, page::html(report, &figure)?.as_bytes())?;
    Ok(page)
}

/// Returns `errors.csv`: a row per estimator, budget and method.
fn errors(report: &StudyReport<'_>) -> String {
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

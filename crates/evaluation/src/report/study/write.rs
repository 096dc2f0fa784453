//! Writes what came of a study.

use std::path::{Path, PathBuf};

use super::whole::StudyReport;
use super::{csv, figure, page, stopping};
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
    write_atomically(&folder.join("errors.csv"), csv::errors(report).as_bytes())?;
    if let Some(csv) = stopping::csv(report) {
        write_atomically(&folder.join("stopping.csv"), csv.as_bytes())?;
    }
    let page = folder.join("index.html");
    write_atomically(&page, page::html(report, &figure)?.as_bytes())?;
    Ok(page)
}

//! Writes the files of a report, each of them either complete or as it was before.

use std::path::{Path, PathBuf};

use super::csv::{number, table};
use super::sections::ReportError;
use super::whole::Report;
use super::{figures, html, tables};
use crate::analysis::Analysis;
use crate::store::Layout;
use crate::store::figures::POLICY_ROW;
use crate::store::record::RowKind;
use basics::files::{FileError, make_folder_beneath, write_atomically};

/// The files of a report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReportPaths {
    /// `DIR/report/index.html`.
    pub html: PathBuf,
    /// What people should know of what the domain adds, such as why a file is missing.
    pub notes: Vec<String>,
    /// `DIR/report/*.svg`.
    pub figures: Vec<PathBuf>,
}

/// Writes a report: to `DIR/report/`, or, where scores are relative to another method than the baseline, to
/// `DIR/report/against-METHOD/`.
///
/// # Errors
///
/// [`ReportError::Io`] when the folder cannot be written or the disk is full.
pub fn write(layout: &Layout, data: &Report) -> Result<ReportPaths, ReportError> {
    write_models(layout, (layout.root(), &layout.report()), data)?;
    write_to(layout.root(), &layout.report(), data)
}

/// Writes a report to a folder, or, where scores are relative to another method than the baseline, to
/// `against-METHOD/` in it.
///
/// # Arguments
///
/// * `root` — the folder itself or one above it, beneath which nothing is written through links.
///
/// # Errors
///
/// As [`write()`].
pub fn write_to(root: &Path, folder: &Path, data: &Report) -> Result<ReportPaths, ReportError> {
    let folder = match data.reference.is_baseline {
        true => folder.to_path_buf(),
        false => folder.join(format!("against-{}", data.reference.name)),
    };
    make_folder_beneath(root, &folder)?;
    let mut figures = figures::figures(data);
    figures.extend(data.sections.figures(data));
    let page = html::page(data, &figures)?;
    let written = data.sections.write(&folder, data)?;
    let mut paths =
        ReportPaths { notes: written.notes, html: folder.join("index.html"), figures: Vec::new() };
    for figure in &figures {
        paths.figures.push(figure.write(&folder)?);
    }
    for (name, text) in tables::files(data) {
        write_atomically(&folder.join(name), text.as_bytes())?;
    }
    // The page comes last: when it is new, everything that it names is new too.
    write_atomically(&paths.html, page.as_bytes())?;
    Ok(paths)
}

/// Writes the index of the models of a results directory: a row per file, in the order of the plan. Writes nothing and
/// returns `None` where there are no models.
///
/// # Arguments
///
/// * `root` — the folder itself or one above it, beneath which nothing is written through links.
///
/// # Errors
///
/// [`FileError`] when the folder cannot be written or the disk is full.
pub fn write_models(
    layout: &Layout,
    (root, folder): (&Path, &Path),
    data: &Analysis,
) -> Result<Option<PathBuf>, FileError> {
    let objective = data.manifest.identity.objective.as_str();
    let header = ["file", "method", "point", "replicate", "episode", "episodes", "seed", objective];
    let mut rows = data.results.models(layout).map(|(task, record)| {
        let path = layout.model(task.task);
        let file = path.strip_prefix(layout.root()).unwrap_or(&path);
        let episodes = record.rows.iter().filter(|row| row.kind == RowKind::Training).count();
        let metric = |name: &str| record.summary.metrics.get(name).copied();
        vec![
            file.display().to_string(),
            task.method.clone(),
            task.point.clone(),
            task.replicate.to_string(),
            // Without a choice among policies it is the last one.
            number(Some(metric(POLICY_ROW).unwrap_or(episodes as f64))),
            episodes.to_string(),
            task.seed.to_string(),
            number(metric(objective)),
        ]
    });
    let Some(first) = rows.next() else { return Ok(None) };
    let text = table(&header, std::iter::once(first).chain(rows));
    make_folder_beneath(root, folder)?;
    let path = folder.join("models.csv");
    write_atomically(&path, text.as_bytes())?;
    Ok(Some(path))
}

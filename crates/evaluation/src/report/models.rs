//! `models.csv`: which file of a results directory has which model.

use std::path::{Path, PathBuf};

use super::csv::{number, table};
use crate::analysis::Analysis;
use crate::store::Layout;
use crate::store::figures::POLICY_ROW;
use crate::store::record::RowKind;
use basics::files::{FileError, make_folder_beneath, write_atomically};

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

//! Writes the files of a report, each of them either complete or as it was before.

use std::fs;

use super::data::ReportData;
use super::{
    ReportError, ReportPaths, context, csv, curves, figures, html, intersections, map, plans,
};
use crate::files::FileError;
use crate::files::write_atomically;
use crate::run::method::Method;
use crate::store::Layout;
use crate::store::results::Results;

/// Reads a results directory and writes its report, with the methods in the colours of `methods`.
///
/// # Errors
///
/// [`ReportError::Store`] when the directory holds no readable results, [`ReportError::Io`] when
/// `DIR/report/` cannot be written or the disk is full.
pub fn write(layout: &Layout, methods: &[Method]) -> Result<ReportPaths, ReportError> {
    write_data(layout, &ReportData::new(&Results::load(layout)?, methods))
}

/// Writes the report of results that were read already: to `DIR/report/`, or, where scores are
/// relative to another method than the baseline, to `DIR/report/against-METHOD/`.
///
/// # Errors
///
/// [`ReportError::Io`] when `DIR/report/` cannot be written or the disk is full.
pub fn write_data(layout: &Layout, data: &ReportData) -> Result<ReportPaths, ReportError> {
    let folder = match data.reference.is_baseline {
        true => layout.report(),
        false => layout.report().join(format!("against-{}", data.reference.name)),
    };
    fs::create_dir_all(&folder).map_err(FileError::at("create", &folder))?;
    let figures: Vec<_> = [
        figures::overall(data),
        figures::distribution(data),
        curves::learning(data),
        figures::levels(data),
        context::by_feature(data),
        map::places(data),
    ]
    .into_iter()
    .flatten()
    .collect();
    let page = html::page(data, &figures).map_err(ReportError::Template)?;
    let written = plans::write(&folder, data)?;
    let placed = |name: &str| (!data.places.intersections.is_empty()).then(|| folder.join(name));
    let mut paths = ReportPaths {
        plans: written.table,
        plans_missing: written.missing,
        intersections: placed("intersections.csv"),
        geojson: placed("results.geojson"),
        html: folder.join("index.html"),
        scores: folder.join("scores.csv"),
        summary: folder.join("summary.csv"),
        episodes: folder.join("episodes.csv"),
        training: (!data.trainings.is_empty()).then(|| folder.join("training.csv")),
        figures: Vec::new(),
    };
    for figure in &figures {
        let path = folder.join(format!("{}.svg", figure.name));
        write_atomically(&path, figure.svg.as_bytes())?;
        paths.figures.push(path);
    }
    write_atomically(&paths.scores, csv::scores(data).as_bytes())?;
    write_atomically(&paths.summary, csv::summary(data).as_bytes())?;
    write_atomically(&paths.episodes, csv::episodes(data).as_bytes())?;
    if let Some(path) = &paths.training {
        write_atomically(path, csv::training(data).as_bytes())?;
    }
    if let Some(path) = &paths.intersections {
        write_atomically(path, intersections::table(data).as_bytes())?;
    }
    if let Some(path) = &paths.geojson {
        write_atomically(path, intersections::geojson(data).as_bytes())?;
    }
    // The page comes last: when it is new, everything that it names is new too.
    write_atomically(&paths.html, page.as_bytes())?;
    Ok(paths)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_cannot_be_replaced_is_named_and_leaves_no_draft() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("index.html");
        fs::create_dir(&path).unwrap();
        let e = write_atomically(&path, b"x").unwrap_err().to_string();
        assert!(e.starts_with("cannot write") && e.contains("index.html"), "{e}");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }
}

//! Writes the files of a report, each of them either complete or as it was before.

use std::path::Path;

use super::error::ReportError;
use super::paths::ReportPaths;
use super::whole::Report;
use super::{compared, context, csv, curves, figures, html, profiles, ranks};
use crate::store::Layout;
use basics::files::{Streamed, make_folder_beneath, write_atomically};

/// Writes a report: to `DIR/report/`, or, where scores are relative to another method than the baseline, to
/// `DIR/report/against-METHOD/`.
///
/// # Errors
///
/// [`ReportError::Io`] when the folder cannot be written or the disk is full.
pub fn write(layout: &Layout, data: &Report) -> Result<ReportPaths, ReportError> {
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
    let general = [
        figures::overall(data),
        ranks::ranks(data),
        profiles::profiles(data),
        figures::distribution(data),
        curves::learning(data),
        context::by_feature(data),
    ];
    let mut figures: Vec<_> = general.into_iter().flatten().collect();
    figures.extend(data.sections.figures(data));
    let page = html::page(data, &figures)?;
    let written = data.sections.write(&folder, data)?;
    let mut paths = ReportPaths {
        further: written.files,
        notes: written.notes,
        html: folder.join("index.html"),
        scores: folder.join("scores.csv"),
        summary: folder.join("summary.csv"),
        episodes: folder.join("episodes.csv"),
        pairs: folder.join("pairs.csv"),
        ranks: folder.join("ranks.csv"),
        profiles: folder.join("profiles.csv"),
        training: (!data.trainings.is_empty()).then(|| folder.join("training.csv")),
        figures: Vec::new(),
    };
    for figure in &figures {
        let path = folder.join(format!("{}.svg", figure.name));
        write_atomically(&path, figure.svg.as_bytes())?;
        paths.figures.push(path);
    }
    csv::scores(data, Streamed::new(&paths.scores)?)?;
    write_atomically(&paths.summary, csv::summary(data).as_bytes())?;
    csv::episodes(data, Streamed::new(&paths.episodes)?)?;
    write_atomically(&paths.pairs, compared::pairs(data).as_bytes())?;
    write_atomically(&paths.ranks, compared::ranks(data).as_bytes())?;
    write_atomically(&paths.profiles, compared::profiles(data).as_bytes())?;
    if let Some(path) = &paths.training {
        csv::training(data, Streamed::new(path)?)?;
    }
    // The page comes last: when it is new, everything that it names is new too.
    write_atomically(&paths.html, page.as_bytes())?;
    Ok(paths)
}

#[cfg(test)]
mod tests {
    use std::fs;

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

//! Writes the files of a report, each of them either complete or as it was before.

use std::path::{Path, PathBuf};

use super::error::ReportError;
use super::models::write_models;
use super::table::Table;
use super::whole::Report;
use super::{csv, curves, figures, html, mix, ranks, summaries, sure, text};
use crate::store::Layout;
use basics::files::{make_folder_beneath, write_atomically};

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
    let general = [
        figures::overall(data),
        ranks::ranks(data),
        figures::distribution(data),
        curves::learning(data),
    ];
    let mut figures: Vec<_> = general.into_iter().flatten().collect();
    figures.extend(data.sections.figures(data));
    let page = html::page(data, &figures)?;
    let written = data.sections.write(&folder, data)?;
    let mut paths =
        ReportPaths { notes: written.notes, html: folder.join("index.html"), figures: Vec::new() };
    for figure in &figures {
        paths.figures.push(figure.write(&folder)?);
    }
    for (name, about, cells) in for_papers(data) {
        write_atomically(&folder.join(name), cells.latex(&about).as_bytes())?;
    }
    let tables = [
        ("scores.csv", Some(csv::scores(data))),
        ("summary.csv", Some(data.ranking().csv())),
        ("pairs.csv", Some(sure::pairs(data, &data.comparison.pairs).csv())),
        ("ranks.csv", Some(sure::places(data).csv())),
        ("profiles.csv", Some(sure::profiles(data).csv())),
        ("mix.csv", data.mix().map(|mix| mix::table(data, mix).csv())),
        ("episodes.csv", Some(csv::episodes(data))),
        ("learning.csv", curves::table(data)),
        ("training.csv", (!data.trainings.is_empty()).then(|| csv::training(data))),
    ];
    for (name, text) in tables {
        text.map_or(Ok(()), |text| write_atomically(&folder.join(name), text.as_bytes()))?;
    }
    // The page comes last: when it is new, everything that it names is new too.
    write_atomically(&paths.html, page.as_bytes())?;
    Ok(paths)
}

fn for_papers(data: &Report) -> Vec<(&'static str, String, Table)> {
    let (of, relative) = (&data.manifest.identity.scenario, data.relative());
    let noun = &data.words.noun;
    let better = data.better();
    let mut tables = vec![(
        "ranking.tex",
        format!("Methods on {of} by overall performance: {noun}{relative}; {better}"),
        data.ranking(),
    )];
    if data.methods.iter().any(|m| m.overall.is_some() && !m.is_reference) {
        let about = format!("Further summaries of the methods on {of}, of {noun}{relative}");
        tables.push(("summaries.tex", about, summaries::table(data)));
    }
    let of_pairs = format!(
        "Methods on {of} two at a time: by how much one is ahead, and how often it is better"
    );
    let of_trainings = format!("Trainings of the learners on {of}, of {noun}{relative}");
    tables.push(("pairs.tex", of_pairs, sure::pairs(data, &data.comparison.pairs)));
    tables.push(("training.tex", of_trainings, text::trainings(data)));
    tables.retain(|(.., table)| !table.is_empty());
    tables
}

//! `tsc-family compare`.

use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::folder::{REPORT, Target};
use super::output::{line, note};
use super::report::{MixArgs, print, show};
use crate::analysis::joined::{Known, Source, join, obstacle, settings};
use crate::cli::exit::{self, refuse};
use crate::domains;
use crate::files::FileError;
use crate::report::{Report, Runs, findings};
use crate::store::Layout;
use crate::store::results::Results;

/// How deep results directories may lie below a folder that is given: family, then run.
const DEPTH: usize = 2;

/// Differences that the terminal shows.
const SHOWN: usize = 12;

/// `tsc-family compare`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The runs have one family, preset, demand and --seed. What differs between them is said first: simulator, \
build, settings. A method whose records differ between the runs is there once per run, as METHOD@RUN. Scores \
are relative to the baseline of the first run. Of a folder with runs in it, those are taken that have all \
point MDPs of the first run, and its settings. Folders alone give a leaderboard: a ranking per family, preset \
and sample of the runs in them. Needs no SUMO.

Examples:
  tsc-family compare results/published results/mine
  tsc-family compare results/mine results/salt-lake-city --out results/compared
  tsc-family compare results/mine results/mine-changed results/published --out results/compared
  tsc-family compare results")]
pub struct CompareArgs {
    /// Results directories that `run` wrote, of one family, or folders with such
    #[arg(value_name = "RESULTS", required = true)]
    pub results: Vec<PathBuf>,
    /// Which methods the mix may take
    #[command(flatten)]
    pub mix: MixArgs,
    /// Folder for the page, tables and figures [default: none is written]
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Print JSON lines instead of the table: one for the runs, one per method
    #[arg(long)]
    pub json: bool,
}

pub(super) fn run(args: &CompareArgs) -> anyhow::Result<u8> {
    let target = args.out.as_ref().map(|out| Target::new(out, out.clone(), Some(out)));
    target.iter().try_for_each(|target| target.check(&REPORT))?;
    let (given, folders): (Vec<&PathBuf>, Vec<&PathBuf>) =
        args.results.iter().partition(|path| is_run(path) || !path.is_dir());
    let in_folders =
        found(&folders)?.iter().map(|path| read(path)).collect::<Result<Vec<_>, _>>()?;
    let mut runs = given.into_iter().map(|path| read(path)).collect::<Result<Vec<_>, _>>()?;
    if runs.is_empty() {
        return leaderboard(in_folders, args);
    }
    let left_out = add_fitting(&mut runs, &in_folders);
    if let ([first], false) = (&runs[..], in_folders.is_empty()) {
        left_out.into_iter().for_each(note);
        let shown: Vec<String> = folders.iter().map(|f| f.display().to_string()).collect();
        return refuse(format!(
            "none of the runs in {} can be compared with {}; run its methods on the point MDPs, preset and seeds of one of them",
            shown.join(", "),
            first.path
        ));
    }
    if runs.len() < 2 {
        return refuse(
            "compare needs two results directories or more of one family, or a folder with runs in it",
        );
    }
    let data = joined(runs, &args.mix)?;
    let runs = data.runs.as_ref().expect("it compares runs");
    if args.json {
        line(runs.json())?;
    } else {
        differences(runs, target.is_some())?;
    }
    left_out.into_iter().for_each(note);
    match &target {
        Some(target) => print(target, &data, args.json, true)?,
        None => {
            show(&data, args.json)?;
            findings::notes(&data).into_iter().filter(|_| !args.json).for_each(note);
        }
    }
    Ok(exit::DONE)
}

/// Prints a ranking per group of runs that can be compared, those of the largest samples first.
fn leaderboard(mut all: Vec<Source>, args: &CompareArgs) -> anyhow::Result<u8> {
    if args.out.is_some() {
        return refuse(
            "a leaderboard has no page; before the folders, name a run with which theirs are compared",
        );
    }
    all.sort_by_key(|run| Reverse(run.results.manifest.identity.points.len()));
    let mut ranked = BTreeSet::new();
    for first in &all {
        if ranked.contains(&first.results.sha256) {
            continue;
        }
        let mut group = vec![first.clone()];
        add_fitting(&mut group, &all);
        ranked.extend(group.iter().map(|run| run.results.sha256.clone()));
        let data = joined(group, &args.mix)?;
        let (identity, runs) = (&data.manifest.identity, data.runs.as_ref());
        let runs = runs.expect("it compares runs");
        match args.json {
            true => line(runs.json())?,
            false => line(format_args!(
                "\n== {}, preset {}, {} of {} point MDPs: {}\n",
                identity.scenario,
                identity.settings["preset"].as_str().unwrap_or("none"),
                identity.points.len(),
                identity.sample.family_size,
                runs.sources.iter().map(|(name, ..)| name.as_str()).collect::<Vec<_>>().join(", ")
            ))?,
        }
        show(&data, args.json)?;
    }
    Ok(exit::DONE)
}

fn joined(runs: Vec<Source>, mix: &MixArgs) -> anyhow::Result<Report> {
    let known = known(&runs);
    let joined = join(Source::named(runs), &known)?;
    let layout = Layout::new(&joined.sources[joined.sample].path);
    let sections = domains::sections(&layout, &joined.results)?;
    mix.applied(Report::joined(joined, sections))
}

fn read(path: &Path) -> anyhow::Result<Source> {
    let (shown, results) = (path.display().to_string(), Results::load(&Layout::new(path))?);
    Ok(Source { name: shown.clone(), path: shown, results })
}

/// Returns what a comparison must know of the domain of the first run.
fn known(runs: &[Source]) -> Known {
    let name = runs.first().map_or("", |run| &run.results.manifest.identity.domain);
    let domain = domains::domains().into_iter().find(|known| known.name() == name);
    domain.map_or_else(Known::default, |domain| Known {
        methods: domain.methods().iter().map(|method| method.name).collect(),
        episodes: domain.episode_sections(),
    })
}

/// Adds the runs that can be compared with the first one on all its point MDPs, under the same settings of all methods;
/// returns why others are left out.
fn add_fitting(runs: &mut Vec<Source>, others: &[Source]) -> Vec<String> {
    let (known, mut left_out) = (known(runs), Vec::new());
    for other in others {
        if runs.iter().any(|run| run.results.sha256 == other.results.sha256) {
            continue;
        }
        let settings = settings(&runs[0], other, &known);
        let reason = match obstacle(&runs[0], other, &known) {
            // The way out is for who asked for this very run.
            Some(e) => e.to_string().split(';').next().unwrap_or_default().to_owned(),
            None if settings.is_empty() => {
                runs.push(other.clone());
                continue;
            }
            None => format!(
                "its settings are others ({}); name the run itself to have it too",
                settings.join(", ")
            ),
        };
        left_out.push(format!("{} is left out: {reason}", other.path));
    }
    left_out
}

/// Prints what differs between runs, and which episodes they share.
fn differences(runs: &Runs, has_page: bool) -> anyhow::Result<()> {
    let all = &runs.differences;
    line(match all.is_empty() {
        true => "The runs differ in their methods alone.",
        false => "What differs between the runs:",
    })?;
    let shown = if has_page { SHOWN } else { all.len() };
    all.iter().take(shown).try_for_each(|difference| line(format_args!("- {difference}")))?;
    if all.len() > shown {
        line(format_args!("- and {} more, which the page has", all.len() - shown))?;
    }
    if !runs.repeated.is_empty() {
        line("\nMethods in several runs:")?;
    }
    runs.repeated.iter().try_for_each(|said| line(format_args!("- {said}")))?;
    Ok(line("")?)
}

/// Returns the results directories that folders are or have in them, those of a folder in the order of their names.
///
/// # Errors
///
/// [`Refused`] for a folder without any.
fn found(dirs: &[&PathBuf]) -> anyhow::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for dir in dirs {
        let before = found.len();
        find(dir, DEPTH, &mut found)?;
        if found.len() == before {
            let dir = dir.display();
            return refuse(format!(
                "{dir} is no results directory, and has none in it; give a folder that `run --out` wrote"
            ));
        }
    }
    Ok(found)
}

/// Returns whether a folder is a results directory itself.
fn is_run(dir: &Path) -> bool {
    let layout = Layout::new(dir);
    let files = [layout.manifest(), layout.adding(), layout.packed()];
    files.iter().any(|path| path.exists())
}

fn find(dir: &Path, depth: usize, found: &mut Vec<PathBuf>) -> anyhow::Result<()> {
    if is_run(dir) {
        found.push(dir.to_path_buf());
        return Ok(());
    }
    if depth == 0 || !dir.is_dir() {
        return Ok(());
    }
    let entries = fs::read_dir(dir).map_err(FileError::at("read", dir))?;
    let folders = entries.flatten().map(|entry| entry.path()).filter(|path| path.is_dir());
    let mut folders: Vec<PathBuf> = folders.collect();
    folders.sort();
    folders.iter().try_for_each(|folder| find(folder, depth - 1, found))
}

//! `tsc-family compare`.

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
point MDPs of the first run, and its settings. Needs no SUMO.

Examples:
  tsc-family compare results/published results/mine
  tsc-family compare results/mine results/salt-lake-city --out results/compared
  tsc-family compare results/mine results/mine-changed results/published --out results/compared")]
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
    let mut runs: Vec<(String, Results)> =
        given.into_iter().map(|path| read(path)).collect::<Result<_, _>>()?;
    let domain = runs.first().map(|(_, results)| results.manifest.identity.domain.clone());
    let known = known(&domain.unwrap_or_default());
    let left_out = add_fitting(&mut runs, &folders, &known)?;
    let joined = join(Source::named(runs), &known)?;
    let layout = Layout::new(&joined.sources[joined.sample].path);
    let sections = domains::sections(&layout, &joined.results)?;
    let data = args.mix.applied(Report::joined(joined, sections))?;
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

fn read(path: &Path) -> anyhow::Result<(String, Results)> {
    Ok((path.display().to_string(), Results::load(&Layout::new(path))?))
}

/// Returns what a comparison must know of a domain.
fn known(domain: &str) -> Known {
    let domain = domains::domains().into_iter().find(|known| known.name() == domain);
    domain.map_or_else(Known::default, |domain| Known {
        methods: domain.methods().iter().map(|method| method.name).collect(),
        episodes: domain.episode_sections(),
    })
}

/// Adds the runs in folders that can be compared with the first one on all its point MDPs, under the same settings of all
/// methods; returns why others are left out.
fn add_fitting(
    runs: &mut Vec<(String, Results)>,
    folders: &[&PathBuf],
    known: &Known,
) -> anyhow::Result<Vec<String>> {
    let mut left_out = Vec::new();
    let Some(first) = runs.first().filter(|_| !folders.is_empty()) else { return Ok(left_out) };
    let source = |(path, results): &(String, Results)| Source {
        name: path.clone(),
        path: path.clone(),
        results: results.clone(),
    };
    let first = source(first);
    let mut taken: Vec<String> = runs.iter().map(|(_, results)| results.sha256.clone()).collect();
    let folders: Vec<PathBuf> = folders.iter().map(|folder| (*folder).clone()).collect();
    for path in found(&folders)? {
        let run = read(&path)?;
        if taken.contains(&run.1.sha256) {
            continue;
        }
        let other = source(&run);
        let others = settings(&first, &other, known);
        let reason = match obstacle(&first, &other, known) {
            // The way out is for who asked for this very run.
            Some(e) => e.to_string().split(';').next().unwrap_or_default().to_owned(),
            None if others.is_empty() => {
                taken.push(run.1.sha256.clone());
                runs.push(run);
                continue;
            }
            None => format!(
                "its settings are others ({}); name the run itself to have it too",
                others.join(", ")
            ),
        };
        left_out.push(format!("{} is left out: {reason}", run.0));
    }
    if let [(first, _)] = &runs[..] {
        left_out.into_iter().for_each(note);
        let shown: Vec<String> = folders.iter().map(|f| f.display().to_string()).collect();
        return refuse(format!(
            "none of the runs in {} can be compared with {first}; run its methods on the point MDPs, preset and seeds of one \
             of them",
            shown.join(", ")
        ));
    }
    Ok(left_out)
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
fn found(dirs: &[PathBuf]) -> anyhow::Result<Vec<PathBuf>> {
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

//! `tsc-family compare`.

use std::path::{Path, PathBuf};

use super::folder::REPORT;
use super::found::{found, is_run};
use super::leaderboard;
use super::output::{line, note};
use super::report::{MixArgs, print, show};
use super::target::Target;
use crate::analysis::joined::{Known, Source, join, obstacle};
use crate::analysis::leaderboard::settings;
use crate::cli::exit;
use crate::cli::refused::Refused;
use crate::domains;
use crate::report::{Report, Runs, text};
use crate::store::Layout;
use crate::store::results::Results;

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
  tsc-family compare results/mine results/mine-changed results/published --out results/compared
  tsc-family compare --leaderboard results --out results/README.md")]
pub struct CompareArgs {
    /// Results directories that `run` wrote, of one family, or folders with such
    #[arg(value_name = "RESULTS", required = true)]
    pub results: Vec<PathBuf>,
    /// Rank all runs instead, per family and preset: one page in Markdown
    #[arg(long)]
    pub leaderboard: bool,
    /// Which methods the mix may take
    #[command(flatten)]
    pub mix: MixArgs,
    /// Folder for the page, tables and figures, or file for a leaderboard [default: none is written]
    #[arg(long, value_name = "FOLDER|FILE")]
    pub out: Option<PathBuf>,
    /// Print JSON lines instead of the table: one for the runs, one per method; of a leaderboard one per row
    #[arg(long)]
    pub json: bool,
}

pub(super) fn run(args: &CompareArgs) -> anyhow::Result<u8> {
    if args.leaderboard {
        return leaderboard::run(args);
    }
    let target = args.out.as_ref().map(|out| Target::new(out, out.clone(), Some(out)));
    target.iter().try_for_each(|target| target.check(&REPORT))?;
    let read = |path: &Path| -> anyhow::Result<(String, Results)> {
        Ok((path.display().to_string(), Results::load(&Layout::new(path))?))
    };
    let (given, folders): (Vec<&PathBuf>, Vec<&PathBuf>) =
        args.results.iter().partition(|path| is_run(path) || !path.is_dir());
    let mut runs: Vec<(String, Results)> =
        given.into_iter().map(|path| read(path)).collect::<Result<_, _>>()?;
    let domain = runs.first().and_then(|(_, results)| {
        let name = &results.manifest.identity.domain;
        domains::domains().into_iter().find(|domain| domain.name() == name)
    });
    let methods: Vec<&str> = domain.iter().flat_map(|d| d.methods()).map(|m| m.name).collect();
    let known = Known {
        methods: &methods,
        episodes: domain.map_or(&[][..], |domain| domain.episode_sections()),
    };
    let left_out = add_fitting(&mut runs, &folders, &read, known)?;
    let joined = join(Source::named(runs), known)?;
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
            text::notes(&data).into_iter().filter(|_| !args.json).for_each(note);
        }
    }
    Ok(exit::DONE)
}

/// Adds the runs in folders that can be compared with the first one on all its point MDPs, under the same settings of all
/// methods; returns why others are left out.
fn add_fitting(
    runs: &mut Vec<(String, Results)>,
    folders: &[&PathBuf],
    read: &dyn Fn(&Path) -> anyhow::Result<(String, Results)>,
    known: Known<'_>,
) -> anyhow::Result<Vec<String>> {
    let mut left_out = Vec::new();
    let folders: Vec<PathBuf> = folders.iter().map(|folder| (*folder).clone()).collect();
    let Some((path, results)) = runs.first().filter(|_| !folders.is_empty()) else {
        return Ok(left_out);
    };
    let source = |(path, results): &(String, Results)| Source {
        name: path.clone(),
        path: path.clone(),
        results: results.clone(),
    };
    let first = source(&(path.clone(), results.clone()));
    let mut taken: Vec<String> = runs.iter().map(|(_, results)| results.sha256.clone()).collect();
    for path in found(&folders)? {
        let run = read(&path)?;
        let other = source(&run);
        if taken.contains(&run.1.sha256) {
            continue;
        }
        if let Some(reason) = obstacle(&first, &other, known) {
            // The way out is for who asked for this very run.
            let reason = reason.to_string();
            let reason = reason.split(';').next().unwrap_or_default();
            left_out.push(format!("{} is left out: {reason}", run.0));
            continue;
        }
        let settings = settings(&first, &other, known);
        if !settings.is_empty() {
            left_out.push(format!(
                "{} is left out: its settings are others ({}); name the run itself to have it too",
                run.0,
                settings.join(", ")
            ));
            continue;
        }
        taken.push(run.1.sha256.clone());
        runs.push(run);
    }
    if let [(first, _)] = &runs[..] {
        left_out.into_iter().for_each(note);
        let shown: Vec<String> = folders.iter().map(|f| f.display().to_string()).collect();
        return Err(Refused(format!(
            "none of the runs in {} can be compared with {first}; run its methods on the point MDPs, preset and seeds of one \
             of them",
            shown.join(", ")
        ))
        .into());
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

//! `tsc-family compare`.

use std::path::PathBuf;

use super::folder::REPORT;
use super::json::method_line;
use super::output::{line, note};
use super::report::print;
use super::target::Target;
use crate::analysis::joined::{Known, Source, join};
use crate::cli::exit;
use crate::domains;
use crate::report::{Report, Runs, text};
use crate::store::Layout;
use crate::store::results::Results;

/// Differences that the terminal shows.
const SHOWN: usize = 12;

/// `tsc-family compare`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The runs have one family, preset, demand and --seed. What differs between them is said first:
simulator, build, settings. A method whose records differ between the runs is there once per run,
as METHOD@RUN. Scores are relative to the baseline of the first run. Needs no SUMO.

Examples:
  tsc-family compare results/published results/mine
  tsc-family compare results/mine results/mine-changed results/published --out results/compared")]
pub struct CompareArgs {
    /// Results directories that `run` wrote, of one family
    #[arg(value_name = "RESULTS", required = true)]
    pub results: Vec<PathBuf>,
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
    let read = |path: &PathBuf| -> anyhow::Result<(String, Results)> {
        Ok((path.display().to_string(), Results::load(&Layout::new(path))?))
    };
    let runs: Vec<(String, Results)> = args.results.iter().map(read).collect::<Result<_, _>>()?;
    let domain = runs.first().and_then(|(_, results)| {
        let name = &results.manifest.identity.domain;
        domains::domains().into_iter().find(|domain| domain.name() == name)
    });
    let methods: Vec<&str> = domain.iter().flat_map(|d| d.methods()).map(|m| m.name).collect();
    let known = Known {
        methods: &methods,
        episodes: domain.map_or(&[][..], |domain| domain.episode_sections()),
    };
    let joined = join(Source::named(runs), known)?;
    let layout = Layout::new(&args.results[joined.sample]);
    let sections = domains::sections(&layout, &joined.results)?;
    let data = Report::joined(joined, sections);
    let runs = data.runs.as_ref().expect("it compares runs");
    if args.json {
        line(runs.json())?;
    } else {
        differences(runs, target.is_some())?;
    }
    match &target {
        Some(target) => print(target, &data, args.json, true)?,
        None if args.json => {
            data.json_rows().into_iter().try_for_each(|row| line(method_line(row)))?
        }
        None => {
            line(text::table(&data))?;
            text::notes(&data).into_iter().for_each(note);
        }
    }
    Ok(exit::DONE)
}

/// Prints what differs between runs.
fn differences(runs: &Runs, has_page: bool) -> anyhow::Result<()> {
    let all = &runs.differences;
    if all.is_empty() {
        line("The runs differ in their methods alone.\n")?;
        return Ok(());
    }
    line("What differs between the runs:")?;
    let shown = if has_page { SHOWN } else { all.len() };
    all.iter().take(shown).try_for_each(|difference| line(format_args!("- {difference}")))?;
    if all.len() > shown {
        line(format_args!("- and {} more, which the page has", all.len() - shown))?;
    }
    line("")?;
    Ok(())
}

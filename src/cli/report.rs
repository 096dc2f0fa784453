//! `tsc-family report`.

use std::path::PathBuf;

use super::folder::{REPORT, Target};
use super::output::{events, line, note};
use crate::cli::exit;
use crate::domains;
use crate::report::{self, Report, findings, text};
use crate::stats::Limit;
use crate::store::Layout;
use crate::store::results::Results;

/// Which methods the mix may take.
#[derive(Debug, clap::Args)]
pub struct MixArgs {
    /// Methods from which the mix takes the best per point MDP [default: all that are ranked]
    #[arg(long, value_name = "METHODS", value_delimiter = ',')]
    pub mix: Option<Vec<String>>,
    /// Leave the mix out
    #[arg(long, conflicts_with = "mix")]
    pub no_mix: bool,
}

impl MixArgs {
    /// Returns the report with the mix that is asked for.
    pub(super) fn applied(&self, data: Report) -> anyhow::Result<Report> {
        Ok(match &self.mix {
            _ if self.no_mix => data.mixing(&[])?,
            Some(methods) => data.mixing(methods)?,
            None => data,
        })
    }
}

/// `tsc-family report`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Needs no SUMO. Writes DIR/report/index.html, scores.csv, summary.csv, episodes.csv and the figures as SVG.

Examples:
  tsc-family report results/slc
  tsc-family report results/slc --against fixed-time
  tsc-family report /media/cdrom/slc --out slc-report")]
pub struct ReportArgs {
    /// Results directory that `run` wrote
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Method to divide by instead of the baseline; the report goes to DIR/report/against-METHOD
    #[arg(long, value_name = "METHOD")]
    pub against: Option<String>,
    /// Definition of a failure, in quotes: 'METRIC>VALUE' or 'METRIC<VALUE' [default: that of the task, for signals
    /// a mean wait above 20 s]
    #[arg(long, value_name = "LIMIT")]
    pub failure: Option<Limit>,
    /// Which methods the mix may take
    #[command(flatten)]
    pub mix: MixArgs,
    /// Folder to write to; with --against, its folder against-METHOD [default: DIR/report]
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Print JSON lines instead of the table: one per method
    #[arg(long)]
    pub json: bool,
}

pub(super) fn run(args: &ReportArgs) -> anyhow::Result<u8> {
    let layout = Layout::new(&args.dir);
    let target = Target::new(layout.root(), layout.report(), args.out.as_ref());
    target.check(&REPORT)?;
    let results = Results::load(&layout)?;
    let sections = domains::sections(&layout, &results)?;
    let data = match &args.against {
        Some(method) => Report::against(&results, method, sections)?,
        None => Report::new(&results, sections),
    };
    let data = match &args.failure {
        Some(limit) => data.failing(limit.clone())?,
        None => data,
    };
    let data = args.mix.applied(data)?;
    report::write_models(&layout, (&target.root, &target.folder), &data)?;
    print(&target, &data, args.json, true)?;
    Ok(exit::DONE)
}

/// Writes a report and prints its table, or with `json` its methods; `notes` go to standard error.
pub(super) fn print(target: &Target, data: &Report, json: bool, notes: bool) -> anyhow::Result<()> {
    let paths = report::write_to(&target.root, &target.folder, data)?;
    show(data, json)?;
    if notes {
        findings::notes(data).into_iter().for_each(note);
        paths.notes.into_iter().for_each(note);
        note(format!("report: {}", paths.html.display()));
    }
    Ok(())
}

/// Prints the table of a report, or with `json` its methods and findings.
pub(super) fn show(data: &Report, json: bool) -> anyhow::Result<()> {
    match json {
        true => {
            events("method", data.json_rows())?;
            events("finding", findings::rows(data))
        }
        false => line(text::table(data)),
    }
    .map_err(Into::into)
}

//! `tsc-family export`.

use std::path::PathBuf;

use serde_json::json;

use super::output::{line, note};
use crate::cli::exit;
use crate::export::{Exported, Format, export};
use crate::store::Layout;

/// `tsc-family export`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A row per episode of training and evaluation, with its task, its seed, every metric, and the features, importance
and weight of its point MDP; a task that failed has one row, with its reason. The same records give the same bytes.

Examples:
  tsc-family export results/slc
  tsc-family export results/slc --out slc.parquet
  tsc-family export results/slc --format csv --out slc.csv")]
pub struct ExportArgs {
    /// Results directory that `run` wrote
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// File to write, over one that is there [default: DIR/records.parquet or DIR/records.csv]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// What to write
    #[arg(long, value_enum, default_value_t = Format::Parquet)]
    pub format: Format,
    /// Print a line of JSON instead of words
    #[arg(long)]
    pub json: bool,
}

pub(super) fn run(args: &ExportArgs) -> anyhow::Result<u8> {
    let layout = Layout::new(&args.dir);
    let own = || layout.root().join(format!("records.{}", args.format.extension()));
    let path = args.out.clone().unwrap_or_else(own);
    let Exported { rows, tasks: (done, tasks) } = export(&layout, &path, args.format)?;
    if args.json {
        line(json!({"event": "export", "path": path, "rows": rows, "done": done, "tasks": tasks}))?;
        return Ok(exit::DONE);
    }
    if done < tasks {
        note(format!("{done} of {tasks} tasks have a record, the others no row"));
    }
    line(format!("{}: {rows} episodes of {done} tasks", path.display()))?;
    Ok(exit::DONE)
}

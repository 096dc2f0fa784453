//! `tsc-family export`.

use std::path::PathBuf;

use serde_json::json;

use super::folder::check_file;
use super::output::{line, note};
use crate::cli::exit;
use crate::export::{Format, export};
use crate::store::Layout;

/// `tsc-family export`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Writes a row per episode of training and evaluation, with its task, its seed, every metric, and the \
features, importance and weight of its point MDP. A failed task has one row, with its reason. The same \
records give the same bytes. `--format packed` writes the run itself in one small file, as it is published: \
a folder with this file alone is read and continued like any other.

Examples:
  tsc-family export results/slc
  tsc-family export results/slc --format packed --out slc.jsonl.xz")]
pub struct ExportArgs {
    /// Results directory that `run` wrote
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// File to write, replacing an earlier export [default: DIR/records.parquet or DIR/run.jsonl.xz]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Format of the file
    #[arg(long, value_enum, default_value_t = Format::Parquet)]
    pub format: Format,
    /// Print a line of JSON instead of text
    #[arg(long)]
    pub json: bool,
}

pub(super) fn run(args: &ExportArgs) -> anyhow::Result<u8> {
    let layout = Layout::new(&args.dir);
    let own = || match args.format {
        Format::Packed => layout.packed(),
        Format::Parquet => layout.root().join("records.parquet"),
    };
    let path = args.out.clone().unwrap_or_else(own);
    check_file(&path, "--out", &[b"PAR1", b"\xfd7zXZ"], "export of records")?;
    let (rows, done, tasks) = export(&layout, &path, args.format)?;
    if args.json {
        line(json!({"event": "export", "path": path, "rows": rows, "done": done, "tasks": tasks}))?;
        return Ok(exit::DONE);
    }
    if done < tasks {
        note(format!("{done} of {tasks} tasks have a record; the others have no row"));
    }
    line(format!("{}: {rows} episodes of {done} tasks", path.display()))?;
    Ok(exit::DONE)
}

//! `tsc-family export`.

use std::path::PathBuf;

use serde_json::json;

use super::folder::check_file;
use super::output::{line, note};
use crate::cli::exit;
use crate::store::Layout;
use crate::store::packed::pack;
use crate::store::results::Results;

/// `tsc-family export`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Writes the run itself in one small file, without episodes of training: a folder with this file alone is read and \
continued like any other. The same records give the same bytes. `report` writes all episodes to episodes.csv.

Example:
  tsc-family export results/slc")]
pub struct ExportArgs {
    /// Results directory that `run` wrote
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// File to write, replacing an earlier one [default: DIR/run.jsonl.xz]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Print a line of JSON instead of text
    #[arg(long)]
    pub json: bool,
}

pub(super) fn run(args: &ExportArgs) -> anyhow::Result<u8> {
    let layout = Layout::new(&args.dir);
    let path = args.out.clone().unwrap_or_else(|| layout.packed());
    check_file(&path, "--out", &[b"\xfd7zXZ"], "packed run")?;
    let results = Results::load_all(&layout)?;
    let (done, tasks) = (results.done().count(), results.plan().len());
    let rows = pack(&layout, &results.manifest, results.done().map(|row| row.1), &path)?;
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

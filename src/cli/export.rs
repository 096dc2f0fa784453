//! `tsc-family export`.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::folder::check_file;
use super::output::{line, note};
use crate::cli::exit;
use crate::export::{Exported, Format, export};
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
  tsc-family export results/slc --out slc.parquet
  tsc-family export results/slc --out slc.csv")]
pub struct ExportArgs {
    /// Results directory that `run` wrote
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// File to write, replacing an earlier export [default: DIR/records.parquet, DIR/records.csv or DIR/run.jsonl.xz]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Format of the file [default: csv if FILE ends in .csv, else parquet]
    #[arg(long, value_enum)]
    pub format: Option<Format>,
    /// Print a line of JSON instead of text
    #[arg(long)]
    pub json: bool,
}

pub(super) fn run(args: &ExportArgs) -> anyhow::Result<u8> {
    let layout = Layout::new(&args.dir);
    let format = args.format.unwrap_or_else(|| by_name(args.out.as_deref()));
    let own = || match format {
        Format::Packed => layout.packed(),
        _ => layout.root().join(format!("records.{}", format.extension())),
    };
    let path = args.out.clone().unwrap_or_else(own);
    check_file(&path, "--out", &[b"PAR1", b"task,", b"\xfd7zXZ"], "export of records")?;
    let Exported { rows, tasks: (done, tasks) } = export(&layout, &path, format)?;
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

/// Returns what a file of this name is expected to be.
fn by_name(path: Option<&Path>) -> Format {
    let extension = path.and_then(|path| path.extension()).and_then(|e| e.to_str());
    match extension.is_some_and(|e| e.eq_ignore_ascii_case(Format::Csv.extension())) {
        true => Format::Csv,
        false => Format::Parquet,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_what_its_name_says() {
        for (name, expected) in [
            (Some("a/slc.csv"), Format::Csv),
            (Some("SLC.CSV"), Format::Csv),
            (Some("slc.parquet"), Format::Parquet),
            (Some("csv"), Format::Parquet),
            (None, Format::Parquet),
        ] {
            assert_eq!(by_name(name.map(Path::new)), expected, "{name:?}");
        }
    }
}

//! `tsc-family across`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::folder::check_file;
use super::json::method_line;
use super::output::{line, note};
use crate::analysis::Analysis;
use crate::analysis::across::{Family, Scale, Weighing, across};
use crate::cli::exit;
use crate::cli::refused::Refused;
use crate::domains;
use crate::files::write_atomically;
use crate::report::across::{table, text};
use crate::store::Layout;
use crate::store::results::Results;

/// `tsc-family across`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Evaluates every combination; 10 million take less than a second. Needs no SUMO.

Examples:
  tsc-family across results/resco results/field
  tsc-family across results/slc results/poles --scale range --by importance
  tsc-family across results/carl results/physical \\
    --reported l0.5-c1-p0.1-f50-g9.8 --reported l0.5-c1-p0.1-f50-g9.8")]
pub struct AcrossArgs {
    /// Results directories that `run` wrote, one per family
    #[arg(value_name = "RESULTS", required = true)]
    pub results: Vec<PathBuf>,
    /// Methods to compare [default: all that every family has, except baselines]
    #[arg(id = "compared", long = "methods", value_name = "METHODS", value_delimiter = ',')]
    pub methods: Option<Vec<String>>,
    /// How scores of different families are made comparable
    #[arg(long, value_name = "SCALE", default_value = "score")]
    pub scale: Scale,
    /// Weight of a combination
    #[arg(long, value_name = "WEIGHT", default_value = "equal")]
    pub by: Weighing,
    /// Point MDP that is usually reported; give one per family, in their order
    #[arg(long, value_name = "POINT")]
    pub reported: Vec<String>,
    /// Write the table to a file too
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Print JSON lines instead of the table: one per method
    #[arg(long)]
    pub json: bool,
}

pub(super) fn run(args: &AcrossArgs) -> anyhow::Result<u8> {
    if let Some(path) = &args.csv {
        check_file(path, "--csv", &[b"method,score,mean_rank"], "table of ranks")?;
    }
    if let Some(path) = &args.csv {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            let (path, folder) = (path.display(), folder.display());
            anyhow::bail!(Refused(format!(
                "--csv {path}: there is no folder {folder}; make it first"
            )));
        }
    }
    let mut seen: BTreeMap<String, String> = BTreeMap::new();
    let mut read: Vec<(String, Analysis)> = Vec::new();
    for path in &args.results {
        let name = path.display().to_string();
        let layout = Layout::new(path);
        let results = Results::load(&layout)?;
        if let Some(first) = seen.insert(results.sha256.clone(), name.clone()) {
            anyhow::bail!(Refused(format!(
                "{first} and {name} hold the same run; give every family once"
            )));
        }
        read.push((name, domains::analysis(&layout, &results)?));
    }
    let families: Vec<Family<'_>> =
        read.iter().map(|(name, analysis)| Family { name: name.clone(), analysis }).collect();
    let methods = args.methods.as_deref();
    let data = across(&families, methods, &args.reported, (args.scale, args.by))?;
    if args.json {
        table(&data).json().into_iter().map(method_line).try_for_each(line)?;
    } else {
        line(text(&data))?;
    }
    if let Some(path) = &args.csv {
        write_atomically(path, table(&data).csv().as_bytes())?;
        note(format!("table: {}", path.display()));
    }
    data.notes.into_iter().for_each(note);
    Ok(exit::DONE)
}

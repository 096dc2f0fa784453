//! `tsc-family across`.

use std::path::PathBuf;

use super::folder::check_file;
use super::output::{events, line, note};
use crate::analysis::Analysis;
use crate::analysis::across::{Scale, across};
use crate::cli::exit::{self, refuse};
use crate::domains;
use crate::files::write_atomically;
use crate::report::across::{table, text};
use crate::store::Layout;
use crate::store::results::Results;

/// `tsc-family across`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Evaluates every combination; 10 million take a few seconds. Needs no SUMO.

Examples:
  tsc-family across results/resco results/field
  tsc-family across results/slc results/poles --scale range --csv across.csv")]
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
    let mut seen: Vec<String> = Vec::new();
    let mut families: Vec<(String, Analysis)> = Vec::new();
    for path in &args.results {
        let layout = Layout::new(path);
        let results = Results::load(&layout)?;
        if seen.contains(&results.sha256) {
            let path = path.display();
            return refuse(format!("{path} holds a run twice; give every family once"));
        }
        seen.push(results.sha256.clone());
        families.push((path.display().to_string(), domains::analysis(&layout, &results)?));
    }
    let data = across(&families, args.methods.as_deref(), args.scale)?;
    if args.json {
        events("method", table(&data).json())?;
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

//! `tsc-family sensitivity`.

use std::path::PathBuf;

use super::folder::{SENSITIVITY, Target};
use super::output::{events, line, note};
use super::values::number;
use crate::analysis::sensitivity::{Question, Sensitivity};
use crate::cli::exit;
use crate::domains;
use crate::files::{make_folder, write_atomically};
use crate::store::Layout;
use crate::store::results::Results;

/// `tsc-family sensitivity`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Reads the records only; needs no SUMO. Writes RESULTS/sensitivity/distributions.csv.

Examples:
  tsc-family sensitivity results/slc
  tsc-family sensitivity results/poles --weigh-by gravity_mps2 --concentration 0.05")]
pub struct SensitivityArgs {
    /// Results directory that `run` wrote
    #[arg(value_name = "RESULTS")]
    pub results: PathBuf,
    /// Methods to compare [default: all with results, except the baseline]
    #[arg(id = "compared", long = "methods", value_name = "METHODS", value_delimiter = ',')]
    pub methods: Option<Vec<String>>,
    /// Feature by which importance is multiplied (repeatable) [default: for signals the inflow]
    #[arg(long, value_name = "FEATURE")]
    pub weigh_by: Vec<String>,
    /// Concentration of random importance: with 1 all distributions are equally likely; smaller values make few
    /// point MDPs count
    #[arg(long, value_name = "NUMBER", default_value = "1", value_parser = number(0.001, 1000.0))]
    pub concentration: f64,
    /// Seed of random importance
    #[arg(long, value_name = "NUMBER", default_value = "0")]
    pub seed: u64,
    /// Point MDP that is usually reported for the family (repeatable)
    #[arg(long, value_name = "POINT")]
    pub reported: Vec<String>,
    /// Folder to write to [default: RESULTS/sensitivity]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print JSON lines instead of the tables
    #[arg(long)]
    pub json: bool,
}

pub(super) fn run(args: &SensitivityArgs) -> anyhow::Result<u8> {
    let layout = Layout::new(&args.results);
    let target = Target::new(layout.root(), layout.root().join("sensitivity"), args.out.as_ref());
    target.check(&SENSITIVITY)?;
    let results = Results::load(&layout)?;
    let identity = &results.manifest.identity;
    let domain = domains::domains().into_iter().find(|d| d.name() == identity.domain);
    let has_feature = |name: &&str| identity.features.iter().any(|f| f.name == *name);
    let volume = domain.and_then(|d| d.volume()).filter(has_feature).map(str::to_owned);
    let weigh_by = match args.weigh_by.as_slice() {
        [] => volume.into_iter().collect(),
        named => named.to_vec(),
    };
    let question = Question {
        methods: args.methods.clone(),
        weigh_by,
        concentration: args.concentration,
        seed: args.seed,
        reported: args.reported.clone(),
    };
    let data = Sensitivity::new(&domains::analysis(&layout, &results)?, &question)?;
    make_folder(&target.folder)?;
    let path = target.folder.join("distributions.csv");
    write_atomically(&path, data.rows().csv().as_bytes())?;
    if args.json {
        events("distribution", data.rows().json())?;
    } else {
        line(data.text())?;
    }
    data.board.notes.into_iter().for_each(note);
    note(format!("table: {}", path.display()));
    Ok(exit::DONE)
}

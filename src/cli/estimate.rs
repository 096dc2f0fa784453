//! `tsc-family estimate`: what estimators miss at which budget, on a family that was evaluated as a whole.

use std::num::{NonZeroU32, NonZeroUsize};
use std::path::{Path, PathBuf};

use super::folder::{ESTIMATE, Target};
use super::output::{Progress, events, line, note};
use super::values::{MOST_REPEATS, from_one_to};
use crate::analysis::Analysis;
use crate::cli::exit::{self, refuse};
use crate::files::{make_folder, write_atomically};
use crate::report::study::{errors, text};
use crate::store::results::Results;
use crate::store::{Layout, assisting};
use crate::study::{Kind, Recorded, StudyPlan, study};
use crate::{domains, published};
use clap::ValueEnum;
use serde_json::Value;

/// Budgets where nothing else is asked for, as far as the family has so many point MDPs.
const BUDGETS: [usize; 4] = [10, 20, 40, 80];

/// Resamples of the interval of every sample; the ends need not be as exact as in a report.
const RESAMPLES: usize = 400;

/// `tsc-family estimate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Needs no SUMO. DIR must hold results of the whole family (--budget all). Writes DIR/estimate/errors.csv.

Examples:
  tsc-family estimate results/all
  tsc-family estimate results/all --budgets 10,20,40,80
  tsc-family estimate results/learners --assist results/all --budgets 20,40 --repeats 200")]
pub struct EstimateArgs {
    /// Results directory in which the whole family was evaluated
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Results of the same family for methods that do not learn, for bq [default: published scores that
    /// come with the program where the settings are theirs, else DIR]
    #[arg(long, value_name = "DIR")]
    pub assist: Option<PathBuf>,
    /// Sizes of samples [default: 10,20,40,80, if the family is larger]
    #[arg(long, value_name = "N,...", value_delimiter = ',')]
    pub budgets: Vec<NonZeroUsize>,
    /// Samples per budget and estimator
    #[arg(long, value_name = "R", default_value = "500", value_parser = from_one_to::<MOST_REPEATS>)]
    pub repeats: NonZeroU32,
    /// Estimators
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_enum, default_values_t = Kind::value_variants().iter().copied())]
    pub estimators: Vec<Kind>,
    /// Seed of the samples
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Folder to write to [default: DIR/estimate]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print JSON lines instead of the table: one per estimator, budget and method
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors
    #[arg(long, short, conflicts_with = "json")]
    pub quiet: bool,
}

pub(super) fn run(args: &EstimateArgs) -> anyhow::Result<u8> {
    let target = Target::new(&args.dir, args.dir.join("estimate"), args.out.as_ref());
    target.check(&ESTIMATE)?;
    let (mut recorded, analysis) = read(&args.dir)?;
    let settings = &analysis.manifest.identity.settings;
    let mut kinds = args.estimators.clone();
    kinds.sort_unstable();
    kinds.dedup();
    if let Some(dir) = &args.assist {
        if !kinds.contains(&Kind::Bq) {
            return refuse("--assist has no effect without bq among --estimators; leave it out");
        }
        let (other, known) = read(dir)?;
        let [dir, own] = [dir, &args.dir].map(|dir| dir.display().to_string());
        if !args.quiet {
            warn_of_settings(&dir, &settings_of(&other, &known), settings);
        }
        recorded.assisted_by(&other, &dir, &own)?;
    } else if let Ok((known, _)) = published::inputs(&recorded.family, settings) {
        recorded.inputs = known;
    }
    let size = recorded.family.points.len();
    let budgets = budgets(&args.budgets, size)?;
    let plan = StudyPlan {
        repeats: args.repeats.get() as usize,
        seed: args.seed,
        resamples: RESAMPLES,
        budgets,
        kinds,
    };
    let total = plan.kinds.len() * plan.budgets.len() * plan.repeats;
    let progress = Progress::new(total as u64, Some("samples"), args.quiet || args.json);
    let cells = study(&recorded, &plan, &|n| progress.add(n, ""));
    progress.finish();
    let cells = cells?;
    make_folder(&target.folder)?;
    let path = target.folder.join("errors.csv");
    write_atomically(&path, errors(&cells).csv().as_bytes())?;
    if args.json {
        events("estimate", errors(&cells).json())?;
        return Ok(exit::DONE);
    }
    if !args.quiet {
        line(text(&recorded, &plan, &cells))?;
        for (method, lacks) in &recorded.lacking {
            note(format!("{method} is left out: it has no score on {lacks} of the point MDPs"));
        }
        note(format!("table: {}", path.display()));
    }
    Ok(exit::DONE)
}

fn budgets(asked: &[NonZeroUsize], size: usize) -> anyhow::Result<Vec<usize>> {
    let mut budgets: Vec<usize> = match asked {
        [] => BUDGETS.into_iter().filter(|b| *b < size).collect(),
        asked => asked.iter().map(|b| b.get()).collect(),
    };
    budgets.sort_unstable();
    budgets.dedup();
    if budgets.is_empty() {
        budgets = (1..=size).collect();
    }
    if let Some(above) = budgets.iter().find(|b| **b > size) {
        return refuse(format!(
            "--budgets {above}: the family has {size} point MDPs; give budgets from 1 to {size}"
        ));
    }
    Ok(budgets)
}

/// Reads results on a whole family.
pub(super) fn read(dir: &Path) -> anyhow::Result<(Recorded, Analysis)> {
    let layout = Layout::new(dir);
    let results = Results::load(&layout)?;
    let analysis = domains::analysis(&layout, &results)?;
    Ok((Recorded::of(&analysis, &dir.display().to_string())?, analysis))
}

/// Returns what is kept of the settings of results that assist.
pub(super) fn settings_of(known: &Recorded, analysis: &Analysis) -> Value {
    let domains = domains::domains();
    let names: Vec<&str> = domains.iter().flat_map(|d| d.methods()).map(|m| m.name).collect();
    let inputs: Vec<&str> = known.inputs.iter().map(|(input, _)| input.method.as_str()).collect();
    assisting::kept(&analysis.manifest.identity.settings, &names, &inputs)
}

/// Warns where results that assist were computed with other settings than what they assist.
pub(super) fn warn_of_settings(subject: &str, there: &Value, here: &Value) {
    if let Some(named) = assisting::differences(there, here) {
        note(format!(
            "warning: {subject} was computed with other settings ({named}): it helps less than results with the same \
             settings would"
        ));
    }
}

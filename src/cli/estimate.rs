//! `tsc-family estimate`: what estimators miss at which budget, on a family that was evaluated as a whole.

use std::num::{NonZeroU32, NonZeroUsize};
use std::path::PathBuf;

use serde_json::Value;

use super::folder::ESTIMATE;
use super::output::{Counted, line, note};
use super::recorded::{read, settings_of, warn_of_settings};
use super::target::Target;
use super::values::{MOST_REPEATS, from_one_to, parse_seed};
use crate::cli::exit;
use crate::cli::refused::Refused;
use crate::report::study::StudyReport;
use crate::study::{Kind, StudyPlan, study};

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
    /// Results of the same family for methods that do not learn, for bq [default: DIR]
    #[arg(long, value_name = "DIR")]
    pub assist: Option<PathBuf>,
    /// Methods whose scores bq knows on all point MDPs [default: all that do not learn]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub inputs: Vec<String>,
    /// Sizes of samples [default: 10,20,40,80, if the family is larger]
    #[arg(long, value_name = "N,...", value_delimiter = ',')]
    pub budgets: Vec<NonZeroUsize>,
    /// Samples per budget and estimator
    #[arg(long, value_name = "R", default_value = "500", value_parser = from_one_to::<MOST_REPEATS>)]
    pub repeats: NonZeroU32,
    /// Estimators
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_enum, default_values_t = Kind::ALL)]
    pub estimators: Vec<Kind>,
    /// Seed of the samples
    #[arg(long, default_value_t = 0, value_parser = parse_seed)]
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
    let kinds = kinds(&args.estimators);
    if let Some(dir) = &args.assist {
        if !kinds.iter().any(|k| k.is_assisted()) {
            let reason = "--assist has no effect without bq among --estimators; leave it out";
            return Err(Refused(reason.to_owned()).into());
        }
        let (other, known) = read(dir)?;
        if !args.quiet {
            let (there, here) = (settings_of(&other, &known), &analysis.manifest.identity.settings);
            warn_of_settings(&dir.display().to_string(), &there, here);
        }
        recorded.assisted_by(
            &other,
            &dir.display().to_string(),
            &args.dir.display().to_string(),
        )?;
    }
    if !args.inputs.is_empty() {
        if !kinds.iter().any(|k| k.is_assisted()) {
            let reason = "--inputs has no effect without bq among --estimators; leave it out";
            return Err(Refused(reason.to_owned()).into());
        }
        recorded.keep_inputs(&args.inputs, &args.dir.display().to_string())?;
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
    let progress = Counted::new(total, "samples", args.quiet || args.json);
    let cells = study(&recorded, &plan, &|n| progress.add(n, ""));
    progress.finish();
    let cells = cells?;
    let report = StudyReport { recorded: &recorded, plan: &plan, cells: &cells };
    let written = report.write(&target.folder)?;
    if args.json {
        for mut row in report.errors().json() {
            row.insert("event".to_owned(), "estimate".into());
            line(Value::Object(row))?;
        }
        return Ok(exit::DONE);
    }
    if !args.quiet {
        line(report.table())?;
        report.notes().into_iter().for_each(note);
        note(format!("table: {}", written.display()));
    }
    Ok(exit::DONE)
}

/// Returns the estimators in order, each once.
fn kinds(asked: &[Kind]) -> Vec<Kind> {
    let mut kinds = asked.to_vec();
    kinds.sort_unstable();
    kinds.dedup();
    kinds
}

fn budgets(asked: &[NonZeroUsize], size: usize) -> Result<Vec<usize>, Refused> {
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
        return Err(Refused(format!(
            "--budgets {above}: the family has {size} point MDPs; give budgets from 1 to {size}"
        )));
    }
    Ok(budgets)
}

//! `tsc-family sensitivity`.

use std::collections::BTreeSet;
use std::num::{NonZeroU32, NonZeroUsize};
use std::path::PathBuf;

use super::estimate::{budgets, kinds};
use super::folder::SENSITIVITY;
use super::output::{Counted, line, note};
use super::target::Target;
use super::values::{MOST_REPEATS, from_one_to, parse_seed};
use crate::analysis::Analysis;
use crate::analysis::sensitivity::{Question, Sensitivity};
use crate::cli::exit;
use crate::cli::refused::Refused;
use crate::domains;
use crate::files::quoted;
use crate::report::sensitivity::{SensitivityReport, folder};
use crate::stats::Limit;
use crate::store::Layout;
use crate::store::results::Results;
use crate::study::{Case, CaseStudy, Kind, Recorded, StudyPlan, study_cases};

/// Concentrations beyond which random distributions are no longer told apart from a single point MDP, or from equal
/// weights.
const CONCENTRATIONS: (f64, f64) = (0.001, 1000.0);

/// Largest factor for the importance of failures; beyond it nothing else counts.
const MOST_ODDS: f64 = 1e6;

/// `tsc-family sensitivity`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Reads the records only; needs no SUMO. Writes RESULTS/sensitivity/index.html, a figure as SVG, and \
distributions.csv, weights.csv, ranks.csv, failures.csv, reported.csv, cases.csv.

Examples:
  tsc-family sensitivity results/slc
  tsc-family sensitivity results/slc --reported-results results/ingolstadt1
  tsc-family sensitivity results/poles --weigh-by gravity_mps2 --concentration 0.05")]
pub struct SensitivityArgs {
    /// Results directory that `run` wrote
    #[arg(value_name = "RESULTS")]
    pub results: PathBuf,
    /// Methods to compare [default: all with results, except the baseline]
    #[arg(id = "compared", long = "methods", value_name = "METHODS", value_delimiter = ',')]
    pub methods: Option<Vec<String>>,
    /// Definition of a failure, in quotes: 'METRIC>VALUE' or 'METRIC<VALUE' [default: that of the task, for signals
    /// a mean wait above 20 s]
    #[arg(long, value_name = "LIMIT")]
    pub failure: Option<Limit>,
    /// Feature by which importance is multiplied (repeatable) [default: for signals the inflow]
    #[arg(long, value_name = "FEATURE")]
    pub weigh_by: Vec<String>,
    /// Concentration of random importance: with 1 all distributions are equally likely; smaller values make few
    /// point MDPs count
    #[arg(long, value_name = "NUMBER", default_value = "1", value_parser = parse_concentration)]
    pub concentration: f64,
    /// Seed of random importance
    #[arg(long, value_name = "NUMBER", default_value = "0", value_parser = parse_seed)]
    pub seed: u64,
    /// Point MDP that is usually reported for the family (repeatable)
    #[arg(long, value_name = "POINT")]
    pub reported: Vec<String>,
    /// Results on the scenario that is usually reported (repeatable)
    #[arg(long, value_name = "DIR")]
    pub reported_results: Vec<PathBuf>,
    /// Test estimators in the paper's cases 1 to 3 too: failures rare, failures frequent, random importance
    #[arg(long)]
    pub cases: bool,
    /// Sizes of samples for the cases [default: 10,20,40,80, if the family is larger]
    #[arg(long, value_name = "N,...", value_delimiter = ',', requires = "cases")]
    pub budgets: Vec<NonZeroUsize>,
    /// Samples per case, budget and estimator
    #[arg(long, value_name = "R", default_value = "100", value_parser = from_one_to::<MOST_REPEATS>, requires = "cases")]
    pub repeats: NonZeroU32,
    /// Estimators for the cases
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_enum, requires = "cases",
          default_values_t = [Kind::M1, Kind::M2, Kind::M3, Kind::Balanced])]
    pub estimators: Vec<Kind>,
    /// Factor that divides the importance of failures in case 1 and multiplies it in case 2
    #[arg(long, value_name = "FACTOR", default_value = "10", value_parser = parse_odds, requires = "cases")]
    pub failure_odds: f64,
    /// Folder to write to [default: RESULTS/sensitivity]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print JSON lines instead of the tables
    #[arg(long)]
    pub json: bool,
}

fn parse_concentration(text: &str) -> Result<f64, String> {
    let (least, most) = CONCENTRATIONS;
    let number: Option<f64> = text.parse().ok();
    let number = number.filter(|number| (least..=most).contains(number));
    number.ok_or_else(|| format!("expected a number from {least} to {most}"))
}

fn parse_odds(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.parse().ok();
    let number = number.filter(|number| *number > 1.0 && *number <= MOST_ODDS);
    number.ok_or_else(|| format!("expected a number above 1, up to {MOST_ODDS}"))
}

pub(super) fn run(args: &SensitivityArgs) -> anyhow::Result<u8> {
    let layout = Layout::new(&args.results);
    let target = Target::new(layout.root(), folder(&layout), args.out.as_ref());
    target.check(&SENSITIVITY)?;
    let results = Results::load(&layout)?;
    let report = domains::report(&layout, &results)?;
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
        failure: args.failure.clone().or_else(|| domain?.failure()),
        weigh_by,
        concentration: args.concentration,
        seed: args.seed,
        reported: args.reported.clone(),
    };
    let mut elsewhere = Vec::new();
    for path in &args.reported_results {
        let layout = Layout::new(path);
        let results = Results::load(&layout)?;
        elsewhere.push((path.display().to_string(), domains::analysis(&layout, &results)?));
    }
    let data = Sensitivity::new(&report, &question, &elsewhere)?;
    let cases = match args.cases {
        true => cases(args, &report, &data)?,
        false => Vec::new(),
    };
    let command = command(args);
    let shown = SensitivityReport { data: &data, report: &report, cases: &cases, command };
    let page = shown.write(&target.folder)?;
    if args.json {
        shown.json().into_iter().try_for_each(line)?;
    } else {
        line(shown.text())?;
    }
    shown.notes().into_iter().for_each(note);
    note(format!("page: {}", page.display()));
    Ok(exit::DONE)
}

/// Studies estimators in the paper's cases.
fn cases(
    args: &SensitivityArgs,
    analysis: &Analysis,
    data: &Sensitivity,
) -> anyhow::Result<Vec<CaseStudy>> {
    let mut recorded = Recorded::of(analysis, &args.results.display().to_string())?;
    recorded.methods.retain(|m| data.board.methods.contains(&m.name));
    if recorded.methods.is_empty() {
        anyhow::bail!(Refused(format!(
            "--cases: none of {} has a score on every point MDP; finish the run, or leave --cases out",
            data.board.methods.join(", ")
        )));
    }
    let points = &recorded.family.points;
    let failed: BTreeSet<&str> = data
        .failures
        .iter()
        .flat_map(|f| &f.by_half)
        .map(|p| data.board.points[*p].id.as_str())
        .collect();
    let fails: Vec<bool> = points.iter().map(|p| failed.contains(p.id.as_str())).collect();
    if !(fails.contains(&true) && fails.contains(&false)) {
        let all = if fails.contains(&true) { "every point MDP" } else { "no point MDP" };
        note(format!(
            "{all} is a failure of at least half of the methods: cases 1 and 2 are left out"
        ));
    }
    let plan = StudyPlan {
        budgets: budgets(&args.budgets, points.len())?,
        repeats: args.repeats.get() as usize,
        kinds: kinds(&args.estimators),
        seed: args.seed,
        resamples: 0,
    };
    let total = Case::ALL.len() * plan.kinds.len() * plan.budgets.len() * plan.repeats;
    let progress = Counted::new(total, "samples", args.json);
    let cases = study_cases(&recorded, &fails, args.failure_odds, &plan, &|n| progress.add(n, ""));
    progress.finish();
    Ok(cases?)
}

/// Returns the command that makes the same page; what has its default is left out.
fn command(args: &SensitivityArgs) -> String {
    let mut words = vec!["tsc-family sensitivity".to_owned(), quoted(&args.results)];
    let mut add =
        |flag: &str, value: String| words.push(format!("{flag} {value}").trim_end().to_owned());
    if let Some(methods) = &args.methods {
        add("--methods", methods.join(","));
    }
    if let Some(limit) = &args.failure {
        add("--failure", format!("'{limit}'"));
    }
    args.weigh_by.iter().for_each(|feature| add("--weigh-by", feature.clone()));
    if args.concentration != 1.0 {
        add("--concentration", args.concentration.to_string());
    }
    if args.seed != 0 {
        add("--seed", args.seed.to_string());
    }
    if args.cases {
        let budgets: Vec<String> = args.budgets.iter().map(ToString::to_string).collect();
        if !budgets.is_empty() {
            add("--budgets", budgets.join(","));
        }
        let kinds: Vec<&str> = args.estimators.iter().map(|kind| kind.name()).collect();
        add("--estimators", kinds.join(","));
        add("--repeats", args.repeats.to_string());
        add("--failure-odds", args.failure_odds.to_string());
        add("--cases", String::new());
    }
    args.reported.iter().for_each(|point| add("--reported", quoted(point.as_ref())));
    args.reported_results.iter().for_each(|path| add("--reported-results", quoted(path)));
    words.join(" ")
}

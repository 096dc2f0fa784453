//! `tsc-family plan`: which point MDPs to train on, what to expect of them, and how long that takes.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::thread::available_parallelism;

use super::folder::check_file;
use super::forecast::{Forecast, Job, range};
use super::output::{line, note};
use super::recorded::{design, read, settings_of, warn_of_settings};
use super::scenario::ScenarioArg;
use super::subject::Subject;
use super::values::{at_least_one_worker, parse_seed};
use crate::cli::exit;
use crate::cli::refused::Refused;
use crate::cli::values::assisted;
use crate::family::MdpFamily;
use crate::files::{quoted, write_atomically};
use crate::run::effort::Efforts;
use crate::run::plan::{Request, draft};
use crate::sample::plan_file::{Expected, PlanFile};
use crate::sample::{Choice, Design, SamplePlan, Sampling};
use crate::study::{Kind, Recorded, StudyPlan, study};

/// Samples from which errors are expected.
const REPEATS: usize = 60;

/// Resamples of the interval of each.
const RESAMPLES: usize = 200;

/// `tsc-family plan`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Writes a file for `run --plan`. With --assist, the choice and the estimates also use the scores of methods \
that do not learn: Bayesian quadrature by default, M4 with --sampling balanced. The expected error is that \
of samples of these methods.

Examples:
  tsc-family plan --budget 40 --assist results/all --out plan.json
  tsc-family plan --half-width 0.05 --assist results/all --out plan.json
  tsc-family plan --hours 2 --methods idqn,mplight --out plan.json
  tsc-family run --plan plan.json --methods idqn,mplight --out results/learners")]
#[command(group(clap::ArgGroup::new("size").required(true).args(["budget", "half_width", "hours"])))]
pub struct PlanArgs {
    /// The scenario
    #[command(flatten)]
    pub scenario: ScenarioArg,
    /// Number of point MDPs
    #[arg(long, value_name = "N")]
    pub budget: Option<NonZeroUsize>,
    /// Choose the smallest sample whose 95% intervals have this half-width, for the median of the known methods
    #[arg(long, value_name = "SCORE", requires = "assist")]
    pub half_width: Option<f64>,
    /// Choose as many point MDPs as can be done in this number of hours
    #[arg(long, value_name = "H")]
    pub hours: Option<f64>,
    /// Results of the whole family for methods that do not learn
    #[arg(long, value_name = "DIR")]
    pub assist: Option<PathBuf>,
    /// How the point MDPs are chosen [default: balanced; with --assist bayesian-quadrature]
    #[arg(long, value_enum)]
    pub sampling: Option<Sampling>,
    /// Methods that will run, separated by commas; the time depends on them
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub methods: Vec<String>,
    /// Worker processes at the same time [default: one per processor]
    #[arg(long, short, value_name = "J", value_parser = at_least_one_worker)]
    pub jobs: Option<NonZeroUsize>,
    /// Seed of the sample
    #[arg(long, default_value_t = 0, value_parser = parse_seed)]
    pub seed: u64,
    /// File to write
    #[arg(long, value_name = "FILE", default_value = "plan.json")]
    pub out: PathBuf,
}

pub(super) fn run(args: &PlanArgs) -> anyhow::Result<u8> {
    check_file(&args.out, "--out", &[b"{\n  \"tsc_family_plan\""], "plan of a sample")?;
    for (flag, value) in [("--half-width", args.half_width), ("--hours", args.hours)] {
        if value.is_some_and(|v| !v.is_finite() || v <= 0.0) {
            return Err(Refused(format!("{flag} must be a number above 0")).into());
        }
    }
    if args.hours.is_some() && args.methods.is_empty() {
        let reason = "--hours needs --methods: how long a point MDP takes depends on them";
        return Err(Refused(reason.to_owned()).into());
    }
    let subject = Subject::plain(&args.scenario)?;
    let known = args.assist.as_ref().map(|dir| -> anyhow::Result<_> {
        let (known, analysis) = read(dir)?;
        let there = settings_of(&known, &analysis);
        warn_of_settings(&dir.display().to_string(), &there, &subject.problem().settings());
        Ok((known, there))
    });
    let (known, assisting) = known.transpose()?.unzip();
    let family = subject.problem().family();
    let sampling = match args.assist {
        Some(_) => assisted(args.sampling, family.points.len())?,
        None => args.sampling.unwrap_or(Sampling::DEFAULT),
    };
    let design = design(family, sampling, known.as_ref().zip(args.assist.as_deref()))?;
    let maker = Maker { args, subject: &subject, family, design, sampling };
    let budget = maker.budget(known.as_ref())?;
    let (sample, design) = maker.sample(budget)?;
    let mut plan = PlanFile { assisting, ..PlanFile::new(&family.name, sample, design) };
    if let Some(known) = &known {
        plan.expected = maker.expected(known, budget, REPEATS)?;
    }
    write_atomically(&args.out, &plan.to_json())?;
    line(maker.described(&plan)?)?;
    note(format!("plan: {}", args.out.display()));
    note(format!(
        "run it: tsc-family run {} --plan {} --methods {}",
        args.scenario.said(),
        quoted(&args.out),
        if args.methods.is_empty() { "...".to_owned() } else { args.methods.join(",") }
    ));
    Ok(exit::DONE)
}

/// What plans are made of.
struct Maker<'a> {
    args: &'a PlanArgs,
    subject: &'a Subject,
    family: &'a MdpFamily,
    design: Design,
    sampling: Sampling,
}

impl Maker<'_> {
    fn sample(&self, budget: usize) -> anyhow::Result<(SamplePlan, Option<Design>)> {
        let (sampling, design) = (self.sampling, Some(self.design.clone()));
        let choice = Choice::Budget { budget, sampling, design, assisting: None };
        Ok(choice.sample(self.family, self.args.seed)?)
    }

    /// Returns the number of point MDPs that is asked for, one way or another.
    fn budget(&self, known: Option<&Recorded>) -> anyhow::Result<usize> {
        let size = self.family.points.len();
        if let Some(budget) = self.args.budget {
            return Ok(budget.get());
        }
        if let (Some(wanted), Some(known)) = (self.args.half_width, known) {
            let narrow = |n: usize| -> anyhow::Result<bool> {
                if n == size {
                    return Ok(true);
                }
                let widths = self.expected(known, n, REPEATS / 3)?;
                let mut widths: Vec<f64> = widths.iter().filter_map(|e| e.half_width).collect();
                widths.sort_by(f64::total_cmp);
                let Some(width) = widths.get(widths.len() / 2) else { return Ok(false) };
                // Each takes seconds to minutes.
                note(format!(
                    "with {n} of {size} point MDPs 95% intervals are expected to be ± {width:.3}"
                ));
                Ok(*width <= wanted)
            };
            return Ok(least(size, narrow)?.unwrap_or(size));
        }
        let hours = self.args.hours.unwrap_or_default();
        let too_long = |n: usize| -> anyhow::Result<bool> {
            Ok(self.seconds(&self.sample(n)?.0)?.is_none_or(|s| s > 3600.0 * hours))
        };
        match least(size, too_long)? {
            Some(1) => Err(Refused(format!(
                "--hours {hours}: one point MDP is expected to take longer; give more hours or fewer methods"
            ))
            .into()),
            Some(n) => Ok(n - 1),
            None => Ok(size),
        }
    }

    /// Returns what samples of this size miss on the methods that are known everywhere.
    fn expected(
        &self,
        known: &Recorded,
        budget: usize,
        repeats: usize,
    ) -> anyhow::Result<Vec<Expected>> {
        let plan = StudyPlan {
            budgets: vec![budget],
            repeats,
            kinds: vec![match self.sampling {
                Sampling::BayesianQuadrature => Kind::Bq,
                _ => Kind::M4,
            }],
            seed: self.args.seed,
            resamples: RESAMPLES,
        };
        let cells = study(known, &plan, &|_| {})?;
        let of = |c: crate::study::Cell| Expected {
            method: c.method,
            rmse: c.error,
            half_width: c.half_width,
            coverage: c.coverage,
        };
        Ok(cells.into_iter().map(of).collect())
    }

    /// Returns the jobs of the methods on a sample.
    fn jobs(&self, sample: &SamplePlan) -> anyhow::Result<Vec<Job>> {
        let request =
            Request::new(self.subject.domain(), self.subject.problem(), &self.args.methods);
        let methods = draft(&request)?.methods;
        let cells = sample.draws.iter().flat_map(|d| methods.iter().map(move |m| (d, m)));
        let efforts = Efforts::of_request(&request)?;
        let job = |(task, (draw, method)): (usize, (&crate::sample::Draw, &String))| {
            let effort = efforts.task(method, &draw.point)?;
            let (method, point) = (method.as_str().into(), draw.point.as_str().into());
            Ok(Job { task, method, point, effort })
        };
        cells.enumerate().map(job).collect()
    }

    fn forecast(&self, sample: &SamplePlan) -> anyhow::Result<Option<Forecast>> {
        let processors = available_parallelism().map_or(1, |j| j.get());
        let workers = self.args.jobs.map_or(processors, |j| j.get());
        let jobs = self.jobs(sample)?;
        let informed = jobs.iter().any(|job| job.effort.is_informed);
        Ok(informed.then(|| Forecast::new(jobs, workers, processors)))
    }

    /// Returns how long the methods are expected to take on a sample, seconds; `None` where that is not known.
    fn seconds(&self, sample: &SamplePlan) -> anyhow::Result<Option<f64>> {
        Ok(self.forecast(sample)?.map(|f| {
            let [low, high] = f.left(0.0).map(|d| d.as_secs_f64());
            (low * high).sqrt()
        }))
    }

    /// Returns the plan in words.
    fn described(&self, plan: &PlanFile) -> anyhow::Result<String> {
        let sample = &plan.sample;
        let (n, size) = (sample.draws.len(), sample.family_size);
        let mut text = format!("{n} of {size} point MDPs of {}", plan.scenario);
        for draw in &sample.draws {
            let pi = draw.inclusion.map_or_else(String::new, |pi| format!(", probability {pi:.3}"));
            text.push_str(&format!("\n{:40} weight {:.4}{pi}", draw.point, draw.weight));
        }
        for e in &plan.expected {
            let width =
                e.half_width.map_or_else(String::new, |w| format!(", 95% interval ± {w:.3}"));
            let holds =
                e.coverage.map_or_else(String::new, |c| format!(" (holds {:.0}%)", 100.0 * c));
            text.push_str(&format!("\nas for {}: error {:.3}{width}{holds}", e.method, e.rmse));
        }
        if !plan.expected.is_empty() {
            text.push_str("\nscores of learners vary more than those of these methods, so expect larger errors");
        }
        if !self.args.methods.is_empty()
            && let Some(forecast) = self.forecast(sample)?
        {
            text.push_str(&format!(
                "\nabout {} for {}",
                range(forecast.left(0.0)),
                self.args.methods.join(", ")
            ));
        }
        Ok(text)
    }
}

/// Returns the least number from 1 to `most` for which something holds that holds for all larger ones.
fn least(
    most: usize,
    holds: impl Fn(usize) -> anyhow::Result<bool>,
) -> anyhow::Result<Option<usize>> {
    if !holds(most)? {
        return Ok(None);
    }
    let (mut low, mut high) = (0, most);
    while high - low > 1 {
        let middle = (low + high) / 2;
        if holds(middle)? { high = middle } else { low = middle }
    }
    Ok(Some(high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_number_is_found() {
        for wanted in 1..=9 {
            assert_eq!(least(9, |n| Ok(n >= wanted)).unwrap(), Some(wanted));
        }
        assert_eq!(least(9, |_| Ok(false)).unwrap(), None);
    }
}

//! `tsc-family train`: one network over several point MDPs.

use std::num::NonZeroUsize;
use std::path::Path;

use super::output::note;
use super::run::{RunArgs, out_of, run_on};
use super::subject::Subject;
use crate::cli::exit::{self, refuse, without_effect};
use crate::files::{limits, read, replace};
use crate::run::method::{Training, find};
use crate::run::together::Joint;
use crate::sample::Sampling;
use crate::store::Layout;
use crate::store::results::Results;
use crate::traffic::control::{mplight, mplight_star};

/// Methods whose network serves signals of any layout.
const SHARED: [&str; 2] = [mplight::METHOD.name, mplight_star::METHOD.name];

/// How policies are judged, unless --set says otherwise: each time on every point MDP.
const DEFAULTS: [&str; 5] = [
    "training.validation_start=40",
    "training.validation_interval=40",
    "training.validation_seeds=1",
    "training.finalists=2",
    "training.finalist_seeds=2",
];

/// `tsc-family train`.
#[derive(Debug, clap::Args)]
#[command(mut_args(|arg| { let is_other = OTHERS.contains(&arg.get_id().as_str()); arg.hide(is_other) }))]
#[command(after_help = "\
One network and one memory learn on all of them, one episode at a time. What is trained is a run of one point MDP that \
has them as its members: status, resume, report and check work as for every run.

Examples:
  tsc-family train --methods mplight --on 20 --episodes 240 --trainings 3 --out results/shared
  tsc-family run --model shared=results/shared/mplight.safetensors --methods max-pressure-resco --out results/few")]
pub struct TrainArgs {
    /// Number of point MDPs to train on
    #[arg(long, value_name = "K", default_value = "20")]
    pub on: NonZeroUsize,
    /// Number of other point MDPs on which policies are judged too
    #[arg(long, value_name = "N", default_value_t = 10)]
    pub others: usize,
    /// All else, as in `run`
    #[command(flatten)]
    pub run: RunArgs,
}

/// Options of `run` that are refused here, or go with refused ones.
const OTHERS: [&str; 8] =
    ["budget", "like", "assist", "no_assist", "until_decided", "within", "looks", "tune"];

pub(super) fn run(mut args: TrainArgs) -> anyhow::Result<u8> {
    let run = &mut args.run;
    let reason = "--on and --others say on which point MDPs";
    without_effect(&[
        ("--budget", run.budget.is_some(), reason),
        ("--like", run.like.is_some(), reason),
        ("--until-decided", run.until_decided, reason),
        ("--tune", !run.tune.is_empty(), "`run --tune` does that on each point MDP"),
    ])?;
    if run.methods.is_empty() {
        run.methods.push(mplight::METHOD.name.to_owned());
    }
    run.scenario.begin_with(DEFAULTS.map(|text| text.parse().expect("a setting")));
    let subject = Subject::new(run)?;
    for name in &run.methods {
        let method = find(subject.domain.methods(), name)?;
        if method.training != Training::None && !SHARED.contains(&method.name) {
            let shared = SHARED.join(" and ");
            return refuse(format!(
                "--methods {name}: only {shared} learn on several point MDPs; beside them may be methods without training"
            ));
        }
    }
    let settings = subject.problem.settings();
    let episodes = settings.pointer("/training/episodes").and_then(|n| n.as_u64()).unwrap_or(0);
    let sampling = run.sampling.take().unwrap_or(Sampling::DEFAULT);
    let sizes = (args.on.get(), args.others);
    let joint = Joint::new(subject.problem, sizes, sampling, run.seed, episodes as usize)?;
    let subject = Subject { problem: Box::new(joint), ..subject };
    let code = run_on(run, &subject)?;
    if code == exit::DONE && !run.dry_run {
        keep_best(&out_of(run, &subject), run.quiet)?;
    }
    Ok(code)
}

/// Copies the model of each method's best training, by its mean on the held-out seeds.
fn keep_best(out: &Path, quiet: bool) -> anyhow::Result<()> {
    let layout = Layout::new(out);
    let results = Results::load(&layout)?;
    let objective = &results.manifest.identity.objective;
    for method in SHARED {
        let done = results.done().filter(|(task, _)| task.method == method);
        let found =
            done.filter_map(|(task, record)| Some((task, record.summary.metrics.get(objective)?)));
        let Some((best, _)) = found.min_by(|a, b| a.1.total_cmp(b.1)) else { continue };
        let path = out.join(format!("{method}.safetensors"));
        replace(out, &path, &layout.tmp(), &read(&layout.model(best.task), limits::ARCHIVE)?)?;
        if !quiet {
            note(format!(
                "best training of {method}: replicate {}, in {}",
                best.replicate,
                path.display()
            ));
        }
    }
    Ok(())
}

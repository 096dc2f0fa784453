//! `tsc-family evaluate`: all models of a results directory on its point MDPs, beside what was trained there.
//!
//! It is a run over the same point MDPs and seeds, in which the models are methods that do not learn. Baseline and own training
//! are records of the directory, so only the models are simulated.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::controllers::ControllersArgs;
use super::executors::{LimitsArgs, check_prepared};
use super::folder::RESULTS;
use super::interrupt::interrupted;
use super::local_run::LocalRun;
use super::output::note;
use crate::cli::exit::refuse;
use crate::cli::method_arguments::model_name;
use crate::domains;
use crate::files::{make_folder_beneath, write_atomically};
use crate::report::transfer::{Origin, table};
use crate::run::session::{Session, open_after};
use crate::store::Layout;
use crate::store::manifest::{Identity, Manifest, Task};
use crate::store::results::Results;
use crate::traffic::domain::Traffic;
use crate::traffic::simulator;

/// `tsc-family evaluate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Every model of a results directory is evaluated on all its point MDPs: the first one's of several trainings on a point MDP. \
Point MDPs, seeds, baseline and own training are those of the run, and only its models are simulated. Hyper-parameters \
come from the models. Writes OUT/transfer/transfer.csv beside the report. `run --model` makes single models methods of a run.

Examples:
  tsc-family evaluate --from results/mplight --out results/mplight-transfer
  tsc-family evaluate --from results/mine --controller mine=mine.py:Learner --out results/mine-transfer")]
pub struct EvaluateArgs {
    /// Results directory whose models are evaluated
    #[arg(long, value_name = "DIR")]
    pub from: PathBuf,
    /// Methods whose models are taken [default: all with models]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub methods: Vec<String>,
    /// Point MDPs of whose trainings the models are taken [default: all with models]
    #[arg(long, value_name = "ID,...", value_delimiter = ',')]
    pub trained_on: Vec<String>,
    /// Class of your own that a model is of, as it was given to the run that trained it (repeatable)
    #[arg(long = "controller", value_name = "NAME=FILE.py:CLASS")]
    pub classes: Vec<String>,
    /// Folder of the networks [default: that of the run]
    #[arg(long, value_name = "DIR")]
    pub networks: Option<PathBuf>,
    /// How many workers there are, and what each may take
    #[command(flatten)]
    pub limits: LimitsArgs,
    /// Results directory, which `report`, `compare` and `check` read; the same command continues it
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Print JSON lines: one per finished task, then one per method
    #[arg(long)]
    pub json: bool,
}

impl EvaluateArgs {
    /// Returns models and classes as `run` takes them.
    pub(super) fn controllers(&self) -> anyhow::Result<ControllersArgs> {
        let layout = Layout::new(&self.from);
        let found = models(self, &layout, &Manifest::read(&layout)?.identity)?;
        let given =
            |(origin, file): &(Origin, PathBuf)| format!("{}={}", origin.name, file.display());
        let models = found.iter().map(given).collect();
        Ok(ControllersArgs { models, ..ControllersArgs::of_classes(&self.classes) })
    }
}

pub(super) fn run(args: &EvaluateArgs) -> anyhow::Result<u8> {
    let (from, out) = (args.from.as_path(), args.out.as_path());
    let layout = Layout::new(from);
    let read = Results::load(&layout)?;
    let models = models(args, &layout, &read.manifest.identity)?;
    same_measure(from, &read.manifest.identity)?;
    RESULTS.check(out, "--out", None)?;
    let place = |path: &Path| path.canonicalize().ok();
    if place(out).is_some_and(|out| place(from) == Some(out)) {
        return refuse(format!(
            "--out {} is the results directory whose models are taken; give another folder",
            out.display()
        ));
    }
    let controllers = args.controllers()?;
    let usual = || PathBuf::from(&read.manifest.provenance.networks);
    let prepared = args.networks.clone().unwrap_or_else(usual);
    check_prepared(domains::traffic(), &read.manifest, &prepared)?;
    let identity = identity(&read.manifest.identity, &models)?;
    let session = open_after(domains::traffic(), &read, identity, out, prepared)?;
    let code = simulate(args, &session, &controllers)?;
    let layout = &session.layout;
    let analysis = domains::analysis(layout, &Results::load(layout)?)?;
    let origins: Vec<Origin> = models.into_iter().map(|(origin, _)| origin).collect();
    let folder = layout.root().join("transfer");
    make_folder_beneath(layout.root(), &folder)?;
    let path = folder.join("transfer.csv");
    write_atomically(&path, table(&analysis, &origins).csv().as_bytes())?;
    note(format!("table: {}", path.display()));
    Ok(code)
}

/// Does what is missing, reports, and returns the exit code.
fn simulate(
    args: &EvaluateArgs,
    session: &Session<'_>,
    controllers: &ControllersArgs,
) -> anyhow::Result<u8> {
    let local = LocalRun {
        session,
        domain: domains::traffic(),
        launcher: controllers.launcher()?,
        limits: &args.limits,
        against: None,
        json: args.json,
        quiet: false,
    };
    let undone = local.work_on(&Results::load(&session.layout)?, interrupted()?.as_ref())?;
    undone.map_or_else(|| local.summarise(), Ok)
}

/// Returns the models that are asked for with their files, those of a method after one another.
fn models(
    args: &EvaluateArgs,
    layout: &Layout,
    identity: &Identity,
) -> anyhow::Result<Vec<(Origin, PathBuf)>> {
    let dir = layout.root().display();
    if identity.domain != Traffic::NAME {
        let domain = &identity.domain;
        return refuse(format!("{dir} is of {domain}; models of signals are evaluated elsewhere"));
    }
    if identity.sample.growth.is_some() {
        return refuse(format!(
            "{dir} is a run that stops when it is sure, which has no fixed point MDPs; repeat it with a --budget alone"
        ));
    }
    let known = |name: &str| identity.methods.iter().any(|method| method == name);
    if let Some(name) = args.methods.iter().find(|name| !known(name)) {
        let all = identity.methods.join(", ");
        return refuse(format!("--methods {name}: {dir} has no such method; it has {all}"));
    }
    let is_point = |id: &str| identity.points.iter().any(|row| row.point == id);
    if let Some(id) = args.trained_on.iter().find(|id| !is_point(id)) {
        return refuse(format!("--trained-on {id}: {dir} has no such point MDP"));
    }
    let asked = |name: &String, list: &[String]| list.is_empty() || list.contains(name);
    let tasks = identity.tasks();
    let is_wanted = |task: &&Task| {
        task.replicate == 0
            && asked(&task.method, &args.methods)
            && asked(&task.point, &args.trained_on)
            && layout.model(task.task).is_file()
    };
    let mut wanted: Vec<&Task> = tasks.iter().filter(is_wanted).collect();
    let place = |task: &Task| identity.methods.iter().position(|m| *m == task.method);
    wanted.sort_by_key(|task| (place(task), task.task));
    if wanted.is_empty() {
        return refuse(format!(
            "{dir} has no model of what is asked for: they lie in its folder models, which published results lack; run \
             a method that learns, or choose others with --methods and --trained-on"
        ));
    }
    let mut taken: Vec<String> = identity.methods.clone();
    let found = |task: &Task| {
        let name = model_name(&task.method, &task.point, task.replicate, &taken);
        taken.push(name.clone());
        let (method, point) = (task.method.clone(), task.point.clone());
        (Origin { name, method, point }, layout.model(task.task))
    };
    Ok(wanted.into_iter().map(found).collect())
}

/// Refuses a run that another simulator or version did: its baseline and own training would be of another measure.
fn same_measure(dir: &Path, identity: &Identity) -> anyhow::Result<()> {
    let here = simulator::version()?;
    let (own, there) = (env!("CARGO_PKG_VERSION"), &identity.tsc_family);
    if identity.simulator != here || there != own {
        return refuse(format!(
            "{} was measured by tsc-family {there} with {}, and this is tsc-family {own} with {here}: its baseline and own \
             training are not comparable with what would be measured now; repeat the run, or use that version",
            dir.display(),
            identity.simulator
        ));
    }
    Ok(())
}

/// Returns what the run of the models is: the point MDPs and seeds of theirs, its baseline, the methods that learned them, and
/// each model as a method.
fn identity(from: &Identity, models: &[(Origin, PathBuf)]) -> anyhow::Result<Identity> {
    let mut identity = from.clone();
    let learners: BTreeSet<&str> =
        models.iter().map(|(origin, _)| origin.method.as_str()).collect();
    identity.methods.retain(|m| *m == from.baseline || learners.contains(m.as_str()));
    identity.controllers.retain(|own| identity.methods.contains(&own.name));
    identity.replicated.retain(|m| identity.methods.contains(m));
    if identity.replicated.is_empty() {
        identity.replicates = 1;
    }
    for (Origin { name, .. }, _) in models {
        identity.methods.push(name.clone());
        identity.controllers.extend(domains::traffic().own(name)?);
    }
    Ok(identity)
}

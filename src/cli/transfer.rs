//! `tsc-family transfer`: every model of a results directory on all its point MDPs, beside what was trained there.
//!
//! It is a run over the same point MDPs and seeds. Baseline and own training are records of the directory, so only the models
//! are simulated.

use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::controllers::ControllersArgs;
use super::folder::RESULTS;
use super::local_run::LocalRun;
use super::output::{line, note};
use super::values::at_least_one_worker;
use crate::analysis::transfer::{Origin, Transfer};
use crate::cli::exit;
use crate::cli::refused::Refused;
use crate::domains;
use crate::files::quoted;
use crate::report::transfer::{text, write};
use crate::run::session::open_after;
use crate::store::Layout;
use crate::store::manifest::{Identity, Manifest, Task};
use crate::store::results::Results;
use crate::traffic::domain::Traffic;
use crate::traffic::method_arguments::model_name;
use crate::traffic::simulator;

/// Most failures that are named.
const MOST_NAMED: usize = 20;

/// `tsc-family transfer`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Point MDPs, seeds, baseline and own training are those of the run: only the models are simulated, and \
nothing is trained. Of several trainings on a point MDP the first one's model is taken. A model that does \
not fit the lanes or phases of a point MDP has no score there, and is named. Writes OUT/transfer: \
transfer.csv, summary.csv, transfer.tex and a heat map as SVG, PDF and PGF.

Examples:
  tsc-family transfer results/mplight --out results/mplight-transfer
  tsc-family transfer results/learners --methods mplight --trained-on quiet,busy --out results/two")]
pub struct TransferArgs {
    /// Results directory with models, that `run` wrote
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Results directory of the models on all point MDPs; the same command continues it, and with more models adds to it
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Methods whose models are taken [default: all with models]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub methods: Vec<String>,
    /// Point MDPs of whose trainings the models are taken [default: all with models]
    #[arg(long, value_name = "ID,...", value_delimiter = ',')]
    pub trained_on: Vec<String>,
    /// Class of your own that models are of, as it was given to the run (repeatable)
    #[arg(long = "controller", value_name = "NAME=FILE.py:CLASS")]
    pub classes: Vec<String>,
    /// Folder of the networks [default: that of the run]
    #[arg(long, value_name = "DIR")]
    pub networks: Option<PathBuf>,
    /// Worker processes at the same time [default: one per processor]
    #[arg(long, short, value_name = "J", value_parser = at_least_one_worker)]
    pub jobs: Option<NonZeroUsize>,
    /// Print JSON lines: one per model
    #[arg(long)]
    pub json: bool,
}

/// A model of a results directory, and its file.
struct Found {
    origin: Origin,
    file: PathBuf,
}

impl TransferArgs {
    /// Returns models and classes as `run` takes them.
    pub(super) fn controllers(&self) -> anyhow::Result<ControllersArgs> {
        let layout = Layout::new(&self.dir);
        let found = self.models(&layout, &Manifest::read(&layout)?.identity)?;
        let given = |found: &Found| format!("{}={}", found.origin.name, found.file.display());
        let models = found.iter().map(given).collect();
        Ok(ControllersArgs { models, ..ControllersArgs::of_classes(&self.classes) })
    }

    /// Returns the models that are asked for, those of a method after one another.
    fn models(&self, layout: &Layout, identity: &Identity) -> anyhow::Result<Vec<Found>> {
        let dir = self.dir.display();
        let refuse = |reason: String| -> anyhow::Result<Vec<Found>> { Err(Refused(reason).into()) };
        if identity.domain != Traffic::NAME {
            let domain = &identity.domain;
            return refuse(format!(
                "{dir} is of {domain}; models of signals are evaluated elsewhere"
            ));
        }
        if identity.sample.growth.is_some() {
            return refuse(format!(
                "{dir} is a run that stops when it is sure, which has no fixed point MDPs; repeat it with a --budget alone"
            ));
        }
        let known = |name: &str| identity.methods.iter().any(|method| method == name);
        if let Some(name) = self.methods.iter().find(|name| !known(name)) {
            let all = identity.methods.join(", ");
            return refuse(format!("--methods {name}: {dir} has no such method; it has {all}"));
        }
        let is_point = |id: &str| identity.points.iter().any(|row| row.point == id);
        if let Some(id) = self.trained_on.iter().find(|id| !is_point(id)) {
            return refuse(format!("--trained-on {id}: {dir} has no such point MDP"));
        }
        let asked = |name: &String, list: &[String]| list.is_empty() || list.contains(name);
        let tasks = identity.tasks();
        let is_wanted = |task: &&Task| {
            task.replicate == 0
                && asked(&task.method, &self.methods)
                && asked(&task.point, &self.trained_on)
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
            Found { origin: Origin { name, method, point }, file: layout.model(task.task) }
        };
        Ok(wanted.into_iter().map(found).collect())
    }
}

pub(super) fn run(args: &TransferArgs) -> anyhow::Result<u8> {
    let layout = Layout::new(&args.dir);
    let from = Results::load(&layout)?;
    let models = args.models(&layout, &from.manifest.identity)?;
    same_measure(&args.dir, &from.manifest.identity)?;
    RESULTS.check(&args.out, "--out", None)?;
    let place = |path: &Path| path.canonicalize().ok();
    if place(&args.out).is_some_and(|out| place(&args.dir) == Some(out)) {
        return Err(Refused(format!(
            "--out {} is the results directory whose models are taken; give another folder",
            args.out.display()
        ))
        .into());
    }
    let controllers = args.controllers()?;
    let domain = domains::traffic();
    let prepared = args.networks.clone();
    let prepared = prepared.unwrap_or_else(|| PathBuf::from(&from.manifest.provenance.networks));
    has_networks(&from.manifest.identity, &prepared)?;
    let identity = identity(&from.manifest.identity, &models)?;
    let session = open_after(domain, &from, identity, &args.out, prepared)?;
    let (launcher, then) = (controllers.launcher()?, "the same command does them");
    if let Some(code) = LocalRun::of_models(&session, launcher, args.jobs, args.json, then)? {
        return Ok(code);
    }
    let results = Results::load(&session.layout)?;
    let analysis = domains::analysis(&session.layout, &results)?;
    let origins: Vec<Origin> = models.into_iter().map(|found| found.origin).collect();
    let data = Transfer::of(&analysis, &origins);
    let (root, folder) = (session.layout.root(), session.layout.root().join("transfer"));
    let written = write(root, &folder, &data, &results.manifest.identity.scenario)?;
    if args.json {
        json_lines(&data)?;
    } else {
        line(text(&data))?;
    }
    note(format!("table: {}", written.transfer.display()));
    note(format!("heat map: {}, and as PDF and PGF", written.figure.display()));
    Ok(say_failures(&data))
}

/// Names the models that have no score somewhere and returns the exit code.
fn say_failures(data: &Transfer) -> u8 {
    let failures: Vec<_> = data.failures().collect();
    for (model, point, reason) in failures.iter().take(MOST_NAMED) {
        note(format!("no score: {} on {point}: {reason}", model.origin.name));
    }
    if failures.len() > MOST_NAMED {
        note(format!("no score: {} more, in transfer.csv", failures.len() - MOST_NAMED));
    }
    if failures.is_empty() { exit::DONE } else { exit::SOME_FAILED }
}

/// Refuses a run that another simulator or version did: its baseline and own training would be of another measure.
fn same_measure(dir: &Path, identity: &Identity) -> anyhow::Result<()> {
    let here = simulator::version()?;
    let (own, there) = (env!("CARGO_PKG_VERSION"), &identity.tsc_family);
    if identity.simulator != here || there != own {
        return Err(Refused(format!(
            "{} was measured by tsc-family {there} with {}, and this is tsc-family {own} with {here}: its baseline and own \
             training are not comparable with what would be measured now; repeat the run, or use that version",
            dir.display(),
            identity.simulator
        ))
        .into());
    }
    Ok(())
}

/// Refuses to begin without the networks.
fn has_networks(identity: &Identity, prepared: &Path) -> anyhow::Result<()> {
    let domain = domains::traffic();
    let mut spoilt = identity.points.iter().flat_map(|row| domain.spoilt(row, prepared));
    let Some(first) = spoilt.next() else { return Ok(()) };
    let what = if first.is_there { "was altered since" } else { "is missing" };
    Err(Refused(format!(
        "{} {what}: the run's networks have to be there as they were; say with --networks where they are, or let its command \
         build them again",
        quoted(&first.path)
    ))
    .into())
}

/// Returns what the run of the models is: the point MDPs and seeds of theirs, its baseline, the methods that learned them, and
/// each model as a method.
fn identity(from: &Identity, models: &[Found]) -> anyhow::Result<Identity> {
    let mut identity = from.clone();
    let learners: BTreeSet<&str> = models.iter().map(|m| m.origin.method.as_str()).collect();
    identity.methods.retain(|m| *m == from.baseline || learners.contains(m.as_str()));
    identity.controllers.retain(|own| identity.methods.contains(&own.name));
    identity.replicated.retain(|m| identity.methods.contains(m));
    if identity.replicated.is_empty() {
        identity.replicates = 1;
    }
    for found in models {
        let name = &found.origin.name;
        identity.methods.push(name.clone());
        identity.controllers.extend(domains::traffic().own(name)?);
    }
    Ok(identity)
}

fn json_lines(data: &Transfer) -> anyhow::Result<()> {
    for (group, model) in data.models() {
        let elsewhere = model.elsewhere.as_ref();
        line(json!({
            "event": "transfer",
            "method": group.method,
            "trained_on": model.origin.point,
            "points": elsewhere.map_or(0, |e| e.points),
            "covered": elsewhere.map(|e| e.covered),
            "near_own_training": elsewhere.map(|e| e.near),
            "median": elsewhere.map(|e| e.median.0),
            "own_training_median": elsewhere.map(|e| e.median.1),
            "score": elsewhere.map(|e| e.score.0),
            "own_training_score": elsewhere.map(|e| e.score.1),
        }))?;
    }
    Ok(())
}

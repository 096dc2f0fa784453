//! All models of a results directory on its point MDPs, beside what was trained there.
//!
//! It is a run over the same point MDPs and seeds. Baseline and own training are records of the directory, so only the models
//! are simulated.

use crate::cli::exit::refuse;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::{EvaluateArgs, finish};
use crate::cli::executors::check_prepared;
use crate::cli::folder::RESULTS;
use crate::cli::method_arguments::model_name;
use crate::cli::output::note;
use crate::domains;
use crate::files::{make_folder_beneath, write_atomically};
use crate::report::transfer::{Origin, table};
use crate::run::session::open_after;
use crate::store::Layout;
use crate::store::manifest::{Identity, Manifest, Task};
use crate::store::results::Results;
use crate::traffic::domain::Traffic;
use crate::traffic::simulator;

/// Returns the models as `run` takes them.
pub(super) fn given(args: &EvaluateArgs, from: &Path) -> anyhow::Result<Vec<String>> {
    let layout = Layout::new(from);
    let found = models(args, &layout, &Manifest::read(&layout)?.identity)?;
    let given = |(origin, file): &(Origin, PathBuf)| format!("{}={}", origin.name, file.display());
    Ok(found.iter().map(given).collect())
}

pub(super) fn run(args: &EvaluateArgs, from: &Path, out: &Path) -> anyhow::Result<u8> {
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
    let prepared = args.networks.clone();
    let prepared = prepared.unwrap_or_else(|| PathBuf::from(&read.manifest.provenance.networks));
    check_prepared(domains::traffic(), &read.manifest, &prepared)?;
    let identity = identity(&read.manifest.identity, &models)?;
    let session = open_after(domains::traffic(), &read, identity, out, prepared)?;
    let code = finish(args, &session, &controllers)?;
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

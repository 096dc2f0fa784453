//! `tsc-family check`: what is damaged in a results directory, and its repair.

use std::collections::BTreeSet;
use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::thread::available_parallelism;

use serde_json::json;

use super::controllers::{ControllersArgs, manifest_of};
use super::interrupt::interrupted;
use super::output::{line, note};
use super::values::at_least_one_worker;
use crate::cli::exit;
use crate::cli::refused::Refused;
use crate::domains::domains;
use crate::files::{FileError, beneath, make_folder_beneath, quoted};
use crate::report::format;
use crate::run::audit::{Beside, audit_beside};
use crate::run::batch;
use crate::run::domain::domain_of;
use crate::run::executor::Event;
use crate::run::session::reopen;
use crate::run::worker::check_own;
use crate::store::audit::{Audit, Damage, Remedy};
use crate::store::manifest::{Manifest, Task};
use crate::store::plan::write_plan;
use crate::store::{Layout, StoreError};
use crate::traffic::places::Places;

/// `tsc-family check`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Exit codes: 0 nothing is damaged and every task has a record, 6 nothing is damaged but some tasks have no \
record, 2 something is damaged.

Examples:
  tsc-family check results/slc
  tsc-family check results/slc --repair")]
pub struct CheckArgs {
    /// Results directory that `run` wrote
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Move damaged files to DIR/damaged, and do only their tasks again
    #[arg(long)]
    pub repair: bool,
    /// Folder of the networks, in which --repair may remove damaged ones [default: that of the run]
    #[arg(long, value_name = "DIR")]
    pub networks: Option<PathBuf>,
    /// Methods that are not the program's own, as they were given to the run, for --repair
    #[command(flatten)]
    pub controllers: ControllersArgs,
    /// Worker processes at the same time [default: one per processor]
    #[arg(long, short, value_name = "J", value_parser = at_least_one_worker)]
    pub jobs: Option<NonZeroUsize>,
    /// Print JSON lines: one per damaged file, then one for the directory
    #[arg(long)]
    pub json: bool,
}

/// A results directory that was looked at.
struct Looked {
    audit: Audit,
    beside: Beside,
    prepared: PathBuf,
}

pub(super) fn run(args: &CheckArgs) -> anyhow::Result<u8> {
    if args.jobs.is_some() && !args.repair {
        let reason = "--jobs has no effect without --repair; leave it out";
        return Err(Refused(reason.to_owned()).into());
    }
    let layout = Layout::new(&args.dir);
    let mut looked = look(&layout, args.networks.as_deref())?;
    say(&looked, &layout, args)?;
    if args.repair && !looked.audit.damage.is_empty() {
        let left = repair(&layout, &looked, args)?;
        if left > 0 {
            let dir = quoted(&args.dir);
            note(format!(
                "interrupted with {} to do again; tsc-family resume {dir} goes on",
                format::count(left, "task")
            ));
            return Ok(exit::INTERRUPTED);
        }
        looked = look(&layout, args.networks.as_deref())?;
        say(&looked, &layout, args)?;
    }
    Ok(match (looked.audit.damage.is_empty(), looked.audit.missing()) {
        (false, _) => exit::USAGE,
        (true, 0) => exit::DONE,
        (true, missing) => {
            if !args.json {
                let (have, them) = if missing == 1 { ("has", "it") } else { ("have", "them") };
                note(format!(
                    "{} {have} no record; tsc-family resume {} does {them}",
                    format::count(missing, "task"),
                    quoted(&args.dir)
                ));
            }
            exit::INCOMPLETE
        }
    })
}

fn look(layout: &Layout, networks: Option<&Path>) -> anyhow::Result<Looked> {
    // What cannot be read there is for `status` and `resume` to name.
    let handed = batch::submission::tasks(layout).unwrap_or_default();
    let begun = batch::submission::begun(layout, handed);
    let mut audit = Audit::of(layout, manifest_of(layout), begun)?;
    let (mut beside, mut prepared) = (Beside::default(), PathBuf::new());
    if let Some(Manifest { identity, provenance }) = audit.manifest.as_deref() {
        prepared = networks.map_or_else(|| PathBuf::from(&provenance.networks), Path::to_path_buf);
        let domain = domain_of(&domains(), layout, identity)?;
        beside = audit_beside(domain, layout, &prepared, &mut audit)?;
        match Places::read(layout).map(drop) {
            Err(StoreError::Renewable { path, reason }) => audit.add(path, reason, Remedy::Renew),
            read => read?,
        }
    }
    Ok(Looked { audit, beside, prepared })
}

fn say(looked: &Looked, layout: &Layout, args: &CheckArgs) -> anyhow::Result<()> {
    let Looked { audit, beside, .. } = looked;
    let command = audit.manifest.as_ref().map(|m| m.provenance.command.as_str());
    for damage in &audit.damage {
        let what = advice(damage, command);
        if args.json {
            let Damage { path, reason, .. } = damage;
            line(json!({"event": "damage", "path": path, "reason": reason, "remedy": what}))?;
        } else {
            line(format!("{}: {}; {what}", damage.path.display(), damage.reason))?;
        }
    }
    let (tasks, done, missing) = (audit.reach.count(), audit.done.len(), audit.missing());
    if args.json {
        line(json!({
            "event": "check",
            "damaged": audit.damage.len(),
            "tasks": tasks,
            "look": audit.reach.look.map(|(look, _)| look),
            "looks": audit.reach.look.map(|(_, looks)| looks),
            "done": done,
            "failed": audit.failed,
            "missing": missing,
            "models": beside.models,
            "no_models": beside.no_models,
            "checkpoints": beside.checkpoints,
            "prepared": beside.prepared,
            "unprepared": beside.unprepared,
            "strays": audit.strays,
            "builds": audit.builds.several(),
        }))?;
        return Ok(());
    }
    if audit.manifest.is_none() {
        return Ok(());
    }
    let look = audit.reach.look.map(|(look, looks)| format!("look {look} of {looks}: "));
    let mut parts =
        vec![format!("{}{done} of {tasks} records are sound", look.unwrap_or_default())];
    let several = [
        (audit.failed, "of failed tasks", "of failed tasks"),
        (missing, "task has none", "tasks have none"),
        (beside.models, "model is sound", "models are sound"),
        (beside.no_models, "model is not here", "models are not here"),
        (beside.checkpoints, "checkpoint", "checkpoints"),
        (beside.prepared, "point MDP has its files", "point MDPs have their files"),
        (
            beside.unprepared,
            "point MDP has none here (they are made again)",
            "point MDPs have none here (they are made again)",
        ),
    ];
    let in_words = |(n, one, many): &(usize, &str, &str)| {
        let what = if *n == 1 { one } else { many };
        format!("{n} {what}")
    };
    parts.extend(several.iter().filter(|(n, ..)| *n > 0).map(in_words));
    line(format!("{}: {}", layout.root().display(), parts.join(", ")))?;
    audit.builds.warning().into_iter().for_each(note);
    if let Some(first) = audit.strays.first() {
        let others = audit.strays.len() - 1;
        let more = if others > 0 { format!(" and {others} more") } else { String::new() };
        note(format!("{}{more}: belongs to no task of this run, and is not read", first.display()));
    }
    if !audit.damage.is_empty() && !args.repair {
        let (damaged, repeated) = (audit.damage.len(), audit.to_repeat().len());
        let (are, them) = if damaged == 1 { ("is", "it") } else { ("are", "them") };
        note(format!(
            "{} {are} damaged; --repair sets {them} aside and does {} again",
            format::count(damaged, "file"),
            format::count(repeated, "task")
        ));
    }
    Ok(())
}

/// Returns what to do with a damaged file, in words.
fn advice(damage: &Damage, command: Option<&str>) -> String {
    match damage.remedy {
        Remedy::Repeat(task) => {
            format!("task {task} can be done again, with the same record as result")
        }
        Remedy::Discard => "without it, the training starts from the beginning".to_owned(),
        Remedy::Renew => "the command of the run writes it again".to_owned(),
        Remedy::Rewrite => "it follows from the manifest".to_owned(),
        Remedy::Rebuild => {
            let command = command.unwrap_or_default();
            format!(
                "--repair with --networks DIR removes it, and the command of the run builds it again ({command})"
            )
        }
        Remedy::Restore => "restore it from a copy".to_owned(),
        Remedy::Begin => {
            let command = command.map(|command| format!(" ({command})")).unwrap_or_default();
            format!(
                "restore it from a copy, or move it away and repeat the command that began the run{command}, which \
                 writes it again and keeps the records"
            )
        }
    }
}

/// Sets damaged files aside and does their tasks again; returns how many an interruption has left.
fn repair(layout: &Layout, looked: &Looked, args: &CheckArgs) -> anyhow::Result<usize> {
    let Looked { audit, beside, prepared } = looked;
    let Some(manifest) = &audit.manifest else {
        return Err(Refused(
            "without its manifest nothing can be repaired; restore it from a copy, or move it away and repeat the \
             command that began the run"
                .to_owned(),
        )
        .into());
    };
    let repeated = audit.to_repeat();
    let (own, there) = (env!("CARGO_PKG_VERSION"), &manifest.identity.tsc_family);
    if !repeated.is_empty() && own != there {
        let reason = format!(
            "tsc-family {there} did the tasks, and this is {own}; repair with that version"
        );
        return Err(Refused(reason).into());
    }
    let domains = domains();
    let session = reopen(&domains, layout, manifest.clone(), prepared.clone())?;
    let todo: Vec<Task> =
        audit.tasks.iter().filter(|t| repeated.contains(&t.task)).cloned().collect();
    let lacks_networks =
        beside.unprepared > 0 || audit.damage.iter().any(|d| d.remedy == Remedy::Rebuild);
    // Nothing is moved where a task could not be done again.
    if !lacks_networks {
        let domain = domain_of(&domains, layout, &manifest.identity)?;
        let mut methods = todo.iter().map(|task| &task.method);
        methods.try_for_each(|method| check_own(domain, layout, &manifest.identity, method))?;
    }
    for damage in &audit.damage {
        match damage.remedy {
            Remedy::Repeat(_) | Remedy::Discard | Remedy::Renew => {
                set_aside(layout, &damage.path)?;
            }
            // A network is whole or gone; nobody misses one that can be built again. Where it is, a manifest may have
            // from a stranger.
            Remedy::Rebuild if args.networks.is_some() => remove_folder_of(prepared, &damage.path)?,
            Remedy::Rebuild => {}
            Remedy::Rewrite => {
                set_aside(layout, &damage.path)?;
                write_plan(layout, &audit.tasks)?;
            }
            Remedy::Restore | Remedy::Begin => {}
        }
    }
    // A model is of no use without its record, and a record without its model.
    for task in &repeated {
        for path in [layout.record(*task), layout.model(*task)] {
            if path.exists() {
                set_aside(layout, &path)?;
            }
        }
    }
    if layout.damaged().is_dir() {
        note(format!("damaged files are in {}", layout.damaged().display()));
    }
    if repeated.is_empty() {
        return Ok(0);
    }
    if lacks_networks {
        let command = &manifest.provenance.command;
        let (are, their) = if repeated.len() == 1 { ("is", "its") } else { ("are", "their") };
        note(format!(
            "{} {are} to do again, but {their} networks are not here: run the command of the run ({command}), \
             which builds them, or say with --networks where they are",
            format::count(repeated.len(), "task")
        ));
        return Ok(0);
    }
    let interrupted = interrupted()?;
    let jobs =
        args.jobs.map_or_else(|| available_parallelism().map_or(1, |j| j.get()), NonZeroUsize::get);
    let mut done: BTreeSet<usize> = BTreeSet::new();
    session.work(
        &todo,
        &session.local(args.controllers.launcher()?, jobs),
        &interrupted,
        &mut |event| match event {
            Event::Finished(record) => {
                done.insert(record.summary.task);
                note(format!(
                    "task {} is done again ({} of {})",
                    record.summary.task,
                    done.len(),
                    todo.len()
                ));
            }
            Event::Retry { task, reason } => {
                note(format!("task {task} failed and is tried again: {reason}"))
            }
            Event::Undone { task, reason } => note(format!("task {task} is not done: {reason}")),
            Event::Fewer { workers, asked, reason } => {
                note(format!("{workers} of {asked} workers: {reason}"))
            }
            Event::Progress { .. } => {}
        },
    )?;
    Ok(if interrupted.load(Ordering::Relaxed) { todo.len() - done.len() } else { 0 })
}

/// Removes the folder beneath another that a file lies in.
fn remove_folder_of(networks: &Path, path: &Path) -> Result<(), FileError> {
    let folder = path.parent().expect("a file lies in a folder");
    beneath(networks, folder)?;
    match fs::remove_dir_all(folder) {
        // It went with another file of it.
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(()),
        removed => removed.map_err(FileError::at("remove", folder)),
    }
}

/// Moves a damaged file out of the way, to where nothing reads it.
fn set_aside(layout: &Layout, path: &Path) -> Result<(), FileError> {
    let name = path.strip_prefix(layout.root()).expect("it lies in the results directory");
    let to = layout.damaged().join(name);
    beneath(layout.root(), path)?;
    make_folder_beneath(layout.root(), to.parent().expect("it lies in a folder"))?;
    match fs::rename(path, &to) {
        // It was missing, or went with another one.
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(()),
        moved => moved.map_err(FileError::at("set aside", path)),
    }
}

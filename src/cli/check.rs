//! `tsc-family check`: what is damaged in a results directory.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::controllers::manifest_of;
use super::output::{line, note};
use crate::cli::exit;
use crate::domains::domains;
use crate::files::quoted;
use crate::report::format;
use crate::run::audit::{Beside, audit_beside};
use crate::run::batch;
use crate::run::domain::domain_of;
use crate::run::error::RunError;
use crate::store::audit::{Audit, Damage, Remedy};
use crate::store::manifest::Manifest;
use crate::store::{Layout, StoreError};
use crate::traffic::places::Places;

/// `tsc-family check`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
It changes nothing. Delete the files that it names, and run again: only their tasks are repeated, to the same records.

Exit codes: 0 nothing is damaged and every task has a record, 6 nothing is damaged but some tasks have no \
record, 2 something is damaged.

Example:
  tsc-family check results/slc")]
pub struct CheckArgs {
    /// Results directory that `run` wrote
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Folder of the networks [default: that of the run]
    #[arg(long, value_name = "DIR")]
    pub networks: Option<PathBuf>,
    /// Print JSON lines: one per damaged file, then one for the directory
    #[arg(long)]
    pub json: bool,
}

/// A results directory that was looked at.
struct Looked {
    audit: Audit,
    beside: Beside,
}

pub(super) fn run(args: &CheckArgs) -> anyhow::Result<u8> {
    let layout = Layout::new(&args.dir);
    let looked = look(&layout, args.networks.as_deref())?;
    say(&looked, &layout, args)?;
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
    let begun = batch::begun(layout).map_err(RunError::from)?;
    let mut audit = Audit::of(layout, manifest_of(layout), begun)?;
    let mut beside = Beside::default();
    if let Some(Manifest { identity, provenance }) = audit.manifest.as_deref() {
        let prepared =
            networks.map_or_else(|| PathBuf::from(&provenance.networks), Path::to_path_buf);
        let domain = domain_of(&domains(), layout, identity)?;
        beside = audit_beside(domain, layout, &prepared, &mut audit)?;
        match Places::read(layout).map(drop) {
            Err(StoreError::Renewable { path, reason }) => audit.add(path, reason, Remedy::Renew),
            read => read?,
        }
    }
    Ok(Looked { audit, beside })
}

fn say(looked: &Looked, layout: &Layout, args: &CheckArgs) -> anyhow::Result<()> {
    let Looked { audit, beside } = looked;
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
    if !audit.damage.is_empty() {
        let (damaged, repeated) = (audit.damage.len(), audit.to_repeat().len());
        let are = if damaged == 1 { "is" } else { "are" };
        note(format!(
            "{} {are} damaged, and {} to do again",
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
            format!(
                "delete it with the record and the model of task {task}, and resume: it is done again"
            )
        }
        Remedy::Discard => "delete it; the training starts from the beginning".to_owned(),
        Remedy::Renew => "delete it; the command of the run writes it again".to_owned(),
        Remedy::Rebuild => {
            let command = command.unwrap_or_default();
            format!("delete its folder; the command of the run builds it again ({command})")
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

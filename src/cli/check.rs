//! `tsc-family check`: what is damaged in a results directory.

use std::path::PathBuf;

use serde_json::json;

use super::controllers::manifest_of;
use super::output::{line, note};
use crate::cli::exit;
use crate::domains::domains;
use crate::files::quoted;
use crate::report::format;
use crate::run::audit::Beside;
use crate::run::batch;
use crate::run::domain::domain_of;
use crate::store::results::Results;
use crate::store::{Damage, Layout, Remedy, StoreError};
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

pub(super) fn run(args: &CheckArgs) -> anyhow::Result<u8> {
    let layout = Layout::new(&args.dir);
    let manifest = match manifest_of(&layout) {
        Err(StoreError::Damaged(damage)) => {
            damage.iter().try_for_each(|found| say_damage(found, args.json))?;
            return Ok(exit::USAGE);
        }
        manifest => manifest?,
    };
    let begun = batch::begun(&layout)?;
    let (results, mut damage) = Results::inspect(&layout, &manifest)?;
    let is_of_the_records = !damage.iter().any(|found| found.path == layout.manifest());
    let mut beside = Beside::default();
    if is_of_the_records {
        let usual = || PathBuf::from(&manifest.provenance.networks);
        let prepared = args.networks.clone().unwrap_or_else(usual);
        let domain = domain_of(&domains(), &layout, &manifest.identity)?;
        beside = Beside::read(domain, &layout, &prepared, &results)?;
        damage.append(&mut beside.damage);
        match Places::read(&layout).map(drop) {
            Err(StoreError::Damaged(found)) => damage.extend(found),
            read => read?,
        }
    }
    damage.iter().try_for_each(|found| say_damage(found, args.json))?;
    let results = results.under_way(&begun);
    let missing = results.missing().count();
    if is_of_the_records {
        say(args, &results, &beside, damage.len())?;
    }
    let is_written_again =
        |found: &Damage| matches!(found.remedy, Remedy::Renew | Remedy::Rebuild | Remedy::Begin);
    if !args.json && damage.iter().any(is_written_again) {
        note(format!("the command of the run: {}", manifest.provenance.command));
    }
    if !damage.is_empty() {
        return Ok(exit::USAGE);
    }
    if missing > 0 && !args.json {
        let (have, them) = if missing == 1 { ("has", "it") } else { ("have", "them") };
        note(format!(
            "{} {have} no record; tsc-family resume {} does {them}",
            format::count(missing, "task"),
            quoted(&args.dir)
        ));
    }
    Ok(if missing > 0 { exit::INCOMPLETE } else { exit::DONE })
}

fn say_damage(found: &Damage, json: bool) -> std::io::Result<()> {
    let Damage { path, reason, remedy } = found;
    if !json {
        return line(found);
    }
    let remedy = remedy.to_string();
    line(json!({"event": "damage", "path": path, "reason": reason, "remedy": remedy}))
}

/// Says what there is; of a sample that grows, of the look that is under way.
fn say(
    args: &CheckArgs,
    results: &Results,
    beside: &Beside,
    damaged: usize,
) -> std::io::Result<()> {
    let (tasks, done) = (results.plan().len(), results.done().count());
    let (failed, missing) = (results.failed().count(), results.missing().count());
    let look = results.manifest.identity.sample.look_of();
    if args.json {
        return line(json!({
            "event": "check",
            "damaged": damaged,
            "tasks": tasks,
            "look": look.map(|(look, _)| look),
            "looks": look.map(|(_, looks)| looks),
            "done": done,
            "failed": failed,
            "missing": missing,
            "models": beside.models,
            "no_models": beside.no_models,
            "checkpoints": beside.checkpoints,
            "prepared": beside.prepared,
            "unprepared": beside.unprepared,
            "builds": results.several_builds(),
        }));
    }
    let look = look.map(|(look, looks)| format!("look {look} of {looks}: "));
    let mut parts =
        vec![format!("{}{done} of {tasks} records are sound", look.unwrap_or_default())];
    let several = [
        (failed, "of failed tasks", "of failed tasks"),
        (missing, "task has none", "tasks have none"),
        (damaged, "file is damaged", "files are damaged"),
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
    line(format!("{}: {}", args.dir.display(), parts.join(", ")))?;
    results.warning_of_builds().into_iter().for_each(note);
    Ok(())
}

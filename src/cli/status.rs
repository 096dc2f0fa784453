//! `tsc-family status`: how far a run is, from its results directory.

use std::path::PathBuf;

use serde_json::json;

use super::controllers::manifest_of;
use super::output::{line, note};
use crate::cli::exit;
use crate::files::quoted;
use crate::run::batch;
use crate::store::Layout;
use crate::store::lock::holder;
use crate::store::manifest::Manifest;
use crate::store::results::Results;

/// Most failed tasks that are named.
const NAMED: usize = 10;

/// `tsc-family status`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Exit codes: 0 every task has a record, 3 every task has a record and some failed, 6 some tasks have no \
record. For a run that stops when enough is known, these are the tasks of the looks until now.

Example:
  tsc-family status results/slc")]
pub struct StatusArgs {
    /// Results directory of the run
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Print one line of JSON
    #[arg(long)]
    pub json: bool,
}

pub(super) fn run(args: &StatusArgs) -> anyhow::Result<u8> {
    let layout = Layout::new(&args.dir);
    let manifest = manifest_of(&layout)?;
    let handed = batch::begun(&layout)?;
    let results = Results::inspect(&layout, &manifest)?.0.under_way(handed);
    let holder = holder(&layout);
    let (tasks, missing) = (results.plan().len(), results.missing().count());
    let (done, failed) = (tasks - missing, results.failed().count());
    let begun = results.missing().filter(|task| layout.checkpoint(task.task).exists()).count();
    let reasons = results
        .failed()
        .take(NAMED)
        .map(|(task, record)| (task, record.summary.reason.as_deref().unwrap_or_default()));
    let look = results.manifest.identity.sample.look_of();
    if args.json {
        let reasons: Vec<_> = reasons
            .map(|(t, why)| json!({"task": t.task, "method": t.method, "point": t.point, "reason": why}))
            .collect();
        line(json!({
            "event": "status",
            "tasks": tasks,
            "look": look.map(|(look, _)| look),
            "looks": look.map(|(_, looks)| looks),
            "done": done,
            "failed": failed,
            "first_failed": reasons,
            "begun": begun,
            "missing": missing,
            "running_here": holder,
            "builds": results.several_builds(),
        }))?;
        return Ok(code(missing, failed));
    }
    let head = look.map(|(look, looks)| format!("look {look} of {looks}: ")).unwrap_or_default();
    let mut parts = vec![format!("{head}{done} of {tasks} tasks are done")];
    let others = [
        (failed, "of them failed"),
        (missing, "to do"),
        (begun, "of the missing with a checkpoint"),
    ];
    parts.extend(others.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")));
    line(format!("{}: {}", args.dir.display(), parts.join(", ")))?;
    if let Some(builds) = results.warning_of_builds() {
        line(format!("  {builds}"))?;
    }
    for (task, reason) in reasons {
        line(format!("failed: task {}, {} on {}: {reason}", task.task, task.method, task.point))?;
    }
    if failed > NAMED {
        line(format!("and {} more", failed - NAMED))?;
    }
    let dir = quoted(&args.dir);
    if missing == 0 {
        note(format!("tsc-family report {dir} writes tables, figures and page"));
        if look.is_some_and(|(look, looks)| look < looks) {
            say_who_inspects(&manifest);
        }
    } else if let Some(holder) = holder {
        note(format!("a run is in progress: {holder}"));
    } else if layout.jobs().exists() {
        note(format!("where no job has them any more, tsc-family resume {dir} does them"));
    } else {
        note(format!("tsc-family resume {dir} does them"));
    }
    Ok(code(missing, failed))
}

/// Says which command looks at the results of a growing run, and begins the next look.
pub(super) fn say_who_inspects(manifest: &Manifest) {
    note(format!(
        "the command of the run inspects the results, and continues if they are not enough: {}",
        manifest.provenance.command
    ));
}

fn code(missing: usize, failed: usize) -> u8 {
    match (missing, failed) {
        (0, 0) => exit::DONE,
        (0, _) => exit::SOME_FAILED,
        _ => exit::INCOMPLETE,
    }
}

//! `tsc-family status`: how far a run is, from its results directory.

use std::path::PathBuf;

use serde_json::json;

use super::controllers::manifest_of;
use super::output::{line, note};
use crate::cli::exit;
use crate::files::quoted;
use crate::run::batch;
use crate::run::error::RunError;
use crate::store::Layout;
use crate::store::dropped::read_dropped;
use crate::store::lock::holder;
use crate::store::manifest::{Manifest, Task};
use crate::store::reach::Reach;
use crate::store::tally::Tally;

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
    let plan = manifest.identity.tasks();
    let tally = Tally::of(&layout, &plan, &manifest.sha256())?;
    let holder = holder(&layout);
    let handed = batch::begun(&layout).map_err(RunError::from)?;
    let begun = |task: usize| tally.done[task] || handed(task);
    let dropped = read_dropped(&layout, &manifest.identity)?;
    let reach = Reach::of(&manifest.identity, &plan, &dropped, begun);
    let to_do = |t: &usize| reach.has(*t) && !tally.done[*t];
    let missing = (0..plan.len()).filter(to_do).count();
    let failed: Vec<(&Task, &String)> =
        tally.failed.iter().take(NAMED).map(|(task, reason)| (&plan[*task], reason)).collect();
    let (tasks, look) = (reach.count(), reach.look);
    let done = tasks - missing;
    if args.json {
        let failed: Vec<_> = failed
            .iter()
            .map(|(t, why)| json!({"task": t.task, "method": t.method, "point": t.point, "reason": why}))
            .collect();
        line(json!({
            "event": "status",
            "tasks": tasks,
            "look": look.map(|(look, _)| look),
            "looks": look.map(|(_, looks)| looks),
            "done": done,
            "failed": tally.failed.len(),
            "first_failed": failed,
            "begun": tally.begun.len(),
            "missing": missing,
            "running_here": holder,
            "builds": tally.builds.several(),
        }))?;
        return Ok(code(missing, tally.failed.len()));
    }
    let look = look.map(|(look, looks)| format!("look {look} of {looks}: ")).unwrap_or_default();
    let mut parts = vec![format!("{look}{done} of {tasks} tasks are done")];
    let others = [(tally.failed.len(), "of them failed"), (missing, "to do")];
    parts.extend(others.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")));
    if !tally.begun.is_empty() {
        parts.push(format!("{} of the missing with a checkpoint", tally.begun.len()));
    }
    line(format!("{}: {}", args.dir.display(), parts.join(", ")))?;
    if let Some(builds) = tally.builds.warning() {
        line(format!("  {builds}"))?;
    }
    for (task, reason) in &failed {
        line(format!("failed: task {}, {} on {}: {reason}", task.task, task.method, task.point))?;
    }
    if tally.failed.len() > NAMED {
        line(format!("and {} more", tally.failed.len() - NAMED))?;
    }
    let dir = quoted(&args.dir);
    if missing == 0 {
        note(format!("tsc-family report {dir} writes tables, figures and page"));
        if reach.may_grow() {
            say_who_inspects(&manifest);
        }
    } else if let Some(holder) = holder {
        note(format!("a run is in progress: {holder}"));
    } else if layout.jobs().exists() {
        note(format!("where no job has them any more, tsc-family resume {dir} does them"));
    } else {
        note(format!("tsc-family resume {dir} does them"));
    }
    Ok(code(missing, tally.failed.len()))
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

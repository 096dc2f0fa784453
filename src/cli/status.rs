//! `tsc-family status`: how far a run is, from its results directory and from the batch system that has it.

use std::path::PathBuf;
use std::time::Duration;

use serde_json::json;

use super::controllers::manifest_of;
use super::executors::{Abroad, abroad};
use super::forecast::range;
use super::output::{line, note};
use crate::cli::exit;
use crate::domains::domains;
use crate::files::quoted;
use crate::report::format;
use crate::run::batch::cost::Costs;
use crate::run::batch::{Standing, submission};
use crate::run::domain::domain_of;
use crate::store::Layout;
use crate::store::dropped::read_dropped;
use crate::store::lock::holder;
use crate::store::manifest::{Manifest, Task};
use crate::store::reach::Reach;
use crate::store::tally::Tally;

/// Most failed tasks that are named.
const NAMED: usize = 10;

/// Factor by which the time that is left may be wrong.
const ERROR: f64 = 1.5;

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
    let (there, silent) = match abroad(&layout) {
        Ok(there) => (there, None),
        // What is done is known all the same.
        Err(e) => (Abroad::default(), Some(e.to_string())),
    };
    let holder = holder(&layout);
    let count = |of: Standing| -> usize {
        let counts = there.submissions.iter().flat_map(|(_, counts)| counts);
        counts.filter(|(standing, ..)| *standing == of).map(|(.., count)| count).sum()
    };
    let [running, queued, held] = [Standing::Running, Standing::Queued, Standing::Held].map(count);
    let handed = submission::tasks(&layout).unwrap_or_default();
    let begun =
        |t: usize| tally.done[t] || handed.contains(&t) || tally.begun.binary_search(&t).is_ok();
    let dropped = read_dropped(&layout, &manifest.identity)?;
    let reach = Reach::of(&manifest.identity, &plan, &dropped, begun);
    let to_do = |t: &usize| reach.has(*t) && !tally.done[*t];
    let missing = (0..plan.len()).filter(to_do).count();
    let rest = (0..plan.len()).filter(to_do).filter(|t| !there.tasks.contains(t)).count();
    let rests = match (&holder, &silent, &there.script) {
        _ if rest == 0 => Rest::Nobody,
        (Some(holder), ..) => Rest::Here(holder.clone()),
        (_, Some(said), _) => Rest::Unknown(said.clone()),
        (.., Some(script)) => Rest::Script(script.number),
        _ => Rest::Nobody,
    };
    let left_s = match running {
        0 => None,
        jobs => Some(seconds_left(&layout, &manifest, (&plan, &reach), &tally)? / jobs as f64),
    };
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
            "with_nobody": matches!(rests, Rest::Nobody).then_some(rest),
            "running_here": holder,
            "packs_running": running,
            "packs_queued": queued,
            "packs_held": held,
            "seconds_left": left_s,
            "batch_error": silent,
            "builds": tally.builds.several(),
        }))?;
        return Ok(code(missing, tally.failed.len()));
    }
    let look = look.map(|(look, looks)| format!("look {look} of {looks}: ")).unwrap_or_default();
    let mut parts = vec![format!("{look}{done} of {tasks} tasks are done")];
    let others = [(tally.failed.len(), "of them failed"), (rest, rests.words())];
    parts.extend(others.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")));
    if !tally.begun.is_empty() {
        parts.push(format!("{} of the missing with a checkpoint", tally.begun.len()));
    }
    line(format!("{}: {}", args.dir.display(), parts.join(", ")))?;
    if let Some(builds) = tally.builds.warning() {
        line(format!("  {builds}"))?;
    }
    for (submission, counts) in &there.submissions {
        let counts = counts.iter().map(|(standing, reason, count)| {
            let what = match standing {
                Standing::Running => "running",
                Standing::Queued => "queued",
                Standing::Held => "held",
                Standing::Ending => "ending",
            };
            let why = if reason.is_empty() { String::new() } else { format!(" ({reason})") };
            format!("{count} {what}{why}")
        });
        line(format!(
            "{} {}: of {} {}",
            submission.executor,
            submission.ids.join(", "),
            format::count(submission.packs, "pack"),
            counts.collect::<Vec<_>>().join(", ")
        ))?;
    }
    for submission in there.cancelled.iter().filter(|_| missing > 0) {
        line(format!(
            "{} {}: cancelled {}",
            submission.executor,
            submission.ids.join(", "),
            submission.cancelled.as_deref().unwrap_or_default()
        ))?;
    }
    if let Some(left_s) = left_s {
        let about = [left_s / ERROR, left_s * ERROR].map(Duration::from_secs_f64);
        line(format!(
            "about {} left, with {} at a time",
            range(about),
            format::count(running, "running pack")
        ))?;
    }
    for (task, reason) in &failed {
        line(format!("failed: task {}, {} on {}: {reason}", task.task, task.method, task.point))?;
    }
    if tally.failed.len() > NAMED {
        line(format!("and {} more", tally.failed.len() - NAMED))?;
    }
    there.say_of_another();
    let dir = quoted(&args.dir);
    match rests {
        _ if missing == 0 => {
            note(format!("tsc-family report {dir} writes tables, figures and page"));
            if reach.may_grow() {
                say_who_inspects(&manifest);
            }
        }
        _ if rest == 0 => {}
        Rest::Here(holder) => note(format!("a run is in progress: {holder}")),
        Rest::Unknown(said) => {
            note(format!(
                "the batch system cannot be queried, so it is not known where they are: {said}"
            ));
        }
        Rest::Script(number) => note(format!(
            "the program that starts {} may have them; if it has ended, run tsc-family resume {dir}",
            quoted(&submission::folder(&layout, number).join("job.sh"))
        )),
        Rest::Nobody => note(format!("tsc-family resume {dir} does them")),
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

/// Who has the tasks that have no record and that no batch system names.
enum Rest {
    /// A process that works on the directory.
    Here(String),
    /// A batch system that does not answer may, for what it says.
    Unknown(String),
    /// Whatever starts the script of a submission, of which only people know.
    Script(usize),
    /// Nobody.
    Nobody,
}

impl Rest {
    /// Returns what is said of them after their number.
    fn words(&self) -> &'static str {
        match self {
            Self::Here(_) => "to do",
            Self::Unknown(_) | Self::Script(_) => "without a record",
            Self::Nobody => "not under way",
        }
    }
}

fn code(missing: usize, failed: usize) -> u8 {
    match (missing, failed) {
        (0, 0) => exit::DONE,
        (0, _) => exit::SOME_FAILED,
        _ => exit::INCOMPLETE,
    }
}

/// Returns the processor time that missing tasks are expected to take, seconds.
fn seconds_left(
    layout: &Layout,
    manifest: &Manifest,
    (plan, reach): (&[Task], &Reach),
    tally: &Tally,
) -> anyhow::Result<f64> {
    let known = domains();
    let domain = domain_of(&known, layout, &manifest.identity)?;
    let done: Vec<&Task> = plan.iter().filter(|t| tally.done[t.task]).collect();
    let costs = Costs::new(domain, layout, manifest, &done)?;
    let missing = plan.iter().filter(|t| reach.has(t.task) && !tally.done[t.task]);
    Ok(missing.map(|t| costs.seconds(t)).sum::<Result<f64, _>>()?)
}

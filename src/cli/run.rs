//! `tsc-family run`: plan, networks, workers, summary.

pub(super) mod arguments;
mod begun;
mod looks;

pub(super) use arguments::RunArgs;

use std::num::{NonZero, NonZeroU32};
use std::path::{Path, PathBuf};
use std::thread::available_parallelism;
use std::time::Duration;

use serde_json::json;

use self::begun::Begun;
use super::estimate::{read, settings_of, warn_of_settings};
use super::executors::{Executes, hand_over};
use super::folder::RESULTS;
use super::interrupt::interrupted;
use super::local_run::LocalRun;
use super::output::{Progress, duration, line, note};
use super::subject::Subject;
use crate::analysis::check_name;
use crate::cli::exit::{self, Refused, refuse, without_effect};
use crate::files::{self, limits};
use crate::heartbeat;
use crate::published;
use crate::report::format;
use crate::run::effort::Efforts;
use crate::run::error::RunError;
use crate::run::method::{Method, TUNED, Training};
use crate::run::plan::{Draft, EVALUATION_SEEDS, Request, draft};
use crate::run::session::{Session, open};
use crate::run::watchdog::Watchdog;
use crate::sample::{Choice, Sampling};
use crate::seed::evaluation_of;
use crate::store::manifest::Identity;
use crate::store::most::MOST_EVALUATION_SEEDS;

/// Most warnings that a run prints when it begins.
const MOST_WARNINGS: usize = 20;

/// What stands for all methods.
const ALL: &str = "all";

pub(super) fn run(args: &RunArgs) -> anyhow::Result<u8> {
    run_on(args, &Subject::new(args)?)
}

/// Returns the results directory.
pub(super) fn out_of(args: &RunArgs, subject: &Subject) -> PathBuf {
    let out = args.out.clone();
    out.unwrap_or_else(|| Path::new("results").join(&subject.problem.family().name))
}

/// Runs what the arguments ask for, on a subject.
pub(super) fn run_on(args: &RunArgs, subject: &Subject) -> anyhow::Result<u8> {
    let out = out_of(args, subject);
    let begun = Begun::find(args, subject, &out)?;
    let mut methods = match &begun {
        Some(begun) if args.methods.is_empty() => begun.identity.methods.clone(),
        Some(begun) => begun.with(methods(&args.methods, subject)),
        None => methods(&args.methods, subject),
    };
    args.controllers.check(subject.domain)?;
    let tuned = args.tune.iter().flat_map(|name| [name.clone(), format!("{name}{TUNED}")]);
    for name in args.controllers.names().chain(tuned) {
        if !methods.contains(&name) {
            methods.push(name);
        }
    }
    let there = begun.as_ref().map(|begun| &begun.identity);
    if let Some(name) = args.replace.iter().find(|m| !there.is_some_and(|t| t.methods.contains(m)))
    {
        return refuse(format!("--replace {name}: {} has no records of it", out.display()));
    }
    let choice = choice(args, subject, begun.as_ref())?;
    // Those that a folder was given in a file stay.
    let kept = || there.filter(|t| args.eval_seeds.is_none() && t.base_seed == args.seed);
    let seeds = match &args.seeds {
        Some(path) => Some(read_seeds(path)?),
        None => kept().map(|t| t.evaluation_seeds.clone()),
    };
    let request = Request {
        domain: subject.domain,
        problem: subject.problem.as_ref(),
        choice: &choice,
        methods: &methods,
        base_seed: args.seed,
        evaluation_seeds: (args.eval_seeds.map(NonZeroU32::get))
            .or(seeds.as_ref().map(|seeds| seeds.len() as u32))
            .or(there.map(|t| t.evaluation_seeds.len() as u32))
            .unwrap_or(EVALUATION_SEEDS),
        seeds: seeds.as_deref(),
        replicates: (args.replicates.map(NonZeroU32::get))
            .or(there.map(|t| t.replicates))
            .unwrap_or(1),
        replace: &args.replace,
    };
    let mut draft = draft(&request)?;
    if let Some(method) = &args.against {
        check_name(method, &draft.methods)?;
    }
    check(args, &request, &draft)?;
    looks::grow(args, &methods, request.domain.baseline(), &mut draft)?;
    let chosen = draft.chosen();
    let mut lacking = draft.methods.iter().filter_map(|m| subject.problem.lacking(m, &chosen));
    if let Some(reason) = lacking.next() {
        return refuse(reason);
    }
    let jobs = args.workers.limits.here();
    let warnings = {
        let _watchdog = prepared_in(Duration::from_secs(args.workers.limits.stall_timeout));
        subject.problem.warnings().map_err(RunError::Prepare)
    };
    let warnings = match warnings {
        // A plan needs no SUMO.
        Err(e) if args.dry_run && exit::code(&e) == exit::NO_SUMO => {
            note("the signals were not checked, because SUMO is missing");
            Vec::new()
        }
        warnings => warnings?,
    };
    if !args.quiet {
        say_warnings(&warnings, args.dry_run);
    }
    draft.memory_per_worker_mb = match args.executor {
        Executes::Local => args.workers.limits.memory_mb(jobs)?,
        // Each job has its share of what it was given.
        Executes::Slurm | Executes::Script => args.workers.limits.memory_per_worker,
    };
    if args.dry_run {
        if args.json {
            for draw in &draft.sample.draws {
                let mut value = json!(draw);
                value["event"] = "plan".into();
                value["methods"] = json!(draft.methods);
                line(value)?;
            }
        } else {
            line(forecast(&request, &draft, jobs)?)?;
        }
        return Ok(exit::DONE);
    }
    RESULTS.check(&out, "--out", Some(args.force))?;
    let made = Progress::new(
        draft.sample.draws.len() as u64,
        Some("networks"),
        args.quiet || args.json || !subject.builds,
    );
    let session = {
        let _watchdog = prepared_in(Duration::from_secs(args.workers.limits.stall_timeout));
        open(&request, &draft, &out, &|point| {
            heartbeat::beat(1);
            made.add(1, point);
        })
    };
    made.finish();
    let session = session?;
    if let Some(kept) = session.kept {
        say_added(args, &session, there, kept)?;
    }
    work(args, &request, &session)
}

fn say_added(
    args: &RunArgs,
    session: &Session<'_>,
    there: Option<&Identity>,
    kept: usize,
) -> anyhow::Result<()> {
    let tasks = session.manifest.identity.tasks().len();
    if args.json {
        return Ok(line(json!({"event": "added", "records": kept, "tasks": tasks}))?);
    }
    if !args.quiet {
        let before = there.map_or(0, |t| t.tasks().len());
        let added = tasks.saturating_sub(before);
        let are = if added == 1 { "is" } else { "are" };
        let stay = if kept == 1 { "stays" } else { "stay" };
        let kept = format::count(kept, "record");
        let seeds = session.manifest.identity.evaluation_seeds.len();
        let seeds_before = there.map_or(seeds, |t| t.evaluation_seeds.len());
        let what = if seeds > seeds_before {
            format!("each task plays {seeds} evaluation seeds instead of {seeds_before}")
        } else if args.replace.is_empty() {
            format!("{} {are} added to {before}", format::count(added, "task"))
        } else {
            format!("computed again: {}", args.replace.join(", "))
        };
        note(format!("{}: {what}; {kept} {stay}", session.layout.root().display()));
    }
    Ok(())
}

/// Says what is to be known of imported scenarios; all of it in a dry run.
fn say_warnings(warnings: &[String], all: bool) {
    let most = if all { warnings.len() } else { MOST_WARNINGS };
    warnings.iter().take(most).for_each(|warning| note(format!("warning: {warning}")));
    if let Some(more) = warnings.len().checked_sub(most).filter(|more| *more > 0) {
        note(format!("warning: {more} more, which the report has; --dry-run prints all"));
    }
}

/// Watches over what is done before the first task, where SUMO loads scenarios in this process: one that hangs
/// cannot be ended in another way than with the process, of which nothing is written yet.
fn prepared_in(limit: Duration) -> Option<Watchdog> {
    let hangs = move |_| {
        let limit = limit.as_secs();
        note(format!(
            "error: no network was built or loaded for {limit} s: netconvert or SUMO hangs (a scenario may wait \
             for somebody); nothing was written; --stall-timeout allows more time"
        ));
        std::process::exit(exit::UNEXPECTED.into());
    };
    // Where a limit allows no thread more, nobody watches.
    Watchdog::start(limit, |_| {}, hangs).ok()
}

/// Returns which point MDPs are asked for: those of another run, a budget, those that are there already, or all.
fn choice(args: &RunArgs, subject: &Subject, begun: Option<&Begun>) -> anyhow::Result<Choice> {
    let family = subject.problem.family();
    let size = family.points.len();
    if let Some(dir) = &args.like {
        return begun::like(dir);
    }
    let budget = args.budget.and_then(|budget| budget.0);
    if let Some(dir) = &args.assist {
        let sampling = Sampling::BayesianQuadrature;
        let fits = args.sampling.is_none_or(|asked| asked == sampling);
        let Some(budget) = budget.filter(|_| fits) else {
            return refuse("--assist has no effect: it is for a --budget by bayesian-quadrature");
        };
        let (known, analysis) = read(dir)?;
        let (dir, there) = (dir.display().to_string(), settings_of(&known, &analysis));
        if !args.quiet {
            warn_of_settings(&dir, &there, &subject.problem.settings());
        }
        let design = known.design(family, &dir)?;
        // A sample that is there stays what it is, and older ones know no estimates apart.
        let is_apart = begun.is_none_or(Begun::is_apart);
        let design = Some(if is_apart { design.assisting() } else { design.modelled() });
        return Ok(Choice::Budget { budget, sampling, design, assisting: Some(there) });
    }
    // Another sampling than that of the folder is another sample, and so is one that nothing assists.
    let is_same = |b: &&Begun| {
        args.sampling.is_none_or(|s| s == b.identity.sample.sampling)
            && !(args.no_assist && b.assisting.is_some())
    };
    if let Some(begun) = begun.filter(is_same) {
        match budget {
            Some(budget) => return begun.with_budget(budget, family),
            None if args.budget.is_none() && args.sampling.is_none() => return begun.choice(),
            None => {}
        }
    }
    let is_free = args.sampling.is_none() && !args.until_decided && !args.no_assist;
    if let Some(budget) = budget.filter(|budget| is_free && begun.is_none() && *budget < size) {
        match published::choice(subject.problem.as_ref(), budget) {
            Ok(choice) => return Ok(choice),
            Err(why) => why.filter(|_| !args.quiet).into_iter().for_each(note),
        }
    }
    // A sample that grows may grow to the whole family.
    Ok(match budget.or(args.until_decided.then_some(size)) {
        Some(budget) => Choice::drawn(budget, args.sampling.unwrap_or(Sampling::DEFAULT)),
        None => Choice::All,
    })
}

/// Returns the methods by name; `all` stands for every one that can run there, none for the domain's default and what
/// signals do today.
fn methods(names: &[String], subject: &Subject) -> Vec<String> {
    let named = |wanted: &dyn Fn(&Method) -> bool| {
        let methods = subject.domain.methods().iter();
        methods.filter(|m| wanted(m)).map(|m| m.name.to_owned()).collect()
    };
    match names {
        [] => named(&|m| m.default || subject.problem.today() == Some(m.name)),
        names if names.iter().any(|name| name == ALL) => named(&|m| subject.problem.can_run(m)),
        names => names.to_vec(),
    }
}

/// Refuses what has no effect, whatever is evaluated.
fn check(args: &RunArgs, request: &Request<'_>, draft: &Draft) -> anyhow::Result<()> {
    args.workers.check(args.executor)?;
    let is_learner = |m: &&Method| m.training == Training::Learned;
    let mut learners = request.domain.methods().iter().filter(is_learner);
    let learns = learners.any(|m| draft.methods.iter().any(|name| name == m.name));
    let is_whole = matches!(request.choice, Choice::All) || draft.sample.family_size == 1;
    let is_later = args.executor != Executes::Local && args.against.is_some();
    let is_alone = request.replicates > 1 && draft.replicated.is_empty();
    without_effect(&[
        ("--sampling", args.sampling.is_some() && is_whole, "every point MDP is evaluated"),
        ("--replicates", is_alone, "no method tunes or learns"),
        ("--against", is_later, "`report --against` comes later"),
        ("--episodes", args.episodes.is_some() && !learns, "no method learns"),
    ])
}

/// Does the tasks that are missing, then reports; or hands them over.
fn work(args: &RunArgs, request: &Request<'_>, session: &Session<'_>) -> anyhow::Result<u8> {
    let local = LocalRun {
        session,
        domain: request.domain,
        launcher: args.controllers.launcher()?,
        limits: &args.workers.limits,
        against: args.against.as_deref(),
        json: args.json,
        quiet: args.quiet,
    };
    let interrupted = interrupted()?;
    args.workers.lines()?;
    // What failed is forgotten when nothing refuses to try it again.
    if args.retry_failed {
        session.forget_failed()?;
    }
    let mut done: Option<usize> = None;
    while let Some(results) = looks::next((session, request.problem), done, args)? {
        if args.executor != Executes::Local && results.missing().next().is_some() {
            let launcher = local.launcher.clone();
            let what = (session, request.domain);
            hand_over(args.executor, what, &results, &args.workers, launcher)?;
            return Ok(exit::DONE);
        }
        if let Some(code) = local.work_on(&results, &interrupted)? {
            return Ok(code);
        }
        done = Some(results.plan().len());
    }
    local.summarise()
}

/// Returns the plan in words, for so many workers.
fn forecast(request: &Request<'_>, draft: &Draft, jobs: usize) -> Result<String, RunError> {
    let sample = &draft.sample;
    let replicates = |method: &String| match draft.replicated.contains(method) {
        true => u64::from(request.replicates),
        false => 1,
    };
    let per_point: u64 = draft.methods.iter().map(replicates).sum();
    let tasks = sample.draws.len() as u64 * per_point;
    let mut text = format!(
        "{} of {} ({}, seed {}), {}, {}",
        sample.draws.len(),
        format::count(sample.family_size, "point MDP"),
        sample.sampling.name(),
        sample.seed,
        format::count(draft.methods.len(), "method"),
        format::count(tasks as usize, "task"),
    );
    let mut episodes = 0;
    let (mut all_s, mut longest_s, mut is_informed) = (0.0, 0.0_f64, false);
    let efforts = Efforts::of_request(request)?;
    for draw in &sample.draws {
        for method in &draft.methods {
            let effort = efforts.task(method, &draw.point)?;
            episodes += replicates(method) * u64::from(effort.episodes());
            all_s += replicates(method) as f64 * effort.whole_seconds();
            longest_s = longest_s.max(effort.whole_seconds());
            is_informed |= effort.is_informed;
        }
        text += &format!("\n{:40} weight {:.4}", draw.point, draw.weight);
    }
    text += &format!("\n{episodes} episodes at most");
    if is_informed {
        let time_s = (all_s / jobs.min(available_parallelism().map_or(1, NonZero::get)) as f64)
            .max(longest_s);
        let time = duration(Duration::from_secs_f64(time_s));
        text += &format!(", about {time} with {}", format::count(jobs, "worker"));
    }
    Ok(text)
}

/// Reads evaluation seeds: a whole number per line; what follows a `#` is a comment.
fn read_seeds(path: &Path) -> anyhow::Result<Vec<u64>> {
    let text = files::read_text(path, limits::DOCUMENT)?;
    let wrong = |line: usize| {
        Refused(format!(
            "{}, line {line}: expected one whole number from 0 to 2147483647 per line, each once, and at most \
             {MOST_EVALUATION_SEEDS}",
            path.display()
        ))
    };
    let mut seeds = Vec::new();
    for (line, text) in (1..).zip(text.lines()) {
        let number = text.split('#').next().unwrap_or_default().trim();
        if !number.is_empty() {
            let seed = number.parse().ok().and_then(evaluation_of);
            seeds.push(seed.filter(|seed| !seeds.contains(seed)).ok_or_else(|| wrong(line))?);
        }
    }
    match seeds.len() {
        0 => Err(wrong(1).into()),
        n if n > MOST_EVALUATION_SEEDS as usize => Err(wrong(n).into()),
        _ => Ok(seeds),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_has_a_seed_per_line() {
        let read = |text: &str| {
            let file = tempfile::NamedTempFile::new().unwrap();
            std::fs::write(file.path(), text).unwrap();
            read_seeds(file.path()).map_err(|e| e.to_string())
        };
        let seeds = read("# of the paper\n1\n\n 1889785958 # as in a manifest\n");
        assert_eq!(seeds, Ok(vec![evaluation_of(1).unwrap(), 1_889_785_958]));
        // The last has the same episode in its two ways of writing.
        for wrong in ["1\n2,3", "1\n-1", "1\n2147483648", "7\n7", "7\n1073741831"] {
            assert!(read(wrong).unwrap_err().contains(", line 2: expected one whole"), "{wrong}");
        }
        assert!(read("# nothing\n").is_err());
    }
}

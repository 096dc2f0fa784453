//! `tsc-family run`: plan, networks, workers, summary.

mod arguments;
mod begun;
mod looks;
mod seeds;

pub(super) use arguments::RunArgs;

use std::num::NonZeroU32;
use std::path::Path;
use std::thread::available_parallelism;
use std::time::Duration;

use serde_json::json;

use self::begun::Begun;
use super::dry_run::estimate;
use super::executors::{Executes, hand_over};
use super::folder::RESULTS;
use super::interrupt::interrupted;
use super::json::merge;
use super::local_run::LocalRun;
use super::output::{Counted, line, note};
use super::recorded::{design, read, settings_of, warn_of_settings};
use super::subject::Subject;
use crate::analysis::check_name;
use crate::cli::exit;
use crate::cli::refused::Refused;
use crate::heartbeat;
use crate::report::format;
use crate::run::method::{Method, Training};
use crate::run::plan::{Draft, EVALUATION_SEEDS, Request, draft};
use crate::run::session::{Session, open};
use crate::run::watchdog::Watchdog;
use crate::sample::{Choice, Sampling};
use crate::store::manifest::Identity;
use crate::traffic::sim::SimError;

/// Most warnings that a run prints when it begins.
const MOST_WARNINGS: usize = 20;

/// What stands for all methods.
const ALL: &str = "all";

pub(super) fn run(args: &RunArgs) -> anyhow::Result<u8> {
    let subject = Subject::new(args)?;
    let out = args.out.clone();
    let out = out.unwrap_or_else(|| Path::new("results").join(&subject.problem().family().name));
    let begun = Begun::find(args, &subject, &out)?;
    let mut methods = match &begun {
        Some(begun) if args.methods.is_empty() => begun.identity.methods.clone(),
        Some(begun) => begun.with(methods(&args.methods, &subject)),
        None => methods(&args.methods, &subject),
    };
    args.controllers.check(subject.domain())?;
    for name in args.controllers.names().filter(|name| !methods.contains(name)).collect::<Vec<_>>()
    {
        methods.push(name);
    }
    for text in subject.models_elsewhere(&args.controllers)?.iter().filter(|_| !args.quiet) {
        note(format!("warning: {text}"));
    }
    let there = begun.as_ref().map(|begun| &begun.identity);
    if let Some(name) = args.replace.iter().find(|m| !there.is_some_and(|t| t.methods.contains(m)))
    {
        let reason = format!("--replace {name}: {} has no records of it", out.display());
        return Err(Refused(reason).into());
    }
    let choice = choice(args, &subject, begun.as_ref())?;
    // Those that a folder was given in a file stay.
    let kept = || there.filter(|t| args.eval_seeds.is_none() && t.base_seed == args.seed);
    let seeds = match &args.seeds {
        Some(path) => Some(seeds::read(path)?),
        None => kept().map(|t| t.evaluation_seeds.clone()),
    };
    let request = Request {
        domain: subject.domain(),
        problem: subject.problem(),
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
    subject.check(args, &draft)?;
    let processors = available_parallelism().map_or(1, |j| j.get());
    let jobs = args.workers.here(processors);
    let warnings = {
        let _watchdog = prepared_in(Duration::from_secs(args.workers.stall_timeout));
        subject.examine()
    };
    let warnings = match warnings {
        // A plan needs no SUMO.
        Err(SimError::Unavailable(_) | SimError::Absent(_)) if args.dry_run => {
            note("the signals were not checked, because SUMO is missing");
            &[]
        }
        warnings => warnings?,
    };
    if !args.quiet {
        say_warnings(warnings, args.dry_run);
    }
    draft.memory_per_worker_mb = match args.executor {
        Executes::Local => args.workers.memory_mb(jobs)?,
        // Each job has its share of what it was given.
        Executes::Slurm | Executes::Script => args.workers.memory_per_worker,
    };
    if args.dry_run {
        if args.json {
            for draw in &draft.sample.draws {
                let mut value = json!({"event": "plan", "methods": draft.methods});
                merge(&mut value, draw);
                line(value)?;
            }
        } else {
            line(estimate(&request, &draft, jobs, processors)?)?;
        }
        return Ok(exit::DONE);
    }
    RESULTS.check(&out, "--out", Some(args.force))?;
    subject.check_folder()?;
    let made = Counted::new(
        draft.sample.draws.len(),
        "networks",
        args.quiet || args.json || !subject.builds(),
    );
    let session = {
        let _watchdog = prepared_in(Duration::from_secs(args.workers.stall_timeout));
        open(&request, &draft, &out, &|point| {
            heartbeat::beat(1);
            made.set(point);
        })
    };
    made.finish();
    let session = session?;
    if let Some(kept) = session.kept {
        say_added(args, &session, there, kept)?;
    }
    work(args, &request, &session, jobs)
}

/// Says what was added to a run that was there.
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
    let family = subject.problem().family();
    let size = family.points.len();
    if let Some(dir) = &args.like {
        return begun::like(dir);
    }
    let budget = args.budget.and_then(|budget| budget.0);
    if let Some(dir) = &args.assist {
        let Some(budget) = budget else {
            let reason = "--assist has no effect: every point MDP is evaluated; give a --budget";
            return Err(Refused(reason.to_owned()).into());
        };
        let (known, analysis) = read(dir)?;
        let there = settings_of(&known, &analysis);
        if !args.quiet {
            let here = subject.problem().settings();
            warn_of_settings(&dir.display().to_string(), &there, &here);
        }
        let sampling = args.sampling.unwrap_or(Sampling::BayesianQuadrature);
        if sampling != Sampling::BayesianQuadrature {
            let reason = "--assist has no effect: only --sampling bayesian-quadrature knows scores";
            return Err(Refused(format!("{reason}; leave one of them out")).into());
        }
        let design = Some(design(family, sampling, Some((&known, dir)))?);
        return Ok(Choice::Budget { budget, sampling, design, assisting: Some(there) });
    }
    // Another sampling than that of the folder is another sample.
    let is_same = |b: &&Begun| args.sampling.is_none_or(|s| s == b.identity.sample.sampling);
    if let Some(begun) = begun.filter(is_same) {
        match budget {
            Some(budget) => return begun.with_budget(budget, family),
            None if args.budget.is_none() && args.sampling.is_none() => return begun.choice(),
            None => {}
        }
    }
    // A sample that grows may grow to the whole family.
    Ok(match budget.or(args.until_decided.then_some(size)) {
        Some(budget) => {
            let sampling = args.sampling.unwrap_or(Sampling::DEFAULT);
            Choice::Budget { budget, sampling, design: None, assisting: None }
        }
        None => Choice::All,
    })
}

/// Returns the methods by name; `all` stands for every one that can run there, none for the domain's default and what
/// signals do today.
fn methods(names: &[String], subject: &Subject) -> Vec<String> {
    let named = |wanted: &dyn Fn(&Method) -> bool| {
        let methods = subject.domain().methods().iter();
        methods.filter(|m| wanted(m)).map(|m| m.name.to_owned()).collect()
    };
    match names {
        [] => named(&|m| m.default || subject.today() == Some(m.name)),
        names if names.iter().any(|name| name == ALL) => named(&|m| subject.can_run(m)),
        names => names.to_vec(),
    }
}

/// Refuses what has no effect, whatever is evaluated.
fn check(args: &RunArgs, request: &Request<'_>, draft: &Draft) -> anyhow::Result<()> {
    let refuse = |flag: &str, reason: &str| -> anyhow::Result<()> {
        Err(Refused(format!("{flag} has no effect: {reason}; leave it out")).into())
    };
    if args.sampling.is_some() && matches!(request.choice, Choice::All) {
        return refuse("--sampling", "without a --budget, every point MDP is evaluated");
    }
    if args.sampling.is_some() && request.problem.family().points.len() == 1 {
        return refuse("--sampling", "there is one point MDP only");
    }
    if request.replicates > 1 && draft.replicated.is_empty() {
        return refuse("--replicates", "no method tunes or learns");
    }
    args.workers.check(args.executor)?;
    if args.executor != Executes::Local && args.against.is_some() {
        return refuse("--against", "the report comes later, from `report --against`");
    }
    let learners = request.domain.methods().iter().filter(|m| m.training == Training::Learned);
    let learners: Vec<&str> = learners.map(|m| m.name).collect();
    if args.episodes.is_some() && !draft.methods.iter().any(|m| learners.contains(&m.as_str())) {
        let reason = format!("no method learns; {} do", learners.join(", "));
        return refuse("--episodes", &reason);
    }
    Ok(())
}

/// Does the tasks that are missing, then reports; or hands them over.
fn work(
    args: &RunArgs,
    request: &Request<'_>,
    session: &Session<'_>,
    jobs: usize,
) -> anyhow::Result<u8> {
    let local = LocalRun {
        session,
        domain: request.domain,
        launcher: args.controllers.launcher()?,
        jobs,
        stall_timeout_s: args.workers.stall_timeout,
        memory_per_worker_mb: args.workers.memory_mb(jobs)?,
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

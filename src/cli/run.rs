//! `tsc-family run`: plan, networks, workers, summary.

mod arguments;

pub(super) use arguments::RunArgs;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::available_parallelism;

use anyhow::Context;
use serde_json::json;

use super::build_networks::{default_folder, prepare};
use super::effects::{Use, any};
use super::estimate::{Effort, estimate};
use super::folder::RESULTS;
use super::json::merge;
use super::monitor::Monitor;
use super::output::{line, note};
use super::report::print;
use super::signals::warning_lines;
use super::simulator::simulator;
use crate::cli::exit;
use crate::cli::refused::Refused;
use crate::family::error::FamilyError;
use crate::files::FileError;
use crate::report::{self, ReportData, check_name};
use crate::run::method::Training;
use crate::run::plan::{Draft, Request, complete, draft, establish};
use crate::run::pool::Pool;
use crate::sample::Sampling;
use crate::settings::overrides::Override;
use crate::store::Layout;
use crate::store::lock::{Holder, RunLock};
use crate::store::manifest::{Manifest, Provenance, Task};
use crate::store::results::Results;
use crate::traffic::control::registry::METHODS;
use crate::traffic::family::load::{LoadedScenario, load_with};
use crate::traffic::settings::{DemandSettings, Preset};
use crate::traffic::sim::error::SimError;

/// What stands for all methods.
const ALL: &str = "all";

pub(super) fn run(args: &RunArgs) -> anyhow::Result<u8> {
    let request = Request {
        scenario: scenario(args)?,
        sumocfgs: args.sumocfg.clone(),
        budget: args.budget.0,
        sampling: args.sampling.unwrap_or(Sampling::KMeans),
        methods: methods(&args.methods),
        base_seed: args.seed,
        evaluation_seeds: args.eval_seeds.get(),
        replicates: args.replicates.get(),
    };
    let draft = draft(&request)?;
    if let Some(method) = &args.against {
        check_name(method, &draft.methods)?;
    }
    check(args, &request, &draft)?;
    let processors = available_parallelism().map_or(1, |j| j.get());
    let jobs = args.jobs.map_or(processors, |j| j.get());
    if args.dry_run {
        if args.json {
            for draw in &draft.sample.draws {
                let mut value = json!({"event": "plan", "methods": draft.methods});
                merge(&mut value, draw);
                line(value)?;
            }
        } else {
            line(estimate(&request, &draft, jobs, processors))?;
        }
        if !args.quiet {
            warn(&request)?;
        }
        return Ok(exit::DONE);
    }
    let networks = args
        .networks
        .clone()
        .unwrap_or_else(|| default_folder(&args.scenario.scenario, &request.scenario));
    let name = if args.sumocfg.is_empty() { &request.scenario.scenario.name } else { "imported" };
    let out = args.out.clone().unwrap_or_else(|| Path::new("results").join(name));
    RESULTS.check(&out, "--out", Some(args.force))?;
    let hashes = networks_of(&request, &draft, &networks, args.quiet || args.json)?;
    let signal = &request.scenario.scenario.signal;
    let simulator = simulator(&request.sumocfgs, signal)?;
    let provenance = provenance(&networks);
    let (manifest, tasks) = complete(&request, &draft, &hashes, simulator, provenance)?;
    let layout = Layout::new(&out);
    fs::create_dir_all(&out).map_err(FileError::at("create", &out))?;
    let started = now();
    let holder =
        Holder { pid: std::process::id(), version: env!("CARGO_PKG_VERSION").to_owned(), started };
    let _lock = RunLock::take(&layout, &holder)?;
    let manifest = establish(&layout, manifest, &tasks)?;
    super::places::write(&layout, &request, &draft, &args.scenario.scenario)?;
    clean(&layout, args.retry_failed)?;
    work(args, &request, &draft, &layout, &manifest, &networks, jobs)
}

/// Returns the methods by name; `all` stands for every one.
fn methods(names: &[String]) -> Vec<String> {
    if names.iter().any(|name| name == ALL) {
        return METHODS.iter().map(|m| m.name.to_owned()).collect();
    }
    names.to_vec()
}

/// Refuses what has no effect.
fn check(args: &RunArgs, request: &Request, draft: &Draft) -> anyhow::Result<()> {
    let imported = !args.sumocfg.is_empty();
    let refuse = |flag: &str, reason: &str| -> anyhow::Result<()> {
        Err(Refused(format!("{flag} has no effect: {reason}; leave it out")).into())
    };
    if args.sampling.is_some() && request.budget.is_none() {
        return refuse("--sampling", "without a --budget, every point MDP is evaluated");
    }
    if args.sampling.is_some() && draft.family.points.len() == 1 {
        return refuse("--sampling", "there is one point MDP only");
    }
    if request.replicates > 1 && draft.replicated.is_empty() {
        return refuse("--replicates", "none of the methods tunes or learns");
    }
    if args.episodes.is_some() && !any(&draft.methods, Training::Learned) {
        let learners = METHODS.iter().filter(|m| m.training == Training::Learned);
        let learners: Vec<&str> = learners.map(|m| m.name).collect();
        let reason = format!("none of the methods learns, as {} do", learners.join(", "));
        return refuse("--episodes", &reason);
    }
    if imported && args.networks.is_some() {
        return refuse("--networks", "the SUMO scenarios bring their networks");
    }
    let used = Use {
        family: !imported,
        networks: !imported,
        simulation: true,
        methods: Some(&draft.methods),
        ..Use::BUILD
    };
    used.check(&request.scenario, &args.scenario.settings())?;
    let demand = &request.scenario.scenario.demand;
    let plain = request.scenario.scenario.preset == Preset::default();
    if imported && plain && !args.quiet && *demand != DemandSettings::default() {
        note(
            "the scenario file's [demand] has no effect: the vehicles of SUMO scenarios are their own",
        );
    }
    Ok(())
}

/// Says what may be wrong with the signals of imported scenarios.
fn warn(request: &Request) -> Result<(), SimError> {
    match warning_lines(&request.sumocfgs, &request.scenario.scenario.signal) {
        // A plan needs no SUMO.
        Err(SimError::Unavailable(_)) => {
            note("the signals were not looked at, since SUMO is missing")
        }
        lines => lines?.iter().for_each(|line| note(format!("warning: {line}"))),
    }
    Ok(())
}

/// Loads the scenario with the settings of `--episodes` and `--set`.
fn scenario(args: &RunArgs) -> Result<LoadedScenario, FamilyError> {
    let episodes = args.episodes.map(|n| Override::episodes(n.get()));
    let settings: Vec<Override> =
        episodes.clone().into_iter().chain(args.scenario.settings()).collect();
    let loaded = load_with(&args.scenario.scenario, &settings)?;
    let trained = loaded.scenario.training.episodes;
    match episodes {
        Some(flag) if args.episodes.is_some_and(|n| n.get() != trained) => {
            let message = format!("--set says training.episodes={trained}; give one of the two");
            Err(FamilyError::Override { flag: flag.flag().to_owned(), message })
        }
        _ => Ok(loaded),
    }
}

/// Does the tasks that are missing, then reports.
fn work(
    args: &RunArgs,
    request: &Request,
    draft: &Draft,
    layout: &Layout,
    manifest: &Manifest,
    networks: &Path,
    jobs: usize,
) -> anyhow::Result<u8> {
    let results = Results::load(layout)?;
    let todo: Vec<Task> = results.missing().cloned().collect();
    let pool = Pool {
        layout: layout.clone(),
        manifest: manifest.sha256(),
        program: std::env::current_exe().context("cannot find this program")?,
        networks: networks.to_path_buf(),
        jobs,
    };
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed))?;
    let talk = !args.quiet && !args.json;
    if talk && todo.len() < results.plan.len() {
        note(format!("{} of {} tasks are already done", results.records.len(), results.plan.len()));
    }
    let effort = |t: &Task| Effort::of(request, draft, &t.method, &t.point);
    let mut monitor = Monitor::new(
        todo.iter().map(|t| (t.clone(), effort(t))),
        &manifest.identity.baseline,
        results.records.values(),
        jobs,
        args.json,
        args.quiet,
    );
    let outcome = pool.run(&todo, &interrupted, &mut |event| monitor.handle(event));
    monitor.close();
    outcome?;
    if interrupted.load(Ordering::Relaxed) {
        let left = todo.len() - monitor.finished();
        if !args.quiet {
            note(format!("interrupted with {left} tasks to do; run the same command to continue"));
        }
        return Ok(exit::INTERRUPTED);
    }
    summarise(args, layout)
}

/// Reports the finished run.
fn summarise(args: &RunArgs, layout: &Layout) -> anyhow::Result<u8> {
    let results = Results::load(layout)?;
    let mut reports = vec![ReportData::new(&results)];
    match args.against.as_ref().map(|method| ReportData::against(&results, method)) {
        Some(Ok(data)) => reports.push(data),
        // Tasks failed, so that some results are missing: the run is no less complete for that.
        Some(Err(e)) => note(e),
        None => {}
    }
    for data in &reports {
        if args.quiet {
            report::write_data(layout, data)?;
        } else {
            print(layout, data, args.json, !args.json)?;
        }
    }
    let failed = results.failed().count();
    if failed > 0 {
        if !args.quiet {
            note(format!(
                "{failed} of {} tasks failed; their reasons are in the report, --retry-failed tries \
                 them again",
                results.plan.len()
            ));
        }
        return Ok(exit::SOME_FAILED);
    }
    Ok(exit::DONE)
}

/// Builds the networks of the chosen point MDPs where they are missing, and returns their hashes.
fn networks_of(
    request: &Request,
    draft: &Draft,
    networks: &Path,
    quiet: bool,
) -> anyhow::Result<BTreeMap<String, BTreeMap<String, String>>> {
    if !draft.imported.is_empty() {
        return Ok(BTreeMap::new());
    }
    let chosen: BTreeSet<&str> = draft.sample.draws.iter().map(|d| d.point.as_str()).collect();
    prepare(&request.scenario, &chosen, networks, quiet)
}

fn provenance(networks: &Path) -> Provenance {
    let processors = available_parallelism().map_or(1, std::num::NonZero::get);
    let command: Vec<String> =
        std::iter::once("tsc-family".to_owned()).chain(std::env::args().skip(1)).collect();
    Provenance {
        command: command.join(" "),
        git: env!("TSC_FAMILY_GIT").to_owned(),
        rustc: env!("TSC_FAMILY_RUSTC").to_owned(),
        host: format!(
            "{} {}, {processors} processors",
            std::env::consts::OS,
            std::env::consts::ARCH
        ),
        started: now(),
        networks: networks.display().to_string(),
    }
}

/// Returns the time, ISO 8601, UTC, to the second.
fn now() -> String {
    jiff::Timestamp::now().strftime("%Y-%m-%dT%H:%M:%SZ").to_string()
}

/// Removes what an earlier run that was killed has left behind, and on request failed records.
fn clean(layout: &Layout, retry_failed: bool) -> anyhow::Result<()> {
    let tmp = layout.tmp();
    if tmp.exists() {
        fs::remove_dir_all(&tmp).map_err(FileError::at("remove", &tmp))?;
    }
    if retry_failed {
        let results = Results::load(layout)?;
        let failed: Vec<PathBuf> =
            results.failed().map(|r| layout.record(r.summary.task)).collect();
        for path in failed {
            fs::remove_file(&path).map_err(FileError::at("remove", &path))?;
        }
    }
    Ok(())
}

//! What `run` evaluates: the domain and the problem that its arguments name, and what of them has no effect there.

use crate::cli::exit::without_effect;
use std::path::Path;

use super::folder::NETWORKS;
use super::output::note;
use super::run::arguments::RunArgs;
use super::scenario::DEFAULT_SCENARIO;
use crate::cli::method_arguments::plan_file;
use crate::domains;
use crate::run::domain::{Domain, Problem};
use crate::settings::overrides::Override;
use crate::traffic::city::default_folder;
use crate::traffic::existing::Plans;
use crate::traffic::family::doubts::Doubt;
use crate::traffic::problem::SignalProblem;
use crate::traffic::settings::{DemandSettings, Preset};
use crate::traffic::utdf::read_plans;

pub(super) struct Subject {
    pub(super) domain: &'static dyn Domain,
    pub(super) problem: Box<dyn Problem>,
    /// Whether preparing it builds networks.
    pub(super) builds: bool,
}

impl Subject {
    /// Reads the scenario that the arguments name.
    pub(super) fn new(args: &RunArgs) -> anyhow::Result<Self> {
        args.given.check(!args.sumocfg.is_empty())?;
        let name = &args.scenario.scenario;
        let Some(entry) = args.scenario.entry()? else {
            let problem = signals(args)?;
            let builds = !problem.is_imported();
            return Ok(Self { domain: domains::traffic(), problem: Box::new(problem), builds });
        };
        let reason = "only signals have it";
        without_effect(&[
            ("--sumocfg", !args.sumocfg.is_empty(), reason),
            ("--networks", args.networks.is_some(), reason),
            ("--existing", args.existing.is_some(), reason),
            (
                "--episodes",
                args.episodes.is_some(),
                "its methods have settings of their own for that",
            ),
        ])?;
        args.scenario.say_which();
        let problem = (entry.load)(name, &args.scenario.settings())?;
        Ok(Self { domain: entry.domain, problem, builds: false })
    }
}

/// Reads a scenario of signals, with the plans that were given.
fn signals(args: &RunArgs) -> anyhow::Result<SignalProblem> {
    let name = &args.scenario.scenario;
    let warn = |doubts: &[Doubt]| {
        doubts.iter().for_each(|doubt| note(format!("warning: {}", doubt.brief())));
    };
    let episodes = args.episodes.map(|n| Override::episodes(n.get()));
    let settings: Vec<Override> = args.scenario.settings().into_iter().chain(episodes).collect();
    let mut loaded = args.scenario.signals(&settings)?;
    let side = loaded.scenario.network.driving_side;
    let read = |path: &Path| -> anyhow::Result<Plans> {
        let (plans, doubts) = read_plans(path, side)?;
        warn(&doubts);
        Ok(plans)
    };
    if let Some(path) = &args.existing {
        loaded.plans = Some(read(path)?);
    }
    let plans = args.controllers.plans.iter().map(|given| {
        let (method, path) = plan_file(given)?;
        Ok((method, read(path)?))
    });
    let plans = plans.collect::<anyhow::Result<Vec<_>>>()?;
    let networks = args.networks.clone().unwrap_or_else(|| default_folder(name, &loaded));
    if !args.dry_run && args.sumocfg.is_empty() {
        NETWORKS.check(&networks, "--networks", None)?;
    }
    let path = Path::new(name);
    let folder = if path.is_dir() { Some(path) } else { path.parent().filter(|_| path.is_file()) };
    let (folder, given) = (folder.map(Path::to_path_buf), args.given.given());
    let problem = SignalProblem::new(loaded, folder, networks, &args.sumocfg, &given, &plans)?;
    let scenario = &problem.loaded.scenario;
    for (name, model) in args.controllers.read_models()? {
        // What is wrong with one is said before anything is built.
        model.check(scenario)?;
        if let Some(difference) = model.difference(scenario).filter(|_| !args.quiet) {
            note(format!(
                "warning: {name} was trained with another timing of signals ({difference}; preset {}); --preset and --set \
                 give the run its own",
                model.preset.name()
            ));
        }
    }
    if args.quiet {
        return Ok(problem);
    }
    for (method, placed) in &problem.plans {
        for doubt in placed.doubts.iter().cloned().chain(placed.left_out()) {
            note(format!("warning: {method}: {}", doubt.brief()));
        }
    }
    let has_demand =
        scenario.preset == Preset::default() && scenario.demand != DemandSettings::default();
    if problem.is_imported() && (name != DEFAULT_SCENARIO || has_demand) {
        note(format!(
            "family and [demand] of {name} have no effect: SUMO scenarios have their own point MDPs and vehicles"
        ));
    }
    Ok(problem)
}

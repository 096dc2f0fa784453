//! What `run` evaluates: the domain and the problem that its arguments name, and what of them has no
//! effect there.

use std::path::{Path, PathBuf};

use super::controllers::ControllersArgs;
use super::folder::NETWORKS;
use super::output::note;
use super::run::RunArgs;
use super::scenario::DEFAULT_SCENARIO;
use crate::cli::refused::Refused;
use crate::domains;
use crate::family::FamilyError;
use crate::run::domain::{Domain, Problem};
use crate::run::entry::Entry;
use crate::run::method::Method;
use crate::run::plan::Draft;
use crate::settings::overrides::Override;
use crate::traffic::city::folder::default_folder;
use crate::traffic::control::{coordinated, existing, program};
use crate::traffic::family::doubts::Doubt;
use crate::traffic::family::load::LoadedScenario;
use crate::traffic::method_arguments::plan_file;
use crate::traffic::model::SignalModel;
use crate::traffic::problem::SignalProblem;
use crate::traffic::settings::{DemandSettings, Preset};
use crate::traffic::sim::SimError;
use crate::traffic::utdf::read_plans;

/// Most point MDPs that a message names.
const MOST_NAMED: usize = 6;

/// What is evaluated.
pub(super) enum Subject {
    /// Traffic signals.
    Signals(Box<SignalProblem>),
    /// A problem of another domain.
    Other(&'static Entry, Box<dyn Problem>),
}

impl Subject {
    /// Reads the scenario that the arguments name.
    pub(super) fn new(args: &RunArgs) -> anyhow::Result<Self> {
        args.given.check(!args.sumocfg.is_empty())?;
        let name = &args.scenario.scenario;
        if let Some(entry) = args.scenario.entry()? {
            without_effect(args, entry.domain.name())?;
            args.scenario.say_which();
            let problem = (entry.load)(name, &args.scenario.settings())?;
            return Ok(Self::Other(entry, problem));
        }
        let mut loaded = scenario(args)?;
        let say = |doubts: &[Doubt]| {
            doubts.iter().for_each(|doubt| note(format!("warning: {}", doubt.brief())));
        };
        let side = loaded.scenario.network.driving_side;
        if let Some(path) = &args.existing {
            let (plans, doubts) = read_plans(path, side)?;
            say(&doubts);
            loaded.plans = Some(plans);
        }
        let mut plans = Vec::new();
        for given in &args.controllers.plans {
            let (method, path) = plan_file(given)?;
            if !args.sumocfg.is_empty() {
                return Err(Refused(format!(
                    "--plan-file {method} has no effect: plans are of generated networks, and SUMO scenarios bring theirs; leave \
                     it out"
                ))
                .into());
            }
            let (read, doubts) = read_plans(path, side)?;
            say(&doubts);
            plans.push((method, read));
        }
        let networks = args.networks.clone().unwrap_or_else(|| default_folder(name, &loaded));
        let (folder, given) = (folder(name), args.given.given());
        let problem = SignalProblem::new(loaded, folder, networks, &args.sumocfg, &given, &plans)?;
        if !args.quiet {
            for (method, placed) in &problem.plans {
                for doubt in placed.doubts.iter().cloned().chain(placed.left_out()) {
                    note(format!("warning: {method}: {}", doubt.brief()));
                }
            }
        }
        Ok(Self::Signals(Box::new(problem)))
    }

    /// Returns the method that does what signals do today, where that is known of all of them.
    pub(super) fn today(&self) -> Option<&'static str> {
        let Self::Signals(problem) = self else { return None };
        let all = problem.family().points.iter().map(|point| point.id.as_str()).collect();
        match problem.is_imported() {
            true => Some(program::METHOD.name),
            false => {
                let lacking = problem.without_plan(existing::METHOD.name, &all);
                lacking.is_empty().then_some(existing::METHOD.name)
            }
        }
    }

    /// Whether a method can run on every point MDP, as far as this is known before SUMO reads a network: coordination needs
    /// several signals, and each of two methods needs its kind of today's plan.
    pub(super) fn can_run(&self, method: &Method) -> bool {
        let Self::Signals(problem) = self else { return true };
        let is = |of: &[Method]| of.iter().any(|of| of.name == method.name);
        if is(&[existing::METHOD, program::METHOD]) {
            return self.today() == Some(method.name);
        }
        let mut signals = problem.family().points.iter().map(|point| problem.agents(&point.id));
        !is(&[coordinated::METHOD]) || signals.all(|signals| signals > 1)
    }

    /// The domain.
    pub(super) fn domain(&self) -> &'static dyn Domain {
        match self {
            Self::Signals(_) => domains::traffic(),
            Self::Other(entry, _) => entry.domain,
        }
    }

    /// The problem.
    pub(super) fn problem(&self) -> &dyn Problem {
        match self {
            Self::Signals(problem) => problem.as_ref(),
            Self::Other(_, problem) => problem.as_ref(),
        }
    }

    /// Returns what is to be warned of: saved models that were trained with another timing of signals.
    pub(super) fn models_elsewhere(&self, given: &ControllersArgs) -> anyhow::Result<Vec<String>> {
        let Self::Signals(problem) = self else { return Ok(Vec::new()) };
        let scenario = &problem.loaded.scenario;
        let models = given.read_models()?;
        // What is wrong with one is said before anything is built.
        models.iter().try_for_each(|(_, model)| model.scenario(scenario, &[]).map(drop))?;
        let differs = |(name, model): &(String, SignalModel)| {
            let difference = model.difference(scenario)?;
            let preset = model.preset.name();
            Some(format!(
                "{name} was trained with another timing of signals ({difference}; preset {preset}); --preset and --set give \
                 the run its own"
            ))
        };
        Ok(models.iter().filter_map(differs).collect())
    }

    /// Whether preparing builds something.
    pub(super) fn builds(&self) -> bool {
        matches!(self, Self::Signals(problem) if !problem.is_imported())
    }

    /// Refuses to write into a folder of something else.
    pub(super) fn check_folder(&self) -> anyhow::Result<()> {
        match self {
            Self::Signals(problem) if self.builds() => {
                NETWORKS.check(&problem.networks, "--networks", None)
            }
            _ => Ok(()),
        }
    }

    /// Refuses what has no effect.
    pub(super) fn check(&self, args: &RunArgs, draft: &Draft) -> anyhow::Result<()> {
        let Self::Signals(problem) = self else { return Ok(()) };
        let imported = problem.is_imported();
        has_plans(args, problem, draft)?;
        if imported && args.networks.is_some() {
            let reason =
                "--networks has no effect: the SUMO scenarios bring their networks; leave it out";
            return Err(Refused(reason.to_owned()).into());
        }
        let scenario = &problem.loaded.scenario;
        let named = &args.scenario.scenario;
        if imported && !args.quiet && named != DEFAULT_SCENARIO {
            note(format!(
                "the family of {named} has no effect: the point MDPs are the SUMO scenarios, and only its settings count"
            ));
        }
        let plain = scenario.preset == Preset::default();
        if imported && plain && !args.quiet && scenario.demand != DemandSettings::default() {
            note(
                "the scenario file's [demand] has no effect: SUMO scenarios have their own vehicles",
            );
        }
        Ok(())
    }

    /// Looks at imported scenarios and returns what is to be said of them.
    pub(super) fn examine(&self) -> Result<&[String], SimError> {
        match self {
            Self::Signals(problem) => problem.examine(),
            Self::Other(..) => Ok(&[]),
        }
    }
}

/// Refuses methods that run plans where these are missing.
fn has_plans(args: &RunArgs, problem: &SignalProblem, draft: &Draft) -> Result<(), Refused> {
    let is_today = |name: &str| name == existing::METHOD.name;
    let is_plan = |name: &&String| {
        let given = args.controllers.plans.iter().filter_map(|given| given.split_once('='));
        is_today(name) || given.into_iter().any(|(own, _)| own == name.as_str())
    };
    let family = problem.family();
    let chosen = draft.sample.draws.iter().map(|draw| draw.point.as_str()).collect();
    for method in draft.methods.iter().filter(is_plan) {
        if is_today(method) && problem.is_imported() {
            return Err(Refused(
                "the method existing runs plans that are given; what SUMO scenarios have today is the method program"
                    .to_owned(),
            ));
        }
        let lacking = problem.without_plan(method, &chosen);
        let few = lacking.iter().take(MOST_NAMED).cloned().collect::<Vec<_>>().join(", ");
        let more = if lacking.len() > MOST_NAMED { ", ..." } else { "" };
        if lacking.is_empty() {
            continue;
        }
        if is_today(method) && !problem.plans.contains_key(method) {
            return Err(Refused(format!(
                "no plan was given for the method existing ({} point MDPs); give one with --existing FILE, or \
                 `existing = \"FILE\"` in [family] of the scenario, or leave the method out",
                lacking.len()
            )));
        }
        return Err(Refused(format!(
            "no plan was given, or none that can be shown, for {} of {} point MDPs ({few}{more}), which the method \
             {method} needs; complete the table, leave them out of the sample (--budget, --like), or leave the method out",
            lacking.len(),
            family.points.len().min(chosen.len())
        )));
    }
    Ok(())
}

/// Refuses what has no effect on other domains than traffic signals.
fn without_effect(args: &RunArgs, domain: &str) -> Result<(), Refused> {
    let total = "its methods have settings of their own for that, such as total_steps; give --set";
    let given = [
        (
            !args.sumocfg.is_empty(),
            "--sumocfg",
            "it is not simulated by SUMO; leave out one of the two",
        ),
        (args.networks.is_some(), "--networks", "it has no networks; leave it out"),
        (args.existing.is_some(), "--existing", "it has no signals; leave it out"),
        (args.episodes.is_some(), "--episodes", total),
    ];
    match given.into_iter().find(|(is_given, ..)| *is_given) {
        None => Ok(()),
        Some((_, flag, reason)) => {
            Err(Refused(format!("{flag} has no effect on {domain}: {reason}")))
        }
    }
}

/// Loads the scenario with the settings of `--episodes` and `--set`.
fn scenario(args: &RunArgs) -> anyhow::Result<LoadedScenario> {
    let episodes = args.episodes.map(|n| Override::episodes(n.get()));
    let settings: Vec<Override> =
        episodes.clone().into_iter().chain(args.scenario.settings()).collect();
    let loaded = args.scenario.signals(&settings);
    let loaded = match args.sumocfg.is_empty() {
        true => loaded?,
        false => loaded.map_err(without_scenario)?,
    };
    let trained = loaded.scenario.training.episodes;
    match episodes {
        Some(flag) if args.episodes.is_some_and(|n| n.get() != trained) => {
            let message = format!("--set says training.episodes={trained}; give one of the two");
            Err(FamilyError::Override { flag: flag.flag().to_owned(), message }.into())
        }
        _ => Ok(loaded),
    }
}

/// Names the flags alone where a setting is wrong: the family of the embedded scenario gives way to SUMO scenarios.
fn without_scenario(e: anyhow::Error) -> anyhow::Error {
    match e.downcast::<FamilyError>() {
        Ok(FamilyError::Setting { file, field, value, expected }) => {
            let flags = file.split_once(" (embedded) with ").map(|(_, flags)| flags.to_owned());
            let file = flags.unwrap_or(file);
            FamilyError::Setting { file, field, value, expected }.into()
        }
        Ok(other) => other.into(),
        Err(e) => e,
    }
}

/// Returns the folder of a scenario's file; `None` for one that the program carries.
fn folder(scenario: &str) -> Option<PathBuf> {
    let path = Path::new(scenario);
    if path.is_dir() {
        return Some(path.to_path_buf());
    }
    path.is_file().then(|| path.parent().map_or_else(PathBuf::new, Path::to_path_buf))
}

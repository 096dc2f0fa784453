//! The scenario of a subcommand, and the settings that replace its own.

use crate::cli::exit::{refuse, without_effect};
use std::path::Path;

use clap::ValueEnum;
use clap::builder::PossibleValuesParser;

use crate::cli::output::note;
use crate::domains::{entry_of, others};
use crate::family::FamilyError;
use crate::files::quoted;
use crate::run::entry::Entry;
use crate::settings::overrides::Override;
use crate::suggest::did_you_mean;
use crate::traffic::family::doubts::Doubt;
use crate::traffic::family::load::{
    EMBEDDED, LoadedScenario, Uncounted, load_uncounted, load_with,
};
use crate::traffic::settings::Preset;
use crate::traffic::sim::obstacle::{Accept, Given};
use crate::traffic::sim::sumocfg::seconds;

/// Name of the scenario where none is given.
pub(super) const DEFAULT_SCENARIO: &str = "salt-lake-city";

/// Scenario of a subcommand.
#[derive(Debug, clap::Args)]
pub struct ScenarioArg {
    /// Path of a scenario or of its table, or the name of an embedded one: `salt-lake-city`,
    /// `salt-lake-city-peak`, `smoke`, `cartpole`, `pendulum`, `mountain-car`, `acrobot`,
    /// `pendulum-swing-up`, `quad`, `half-cheetah`, `swimmer`
    #[arg(value_name = "SCENARIO", default_value = DEFAULT_SCENARIO)]
    pub scenario: String,
    /// Setting of the scenario file to replace, such as `demand.horizon_s=600` (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<Override>,
    /// Limits of timing, and demand: `resco` as in the literature, or `field` as on the street; for control tasks
    /// `sb3` or `tuned` [default: the scenario's, else `resco` or `sb3`]
    #[arg(long, value_name = "PRESET", value_parser = presets(), hide_possible_values = true)]
    preset: Option<String>,
}

impl ScenarioArg {
    /// Returns what replaces settings: the preset first, so that a setting counts more.
    pub(super) fn settings(&self) -> Vec<Override> {
        self.preset
            .as_deref()
            .map(Override::preset)
            .into_iter()
            .chain(self.set.iter().cloned())
            .collect()
    }

    /// Has these settings replaced too, unless the command line says otherwise.
    pub(super) fn begin_with(&mut self, settings: impl IntoIterator<Item = Override>) {
        self.set.splice(0..0, settings);
    }

    /// Returns the domain that reads the scenario; `None` for traffic signals.
    pub(super) fn entry(&self) -> Result<Option<&'static Entry>, FamilyError> {
        entry_of(&self.scenario)
    }

    /// Says that the name is that of an embedded scenario where a file or folder has it too.
    pub(super) fn say_which(&self) {
        let name = self.scenario.as_str();
        let embedded = EMBEDDED.iter().map(|(name, _)| *name);
        let mut names = embedded.chain(others().iter().flat_map(|entry| entry.scenarios).copied());
        if Path::new(name).exists() && names.any(|embedded| embedded == name) {
            note(format!(
                "warning: {name} is the embedded scenario, not the {name} that is in this folder; for that one write ./{name}"
            ));
        }
    }

    pub(super) fn signals(&self, settings: &[Override]) -> anyhow::Result<LoadedScenario> {
        self.check_signals()?;
        self.say_which();
        let loaded = load_with(&self.scenario, settings).map_err(with_others)?;
        for doubt in &loaded.doubts {
            note(format!("warning: {}: {}", table_of(&loaded), doubt.brief()));
        }
        if loaded.doubts.iter().any(Doubt::is_long) {
            note(format!(
                "all rows: tsc-family list {} --warnings",
                quoted(Path::new(&self.scenario))
            ));
        }
        Ok(loaded)
    }

    /// Loads a scenario of traffic signals to which turning counts are given.
    pub(super) fn uncounted(&self) -> anyhow::Result<Uncounted> {
        self.check_signals()?;
        Ok(load_uncounted(&self.scenario, &self.settings()).map_err(with_others)?)
    }

    /// Refuses a scenario of another domain.
    fn check_signals(&self) -> anyhow::Result<()> {
        if let Some(entry) = self.entry()? {
            let (scenario, domain) = (&self.scenario, entry.domain.name());
            return refuse(format!(
                "{scenario}: a scenario of {domain} has no signals; `run`, `report` and `list` know it"
            ));
        }
        Ok(())
    }
}

fn table_of(loaded: &LoadedScenario) -> &str {
    let family = &loaded.scenario.family;
    family.approaches.as_deref().or(family.points.as_deref()).unwrap_or(&loaded.scenario.name)
}

/// Returns the names of the presets of all domains.
fn presets() -> PossibleValuesParser {
    let mut names: Vec<&str> =
        Preset::value_variants().iter().map(|preset| preset.name()).collect();
    for preset in others().iter().flat_map(|entry| entry.presets) {
        if !names.contains(preset) {
            names.push(preset);
        }
    }
    PossibleValuesParser::new(names)
}

/// Adds the carried scenarios of the other domains to those that might have been meant.
fn with_others(error: FamilyError) -> FamilyError {
    let FamilyError::UnknownScenario { name, embedded, meant } = error else { return error };
    let others = || others().iter().flat_map(|entry| entry.scenarios).copied();
    let embedded: Vec<&str> = std::iter::once(embedded.as_str()).chain(others()).collect();
    let meant = if meant.is_empty() { did_you_mean(&name, others()) } else { meant };
    FamilyError::UnknownScenario { embedded: embedded.join(", "), name, meant }
}

/// Options on SUMO scenarios of somebody's own.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct SumocfgArgs {
    /// Start of SUMO scenarios, seconds or HH:MM:SS [default: their own]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub begin: Option<f64>,
    /// End of SUMO scenarios, seconds or HH:MM:SS [default: their own]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub end: Option<f64>,
    /// Length of a step of SUMO scenarios, seconds [default: their own]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub step_length: Option<f64>,
    /// Things in SUMO scenarios that are refused without this option
    #[arg(long, value_name = "WHAT,...", value_enum, value_delimiter = ',')]
    pub accept: Vec<Accept>,
}

impl SumocfgArgs {
    /// Returns what is said.
    pub fn given(&self) -> Given {
        Given {
            begin_s: self.begin,
            end_s: self.end,
            step_length_s: self.step_length,
            accept: self.accept.iter().copied().collect(),
        }
    }

    /// Refuses what has no effect where no SUMO scenario is given.
    pub fn check(&self, imported: bool) -> anyhow::Result<()> {
        let has = |is_given: bool| is_given && !imported;
        let reason = "no SUMO configuration is given";
        without_effect(&[
            ("--begin", has(self.begin.is_some()), reason),
            ("--end", has(self.end.is_some()), reason),
            ("--step-length", has(self.step_length.is_some()), reason),
            ("--accept", has(!self.accept.is_empty()), reason),
        ])
    }
}

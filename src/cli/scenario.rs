//! The scenario of a subcommand, and the settings that replace its own.

use crate::settings::overrides::Override;
use crate::traffic::settings::Preset;

/// Presets of all domains.
const PRESETS: [&str; 4] = ["resco", "field", "sb3", "tuned"];

/// Scenario of a subcommand.
#[derive(Debug, clap::Args)]
pub struct ScenarioArg {
    /// Path of a scenario, or the name of an embedded one: `salt-lake-city`,
    /// `salt-lake-city-peak`, `smoke`
    #[arg(value_name = "SCENARIO", default_value = "salt-lake-city")]
    pub scenario: String,
    /// Setting of the scenario file to replace, such as `demand.horizon_s=600` (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<Override>,
    /// Limits of timing and demand: `resco`, the literature's, or `field`, what a cabinet in the street
    /// allows [default: the scenario's, else `resco`]
    #[arg(long, value_name = "PRESET", value_parser = PRESETS, hide_possible_values = true)]
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

    /// Returns the same with a preset where none is given.
    pub(super) fn settings_on(&self, preset: Preset) -> Vec<Override> {
        let preset = self.preset.as_deref().unwrap_or(preset.name());
        std::iter::once(Override::preset(preset)).chain(self.set.iter().cloned()).collect()
    }
}

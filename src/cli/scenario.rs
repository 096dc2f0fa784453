//! The scenario of a subcommand, and the settings that replace its own.

use crate::settings::overrides::Override;
use crate::traffic::settings::Preset;

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
    #[arg(long, value_name = "PRESET", value_enum, hide_possible_values = true)]
    preset: Option<Preset>,
}

impl ScenarioArg {
    /// Returns what replaces settings: the preset first, so that a setting counts more.
    pub(super) fn settings(&self) -> Vec<Override> {
        let preset = self.preset.map(|p| Override::preset(p.name()));
        preset.into_iter().chain(self.set.iter().cloned()).collect()
    }

    /// Returns the same with a preset where none is given.
    pub(super) fn settings_on(&self, preset: Preset) -> Vec<Override> {
        let preset = Override::preset(self.preset.unwrap_or(preset).name());
        std::iter::once(preset).chain(self.set.iter().cloned()).collect()
    }
}

//! Settings of a scenario of carts and poles: the environment, a section per method, a preset under them.

use serde::{Deserialize, Serialize};
use toml::Table;

use super::dynamics::Variant;
use super::environment::CARL_START;
use super::{dqn, ppo};
use crate::family::FamilyError;
use crate::settings::overrides::{Override, overlay};
use crate::settings::setting::{Section, settings};
use crate::settings::{OutOfRange, all_within};

/// Settings that others stand on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// Stable-Baselines3's defaults.
    #[default]
    Sb3,
    /// Those that rl-baselines3-zoo tuned for gymnasium's own cart and pole.
    Tuned,
}

impl Preset {
    /// Returns its settings, as a scenario has them.
    fn text(self) -> &'static str {
        match self {
            Self::Sb3 => "",
            Self::Tuned => include_str!("../../scenarios/presets/cartpole-tuned.toml"),
        }
    }
}

settings! {
    /// Where methods act.
    pub struct Environment, source "CARL 0.2.0 and later" {
        /// Where the context acts: as it does in CARL (`carl-compat`), where the mass of the cart has no effect and
        /// mass and length of the pole have one in its inertia only, or everywhere that physics has it (`physical`).
        dynamics: Variant = Variant::CarlCompat;
        /// Where episodes start: position, velocity, angle (rad) and its velocity are uniform within this of 0;
        /// gymnasium's start within 0.05.
        start: f64 = CARL_START, in 0.0..=0.2;
    }
}

/// A scenario as written in TOML; all settings have defaults, unknown ones are errors.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scenario {
    /// Settings under those of the scenario.
    pub preset: Preset,
    /// Where methods act.
    pub environment: Environment,
    /// Hyper-parameters of `ppo`.
    pub ppo: ppo::Config,
    /// Hyper-parameters of `dqn`.
    pub dqn: dqn::Config,
}

impl Scenario {
    /// Reads a scenario.
    ///
    /// # Arguments
    ///
    /// * `file` — the file named in errors.
    /// * `overrides` — settings that replace the text's.
    ///
    /// # Errors
    ///
    /// [`FamilyError`] when a setting does not exist, has a wrong type or is out of range.
    pub fn read(text: &str, file: &str, overrides: &[Override]) -> Result<Self, FamilyError> {
        let wrong = |message: String| FamilyError::Toml { file: file.to_owned(), message };
        let mut settings: Table =
            text.parse().map_err(|e: toml::de::Error| wrong(e.to_string()))?;
        let mut scenario = on_preset(&settings).map_err(wrong)?;
        for setting in overrides {
            setting.put_into(&mut settings)?;
            scenario = on_preset(&settings).map_err(|message| FamilyError::Override {
                flag: setting.flag().to_owned(),
                message,
            })?;
        }
        scenario.check(file)?;
        Ok(scenario)
    }

    /// Checks the ranges of numbers.
    ///
    /// # Errors
    ///
    /// [`FamilyError::Setting`] naming file and setting.
    pub fn check(&self, file: &str) -> Result<(), FamilyError> {
        all_within(&self.sections()).map_err(|OutOfRange { field, value, expected }| {
            FamilyError::Setting { file: file.to_owned(), field, value, expected }
        })
    }

    /// Returns its sections by name.
    pub fn sections(&self) -> [(&'static str, &dyn Section); 3] {
        [("environment", &self.environment), ("ppo", &self.ppo), ("dqn", &self.dqn)]
    }
}

/// Returns the scenario of settings that stand on their preset.
fn on_preset(settings: &Table) -> Result<Scenario, String> {
    #[derive(Deserialize)]
    #[serde(default)]
    #[derive(Default)]
    struct Named {
        preset: Preset,
    }
    let message = |e: toml::de::Error| e.message().to_owned();
    let named: Named = settings.clone().try_into().map_err(message)?;
    let mut all: Table = named.preset.text().parse().expect("a preset is TOML");
    overlay(&mut all, settings.clone());
    all.try_into().map_err(message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rl::sb3::Schedule;

    fn read(text: &str, settings: &[&str]) -> Result<Scenario, String> {
        let overrides: Vec<Override> = settings.iter().map(|s| s.parse().unwrap()).collect();
        Scenario::read(text, "a.toml", &overrides).map_err(|e| e.to_string())
    }

    #[test]
    fn an_empty_scenario_is_carl_s_environment_with_stable_baselines3_s_defaults() {
        let scenario = read("", &[]).unwrap();
        assert_eq!(scenario, Scenario::default());
        assert_eq!(scenario.environment.dynamics, Variant::CarlCompat);
        assert_eq!((scenario.environment.start, scenario.ppo.num_steps), (0.1, 2048));
    }

    #[test]
    fn a_preset_stands_under_what_is_named() {
        for (text, settings) in [
            ("preset = \"tuned\"\n[ppo]\nnum_steps = 64", &[][..]),
            ("[ppo]\nnum_steps = 64", &["preset=tuned"][..]),
            ("", &["preset=tuned", "ppo.num_steps=64"][..]),
        ] {
            let scenario = read(text, settings).unwrap();
            assert_eq!((scenario.ppo.num_steps, scenario.ppo.environments), (64, 8));
            assert_eq!(scenario.ppo.clip_range_schedule, Schedule::Linear);
            assert_eq!((scenario.dqn.hidden, scenario.dqn.max_grad_norm), (256, 10.0));
        }
    }

    #[test]
    fn what_does_not_exist_or_is_out_of_range_is_named() {
        let e = read("[ppo]\nnum_step = 64", &[]).unwrap_err();
        assert!(e.starts_with("a.toml: ") && e.contains("num_step"), "{e}");
        let e = read("", &["ppo.num_steps=0"]).unwrap_err();
        assert!(e.contains("a.toml") && e.contains("ppo.num_steps"), "{e}");
        assert!(e.contains("expected a number from 1 to 1000000"), "{e}");
        let e = read("", &["environment.dynamics=moon"]).unwrap_err();
        assert!(e.contains("--set environment.dynamics=moon") && e.contains("physical"), "{e}");
        assert!(read("", &["preset=best"]).unwrap_err().contains("--set preset=best"));
        assert!(read("environment = 1", &[]).is_err());
    }
}

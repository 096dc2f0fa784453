//! Settings of a scenario of carts and poles: the environment, a section per method, a preset under them.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};
use toml::Table;

use super::dynamics::Variant;
use super::environment::CARL_START;
use super::family::NAME;
use super::{dqn, ppo};
use evaluation::family::FamilyError;
use evaluation::run::selection::training_settings;
use evaluation::settings::default_name::{self, name_of};
use evaluation::settings::named::{Named, names_of};
use evaluation::settings::overrides::{Override, overlay};
use evaluation::settings::setting::{Section, settings};
use evaluation::settings::wording::{explain, file_error};
use evaluation::settings::{OutOfRange, all_within};

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
    /// Names of all.
    pub const NAMES: [&str; 2] = ["sb3", "tuned"];

    /// Returns its settings, as a scenario has them.
    fn text(self) -> &'static str {
        match self {
            Self::Sb3 => "",
            Self::Tuned => include_str!("../../../../scenarios/presets/cartpole-tuned.toml"),
        }
    }
}

settings! {
    /// Where methods act.
    pub struct Environment, source "CARL 0.2.0 and later" {
        /// Which features act: with `carl-compat`, as in CARL, the mass of the cart has no effect, and mass and length
        /// of the pole act in its inertia only; with `physical` all features act.
        dynamics: Variant = Variant::CarlCompat;
        /// Start of episodes: position, velocity, angle (rad) and angular velocity are uniform within this of 0.
        /// Gymnasium has 0.05.
        start: f64 = CARL_START, in 0.0..=0.2;
    }
}

training_settings! {
    {
        /// Which policy of a training is evaluated. A row of training is 2,000 steps.
        pub struct TrainingSettings, source "our choice"
    }
}

/// Where the point MDPs come from.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FamilySettings {
    /// Table of point MDPs, relative to the scenario file; CARL's 576 without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<String>,
}

/// A scenario as written in TOML; all settings have defaults, unknown ones are errors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scenario {
    /// Always `cartpole`: which domain reads the file.
    pub domain: String,
    /// Name of the family, also the default results directory. By default that of the file.
    pub name: String,
    /// One sentence for people.
    pub title: String,
    /// Settings under those of the scenario.
    pub preset: Preset,
    /// Where the point MDPs come from.
    pub family: FamilySettings,
    /// Where methods act.
    pub environment: Environment,
    /// Which policy of a training is evaluated.
    pub training: TrainingSettings,
    /// Hyper-parameters of `ppo`.
    pub ppo: ppo::Config,
    /// Hyper-parameters of `dqn`.
    pub dqn: dqn::Config,
}

static NAMES: LazyLock<Vec<String>> = LazyLock::new(|| {
    let points = Some(String::new());
    let whole = Scenario { family: FamilySettings { points }, ..Scenario::default() };
    names_of(&Table::try_from(whole).expect("a scenario is plain data"))
});

impl Named for Scenario {
    fn names() -> &'static [String] {
        &NAMES
    }
}

impl Default for Scenario {
    fn default() -> Self {
        Self {
            domain: NAME.to_owned(),
            name: NAME.to_owned(),
            title: String::new(),
            preset: Preset::default(),
            family: FamilySettings::default(),
            environment: Environment::default(),
            training: TrainingSettings::default(),
            ppo: ppo::Config::default(),
            dqn: dqn::Config::default(),
        }
    }
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
        toml::from_str::<Self>(text).map_err(|e| file_error::<Self>(file, text, &e))?;
        let mut settings: Table = text.parse().expect("it has been read");
        settings.entry("name").or_insert_with(|| name_of(file).into());
        let mut scenario = on_preset(&settings).map_err(wrong)?;
        for setting in overrides {
            setting.apply(&scenario)?;
            // A preset has to stand under what the file says, not over it.
            setting.put_into(&mut settings)?;
            scenario = on_preset(&settings).map_err(wrong)?;
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
        let wrong = |field: &str, value: &str, expected: &str| {
            Err(FamilyError::Setting {
                file: file.to_owned(),
                field: field.to_owned(),
                value: format!("{value:?}"),
                expected: expected.to_owned(),
            })
        };
        if self.domain != NAME {
            return wrong("domain", &self.domain, "expected \"cartpole\"");
        }
        if let Err(expected) = default_name::check(&self.name) {
            return wrong("name", &self.name, expected);
        }
        all_within(&self.sections()).map_err(|OutOfRange { field, value, expected }| {
            FamilyError::Setting { file: file.to_owned(), field, value, expected }
        })
    }

    /// Returns its sections by name.
    pub fn sections(&self) -> [(&'static str, &dyn Section); 4] {
        [
            ("environment", &self.environment),
            ("training", &self.training),
            ("ppo", &self.ppo),
            ("dqn", &self.dqn),
        ]
    }
}

/// Returns the scenario of settings that stand on their preset.
fn on_preset(settings: &Table) -> Result<Scenario, String> {
    #[derive(Default, Deserialize)]
    #[serde(default)]
    struct OnPreset {
        preset: Preset,
    }
    let message = |e: toml::de::Error| explain::<Scenario>(e.message(), "");
    let named: OnPreset = settings.clone().try_into().map_err(message)?;
    let mut all: Table = named.preset.text().parse().expect("a preset is TOML");
    overlay(&mut all, settings.clone());
    all.try_into().map_err(message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use learners::rl::sb3::Schedule;

    fn read(text: &str, settings: &[&str]) -> Result<Scenario, String> {
        let overrides: Vec<Override> = settings.iter().map(|s| s.parse().unwrap()).collect();
        Scenario::read(text, "a.toml", &overrides).map_err(|e| e.to_string())
    }

    #[test]
    fn an_empty_scenario_is_carl_s_environment_with_stable_baselines3_s_defaults() {
        let scenario = read("", &[]).unwrap();
        assert_eq!(scenario, Scenario { name: "a".to_owned(), ..Scenario::default() });
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
        let said = |text, settings: &[&str]| read(text, settings).unwrap_err();
        insta::assert_snapshot!(
            [
                said("[ppo]\nnum_step = 64", &[]),
                said("[ppo]\nnum_steps = \"many\"", &[]),
                said("", &["ppo.num_steps=0"]),
                said("", &["ppo.num_step=0"]),
                said("", &["environment.dynamics=moon"]),
                said("", &["preset=best"]),
                said("environment = 1", &[]),
                said("name = \"a b\"", &[]),
                said("domain = \"swimmer\"", &[]),
            ]
            .join("\n"),
            @r#"
        a.toml, line 2: unknown setting ppo.num_step; did you mean ppo.num_steps?
        a.toml, line 2: ppo.num_steps: expected a whole number that is not negative, found the text "many"
        a.toml: ppo.num_steps = 0: expected a number from 1 to 1000000
        --set ppo.num_step=0: unknown setting ppo.num_step; did you mean ppo.num_steps?
        --set environment.dynamics=moon: moon is not one of its values carl-compat, physical
        --set preset=best: best is not one of its values sb3, tuned
        a.toml, line 1: environment: expected a table, found 1
        a.toml: name = "a b": expected letters, digits, `-` and `_`
        a.toml: domain = "swimmer": expected "cartpole"
        "#
        );
    }
}

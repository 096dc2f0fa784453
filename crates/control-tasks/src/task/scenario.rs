//! Settings of a scenario: the environment, a section per method, a preset under them.

use serde::{Deserialize, Serialize};
use toml::Table;

use crate::methods::Begin;
use crate::task::Task;
use evaluation::family::FamilyError;
use evaluation::run::selection::training_settings;
use evaluation::settings::all_within;
use evaluation::settings::default_name::{self, name_of};
use evaluation::settings::named::Named;
use evaluation::settings::overrides::{Override, overlay};
use evaluation::settings::setting::Section;
use evaluation::settings::wording::{explain, file_error};
use learners::rl::environment::Environment;

/// Settings that others stand on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// Stable-Baselines3's defaults.
    #[default]
    Sb3,
    /// Those that rl-baselines3-zoo tuned for gymnasium's own environment.
    Tuned,
}

impl Preset {
    /// Names of all.
    pub const NAMES: [&str; 2] = ["sb3", "tuned"];
}

training_settings! {
    {
        /// Which policy of a training is evaluated. A row of training is a fiftieth of its steps, but 2,000 steps at most
        /// and one update at least.
        pub struct TrainingSettings, source "our choice"
    }
}

/// Where the point MDPs come from.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FamilySettings {
    /// Table of point MDPs, relative to the scenario file; the task's own without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<String>,
}

/// A scenario as written in TOML; all settings have defaults, unknown ones are errors. The macro `scenario!` makes one.
pub trait Settings: Named + Default + Clone + std::fmt::Debug + Send + Sync + 'static {
    /// Its task.
    type Task: Task<Scenario = Self>;

    /// Returns its domain, which says which task reads the file; the name of its family, also the default results
    /// directory; and where the point MDPs come from.
    fn head(&self) -> (&str, &str, &FamilySettings);

    /// Returns its sections by name.
    fn sections(&self) -> Vec<(&'static str, &dyn Section)>;

    /// The methods of the task.
    const METHODS: &'static [evaluation::run::method::Method];

    /// Returns how trainings of a method begin; `None` where there is none of this name.
    fn begin<E: Environment + Clone + 'static>(
        &self,
        method: &str,
        environment: E,
    ) -> Option<Box<Begin>>;

    /// Returns the steps of a training.
    fn total_steps(&self, method: &str) -> Option<u64>;

    /// Returns products and sums per step in relation to those of the method's defaults on CartPole, for so many numbers of
    /// an observation and an action.
    fn work(&self, method: &str, numbers: usize) -> Option<f64>;

    /// Reads a scenario; errors name `file`, and `overrides` replace settings of the text.
    /// Fails with [`FamilyError`] when a setting does not exist, has a wrong type or is out of range.
    fn read(text: &str, file: &str, overrides: &[Override]) -> Result<Self, FamilyError> {
        let wrong = |message: String| FamilyError::Toml { file: file.to_owned(), message };
        toml::from_str::<Self>(text).map_err(|e| file_error::<Self>(file, text, &e))?;
        let mut settings: Table = text.parse().expect("it has been read");
        settings.entry("name").or_insert_with(|| name_of(file).into());
        let mut scenario: Self = on_preset(&settings).map_err(wrong)?;
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
    /// Fails with [`FamilyError::Setting`] naming file and setting.
    fn check(&self, file: &str) -> Result<(), FamilyError> {
        let wrong = |field: &str, value: &str, expected: &str| {
            Err(FamilyError::Setting {
                file: file.to_owned(),
                field: field.to_owned(),
                value: format!("{value:?}"),
                expected: expected.to_owned(),
            })
        };
        let (domain, name, _) = self.head();
        if domain != Self::Task::NAME {
            return wrong("domain", domain, &format!("expected {:?}", Self::Task::NAME));
        }
        if let Err(expected) = default_name::check(name) {
            return wrong("name", name, expected);
        }
        all_within(file, &self.sections())
    }
}

/// Returns the scenario of settings that stand on their preset.
fn on_preset<S: Settings>(settings: &Table) -> Result<S, String> {
    let message = |e: toml::de::Error| explain::<S>(e.message(), "");
    let preset = settings.get("preset").cloned();
    let preset = preset.map_or(Ok(Preset::default()), toml::Value::try_into);
    let text = match preset.map_err(message)? {
        Preset::Sb3 => "",
        Preset::Tuned => S::Task::TUNED,
    };
    let mut all: Table = text.parse().expect("a preset is TOML");
    overlay(&mut all, settings.clone());
    all.try_into().map_err(message)
}

/// Makes the scenario of a task, with a section per method: modules of [`crate::methods`].
macro_rules! scenario {
    ($(#[$doc:meta])* task: $task:ident, environment: $environment:ty, methods: { $($method:ident),* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, Default)]
        pub struct $task;

        /// A scenario as written in TOML; all settings have defaults, unknown ones are errors.
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct Scenario {
            /// The name of the task: which domain reads the file.
            pub domain: String,
            /// Name of the family, also the default results directory. By default that of the file.
            pub name: String,
            /// One sentence for people.
            pub title: String,
            /// Settings under those of the scenario.
            pub preset: $crate::task::scenario::Preset,
            /// Where the point MDPs come from.
            pub family: $crate::task::scenario::FamilySettings,
            /// Where methods act.
            pub environment: $environment,
            /// Which policy of a training is evaluated.
            pub training: $crate::task::scenario::TrainingSettings,
            $(
                /// Hyper-parameters of the method of this name.
                pub $method: $method::Config,
            )*
        }

        impl Default for Scenario {
            fn default() -> Self {
                let name = <$task as $crate::task::Task>::NAME;
                Self {
                    domain: name.to_owned(),
                    name: name.to_owned(),
                    title: String::new(),
                    preset: Default::default(),
                    family: Default::default(),
                    environment: Default::default(),
                    training: Default::default(),
                    $($method: Default::default(),)*
                }
            }
        }

        impl evaluation::settings::named::Named for Scenario {
            fn names() -> &'static [String] {
                static NAMES: std::sync::LazyLock<Vec<String>> = std::sync::LazyLock::new(|| {
                    let family = $crate::task::scenario::FamilySettings { points: Some(String::new()) };
                    let whole = Scenario { family, ..Scenario::default() };
                    let table = toml::Table::try_from(whole).expect("a scenario is plain data");
                    evaluation::settings::named::names_of(&table)
                });
                &NAMES
            }
        }

        impl $crate::task::scenario::Settings for Scenario {
            type Task = $task;

            fn head(&self) -> (&str, &str, &$crate::task::scenario::FamilySettings) {
                (&self.domain, &self.name, &self.family)
            }

            fn sections(&self) -> Vec<(&'static str, &dyn evaluation::settings::setting::Section)> {
                vec![
                    ("environment", &self.environment),
                    ("training", &self.training),
                    $((stringify!($method), &self.$method),)*
                ]
            }

            const METHODS: &'static [evaluation::run::method::Method] = &[$($method::METHOD),*];

            fn begin<E: learners::rl::environment::Environment + Clone + 'static>(
                &self,
                method: &str,
                environment: E,
            ) -> Option<Box<$crate::methods::Begin>> {
                $(if method == $method::METHOD.name {
                    let config = self.$method.clone();
                    return Some(Box::new(move |seed| {
                        Box::new($method::Algorithm::new(config.clone(), environment.clone(), seed))
                    }));
                })*
                None
            }

            fn total_steps(&self, method: &str) -> Option<u64> {
                $(if method == $method::METHOD.name {
                    return Some(self.$method.total_steps);
                })*
                None
            }

            fn work(&self, method: &str, numbers: usize) -> Option<f64> {
                $(if method == $method::METHOD.name {
                    let usual = ($method::WORK)(&$method::Config::default(), 4 + 2);
                    return Some(($method::WORK)(&self.$method, numbers) / usual);
                })*
                None
            }
        }
    };
}

pub(crate) use scenario;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cartpole::{Scenario, Variant};
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

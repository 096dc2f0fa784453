//! Settings from the command line, which replace those of a scenario file.

use std::str::FromStr;

use toml::{Table, Value};

use super::scenario::{Preset, Scenario};
use crate::error::FamilyError;

/// Rust's words in messages of the deserialiser, and what a user calls them.
const WORDS: [(&str, &str); 8] = [
    ("unknown field", "unknown setting"),
    ("unknown variant", "unknown value"),
    ("invalid type: map", "invalid type: table"),
    ("expected f32", "expected a number"),
    ("expected f64", "expected a number"),
    ("expected u32", "expected a whole number that is not negative"),
    ("expected usize", "expected a whole number that is not negative"),
    ("expected a boolean", "expected true or false"),
];

/// A setting by its dotted name, such as `demand.horizon_s`, and its new value.
#[derive(Debug, Clone, PartialEq)]
pub struct Override {
    flag: String,
    path: Vec<String>,
    value: Value,
}

impl Override {
    /// Returns how long learners are trained, as `--episodes` says it.
    pub fn episodes(episodes: u32) -> Self {
        Self {
            flag: format!("--episodes {episodes}"),
            path: vec!["training".to_owned(), "episodes".to_owned()],
            value: Value::Integer(episodes.into()),
        }
    }

    /// Returns a preset, as `--preset` says it.
    pub fn preset(preset: Preset) -> Self {
        Self {
            flag: format!("--preset {}", preset.name()),
            path: vec!["preset".to_owned()],
            value: Value::String(preset.name().to_owned()),
        }
    }

    /// What the user wrote.
    pub fn flag(&self) -> &str {
        &self.flag
    }

    /// Returns a scenario with the setting replaced; the ranges of numbers are not checked here.
    ///
    /// # Errors
    ///
    /// [`FamilyError::Override`] for a setting that does not exist or a value of a wrong type.
    pub fn apply(&self, scenario: &Scenario) -> Result<Scenario, FamilyError> {
        // All defaults are written out, so that a part of a table can be replaced as well.
        let mut settings = Table::try_from(scenario).expect("a scenario is plain data");
        self.put_into(&mut settings)?;
        settings.try_into().map_err(|e: toml::de::Error| self.wrong(readable(e.message())))
    }

    /// Puts the setting into the text of a scenario, where it need not be right yet.
    ///
    /// # Errors
    ///
    /// [`FamilyError::Override`] where a table is expected and a value stands.
    pub fn put_into(&self, settings: &mut Table) -> Result<(), FamilyError> {
        let mut table = settings;
        let (last, above) = self.path.split_last().expect("a name has at least one part");
        for (depth, part) in above.iter().enumerate() {
            let entry = table.entry(part).or_insert_with(|| Value::Table(Table::new()));
            let Value::Table(inner) = entry else {
                let name = self.path[..=depth].join(".");
                return Err(self.wrong(format!("{name} is one value and has no settings")));
            };
            table = inner;
        }
        put(table, last, self.value.clone());
        Ok(())
    }

    fn wrong(&self, message: String) -> FamilyError {
        FamilyError::Override { flag: self.flag.clone(), message }
    }
}

impl FromStr for Override {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (key, value) = text
            .split_once('=')
            .ok_or("expected KEY=VALUE, such as demand.horizon_s=600".to_owned())?;
        let path: Vec<String> = key.split('.').map(|part| part.trim().to_owned()).collect();
        if path.iter().any(String::is_empty) {
            return Err("the key before `=` has an empty part; expected one such as \
                        demand.horizon_s"
                .to_owned());
        }
        let value = value.trim();
        let value = value.parse().unwrap_or_else(|_| Value::String(value.to_owned()));
        Ok(Self { flag: format!("--set {text}"), path, value })
    }
}

/// Puts the settings of a table over those of another.
pub fn overlay(settings: &mut Table, over: Table) {
    for (key, value) in over {
        put(settings, &key, value);
    }
}

/// Puts a value into a table; of a table, the settings that it names.
fn put(table: &mut Table, key: &str, value: Value) {
    match (table.get_mut(key), value) {
        (Some(Value::Table(old)), Value::Table(new)) => overlay(old, new),
        (_, value) => {
            table.insert(key.to_owned(), value);
        }
    }
}

/// Returns a message of the deserialiser in a user's words.
pub fn readable(message: &str) -> String {
    let message =
        WORDS.iter().fold(message.trim().to_owned(), |text, (from, to)| text.replace(from, to));
    match message.split_once("expected struct ") {
        Some((before, _)) => format!("{before}expected a table"),
        None => message,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scenario() -> Scenario {
        toml::from_str("name = \"x\"\nfamily.points = \"p.csv\"\nbaseline.green_s = 30").unwrap()
    }

    fn applied(text: &str) -> Scenario {
        text.parse::<Override>().unwrap().apply(&scenario()).unwrap()
    }

    fn refused(text: &str) -> String {
        text.parse::<Override>().unwrap().apply(&scenario()).unwrap_err().to_string()
    }

    #[test]
    fn a_setting_that_stays_the_same_changes_nothing() {
        assert_eq!(applied("baseline.green_s=30.0"), scenario());
        assert_eq!(applied("training={}"), scenario());
    }

    #[test]
    fn every_kind_of_value_can_be_given() {
        assert_eq!(applied("idqn.learning_rate=5e-4").idqn.learning_rate, 5e-4);
        assert_eq!(applied("demand.horizon_s = 600").demand.horizon_s, 600.0);
        assert_eq!(applied("training.episodes=7").training.episodes, 7);
        assert!(applied("ippo.evaluate_mode=true").ippo.evaluate_mode);
        assert_eq!(applied("title=one = two").title, "one = two");
        assert_eq!(applied("title=").title, "");
        assert_eq!(applied("family.approaches=\"a.csv\"").family.approaches.unwrap(), "a.csv");
        let program = applied("baseline.program=equal-split").baseline.program;
        assert_eq!(program, crate::family::scenario::BaselineProgram::EqualSplit);
    }

    #[test]
    fn a_part_of_a_table_leaves_its_other_settings() {
        for text in ["demand.turn_shares={left=0.3}", "demand.turn_shares.left=0.3"] {
            let shares = applied(text).demand.turn_shares;
            assert_eq!((shares.left, shares.through), (0.3, 0.8), "{text}");
        }
        assert_eq!(applied("family.bins.lanes=2").family.bins.speed_mph, 5.0);
    }

    #[test]
    fn an_unknown_setting_says_which_there_are() {
        assert_eq!(
            refused("demand.horizon=600"),
            "--set demand.horizon=600: unknown setting `horizon`, expected one of `horizon_s`, \
             `turn_shares`, `peak_hour_factor`, `approach_spread`"
        );
        let e = refused("learning_rate=1");
        assert!(e.contains("unknown setting `learning_rate`, expected one of `name`"), "{e}");
        let e = refused("dqn.learning_rate=1");
        assert!(e.contains("unknown setting `dqn`, expected one of `name`"), "{e}");
    }

    #[test]
    fn a_value_of_a_wrong_type_says_what_is_expected() {
        let cases = [
            ("demand.horizon_s=soon", "invalid type: string \"soon\", expected a number"),
            (
                "training.episodes=1.5",
                "invalid type: floating point `1.5`, expected a whole number that is not negative",
            ),
            (
                "idqn.batch_size=-3",
                "invalid value: integer `-3`, expected a whole number that is not negative",
            ),
            ("ippo.evaluate_mode=1", "invalid type: integer `1`, expected true or false"),
            ("demand=3", "invalid type: integer `3`, expected a table"),
            ("name={a=1}", "invalid type: table, expected a string"),
            ("demand.horizon_s.x=3", "demand.horizon_s is one value and has no settings"),
            (
                "baseline.program=own",
                "unknown value `own`, expected one of `auto`, `netconvert`, `equal-split`",
            ),
        ];
        for (text, expected) in cases {
            assert_eq!(refused(text), format!("--set {text}: {expected}"));
        }
    }

    #[test]
    fn a_text_without_name_or_value_is_refused() {
        for (text, expected) in [
            ("demand.horizon_s", "expected KEY=VALUE"),
            ("=3", "empty part"),
            ("demand.=3", "empty part"),
            ("demand..horizon_s=3", "empty part"),
        ] {
            let e = text.parse::<Override>().unwrap_err();
            assert!(e.contains(expected), "{text}: {e}");
        }
    }
}

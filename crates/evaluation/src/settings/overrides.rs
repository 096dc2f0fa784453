//! Settings from the command line, which replace those of a scenario file.

use std::str::FromStr;

use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use super::named::{Named, names_of};
use super::setting::Section;
use super::wording::explain;
use crate::family::error::FamilyError;

/// Most parts of a dotted name; settings have three.
const MOST_PARTS: usize = 16;

/// A setting by its dotted name, such as `demand.horizon_s`, and its new value.
#[derive(Debug, Clone, PartialEq)]
pub struct Override {
    flag: String,
    path: Vec<String>,
    value: Value,
}

/// Returns the value of a number among settings, by its section and name.
///
/// # Panics
///
/// Where there is none; a domain looks up names that it has declared.
pub fn number(sections: &[(&str, &dyn Section)], setting: &str) -> f64 {
    let value = |(section, settings): &(&str, &dyn Section)| {
        let name = setting.strip_prefix(section)?.strip_prefix('.')?;
        Some(settings.ranges().iter().find(|range| range.name == name)?.value)
    };
    sections.iter().find_map(value).expect("a setting that the domain has declared")
}

/// Returns settings with other numbers, by section and name.
///
/// # Panics
///
/// Where one is no value of its setting; a domain has declared both.
pub fn with_numbers<'a, S: Serialize + DeserializeOwned>(
    settings: &S,
    numbers: impl IntoIterator<Item = (&'a str, f64)>,
) -> S {
    let mut other = serde_json::to_value(settings).expect("settings are plain data");
    for (setting, value) in numbers {
        let (section, name) = setting.split_once('.').unwrap_or_default();
        other[section][name] = value.to_string().parse().expect("a number");
    }
    serde_json::from_value(other).expect("values that the domain has declared")
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
    pub fn preset(name: &str) -> Self {
        Self {
            flag: format!("--preset {name}"),
            path: vec!["preset".to_owned()],
            value: Value::String(name.to_owned()),
        }
    }

    /// What the user wrote.
    pub fn flag(&self) -> &str {
        &self.flag
    }

    /// Returns settings with this one replaced; the ranges of numbers are not checked here.
    ///
    /// # Errors
    ///
    /// [`FamilyError::Override`] for a setting that does not exist or a value of a wrong type.
    pub fn apply<S: Named>(&self, settings: &S) -> Result<S, FamilyError> {
        // All defaults are written out, so that a part of a table can be replaced as well.
        let mut settings = Table::try_from(settings).expect("settings are plain data");
        self.put_into(&mut settings)?;
        let key = self.path.join(".");
        settings.try_into().map_err(|e: toml::de::Error| self.wrong(reason::<S>(e.message(), &key)))
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

    /// Returns the dotted names of what it sets: of a table, those of the settings in it.
    pub fn keys(&self) -> Vec<String> {
        names_of(&Table::from_iter([(self.path.join("."), self.value.clone())]))
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
        if path.len() > MOST_PARTS {
            return Err(format!("the key before `=` has more than {MOST_PARTS} parts"));
        }
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

/// Returns what is wrong with a setting; its name is in front of the message already.
fn reason<S: Named>(message: &str, key: &str) -> String {
    let text = explain::<S>(message, key);
    text.strip_prefix(&format!("{key}: ")).map_or_else(|| text.clone(), str::to_owned)
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

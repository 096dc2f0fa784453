//! What is wrong with a setting, in the words of the one who wrote it: the deserialiser's messages
//! name its own types, and list all names where one was meant.

use toml::de::{DeTable, DeValue, Error};

use super::named::Named;
use crate::family::error::FamilyError;
use basics::suggest::{did_you_mean, similar_settings};

/// The deserialiser's types, and what a user calls them.
const TYPES: [(&str, &str); 9] = [
    ("f32", "a number"),
    ("f64", "a number"),
    ("u32", "a whole number from 0 to 4294967295"),
    ("u64", "a whole number that is not negative"),
    ("usize", "a whole number that is not negative"),
    ("i64", "a whole number"),
    ("a boolean", "true or false"),
    ("a string", "a text"),
    ("a map", "a table"),
];

/// What the deserialiser found, and what a user calls it.
const FOUND: [(&str, &str); 6] = [
    ("string ", "the text "),
    ("integer ", ""),
    ("floating point ", ""),
    ("boolean ", ""),
    ("map", "a table"),
    ("sequence", "a list"),
];

/// Returns the error for a file of settings that cannot be read, with line, setting and plain words.
pub fn file_error<S: Named>(file: &str, text: &str, error: &Error) -> FamilyError {
    let start = error.span().map_or(0, |span| span.start.min(text.len()));
    let line = 1 + text.as_bytes()[..start].iter().filter(|b| **b == b'\n').count();
    let key = DeTable::parse(text).ok().and_then(|table| key_at(table.get_ref(), start));
    let key = key.unwrap_or_default();
    let message = explain::<S>(error.message(), &key.join("."));
    FamilyError::Toml { file: format!("{file}, line {line}"), message }
}

/// Returns the dotted name of the setting whose name or value is at a place.
fn key_at(table: &DeTable<'_>, at: usize) -> Option<Vec<String>> {
    table.iter().find_map(|(key, value)| {
        let own = || vec![key.get_ref().to_string()];
        let inner = match value.get_ref() {
            DeValue::Table(inner) => key_at(inner, at),
            _ => value.span().contains(&at).then(Vec::new),
        };
        match inner {
            Some(inner) => Some(own().into_iter().chain(inner).collect()),
            None => key.span().contains(&at).then(own),
        }
    })
}

/// Returns a message of the deserialiser in a user's words.
///
/// # Arguments
///
/// * `key`: dotted name of the setting that it is about, empty where that is not known.
pub fn explain<S: Named>(message: &str, key: &str) -> String {
    let message = message.trim();
    let about = |text: String| if key.is_empty() { text } else { format!("{key}: {text}") };
    if let Some(rest) = message.strip_prefix("unknown field `") {
        let (name, others) = rest.split_once('`').unwrap_or((rest, ""));
        return unknown::<S>(key, name, others);
    }
    if let Some(rest) = message.strip_prefix("unknown variant `") {
        let (value, others) = rest.split_once('`').unwrap_or((rest, ""));
        let values = quoted(others);
        let meant = did_you_mean(value, values.iter().copied());
        return about(format!("{value} is not one of its values {}{meant}", values.join(", ")));
    }
    if let Some(name) = message.strip_prefix("missing field `") {
        let above = if key.is_empty() { String::new() } else { format!("{key}.") };
        return format!("the setting {above}{} is missing; add it", name.trim_end_matches('`'));
    }
    let wrong = ["invalid type: ", "invalid value: "];
    if let Some(rest) = wrong.iter().find_map(|start| message.strip_prefix(start))
        && let Some((found, expected)) = rest.rsplit_once(", expected ")
    {
        let start = FOUND.iter().find(|(theirs, _)| found.starts_with(theirs));
        let found = match start {
            Some((theirs, ours)) => format!("{ours}{}", found[theirs.len()..].replace('`', "")),
            None => found.to_owned(),
        };
        let kind = TYPES.iter().find(|(theirs, _)| *theirs == expected);
        let table = expected.starts_with("struct ").then_some("a table");
        let expected = table.or(kind.map(|(_, ours)| *ours)).unwrap_or(expected);
        return about(format!("expected {expected}, found {found}"));
    }
    about(message.to_owned())
}

/// Returns the message for a setting that does not exist.
fn unknown<S: Named>(key: &str, name: &str, others: &str) -> String {
    // Any part of the name may be the one that does not exist.
    let dotted = match key {
        "" => name.to_owned(),
        key if key.split('.').any(|part| part == name) => key.to_owned(),
        table => format!("{table}.{name}"),
    };
    let meant = similar_settings(&dotted, S::names().iter().map(String::as_str));
    if !meant.is_empty() {
        return format!("unknown setting {dotted}; did you mean {}?", meant.join(" or "));
    }
    // The names beside it are what there is; a table's are listed where it is known.
    let others = quoted(others);
    match others.is_empty() {
        true => format!("unknown setting {dotted}"),
        false => format!("unknown setting {dotted}; there are {}", others.join(", ")),
    }
}

/// Returns the names between backticks.
fn quoted(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).collect()
}

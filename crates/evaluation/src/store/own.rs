//! Methods that a run was given beside those of its domain: what they consist of, so that a changed one is another run.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Most characters of a value that are shown.
const QUOTED: usize = 80;

/// What a method of somebody's own is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OwnKind {
    /// It is compiled into the program.
    Program,
    /// A command that is asked over pipes.
    Exec,
    /// A class within this process, in Python.
    Python,
    /// A plan of signals, which the manifest keeps with each point MDP.
    Plan,
    /// What a method has learned elsewhere, in the file of a model.
    Model,
}

impl OwnKind {
    /// Returns what it is in a few words.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Program => "compiled into the program",
            Self::Exec => "a command",
            Self::Python => "a class in Python",
            Self::Plan => "a plan that was given with --plan-file",
            Self::Model => "a saved model",
        }
    }
}

/// A method of somebody's own as the manifest keeps it. Nothing in it is started: what is comes from the command line,
/// and has to have these hashes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnMethod {
    /// Name.
    pub name: String,
    /// What it is made of.
    pub kind: OwnKind,
    /// How it was named on the command line, with files by their names alone.
    pub source: String,
    /// A sentence for people; empty where nobody wrote one.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub summary: String,
    /// Whether it learns before it is evaluated.
    pub learns: bool,
    /// The method that it is but for what it sees or is paid for; its settings are that method's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub learner: Option<String>,
    /// Ids of the point MDPs that a saved model was trained on, where they were several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub trained_on: Vec<String>,
    /// sha256 of every file that it consists of, by name.
    pub sha256: BTreeMap<String, String>,
    /// Versions of what runs it, such as `python`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub versions: BTreeMap<String, String>,
}

impl OwnMethod {
    /// Returns a method that does not learn, of which nothing is said and hashed yet.
    pub fn new(name: &str, kind: OwnKind, source: String) -> Self {
        Self {
            name: name.to_owned(),
            kind,
            source,
            summary: String::new(),
            learns: false,
            learner: None,
            trained_on: Vec::new(),
            sha256: BTreeMap::new(),
            versions: BTreeMap::new(),
        }
    }

    /// Returns what differs between the method that a run has and one of the same name, in words; `None` if nothing does.
    pub fn difference(&self, now: &Self) -> Option<String> {
        if self == now {
            return None;
        }
        let own = |own: &Self| flat(&serde_json::to_value(own).expect("plain data"));
        let (name, there, now) = (&self.name, own(self), own(now));
        let key = *differing(&there, &now).first()?;
        if let Some(file) = key.strip_prefix("sha256") {
            let file = file.trim_start_matches('.');
            return Some(format!("controller {name}: {file} has changed"));
        }
        Some(format!("controller {name}: {}", both(key, there.get(key), now.get(key))))
    }
}

/// Returns the names, in their order, whose values differ or which only one of two has: a setting at its default may be left out.
pub fn differing<'a>(
    there: &'a BTreeMap<String, Value>,
    now: &'a BTreeMap<String, Value>,
) -> Vec<&'a String> {
    let keys: BTreeSet<&String> = there.keys().chain(now.keys()).collect();
    keys.into_iter().filter(|key| there.get(*key) != now.get(*key)).collect()
}

/// Returns in words what a name has in an existing run, model or sample, and what it has now.
pub fn both(name: &str, there: Option<&Value>, now: Option<&Value>) -> String {
    let said = |value: Option<&Value>| match value {
        None | Some(Value::Null) => "not set".to_owned(),
        Some(value) => shortened(&value.to_string()),
    };
    format!("{name} is {} there and {} now", said(there), said(now))
}

fn shortened(text: &str) -> String {
    match text.char_indices().nth(QUOTED) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}
/// Returns in words how the settings of a section differ there and here; `None` where nothing does.
pub fn said(section: &str, there: &Value, here: &Value) -> Option<String> {
    let (there, here) = (flat(there), flat(here));
    let named = |key: &String| both(&format!("{section}.{key}"), there.get(key), here.get(key));
    let named: Vec<String> = differing(&there, &here).into_iter().map(named).collect();
    (!named.is_empty()).then(|| named.join("; "))
}

/// Returns the values of a tree by their dotted names.
pub fn flat(value: &Value) -> BTreeMap<String, Value> {
    fn gather(above: &str, value: &Value, into: &mut BTreeMap<String, Value>) {
        match value {
            Value::Object(inner) => {
                for (key, value) in inner {
                    let dot = if above.is_empty() { "" } else { "." };
                    gather(&format!("{above}{dot}{key}"), value, into);
                }
            }
            _ => {
                into.insert(above.to_owned(), value.clone());
            }
        }
    }
    let mut values = BTreeMap::new();
    gather("", value, &mut values);
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    fn own() -> OwnMethod {
        OwnMethod {
            name: "mine".to_owned(),
            kind: OwnKind::Python,
            source: "mine.py:Mine".to_owned(),
            summary: String::new(),
            learns: false,
            learner: None,
            trained_on: Vec::new(),
            sha256: BTreeMap::from([("mine.py".to_owned(), "ab".to_owned())]),
            versions: BTreeMap::from([("python".to_owned(), "3.11.7".to_owned())]),
        }
    }

    #[test]
    fn what_differs_is_named() {
        let there = own();
        let with = |change: &dyn Fn(&mut OwnMethod)| {
            let mut now = own();
            change(&mut now);
            there.difference(&now)
        };
        assert_eq!(with(&|_| {}), None);
        type Change<'a> = &'a dyn Fn(&mut OwnMethod);
        let cases: [(Change<'_>, &str); 3] = [
            (
                &|m| m.sha256.values_mut().for_each(|h| h.push('c')),
                "controller mine: mine.py has changed",
            ),
            (
                &|m| drop(m.versions.insert("python".into(), "3.12.1".into())),
                "controller mine: versions.python is \"3.11.7\" there and \"3.12.1\" now",
            ),
            (&|m| m.learns = true, "controller mine: learns is false there and true now"),
        ];
        for (change, expected) in cases {
            assert_eq!(with(change).as_deref(), Some(expected));
        }
    }
}

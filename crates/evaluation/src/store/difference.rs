//! What makes one run another one, in words: the settings and flags that people give come before the
//! files and hashes that follow from them.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Debug;

use serde_json::Value;

use super::manifest::{Identity, PointRow};
use crate::sample::SamplePlan;

/// Most settings or points that are named.
const NAMED: usize = 3;

/// Most characters of a value that are shown.
const QUOTED: usize = 80;

/// Returns what differs between an existing run and the one that is asked for; nothing if they are the
/// same.
pub fn between(there: &Identity, now: &Identity) -> Option<String> {
    if there == now {
        return None;
    }
    let flags = [
        differs("the scenario", &there.scenario, &now.scenario),
        settings(&there.settings, &now.settings),
        differs("--methods", &there.methods.join(","), &now.methods.join(",")),
        differs("--seed", &there.base_seed, &now.base_seed),
        differs("--eval-seeds", &there.evaluation_seeds.len(), &now.evaluation_seeds.len()),
        seeds(there, now),
        differs("--replicates", &there.replicates, &now.replicates),
        differs("--budget", &there.sample.budget, &now.sample.budget),
        differs("--sampling", &there.sample.sampling.name(), &now.sample.sampling.name()),
        growth(&there.sample, &now.sample),
    ];
    if let Some(text) = flags.into_iter().flatten().next() {
        return Some(text);
    }
    let versions = [
        differs("tsc-family", &there.tsc_family, &now.tsc_family),
        differs("SUMO", &there.simulator, &now.simulator),
    ];
    let points = points(&there.points, &now.points);
    let controllers = there.controllers.iter().zip(&now.controllers);
    let controllers = controllers.filter_map(|(there, now)| there.difference(now)).next();
    let rest = controllers.or(versions.into_iter().flatten().next()).or(points);
    // Everything that is compared has its words above but constants of a version.
    Some(rest.unwrap_or_else(|| {
        "it was planned by a version of tsc-family that chooses otherwise".to_owned()
    }))
}

/// Returns how evaluation seeds differ where as many are given in a file.
fn seeds(there: &Identity, now: &Identity) -> Option<String> {
    let other = there.evaluation_seeds.iter().zip(&now.evaluation_seeds).find(|(a, b)| a != b);
    other.map(|(a, b)| format!("an evaluation seed (--seeds) is {a} there and {b} now"))
}

/// Returns what differs in how samples grow.
fn growth(there: &SamplePlan, now: &SamplePlan) -> Option<String> {
    let until = |sample: &SamplePlan| match &sample.growth {
        Some(growth) => format!("until {}", growth.until),
        None => "not stopped early".to_owned(),
    };
    let budgets = |sample: &SamplePlan| {
        let looks = sample.growth.iter().flat_map(|growth| &growth.looks);
        looks.map(|look| look.budget).collect::<Vec<_>>()
    };
    differs("the run", &until(there), &until(now))
        .or_else(|| differs("--looks", &budgets(there), &budgets(now)))
}

fn differs<T: PartialEq + Debug>(what: &str, there: &T, now: &T) -> Option<String> {
    let plain = |value: &T| format!("{value:?}").trim_matches('"').to_owned();
    (there != now).then(|| format!("{what} is {} there and {} now", plain(there), plain(now)))
}

/// Returns the settings that differ.
fn settings(there: &Value, now: &Value) -> Option<String> {
    let (there, now) = (flat(there), flat(now));
    let differ = differing(&there, &now);
    let shown = |values: &BTreeMap<String, Value>, key: &String| match values.get(key) {
        None | Some(Value::Null) => "not set".to_owned(),
        Some(value) => shortened(&value.to_string()),
    };
    let text = |key: &&String| {
        format!("{key} is {} there and {} now", shown(&there, key), shown(&now, key))
    };
    // Other settings follow from the preset.
    if let Some(preset) = differ.iter().find(|key| key.as_str() == "preset") {
        return Some(text(preset));
    }
    if differ.is_empty() {
        return None;
    }
    let named: Vec<String> = differ.iter().take(NAMED).map(text).collect();
    let more = match differ.len() - named.len() {
        0 => String::new(),
        more => format!(", and {more} more settings differ"),
    };
    Some(format!("the setting {}{more}", named.join(", ")))
}

/// Returns the names, in their order, whose values differ or which only one of two has: a setting at its default may be left out.
pub fn differing<'a>(
    there: &'a BTreeMap<String, Value>,
    now: &'a BTreeMap<String, Value>,
) -> Vec<&'a String> {
    let keys: BTreeSet<&String> = there.keys().chain(now.keys()).collect();
    keys.into_iter().filter(|key| there.get(*key) != now.get(*key)).collect()
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

/// Returns what differs between the point MDPs where all settings are the same: the table that they come
/// from, or the files of their networks.
fn points(there: &[PointRow], now: &[PointRow]) -> Option<String> {
    let names =
        |rows: &[PointRow]| -> Vec<String> { rows.iter().map(|row| row.point.clone()).collect() };
    let (old, new) = (names(there), names(now));
    if old != new {
        let only = |a: &[String], b: &[String]| {
            let names: Vec<&str> =
                a.iter().filter(|n| !b.contains(n)).take(NAMED).map(String::as_str).collect();
            if names.is_empty() { "no other".to_owned() } else { names.join(", ") }
        };
        return Some(format!(
            "other point MDPs were chosen, since the table of the family was changed: {} there and {} \
             now",
            only(&old, &new),
            only(&new, &old)
        ));
    }
    let (old, new) = there.iter().zip(now).find(|(old, new)| old != new)?;
    let name = old.name();
    let table = old.features != new.features
        || old.importance != new.importance
        || old.instances != new.instances
        || old.places != new.places;
    if table {
        let values = |row: &PointRow| format!("{:?}", (row.importance, &row.features));
        return Some(format!(
            "the point MDP {name} is another one, since the table of the family was changed: importance \
             and features are {} there and {} now",
            shortened(&values(old)),
            shortened(&values(new))
        ));
    }
    let given = |row: &PointRow| serde_json::to_string(&row.given).expect("plain data");
    let said = format!("what the command line says of the scenario {name}");
    let environment = format!("the path of the point MDP {name}");
    differs(&said, &given(old), &given(new))
        .or_else(|| {
            let files = old.sha256.keys().chain(new.sha256.keys());
            let mut files = files.filter(|file| old.sha256.get(*file) != new.sha256.get(*file));
            let file = files.next()?;
            Some(format!(
                "the settings are the same, but the file {file} of the point MDP {name} was changed or removed; restore it"
            ))
        })
        .or_else(|| differs(&environment, &old.environment, &new.environment))
        .or_else(|| Some(format!("the point MDP {name} has another content than there")))
}

fn shortened(text: &str) -> String {
    match text.char_indices().nth(QUOTED) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn settings_are_named_with_both_values() {
        let there =
            json!({"preset": "resco", "demand": {"horizon_s": 600.0}, "a": 1, "b": 1, "c": 1});
        let mut now = there.clone();
        now["demand"]["horizon_s"] = json!(1200.0);
        assert_eq!(
            settings(&there, &now).unwrap(),
            "the setting demand.horizon_s is 600.0 there and 1200.0 now"
        );
        now["a"] = json!(2);
        now["b"] = json!(2);
        now["c"] = Value::Null;
        assert_eq!(
            settings(&there, &now).unwrap(),
            "the setting a is 1 there and 2 now, b is 1 there and 2 now, c is 1 there and not set now, \
             and 1 more settings differ"
        );
        now["preset"] = json!("field");
        let text = settings(&there, &now).unwrap();
        assert_eq!(text, "preset is \"resco\" there and \"field\" now");
        assert_eq!(settings(&there, &there), None);
    }
}

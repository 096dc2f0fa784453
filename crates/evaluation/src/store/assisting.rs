//! The settings of a run whose scores assist a sample: what is kept of them, and how they differ from those of the run on
//! the sample.
//!
//! Only sections that the scores depend on are kept. Methods that learn do not assist, so neither the sections of other
//! methods nor those of training are among them.

use std::collections::BTreeSet;

use serde_json::{Map, Value};

use super::own::{self, flat};

/// Section that only methods that learn read.
pub const TRAINING: &str = "training";

/// Most settings that a warning names.
pub(crate) const MOST_NAMED: usize = 3;

/// Returns what is kept of the settings of a run that assists.
///
/// # Arguments
///
/// * `settings` — all settings of that run.
/// * `methods` — names of all methods, which sections may belong to.
/// * `inputs` — names of the methods whose scores assist.
pub fn kept(settings: &Value, methods: &[&str], inputs: &[&str]) -> Value {
    let is_read = |section: &str| {
        let method = section.replace('_', "-");
        section != TRAINING
            && (inputs.contains(&method.as_str()) || !methods.contains(&method.as_str()))
    };
    let sections = settings.as_object().into_iter().flatten();
    let sections = sections.filter(|(section, _)| is_read(section));
    Value::Object(sections.map(|(key, value)| (key.clone(), value.clone())).collect::<Map<_, _>>())
}

/// Returns the names of the settings that differ, of the sections that were kept.
///
/// # Arguments
///
/// * `there` — from [`kept`].
/// * `here` — all settings of the run on the sample.
pub fn differing(there: &Value, here: &Value) -> Vec<String> {
    let (there, here) = (flat(there), flat(here));
    let known: BTreeSet<&str> = there.keys().map(|key| section(key)).collect();
    let differing = own::differing(&there, &here).into_iter();
    differing.filter(|key| known.contains(section(key))).cloned().collect()
}

/// Returns the settings that differ with both values, the first ones; `None` where all are the same. Arguments are those
/// of [`differing`].
pub fn differences(there: &Value, here: &Value) -> Option<String> {
    let keys = differing(there, here);
    let (there, here) = (flat(there), flat(here));
    let both = |key: &String| own::both(key, there.get(key), here.get(key));
    let mut named: Vec<String> = keys.iter().take(MOST_NAMED).map(both).collect();
    if keys.len() > MOST_NAMED {
        named.push(format!("and {} more", keys.len() - MOST_NAMED));
    }
    (!named.is_empty()).then(|| named.join("; "))
}

/// Returns the section of a setting.
pub fn section(key: &str) -> &str {
    key.split('.').next().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn only_settings_that_the_scores_depend_on_differ() {
        let there = json!({
            "preset": "resco", "demand": {"horizon_s": 3600.0}, "idqn": {"gamma": 0.9},
            "fixed_time": {"simulations": 24}, "training": {"episodes": 100},
        });
        let there = kept(&there, &["fixed-time", "idqn"], &["fixed-time"]);
        let mut here = there.clone();
        here["idqn"] = json!({"gamma": 0.5});
        here["training"] = json!({"episodes": 6, "finalist_seeds": 5});
        assert_eq!(differences(&there, &here), None);
        here["preset"] = json!("field");
        here["demand"]["sigma"] = json!(0.2);
        here["fixed_time"]["simulations"] = json!(8);
        let expected = "demand.sigma is not set there and 0.2 now; fixed_time.simulations is 24 there and 8 now; \
                        preset is \"resco\" there and \"field\" now";
        assert_eq!(differences(&there, &here).unwrap(), expected);
        here["demand"]["horizon_s"] = json!(60.0);
        assert!(differences(&there, &here).unwrap().ends_with("8 now; and 1 more"));
    }
}

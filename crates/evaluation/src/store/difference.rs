//! What makes one run another one: what people give comes before the files and hashes that follow from it.

use serde_json::json;

use super::manifest::{Identity, PointRow};
use super::own::{both, differing, flat};

/// Most differences that are named.
const NAMED: usize = 3;

/// Returns what differs between an existing run and the one that is asked for; nothing if they are the same.
pub fn between(there: &Identity, now: &Identity) -> Option<String> {
    let own = there.controllers.iter().zip(&now.controllers);
    let own = own.filter_map(|(there, now)| there.difference(now)).next();
    let parts = |identity: &Identity| {
        let mut value = json!(identity);
        let point = |p: &PointRow| (format!("the point MDP {}", p.name()), json!(p));
        value["points"] = identity.points.iter().map(point).collect();
        flat(&value)
    };
    let (there, now) = (parts(there), parts(now));
    let mut differ = differing(&there, &now);
    // What people say comes before what follows from it, and the preset before other settings.
    let rank = |key: &str| match key {
        "scenario" | "settings.preset" => 0,
        _ if key.starts_with("settings.") => 1,
        "tsc_family" | "simulator" => 3,
        "replicated" | "sample.design" | "sample.draws" => 4,
        _ if key.starts_with("points.")
            && (key.contains(".sha256.") || key.ends_with(".content")) =>
        {
            5
        }
        _ if key.starts_with("points.") => 4,
        _ => 2,
    };
    let least = differ.iter().map(|key| rank(key)).min()?;
    differ.retain(|key| rank(key) == least);
    if let Some(own) = own.filter(|_| least > 1) {
        return Some(own);
    }
    let text = |key: &&String| {
        let name = key.trim_start_matches("settings.").trim_start_matches("points.");
        both(name, there.get(*key), now.get(*key))
    };
    let mut named: Vec<String> = differ.iter().take(NAMED).map(text).collect();
    if differ.len() > NAMED {
        named.push(format!("and {} more", differ.len() - NAMED));
    }
    Some(named.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::testing::planned;

    #[test]
    fn settings_are_named_before_what_follows_from_them() {
        let mut there = planned(2).0.identity;
        there.settings = json!({"preset": "resco", "demand": {"horizon_s": 600.0}});
        let mut now = there.clone();
        assert_eq!(between(&there, &now), None);
        now.points[0].content = "other".to_owned();
        let text = between(&there, &now).unwrap();
        assert!(text.starts_with("the point MDP ") && text.contains(".content is "), "{text}");
        now.base_seed += 1;
        let seed = there.base_seed;
        let expected = format!("base_seed is {seed} there and {} now", seed + 1);
        assert_eq!(between(&there, &now).unwrap(), expected);
        now.settings["demand"]["horizon_s"] = json!(1200.0);
        let expected = "demand.horizon_s is 600.0 there and 1200.0 now";
        assert_eq!(between(&there, &now).unwrap(), expected);
        now.settings["preset"] = json!("field");
        let expected = "preset is \"resco\" there and \"field\" now";
        assert_eq!(between(&there, &now).unwrap(), expected);
    }
}

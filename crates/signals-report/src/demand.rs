//! Which hour is simulated and where its inflows come from, in words, for both pages.

use serde_json::Value;

use evaluation::report::format::percent;
use evaluation::store::manifest::Identity;

/// Seconds in an hour, and in a minute.
pub(super) const HOUR_S: f64 = 3600.0;
const MINUTE_S: f64 = 60.0;

/// Share of the approaches with a default inflow above which a headline says so.
const MOSTLY: f64 = 0.5;

/// Headings of the middle of two compass directions, degrees, and what goes there.
const HEADINGS: [(f64, &str); 4] = [
    (45.0, "north- and eastbound"),
    (135.0, "south- and eastbound"),
    (225.0, "south- and westbound"),
    (315.0, "north- and westbound"),
];

/// Says which part of a day the hour is, and how the directions of a street share it.
pub(super) fn hour(share: f64, split: f64, heading_deg: f64) -> String {
    let hour = format!("{:.1}% of the day\u{2019}s traffic in the hour", 100.0 * share);
    if split <= 0.5 {
        return hour;
    }
    let named = HEADINGS.iter().find(|(heading, _)| *heading == heading_deg);
    let peak = named.map_or_else(
        || format!("within 90 degrees of a heading of {heading_deg}"),
        |(_, words)| (*words).to_owned(),
    );
    format!(
        "{hour}, {} of a two-way street\u{2019}s in its peak direction ({peak})",
        percent(split)
    )
}

/// Says what inflows rest on: counted, spread, from the class, default.
pub(super) fn sources([counted, spread, imputed, default]: [f64; 4]) -> String {
    if default >= 1.0 {
        return "all defaults by class of street".to_owned();
    }
    format!(
        "{} counted, {} counted elsewhere on their street, {} the mean of counted streets of their \
         class, {} defaults by class",
        percent(counted),
        percent(spread),
        percent(imputed),
        percent(default)
    )
}

/// Says what the settings of a run tell of its hour, for families of approaches.
pub(super) fn of_run(settings: &Value) -> Option<String> {
    let number = |name: &str| settings.pointer(&format!("/family/{name}"))?.as_f64();
    settings.pointer("/family/approaches").filter(|table| !table.is_null())?;
    let split = number("directional_split").unwrap_or(0.5);
    let by_turn = by_turn(settings);
    if by_turn >= 1.0 {
        return Some("vehicles as counted by turn".to_owned());
    }
    let mut text = hour(number("hourly_share")?, split, number("peak_heading_deg").unwrap_or(45.0));
    if let Some(shares) = inflows(settings) {
        text.push_str(&format!("; inflows: {}", sources(shares)));
    }
    if by_turn > 0.0 {
        text.push_str(&format!("; {} of the approaches as counted by turn", percent(by_turn)));
    }
    Some(text)
}

/// Returns the length of the episodes on generated networks; `None` for imported scenarios, each of
/// which has its own.
pub(super) fn horizon_s(identity: &Identity) -> Option<f64> {
    let generated = Some(identity).filter(|identity| identity.scenario != "imported")?;
    generated.settings.pointer("/demand/horizon_s")?.as_f64()
}

/// Returns a length of episodes as the end of `in the simulated`: `hour`, `minute`, or `300 s`.
pub(super) fn span(horizon_s: f64) -> String {
    match horizon_s {
        HOUR_S => "hour".to_owned(),
        MINUTE_S => "minute".to_owned(),
        s => format!("{s} s"),
    }
}

/// Returns the share of the approaches whose vehicles were counted by turn.
fn by_turn(settings: &Value) -> f64 {
    settings.pointer("/family/inflows/by_turn").and_then(Value::as_f64).unwrap_or_default()
}

/// Returns whether the settings of a run say that most of its inflows are defaults.
pub(super) fn on_defaults(settings: &Value) -> bool {
    inflows(settings).is_some_and(|[.., default]| default > MOSTLY)
}

/// Returns whether the settings of a run say that all of its inflows are defaults.
pub(super) fn all_defaults(settings: &Value) -> bool {
    inflows(settings).is_some_and(|[.., default]| default >= 1.0)
}

fn inflows(settings: &Value) -> Option<[f64; 4]> {
    let of = settings.pointer("/family/inflows")?;
    let share = |name: &str| of.get(name)?.as_f64();
    Some([share("counted")?, share("spread")?, share("imputed")?, share("default")?])
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_run_says_its_hour_and_where_inflows_come_from() {
        let inflows = json!({"counted": 0.25, "spread": 0.1, "imputed": 0.05, "default": 0.6});
        let mut family = json!({"approaches": "a.csv", "hourly_share": 0.09, "inflows": inflows});
        family["directional_split"] = json!(0.55);
        let settings = json!({"family": family});
        assert_eq!(
            of_run(&settings).unwrap(),
            "9.0% of the day\u{2019}s traffic in the hour, 55% of a two-way street\u{2019}s in its peak \
             direction (north- and eastbound); inflows: 25% counted, 10% counted elsewhere on their \
             street, 5% the mean of counted streets of their class, 60% defaults by class"
        );
        assert!(on_defaults(&settings));
    }

    #[test]
    fn counts_of_an_hour_say_nothing_of_the_day() {
        let inflows = |by_turn: f64| {
            let shares = json!({"counted": 1.0, "spread": 0.0, "imputed": 0.0, "default": 0.0, "by_turn": by_turn});
            json!({"family": {"approaches": "a.csv", "hourly_share": 0.09, "inflows": shares}})
        };
        assert_eq!(of_run(&inflows(1.0)).unwrap(), "vehicles as counted by turn");
        assert!(
            of_run(&inflows(0.5)).unwrap().ends_with("; 50% of the approaches as counted by turn")
        );
    }

    #[test]
    fn a_length_of_episodes_is_said_as_it_is() {
        let texts = [3600.0, 60.0, 300.0, 7200.0, 0.5].map(span);
        assert_eq!(texts, ["hour", "minute", "300 s", "7200 s", "0.5 s"]);
    }

    #[test]
    fn a_family_with_equal_directions_says_its_share_only() {
        let settings = json!({"family": {"approaches": "a.csv", "hourly_share": 1.0 / 24.0}});
        assert_eq!(of_run(&settings).unwrap(), "4.2% of the day\u{2019}s traffic in the hour");
        assert!(!on_defaults(&settings));
        assert_eq!(of_run(&json!({"family": {"approaches": null}})), None);
    }
}

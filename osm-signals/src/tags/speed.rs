//! Speed limits: numbers with and without units, lists, and words.

use super::{Tags, tag};
use crate::error::brief;
use crate::oddities::Oddities;

/// Kilometres in a mile (exact).
const KM_PER_MILE: f64 = 1.609_344;

/// Kilometres in a nautical mile (exact).
const KM_PER_NAUTICAL_MILE: f64 = 1.852;

/// Speed limits that are believed, miles per hour.
const RANGE_MPH: std::ops::RangeInclusive<f32> = 3.0..=100.0;

/// Words that mean that there is no fixed limit; not worth counting as unusable.
const NO_NUMBER: [&str; 4] = ["none", "signals", "variable", "implicit"];

/// Tags that say by which rule a limit holds that has no sign of its own, where `maxspeed` has no number.
const RULES: [&str; 4] = ["zone:maxspeed", "maxspeed:type", "source:maxspeed", "zone:traffic"];

/// What `walk` means, km/h (OpenStreetMap's wiki, Key:maxspeed).
const WALK_KMH: f64 = 7.0;

/// Limits for cars within and outside built-up areas, km/h, and their countries (OpenStreetMap's wiki, Default speed
/// limits).
const LEGAL_KMH: [(f64, f64, &str); 6] = [
    (50.0, 90.0, "be-wal bg cz ee es gr hr hu it lt lv pl pt ro si ua"),
    (50.0, 80.0, "ch dk fi fr nl no rs"),
    (50.0, 100.0, "at de"),
    (50.0, 70.0, "be-vlg se"),
    (60.0, 90.0, "by ru"),
    (30.0, 70.0, "be-bru"),
];

/// Countries whose signs are in miles per hour.
const MILES: [&str; 3] = ["gb", "uk", "us"];

/// `maxspeed` and its suffixes, miles per hour.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SpeedTags {
    /// `maxspeed`.
    pub both_mph: Option<f32>,
    /// `maxspeed:forward`.
    pub forward_mph: Option<f32>,
    /// `maxspeed:backward`.
    pub backward_mph: Option<f32>,
}

impl SpeedTags {
    pub(super) fn parse(way: i64, tags: &Tags<'_>, oddities: &mut Oddities) -> Self {
        let mut speed = |key: &str| {
            let text = tag(tags, key)?;
            let speed_mph = speed_mph(text).filter(|speed| RANGE_MPH.contains(speed));
            if speed_mph.is_none() && !NO_NUMBER.contains(&text) {
                oddities
                    .add("unusable speed limit", || format!("way {way}, {key}={}", brief(text)));
            }
            speed_mph
        };
        let both_mph = speed("maxspeed");
        let by_rule = || {
            let limits = RULES.iter().filter_map(|key| by_rule(tag(tags, key)?.trim()));
            limits.map(|mph| mph as f32).find(|mph| RANGE_MPH.contains(mph))
        };
        Self {
            both_mph: both_mph.or_else(by_rule),
            forward_mph: speed("maxspeed:forward"),
            backward_mph: speed("maxspeed:backward"),
        }
    }

    /// Returns the limit in a direction.
    pub fn in_direction(self, forward: bool) -> Option<f32> {
        if forward { self.forward_mph } else { self.backward_mph }.or(self.both_mph)
    }
}

/// Returns a speed limit; of a list the mean, as OSMnx takes it.
fn speed_mph(text: &str) -> Option<f32> {
    let parts = text.split([';', '|']).map(str::trim).filter(|part| !part.is_empty());
    let speeds: Vec<f32> = parts.map(single).collect::<Option<_>>()?;
    (!speeds.is_empty()).then(|| speeds.iter().sum::<f32>() / speeds.len() as f32)
}

fn kmh_to_mph(speed_kmh: f64) -> f64 {
    speed_kmh / KM_PER_MILE
}

fn knots_to_mph(speed_knots: f64) -> f64 {
    kmh_to_mph(speed_knots * KM_PER_NAUTICAL_MILE)
}

/// Returns one speed limit; a number without a unit is in km/h.
fn single(text: &str) -> Option<f32> {
    by_rule(text).or_else(|| signed(text, kmh_to_mph)).map(|mph| mph as f32)
}

/// Returns the limit of a rule, such as `DE:urban`, `DE:zone30` or `GB:zone:20`, miles per hour.
fn by_rule(text: &str) -> Option<f64> {
    let text = text.to_ascii_lowercase();
    if text == "walk" {
        return Some(kmh_to_mph(WALK_KMH));
    }
    let (country, rule) = text.split_once(':')?;
    if !matches!(country.len(), 2..=6) || !country.starts_with(|c: char| c.is_ascii_lowercase()) {
        return None;
    }
    let legal = || LEGAL_KMH.iter().find(|(.., codes)| codes.split(' ').any(|c| c == country));
    match rule {
        "urban" => return legal().map(|(urban, ..)| kmh_to_mph(*urban)),
        "rural" => return legal().map(|(_, rural, _)| kmh_to_mph(*rural)),
        "walk" => return Some(kmh_to_mph(WALK_KMH)),
        // The limits of Great Britain outside motorways (the Highway Code, rule 124).
        "nsl_restricted" => return Some(30.0),
        "nsl_single" => return Some(60.0),
        "nsl_dual" => return Some(70.0),
        _ => {}
    }
    let zone = rule.strip_prefix("zone").unwrap_or(rule).trim_start_matches([':', ' ']);
    let plain = if MILES.contains(&country) { |mph| mph } else { kmh_to_mph };
    signed(zone, plain)
}

/// The limit on a sign; `plain` makes miles per hour of a number without a unit.
fn signed(text: &str, plain: fn(f64) -> f64) -> Option<f64> {
    let text = text.trim().to_ascii_lowercase();
    let is_of_number = |c: char| c.is_ascii_digit() || c == '.' || c == ',';
    let end = text.find(|c| !is_of_number(c)).unwrap_or(text.len());
    let value: f64 = text[..end].replace(',', ".").parse().ok()?;
    Some(match text[end..].trim() {
        "" => plain(value),
        "mph" => value,
        "km/h" | "kmh" | "kph" | "kmph" => kmh_to_mph(value),
        "knots" | "knot" => knots_to_mph(value),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> (Option<f32>, u64) {
        let mut oddities = Oddities::default();
        let speed = SpeedTags::parse(1, &[("maxspeed", text)], &mut oddities);
        (speed.both_mph, oddities.count("unusable speed limit"))
    }

    #[test]
    fn units_are_understood() {
        assert_eq!(parse("30 mph").0, Some(30.0));
        assert_eq!(parse("30mph").0, Some(30.0));
        for text in ["50", "50 km/h", "50kmh", "50 kph"] {
            assert!((parse(text).0.unwrap() - 31.0686).abs() < 1e-3, "{text}");
        }
        assert!((parse("10 knots").0.unwrap() - 11.5078).abs() < 1e-3);
    }

    #[test]
    fn units_may_be_in_capitals_and_decimals_have_a_comma() {
        assert_eq!(parse("35 MPH").0, Some(35.0));
        assert_eq!(parse("30mph;").0, Some(30.0));
        assert_eq!(parse("50,5 Km/h"), parse("50.5"));
    }

    #[test]
    fn rules_have_the_limit_of_their_country() {
        let kmh = |text: &str| (parse(text).0.unwrap() * 1.609_344).round();
        for (text, expected) in [
            ("DE:urban", 50.0),
            ("de:rural", 100.0),
            ("RU:urban", 60.0),
            ("BE-VLG:rural", 70.0),
            ("DE:zone30", 30.0),
            ("DE:zone:30", 30.0),
            ("FR:30", 30.0),
            ("walk", 7.0),
        ] {
            assert_eq!(kmh(text), expected, "{text}");
        }
        assert_eq!(parse("GB:nsl_single").0, Some(60.0));
        assert_eq!(parse("GB:zone20").0, Some(20.0));
        assert_eq!(parse("XX:urban"), (None, 1));
        // Other tags count where the limit itself has no number, and are no mistake.
        let of = |tags: &Tags<'_>| {
            let mut oddities = Oddities::default();
            let speed = SpeedTags::parse(1, tags, &mut oddities);
            (speed.both_mph.map(f32::round), oddities.iter().count())
        };
        assert_eq!(of(&[("zone:maxspeed", "DE:30")]), (Some(19.0), 0));
        assert_eq!(of(&[("source:maxspeed", "DE:urban")]), (Some(31.0), 0));
        assert_eq!(
            of(&[("source:maxspeed", "sign"), ("maxspeed:type", "GB:nsl_dual")]).0,
            Some(70.0)
        );
        assert_eq!(of(&[("maxspeed", "20 mph"), ("zone:traffic", "DE:urban")]).0, Some(20.0));
        assert_eq!(of(&[("source:maxspeed", "survey:2019")]), (None, 0));
    }

    #[test]
    fn of_a_list_the_mean_counts() {
        assert_eq!(parse("30 mph;40 mph").0, Some(35.0));
        assert_eq!(parse("20 mph|40 mph").0, Some(30.0));
    }

    #[test]
    fn words_for_no_limit_are_no_mistake() {
        assert_eq!(parse("none"), (None, 0));
        assert_eq!(parse("signals"), (None, 0));
    }

    #[test]
    fn what_cannot_be_a_limit_is_counted() {
        for text in ["999", "-30", "fast", "", "NaN", "0", "30 leagues", "1e9"] {
            assert_eq!(parse(text), (None, 1), "{text:?}");
        }
    }

    #[test]
    fn a_direction_has_its_own_limit_before_that_of_the_way() {
        let tags = [("maxspeed", "30 mph"), ("maxspeed:backward", "20 mph")];
        let speed = SpeedTags::parse(1, &tags, &mut Oddities::default());
        assert_eq!(speed.in_direction(true), Some(30.0));
        assert_eq!(speed.in_direction(false), Some(20.0));
    }
}

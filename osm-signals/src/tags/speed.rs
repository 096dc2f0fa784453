//! Speed limits: numbers with and without units, lists, and words.

use super::value::{Tags, tag};
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
        Self {
            both_mph: speed("maxspeed"),
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
    let speeds: Vec<f32> = text.split([';', '|']).map(single).collect::<Option<_>>()?;
    Some(speeds.iter().sum::<f32>() / speeds.len() as f32)
}

fn kmh_to_mph(speed_kmh: f64) -> f64 {
    speed_kmh / KM_PER_MILE
}

fn knots_to_mph(speed_knots: f64) -> f64 {
    kmh_to_mph(speed_knots * KM_PER_NAUTICAL_MILE)
}

/// Returns one speed limit; a number without a unit is in km/h.
fn single(text: &str) -> Option<f32> {
    let text = text.trim();
    let end = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let value: f64 = text[..end].parse().ok()?;
    let mph = match text[end..].trim() {
        "mph" => value,
        "" | "km/h" | "kmh" | "kph" | "kmph" => kmh_to_mph(value),
        "knots" | "knot" => knots_to_mph(value),
        _ => return None,
    };
    Some(mph as f32)
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

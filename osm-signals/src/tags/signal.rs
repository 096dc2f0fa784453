//! What a node says of signals.

use super::{Tags, tag};
use crate::flags::Skip;

/// Returns what a value of `traffic_signals` says; `None` for any that a signal of a junction may have, such
/// as `signal`, `blink_mode` or `tram_priority`.
fn special(value: &str) -> Option<Skip> {
    Some(match value {
        "level_crossing" | "rail_crossing" | "railway_crossing" => Skip::LevelCrossing,
        "emergency" | "fire_station" => Skip::Emergency,
        "bridge" | "lift_bridge" | "movable_bridge" | "drawbridge" => Skip::Bridge,
        "one_lane" | "single_lane" | "alternating" => Skip::SingleLane,
        "blinker" => Skip::Beacon,
        _ => return None,
    })
}

/// What the tags of a signal node say beside `highway=traffic_signals`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SignalTags {
    /// Direction of traffic that it is for, relative to its way; `None` if not tagged or both.
    pub forward: Option<bool>,
    /// Whether it is (also) a crossing of pedestrians.
    pub crossing: bool,
    /// Whether it meters a ramp.
    pub meter: bool,
    /// What it is for if that is no junction.
    pub special: Option<Skip>,
    /// Whether it is at a level crossing and nothing else says what it is for.
    pub on_rails: bool,
}

impl SignalTags {
    /// Returns what the tags of a node say; `None` if it is no signal for vehicles.
    ///
    /// A crossing with signals alone (`highway=crossing`) is none; `highway=traffic_signals;crossing` is both.
    pub fn parse(tags: &Tags<'_>) -> Option<Self> {
        let is = |value: &str| tag(tags, "highway")?.split(';').find(|v| v.trim() == value);
        is("traffic_signals")?;
        let crossing = is("crossing").is_some()
            || tag(tags, "crossing").is_some_and(|v| v != "no")
            || tag(tags, "crossing_ref").is_some()
            || matches!(
                tag(tags, "traffic_signals"),
                Some("crossing" | "pedestrian_crossing" | "crossing_only")
            );
        let forward =
            match tag(tags, "traffic_signals:direction").or_else(|| tag(tags, "direction")) {
                Some("forward") => Some(true),
                Some("backward") => Some(false),
                _ => None,
            };
        let purpose = tag(tags, "traffic_signals");
        let meter = purpose == Some("ramp_meter");
        // Of several, one that a junction may have counts.
        let special = purpose.and_then(|purpose| {
            let mut all = purpose.split(';').map(|value| special(value.trim()));
            let first = all.next()?;
            first.filter(|_| all.all(|other| other.is_some()))
        });
        let on_rails = purpose.is_none() && tag(tags, "railway") == Some("level_crossing");
        Some(Self { forward, crossing, meter, special, on_rails })
    }
}

/// Returns whether a node with these tags is a crossing of pedestrians with signals, which stop vehicles too
/// but are not mapped as signals for them.
pub(crate) fn is_crossing_signal(tags: &Tags<'_>) -> bool {
    let is = |key, values: &[&str]| tag(tags, key).is_some_and(|v| values.contains(&v));
    is("highway", &["crossing"])
        && (is("crossing", &["traffic_signals", "toucan", "pelican", "puffin", "pegasus"])
            || is("crossing:signals", &["yes"])
            || is("crossing_ref", &["toucan", "pelican", "puffin", "pegasus"]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crossing_with_signals_alone_is_no_signal() {
        assert_eq!(
            SignalTags::parse(&[("highway", "crossing"), ("crossing", "traffic_signals")]),
            None
        );
        let both =
            SignalTags::parse(&[("crossing", "traffic_signals"), ("highway", "traffic_signals")]);
        assert_eq!(both, Some(SignalTags { crossing: true, ..SignalTags::default() }));
        for value in ["traffic_signals;crossing", "crossing; traffic_signals"] {
            assert_eq!(SignalTags::parse(&[("highway", value)]), both, "{value}");
        }
        assert_eq!(SignalTags::parse(&[("highway", "traffic_signals_off;crossing")]), None);
    }

    #[test]
    fn a_crossing_is_signalised_by_any_of_its_tags() {
        for tag in [
            ("crossing", "traffic_signals"),
            ("crossing:signals", "yes"),
            ("crossing_ref", "puffin"),
        ] {
            assert!(is_crossing_signal(&[("highway", "crossing"), tag]), "{tag:?}");
        }
        assert!(!is_crossing_signal(&[("highway", "crossing"), ("crossing", "zebra")]));
        assert!(!is_crossing_signal(&[("highway", "footway"), ("crossing", "traffic_signals")]));
    }

    #[test]
    fn a_signal_for_trains_fire_engines_ships_or_one_lane_is_of_no_junction() {
        let special = |value| {
            let tags = [("highway", "traffic_signals"), ("traffic_signals", value)];
            SignalTags::parse(&tags).unwrap().special
        };
        for (value, expected) in [
            ("level_crossing", Skip::LevelCrossing),
            ("emergency", Skip::Emergency),
            ("bridge", Skip::Bridge),
            ("one_lane", Skip::SingleLane),
            ("blinker", Skip::Beacon),
            ("emergency;level_crossing", Skip::Emergency),
        ] {
            assert_eq!(special(value), Some(expected), "{value}");
        }
        for value in [
            "signal", "traffic_lights", "blink_mode", "tram_priority", "tram", "signal;emergency",
            "emergency; signal",
        ] {
            assert_eq!(special(value), None, "{value}");
        }
    }

    #[test]
    fn a_signal_on_rails_that_says_what_it_is_for_is_not_taken_for_that_of_trains() {
        let on_rails = |tag| {
            let tags = [("highway", "traffic_signals"), tag, ("railway", "level_crossing")];
            SignalTags::parse(&tags).unwrap().on_rails
        };
        assert!(on_rails(("crossing:barrier", "full")));
        assert!(!on_rails(("traffic_signals", "signal")));
        let tram = [("highway", "traffic_signals"), ("railway", "tram_level_crossing")];
        assert!(!SignalTags::parse(&tram).unwrap().on_rails);
    }

    #[test]
    fn a_signal_for_one_direction_says_so() {
        let tags = [("highway", "traffic_signals"), ("traffic_signals:direction", "backward")];
        assert_eq!(SignalTags::parse(&tags).unwrap().forward, Some(false));
    }
}

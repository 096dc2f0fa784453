//! What a node says of signals.

use super::value::{Tags, tag};

/// What the tags of a signal node say beside `highway=traffic_signals`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SignalTags {
    /// Direction of traffic that it is for, relative to its way; `None` if not tagged or both.
    pub forward: Option<bool>,
    /// Whether it is (also) a crossing of pedestrians.
    pub crossing: bool,
    /// Whether it meters a ramp.
    pub meter: bool,
}

impl SignalTags {
    /// Returns what the tags of a node say; `None` if it is no signal for vehicles.
    ///
    /// A crossing with signals alone (`highway=crossing`) is none.
    pub fn parse(tags: &Tags<'_>) -> Option<Self> {
        if tag(tags, "highway") != Some("traffic_signals") {
            return None;
        }
        let crossing = tag(tags, "crossing").is_some_and(|v| v != "no")
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
        let meter = tag(tags, "traffic_signals") == Some("ramp_meter");
        Some(Self { forward, crossing, meter })
    }
}

/// Returns whether a node with these tags is a crossing of pedestrians with signals, which stop vehicles too
/// but are not mapped as signals for them.
pub fn is_crossing_signal(tags: &Tags<'_>) -> bool {
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
        assert_eq!(both, Some(SignalTags { forward: None, crossing: true, meter: false }));
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
    fn a_signal_for_one_direction_says_so() {
        let tags = [("highway", "traffic_signals"), ("traffic_signals:direction", "backward")];
        assert_eq!(SignalTags::parse(&tags).unwrap().forward, Some(false));
    }
}

//! What the tags of ways and nodes mean: which ways are drivable, which way traffic goes, what a signal node controls.
//!
//! Drivable is what OSMnx's filter `drive` keeps.
//!
//! Deviation: the paper removes motorways and their links. They are streets here unless
//! `streets.motorways` and `streets.motorway_links` say otherwise: an off-ramp that ends at a signal is an
//! approach of it, and so is a motorway that does.
//!
//! Deviation: streets that are private to motor vehicles by another tag than `access`
//! (`motor_vehicle=private`, `motorcar=private`, `vehicle=no` or `private`) are not drivable either.
//! OSMnx keeps them, but private drives would end the approaches of public streets.

mod closed;
mod highway;
pub mod lanes;
mod signal;
pub mod speed;
mod street;

pub use highway::Highway;
pub use signal::SignalTags;
pub(crate) use signal::is_crossing_signal;
pub use street::Street;

/// Tags that say lane by lane whether motor vehicles may use it.
const LANE_ACCESS: [&str; 3] = ["motor_vehicle:lanes", "vehicle:lanes", "access:lanes"];

/// Values of access tags that keep the public's motor vehicles out.
const CLOSED: [&str; 2] = ["no", "private"];

/// Values of access tags that let the public's motor vehicles in, whatever a more general tag says.
const OPEN: [&str; 4] = ["yes", "designated", "permissive", "destination"];

/// Tags that say who may drive, the most specific first.
const WHO: [&str; 4] = ["motorcar", "motor_vehicle", "vehicle", "access"];

/// Values of `highway` that are not drivable (OSMnx's filter).
const NOT_DRIVABLE: [&str; 27] = [
    "abandoned", "bridleway", "bus_guideway", "busway", "construction", "corridor", "cycleway",
    "elevator", "escalator", "footway", "no", "path", "pedestrian", "planned", "platform",
    "proposed", "raceway", "razed", "rest_area", "service", "services", "steps", "track",
    "crossing", "demolished", "via_ferrata", "motorway_junction",
];

/// Values of `service` that OSMnx's filter leaves out.
const SERVICE: [&str; 6] =
    ["alley", "driveway", "emergency_access", "parking", "parking_aisle", "private"];

/// Which way traffic goes, relative to the order of a way's nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Both ways.
    Both,
    /// One-way, as the nodes go.
    Forward,
    /// One-way, against the nodes (`oneway=-1`).
    Backward,
}

impl Direction {
    /// Returns whether traffic goes as the nodes go (`true`) or against them (`false`).
    pub fn allows(self, forward: bool) -> bool {
        match self {
            Self::Both => true,
            Self::Forward => forward,
            Self::Backward => !forward,
        }
    }
}

/// Returns which way traffic goes, as OSMnx reads `oneway`; a motorway is one-way unless it says otherwise,
/// as OpenStreetMap has it.
///
/// Deviation: `oneway=no` on a roundabout does not make it two-way in OSMnx either, but
/// `junction=circular` counts as a roundabout here.
fn direction(tags: &Tags<'_>) -> Direction {
    let roundabout = matches!(tag(tags, "junction"), Some("roundabout" | "circular"));
    match tag(tags, "oneway") {
        Some("-1" | "reverse" | "T") => Direction::Backward,
        Some("yes" | "true" | "1" | "F") => Direction::Forward,
        _ if roundabout => Direction::Forward,
        None if tag(tags, "highway") == Some("motorway") => Direction::Forward,
        // A two-way street that vehicles, but not buses or bicycles, may use in one direction only.
        _ => match (is_closed(tags, ":forward"), is_closed(tags, ":backward")) {
            (false, true) => Direction::Forward,
            (true, false) => Direction::Backward,
            _ => Direction::Both,
        },
    }
}

/// Tags of a way or node, in the order of the file.
pub type Tags<'a> = [(&'a str, &'a str)];

pub(crate) fn tag<'a>(tags: &Tags<'a>, key: &str) -> Option<&'a str> {
    tags.iter().find(|(k, _)| *k == key).map(|(_, v)| *v)
}

fn closes(value: &str) -> bool {
    CLOSED.contains(&value)
}

/// Returns whether the public's motor vehicles are kept out: the most specific tag that says so or the opposite decides.
fn is_closed(tags: &Tags<'_>, suffix: &str) -> bool {
    let values = WHO.iter().filter_map(|key| match suffix {
        "" => tag(tags, key),
        suffix => tag(tags, &format!("{key}{suffix}")),
    });
    let mut values = values.filter(|value| closes(value) || OPEN.contains(value));
    values.next().is_some_and(closes)
}

/// Returns what is said of motor vehicles lane by lane, for a suffix of `turn:lanes`.
fn lane_by_lane<'a>(tags: &Tags<'a>, suffix: &str) -> Option<Vec<&'a str>> {
    let mut found = LANE_ACCESS.iter().filter_map(|key| tag(tags, &format!("{key}{suffix}")));
    found.next().map(|text| text.split('|').map(str::trim).collect())
}

/// Returns whether a way with these tags is a street for this project.
///
/// Deviation: OSMnx keeps `access=no`, and looks at no tag that is more specific than one that closes a way.
fn drivable(tags: &Tags<'_>) -> bool {
    let is = |key, values: &[&str]| tag(tags, key).is_some_and(|v| values.contains(&v));
    tag(tags, "highway").is_some_and(|h| !NOT_DRIVABLE.contains(&h))
        && !is("area", &["yes"])
        && !is_closed(tags, "")
        && !is("service", &SERVICE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_that_is_closed_to_motor_vehicles_makes_a_street_one_way() {
        assert_eq!(direction(&[("motor_vehicle:backward", "no")]), Direction::Forward);
        assert_eq!(direction(&[("vehicle:forward", "private")]), Direction::Backward);
        let open = [("access:backward", "no"), ("motorcar:backward", "yes")];
        assert_eq!(direction(&open), Direction::Both);
        let neither = [("access:backward", "no"), ("access:forward", "no")];
        assert_eq!(direction(&neither), Direction::Both);
        let tagged = [("oneway", "-1"), ("vehicle:backward", "no")];
        assert_eq!(direction(&tagged), Direction::Backward);
    }

    #[test]
    fn what_osmnx_drives_on_is_drivable() {
        for value in ["motorway", "trunk", "residential", "living_street", "motorway_link", "road"]
        {
            assert!(drivable(&[("highway", value)]), "{value}");
        }
        for value in ["service", "footway", "construction", "track"] {
            assert!(!drivable(&[("highway", value)]), "{value}");
        }
        for other in [
            ("area", "yes"),
            ("access", "private"),
            ("access", "no"),
            ("motor_vehicle", "no"),
            ("motorcar", "no"),
            ("motor_vehicle", "private"),
            ("motorcar", "private"),
            ("vehicle", "no"),
            ("vehicle", "private"),
            ("service", "alley"),
        ] {
            assert!(!drivable(&[("highway", "residential"), other]), "{other:?}");
        }
        assert!(!drivable(&[("building", "yes")]));
    }

    #[test]
    fn a_tag_of_motor_vehicles_wins_over_that_of_all_vehicles() {
        let with = |key, value| {
            drivable(&[("highway", "residential"), ("vehicle", "private"), (key, value)])
        };
        assert!(with("motor_vehicle", "yes") && with("motorcar", "designated"));
        assert!(!with("motor_vehicle", "delivery") && !with("bicycle", "yes"));
        let open = [("highway", "residential"), ("access", "private"), ("motor_vehicle", "yes")];
        assert!(drivable(&open));
        let buses = [("highway", "residential"), ("access", "no"), ("bus", "yes")];
        assert!(!drivable(&buses));
    }
}

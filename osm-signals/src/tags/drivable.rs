//! Which ways are drivable: what OSMnx's filter `drive` keeps, less private drives.

use super::access::is_closed;
use super::value::{Tags, tag};

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

/// Returns whether a way with these tags is a street for this project.
///
/// Deviation: OSMnx keeps `access=no`, and looks at no tag that is more specific than one that closes a way.
pub fn drivable(tags: &Tags<'_>) -> bool {
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

//! What the tags of ways and nodes mean: which ways are drivable, which way traffic goes, what a
//! signal node controls.
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

pub mod lanes;
pub mod speed;

use serde::{Deserialize, Serialize};

use super::oddities::Oddities;
use crate::traffic::side::DrivingSide;
use lanes::{LaneTags, TurnTags};
use speed::SpeedTags;

/// Tags of a way or node, in the order of the file.
pub type Tags<'a> = [(&'a str, &'a str)];

/// Returns the value of a tag.
pub fn tag<'a>(tags: &Tags<'a>, key: &str) -> Option<&'a str> {
    tags.iter().find(|(k, _)| *k == key).map(|(_, v)| *v)
}

/// Class of a drivable street: its `highway` tag.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Highway {
    /// `motorway`.
    Motorway,
    /// `trunk`.
    Trunk,
    /// `primary`.
    Primary,
    /// `secondary`.
    Secondary,
    /// `tertiary`.
    Tertiary,
    /// `unclassified`.
    Unclassified,
    /// `residential`.
    Residential,
    /// `living_street`.
    LivingStreet,
    /// `trunk_link`.
    TrunkLink,
    /// `primary_link`.
    PrimaryLink,
    /// `secondary_link`.
    SecondaryLink,
    /// `tertiary_link`.
    TertiaryLink,
    /// `motorway_link`: a ramp.
    MotorwayLink,
    /// Any other value that the filter lets through, such as `road`.
    Other,
}

impl Highway {
    /// All classes with the names that files and settings use.
    pub const NAMES: [(Self, &'static str); 14] = [
        (Self::Motorway, "motorway"),
        (Self::Trunk, "trunk"),
        (Self::Primary, "primary"),
        (Self::Secondary, "secondary"),
        (Self::Tertiary, "tertiary"),
        (Self::Unclassified, "unclassified"),
        (Self::Residential, "residential"),
        (Self::LivingStreet, "living_street"),
        (Self::TrunkLink, "trunk_link"),
        (Self::PrimaryLink, "primary_link"),
        (Self::SecondaryLink, "secondary_link"),
        (Self::TertiaryLink, "tertiary_link"),
        (Self::MotorwayLink, "motorway_link"),
        (Self::Other, "other"),
    ];

    /// Returns the name.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize].1
    }

    /// Returns whether it is a motorway or a ramp of one.
    pub fn is_motorway(self) -> bool {
        matches!(self, Self::Motorway | Self::MotorwayLink)
    }

    /// Returns whether it is a link, such as a slip lane.
    pub fn is_link(self) -> bool {
        use Highway::{MotorwayLink, PrimaryLink, SecondaryLink, TertiaryLink, TrunkLink};
        matches!(self, TrunkLink | PrimaryLink | SecondaryLink | TertiaryLink | MotorwayLink)
    }
}

/// Values of `highway` that are not drivable (OSMnx's filter).
const NOT_DRIVABLE: [&str; 27] = [
    "abandoned",
    "bridleway",
    "bus_guideway",
    "busway",
    "construction",
    "corridor",
    "cycleway",
    "elevator",
    "escalator",
    "footway",
    "no",
    "path",
    "pedestrian",
    "planned",
    "platform",
    "proposed",
    "raceway",
    "razed",
    "rest_area",
    "service",
    "services",
    "steps",
    "track",
    "crossing",
    "demolished",
    "via_ferrata",
    "motorway_junction",
];

/// Values of `service` that OSMnx's filter leaves out.
const SERVICE: [&str; 6] =
    ["alley", "driveway", "emergency_access", "parking", "parking_aisle", "private"];

/// Values of access tags that keep the public's motor vehicles out.
const CLOSED: [&str; 2] = ["no", "private"];

/// Values of access tags that let the public's motor vehicles in, whatever a more general tag says.
const OPEN: [&str; 4] = ["yes", "designated", "permissive", "destination"];

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

/// A drivable way's tags.
#[derive(Debug, Clone, PartialEq)]
pub struct Street {
    /// Its class.
    pub highway: Highway,
    /// Which way traffic goes.
    pub direction: Direction,
    /// Whether it is part of a roundabout or traffic circle.
    pub roundabout: bool,
    /// Numbers of lanes.
    pub lanes: LaneTags,
    /// Turns that lanes are marked for; most ways have none.
    pub turns: Option<Box<TurnTags>>,
    /// Speed limits.
    pub speed: SpeedTags,
    /// Side of the street that traffic keeps to on it.
    pub driving_side: Option<DrivingSide>,
    /// Its name, or else its number.
    pub name: Option<Box<str>>,
}

impl Street {
    /// Returns what the tags of a way say; `None` if it is not drivable.
    ///
    /// Unusable values are ignored and counted in `oddities`.
    pub fn parse(way: i64, tags: &Tags<'_>, oddities: &mut Oddities) -> Option<Self> {
        if !drivable(tags) {
            return None;
        }
        let value = tag(tags, "highway")?;
        let known = Highway::NAMES.iter().find(|(_, name)| *name == value);
        let highway = known.map_or(Highway::Other, |(class, _)| *class);
        let roundabout = matches!(tag(tags, "junction"), Some("roundabout" | "circular"));
        let name = tag(tags, "name").or_else(|| tag(tags, "ref")).filter(|n| !n.is_empty());
        let direction = direction(tags);
        Some(Self {
            highway,
            direction,
            roundabout,
            lanes: LaneTags::parse(way, tags, direction, oddities),
            turns: TurnTags::parse(way, tags, oddities).map(Box::new),
            speed: SpeedTags::parse(way, tags, oddities),
            driving_side: match tag(tags, "driving_side") {
                Some("left") => Some(DrivingSide::Left),
                Some("right") => Some(DrivingSide::Right),
                _ => None,
            },
            name: name.map(Into::into),
        })
    }

    /// Returns the memory beside the street itself, bytes.
    pub fn heap_bytes(&self) -> usize {
        let turns = self.turns.as_ref().map_or(0, |t| size_of_val(&**t) + t.heap_bytes());
        turns + self.name.as_ref().map_or(0, |n| n.len())
    }
}

/// Returns whether a way with these tags is a street for this project.
pub fn drivable(tags: &Tags<'_>) -> bool {
    let is = |key, values: &[&str]| tag(tags, key).is_some_and(|v| values.contains(&v));
    tag(tags, "highway").is_some_and(|h| !NOT_DRIVABLE.contains(&h))
        && !is("area", &["yes"])
        && !is("access", &["private"])
        && !is("motor_vehicle", &CLOSED)
        && !is("motorcar", &CLOSED)
        && (!is("vehicle", &CLOSED) || is("motor_vehicle", &OPEN) || is("motorcar", &OPEN))
        && !is("service", &SERVICE)
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
        _ => Direction::Both,
    }
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

    fn street(tags: &Tags<'_>) -> Option<Street> {
        Street::parse(1, tags, &mut Oddities::default())
    }

    #[test]
    fn names_stand_in_the_order_of_the_classes() {
        assert!(Highway::NAMES.iter().enumerate().all(|(i, (class, _))| *class as usize == i));
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
    }

    #[test]
    fn oneway_has_three_ways_to_say_backward() {
        for value in ["-1", "reverse", "T"] {
            let street = street(&[("highway", "primary"), ("oneway", value)]).unwrap();
            assert_eq!(street.direction, Direction::Backward, "{value}");
        }
        for value in ["yes", "true", "1", "F"] {
            let street = street(&[("highway", "primary"), ("oneway", value)]).unwrap();
            assert_eq!(street.direction, Direction::Forward, "{value}");
        }
        for value in ["no", "reversible", "false"] {
            let street = street(&[("highway", "primary"), ("oneway", value)]).unwrap();
            assert_eq!(street.direction, Direction::Both, "{value}");
        }
    }

    #[test]
    fn a_roundabout_is_one_way() {
        let street = street(&[("highway", "primary"), ("junction", "roundabout")]).unwrap();
        assert!(street.roundabout);
        assert_eq!(street.direction, Direction::Forward);
    }

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

//! Settings of how an extract is read. Every field has a default, also where a file is deserialised.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::counts::CountSettings;
use super::driving_side::DrivingSide;
use super::error::check_range;
use super::signals::SignalColumns;
use super::tags::Highway;

/// Everything that decides which intersections an extract has, with which arms and how much traffic.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// What is assumed where tags say nothing.
    pub streets: StreetSettings,
    /// Which nodes are one intersection, and which legs one arm.
    pub intersections: IntersectionSettings,
    /// Columns of a signal list.
    pub signals: SignalColumns,
    /// How counts are read and matched.
    pub counts: CountSettings,
    /// How much traffic arms carry.
    pub traffic: TrafficSettings,
}

/// What is assumed where neither a way nor others of its class say anything.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StreetSettings {
    /// Speed limit, miles per hour (the paper's).
    pub default_speed_mph: f64,
    /// Whether motorways are streets.
    ///
    /// Deviation: the paper removes them, and with them approaches where one ends at a signal.
    pub motorways: bool,
    /// Whether ramps (`motorway_link`) are streets.
    ///
    /// Deviation: the paper removes them, too, and with them the intersections at their ends.
    pub motorway_links: bool,
    /// Lanes per direction by highway class.
    pub default_lanes: BTreeMap<Highway, u8>,
    /// Side of the street that traffic keeps to; by default that of the place, which has to be said where it may be either.
    pub driving_side: Option<DrivingSide>,
    /// Distance from the junction within which the best tagged piece of a leg gives its lanes,
    /// metres: ways are often split shortly before the stop line, and the last bit left untagged.
    pub stop_line_m: f64,
    /// When the simulated hour begins, hours after midnight of a working day: turn restrictions that hold in
    /// the middle of that hour are applied. By default the morning peak, as is the peak direction of traffic.
    pub time_of_day: f64,
}

impl Default for StreetSettings {
    fn default() -> Self {
        let lanes = |class: Highway| match class {
            Highway::Motorway | Highway::Trunk | Highway::Primary => 2,
            _ => 1,
        };
        Self {
            default_speed_mph: 25.0,
            motorways: true,
            motorway_links: true,
            default_lanes: Highway::NAMES.iter().map(|(c, _)| (*c, lanes(*c))).collect(),
            driving_side: None,
            stop_line_m: 25.0,
            time_of_day: 8.0,
        }
    }
}

impl StreetSettings {
    /// Returns whether ways of a class are streets.
    pub fn is_street(&self, class: Highway) -> bool {
        match class {
            Highway::Motorway => self.motorways,
            Highway::MotorwayLink => self.motorway_links,
            _ => true,
        }
    }
}

/// Which nodes are one intersection, and which legs one arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct IntersectionSettings {
    /// Farthest that a signal before a junction may stand from it, metres along the street.
    pub signal_reach_m: f64,
    /// Signalised junctions at most this far apart along a street are one, metres.
    pub join_m: f64,
    /// Whether a junction has a signal if pedestrians cross all of its streets at one, although no node
    /// is a signal for vehicles.
    pub from_crossings: bool,
    /// Widest median: crossings with the two carriageways of one street at most this far apart
    /// are one intersection, metres.
    pub median_m: f64,
    /// Farthest that the signals of two ramps may be apart along a street to be one intersection, metres: one
    /// controller runs a single-point interchange, and vehicles have no room between.
    pub ramps_m: f64,
    /// Largest distance between two nodes of one intersection, metres.
    pub max_extent_m: f64,
    /// Farthest from the junction that a slip lane may begin or end, metres along the street.
    pub slip_reach_m: f64,
    /// Distance from the junction at which the bearing of an arm is taken, metres.
    pub bearing_at_m: f64,
    /// Shortest length that an approach is given, metres: a network needs room to stop in.
    pub min_length_m: f64,
    /// Longest that an approach is made, metres: vehicles would only drive longer.
    pub max_length_m: f64,
    /// Farthest that an intersection may be from its place in the signal list, metres.
    pub list_match_m: f64,
}

impl Default for IntersectionSettings {
    fn default() -> Self {
        Self {
            signal_reach_m: 50.0,
            join_m: 30.0,
            from_crossings: true,
            median_m: 45.0,
            ramps_m: 50.0,
            max_extent_m: 100.0,
            slip_reach_m: 80.0,
            bearing_at_m: 40.0,
            min_length_m: 25.0,
            max_length_m: 5000.0,
            list_match_m: 40.0,
        }
    }
}

/// How much traffic arms carry.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrafficSettings {
    /// Whether a count is the total of both directions of a two-way street.
    pub both_directions: bool,
    /// Annual average daily traffic per lane towards the signal by highway class where no count is known, vehicles per day.
    ///
    /// Source: the middle of FHWA's ranges for urban roads (Highway Functional Classification, 2013, tables 3-5 and 3-6:
    /// principal arterials 7,000 to 27,000, minor arterials 3,000 to 14,000, collectors 1,100 to 6,300, local roads 80 to
    /// 700), over four, two, two and two lanes.
    pub default_aadt_per_lane: BTreeMap<Highway, f64>,
}

impl Default for TrafficSettings {
    fn default() -> Self {
        let aadt = |class: Highway| match class {
            Highway::Trunk | Highway::TrunkLink | Highway::Primary | Highway::PrimaryLink => 4250.0,
            Highway::Secondary | Highway::SecondaryLink => 4250.0,
            Highway::Motorway | Highway::MotorwayLink => 4250.0,
            Highway::Tertiary | Highway::TertiaryLink => 1850.0,
            _ => 195.0,
        };
        Self {
            both_directions: true,
            default_aadt_per_lane: Highway::NAMES.iter().map(|(c, _)| (*c, aadt(*c))).collect(),
        }
    }
}

impl Settings {
    /// Fills in the classes that a file leaves out.
    #[must_use]
    pub fn completed(mut self) -> Self {
        let usual = Self::default();
        for (class, lanes) in usual.streets.default_lanes {
            self.streets.default_lanes.entry(class).or_insert(lanes);
        }
        for (class, aadt) in usual.traffic.default_aadt_per_lane {
            self.traffic.default_aadt_per_lane.entry(class).or_insert(aadt);
        }
        self
    }

    /// Checks the numbers.
    pub fn check(&self) -> Result<(), String> {
        let (s, i) = (&self.streets, &self.intersections);
        let ranges = [
            ("streets.default_speed_mph", s.default_speed_mph, 3.0, 100.0),
            ("streets.stop_line_m", s.stop_line_m, 0.0, 200.0),
            ("streets.time_of_day", s.time_of_day, 0.0, 24.0),
            ("intersections.signal_reach_m", i.signal_reach_m, 0.0, 200.0),
            ("intersections.join_m", i.join_m, 0.0, 200.0),
            ("intersections.median_m", i.median_m, i.join_m, 200.0),
            ("intersections.ramps_m", i.ramps_m, 0.0, 200.0),
            ("intersections.max_extent_m", i.max_extent_m, 10.0, 500.0),
            ("intersections.slip_reach_m", i.slip_reach_m, 0.0, 300.0),
            ("intersections.bearing_at_m", i.bearing_at_m, 1.0, 200.0),
            ("intersections.min_length_m", i.min_length_m, 10.0, 1000.0),
            ("intersections.max_length_m", i.max_length_m, i.min_length_m, 20_000.0),
            ("intersections.list_match_m", i.list_match_m, 1.0, 500.0),
        ];
        for (setting, value, low, high) in ranges {
            check_range(setting, value, (low, high))?;
        }
        for (class, lanes) in &s.default_lanes {
            let setting = format!("streets.default_lanes.{}", class.name());
            check_range(&setting, f64::from(*lanes), (1.0, 6.0))?;
        }
        for (class, aadt) in &self.traffic.default_aadt_per_lane {
            let setting = format!("traffic.default_aadt_per_lane.{}", class.name());
            check_range(&setting, *aadt, (0.0, 1e5))?;
        }
        self.counts.check()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_that_a_file_leaves_out_keep_their_defaults() {
        let settings: Settings = toml::from_str("[streets.default_lanes]\nprimary = 3\n").unwrap();
        let settings = settings.completed();
        assert_eq!(settings.streets.default_lanes[&Highway::Primary], 3);
        assert_eq!(settings.streets.default_lanes[&Highway::Trunk], 2);
    }

    #[test]
    fn a_count_per_lane_without_end_is_refused_with_the_range() {
        let settings: Settings =
            toml::from_str("[counts]\nmax_veh_per_day_per_lane = inf\n").unwrap();
        assert_eq!(
            settings.check().unwrap_err(),
            "counts.max_veh_per_day_per_lane: inf: expected a number from 1 to 1000000"
        );
        assert_eq!(Settings::default().check(), Ok(()));
    }
}

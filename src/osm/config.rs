//! Settings of `build-networks --osm`: a TOML file of which every field has a default.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::OsmError;
use super::counts::CountSettings;
use super::error::shortened;
use super::side::SideSetting;
use super::signals::SignalColumns;
use super::table;
use super::tags::Highway;
use crate::settings::within;
use crate::traffic::settings::inflow::{EVEN_SPLIT, NORTH_EAST_DEG};

/// Most characters of what the parser says, which quotes whole lines.
const PARSER_CHARS: usize = 500;

/// Everything that decides how an extract becomes a family.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OsmConfig {
    /// What is assumed where tags say nothing.
    pub streets: StreetSettings,
    /// Which nodes are one intersection, and which legs one arm.
    pub intersections: IntersectionSettings,
    /// Columns of a signal list.
    pub signals: SignalColumns,
    /// How counts are read and matched.
    pub counts: CountSettings,
    /// How many vehicles arrive.
    pub traffic: TrafficSettings,
    /// Settings for the scenario that is written: the tables of a scenario file, such as
    /// `[scenario.family]` with `hourly_share`.
    pub scenario: toml::Table,
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
    /// Side of the street that traffic keeps to.
    pub driving_side: SideSetting,
    /// Distance from the junction within which the best tagged piece of a leg gives its lanes,
    /// metres: ways are often split shortly before the stop line, and the last bit left untagged.
    pub stop_line_m: f64,
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
            driving_side: SideSetting::Auto,
            stop_line_m: 25.0,
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
            max_extent_m: 100.0,
            slip_reach_m: 80.0,
            bearing_at_m: 40.0,
            min_length_m: 25.0,
            max_length_m: 5000.0,
            list_match_m: 40.0,
        }
    }
}

/// How many vehicles arrive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrafficSettings {
    /// Whether a count is the total of both directions of a two-way street.
    pub both_directions: bool,
    /// Share of the day's traffic in the simulated hour (the factor K), written to the scenario.
    ///
    /// Source: a design hour on urban streets, Highway Capacity Manual; FDOT's standard K factor of
    /// urban arterials.
    pub hourly_share: f64,
    /// Share of that hour that goes in the peak direction of a two-way street (the factor D), written
    /// to the scenario; only where counts are totals of both directions, else directions are as counted.
    pub directional_split: f64,
    /// Heading around which the peak direction of all streets lies, degrees clockwise from north,
    /// written to the scenario: see [`crate::traffic::settings::inflow`] for the rule.
    pub peak_heading_deg: f64,
    /// Annual average daily traffic per lane by highway class where no count is known, vehicles
    /// per day.
    ///
    /// Source: the middle of FHWA's ranges for urban roads (Highway Functional Classification,
    /// 2013, tables 3-5 and 3-6: principal arterials 7,000 to 27,000, minor arterials 3,000 to
    /// 14,000, collectors 1,100 to 6,300, local roads 80 to 700), over four, two, two and two
    /// lanes.
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
            hourly_share: 0.09,
            directional_split: 0.55,
            peak_heading_deg: NORTH_EAST_DEG,
            default_aadt_per_lane: Highway::NAMES.iter().map(|(c, _)| (*c, aadt(*c))).collect(),
        }
    }
}

impl OsmConfig {
    /// Reads settings from a file.
    ///
    /// # Errors
    ///
    /// [`OsmError::Io`] if it cannot be read, [`OsmError::Malformed`] naming line or field.
    pub fn read(path: &Path) -> Result<Self, OsmError> {
        let bytes = table::bytes(path)?;
        let at = |place: &str, reason: String| OsmError::Malformed {
            path: path.to_path_buf(),
            place: place.to_owned(),
            reason,
        };
        let text = String::from_utf8(bytes)
            .map_err(|_| at("text", "not UTF-8; save the file as UTF-8".to_owned()))?;
        let config: Self = toml::from_str(&text).map_err(|e| at("settings", parser_message(&e)))?;
        config.check().map_err(|(field, reason)| at(&field, reason))?;
        Ok(config.completed())
    }

    /// Fills in the classes that a file leaves out.
    fn completed(mut self) -> Self {
        let usual = Self::default();
        for (class, lanes) in usual.streets.default_lanes {
            self.streets.default_lanes.entry(class).or_insert(lanes);
        }
        for (class, aadt) in usual.traffic.default_aadt_per_lane {
            self.traffic.default_aadt_per_lane.entry(class).or_insert(aadt);
        }
        self
    }

    /// Returns the first field that is out of range and why.
    fn check(&self) -> Result<(), (String, String)> {
        let (s, i, t) = (&self.streets, &self.intersections, &self.traffic);
        let ranges = [
            ("streets.default_speed_mph", s.default_speed_mph, 3.0, 100.0),
            ("streets.stop_line_m", s.stop_line_m, 0.0, 200.0),
            ("intersections.signal_reach_m", i.signal_reach_m, 0.0, 200.0),
            ("intersections.join_m", i.join_m, 0.0, 200.0),
            ("intersections.median_m", i.median_m, i.join_m, 200.0),
            ("intersections.max_extent_m", i.max_extent_m, 10.0, 500.0),
            ("intersections.slip_reach_m", i.slip_reach_m, 0.0, 300.0),
            ("intersections.bearing_at_m", i.bearing_at_m, 1.0, 200.0),
            ("intersections.min_length_m", i.min_length_m, 10.0, 1000.0),
            ("intersections.max_length_m", i.max_length_m, i.min_length_m, 20_000.0),
            ("intersections.list_match_m", i.list_match_m, 1.0, 500.0),
            ("traffic.hourly_share", t.hourly_share, 1e-6, 1.0),
            ("traffic.directional_split", t.directional_split, EVEN_SPLIT, 1.0),
            ("traffic.peak_heading_deg", t.peak_heading_deg, 0.0, 360.0),
        ];
        let ranges = ranges.map(|(field, v, low, high)| (field.to_owned(), v, low, high));
        let lanes = s.default_lanes.iter().map(|(class, lanes)| {
            (format!("streets.default_lanes.{}", class.name()), f64::from(*lanes), 1.0, 6.0)
        });
        let aadt = t.default_aadt_per_lane.iter().map(|(class, aadt)| {
            (format!("traffic.default_aadt_per_lane.{}", class.name()), *aadt, 0.0, 1e5)
        });
        for (field, value, low, high) in ranges.into_iter().chain(lanes).chain(aadt) {
            within(value, low, high).map_err(|expected| (field, format!("{value}: {expected}")))?;
        }
        self.counts.check().map_err(|(field, reason)| (format!("counts.{field}"), reason))
    }
}

/// Returns what the parser says; without the line that it quotes if that is long.
fn parser_message(error: &toml::de::Error) -> String {
    let full = error.to_string();
    if full.chars().nth(PARSER_CHARS).is_none() {
        return full.trim_end().to_owned();
    }
    let place = full.lines().next().unwrap_or_default();
    shortened(&format!("{place}: {}", error.message()), PARSER_CHARS)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config(text: &str) -> Result<OsmConfig, OsmError> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        OsmConfig::read(file.path())
    }

    #[test]
    fn the_commented_file_has_the_defaults() {
        let text = include_str!("../../scenarios/openstreetmap.toml");
        assert_eq!(config(text).unwrap(), OsmConfig::default());
    }

    #[test]
    fn classes_that_a_file_leaves_out_keep_their_defaults() {
        let config = config("[streets.default_lanes]\nprimary = 3\n").unwrap();
        assert_eq!(config.streets.default_lanes[&Highway::Primary], 3);
        assert_eq!(config.streets.default_lanes[&Highway::Trunk], 2);
    }

    #[test]
    fn a_value_out_of_range_is_named_with_its_range() {
        let error = config("[traffic]\ndirectional_split = nan\n").unwrap_err().to_string();
        assert!(error.contains("traffic.directional_split: NaN: expected a number from 0.5 to 1"));
    }

    #[test]
    fn a_message_does_not_quote_lines_without_end() {
        let long = "x".repeat(100_000);
        for text in [
            format!("[traffic]\ndirectional_split = \"{long}\"\n"),
            format!("{long} = 3\n"),
            format!("a = {long}\n"),
        ] {
            let error = config(&text).unwrap_err().to_string();
            assert!(error.len() < 700 && error.contains("line "), "{error}");
        }
        let error = config("[traffic]\ndirectional_split = \"half\"\n").unwrap_err().to_string();
        assert!(error.contains("2 | directional_split = \"half\""), "{error}");
    }

    #[test]
    fn a_count_per_lane_without_end_is_refused_with_the_range() {
        let error = config("[counts]\nmax_veh_per_day_per_lane = inf\n").unwrap_err().to_string();
        assert!(
            error.ends_with(
                "counts.max_veh_per_day_per_lane: inf: expected a number from 1 to 1000000"
            ),
            "{error}"
        );
    }

    #[test]
    fn an_unknown_class_is_refused() {
        let error = config("[streets.default_lanes]\nboulevard = 2\n").unwrap_err().to_string();
        assert!(error.contains("boulevard"), "{error}");
    }
}

//! Traffic counts (AADT) and their join to streets.
//!
//! Counts come as GeoJSON, a line per counted stretch of road, or as CSV, a row per count
//! station. A count is the traffic of a road in both directions, of a one-way road in its one.
//!
//! The join looks along a street, from its junction outwards, for counted lines that run beside
//! it. Taking the nearest line instead gives a street the traffic of a freeway that crosses above
//! it (which happened in the embedded family: 200,403 vehicles per day on one lane) or of the
//! street that it meets; so a line has to have the street's direction, has to stay near it, and
//! its count has to be possible on the street's lanes.

mod csv;
mod field;
mod geojson;
mod index;
mod samples;

use std::path::{Path, PathBuf};

use geo::Rect;
use serde::{Deserialize, Serialize};

use self::index::Index;
use super::error::{OsmError, brief};
use super::extract::Place;
use super::oddities::Oddities;
use super::table;
use crate::settings::within;

/// Ends of the names of files that hold GeoJSON, also if they are empty.
const JSON: [&str; 2] = ["json", "geojson"];

/// Which number is the count and when a count belongs to a street.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CountSettings {
    /// Property or column with the count, vehicles per day; by default the one named AADT, that
    /// of the latest year if there are several.
    pub field: Option<String>,
    /// Greatest distance of the street from the counted line or station, metres.
    pub match_m: f64,
    /// Greatest angle between the axes of the street and of the counted line, degrees.
    pub match_deg: f64,
    /// How far along its street a count stands for other blocks too, metres; 0 keeps it where it is.
    pub spread_m: f64,
    /// Greatest count per lane of the street, vehicles per day; above it a count is taken for
    /// another road, such as a freeway above or beside.
    pub max_veh_per_day_per_lane: f64,
}

impl Default for CountSettings {
    fn default() -> Self {
        Self {
            field: None,
            // Half the width of a divided road of eight lanes with its median. In Salt Lake City
            // three quarters of the matches are within 4 m; at 30 m 69% of the arms have one and
            // 1.4% of streets moved by 60 m, where none is; 50 m finds 2% more arms and nearly
            // triples the wrong ones (tests/osm_salt_lake_city.rs).
            match_m: 30.0,
            // A grid of streets has its next axis at 90 degrees, a fork at 45.
            match_deg: 30.0,
            // Leaving out each of 403 counted sections of streets in Salt Lake City (UDOT, 2019, no
            // freeways; neighbours with one value are one section), the next section of the street within
            // 1000 m is off by a factor of 1.26 in the median, the mean of its class (state route or
            // not) by 1.44; 49% and 34% are within 25%, 15% and 24% off by more than 2. Within 250 m
            // and within 2500 m it is 1.27.
            spread_m: 1000.0,
            // More than twice what a signal with half the green lets through: 1900 veh/h of
            // saturation flow in a peak hour of 9% of the day give 10,500 vehicles per day. In
            // Salt Lake City 6 of 763 joined arms are above it, all on freeways.
            max_veh_per_day_per_lane: 25_000.0,
        }
    }
}

impl CountSettings {
    /// Checks the numbers.
    ///
    /// # Errors
    ///
    /// The setting and what is wrong with it.
    pub fn check(&self) -> Result<(), (&'static str, String)> {
        for (name, value, low, high) in [
            ("match_m", self.match_m, 1.0, 1000.0),
            ("match_deg", self.match_deg, 1.0, 90.0),
            ("spread_m", self.spread_m, 0.0, 10_000.0),
            ("max_veh_per_day_per_lane", self.max_veh_per_day_per_lane, 1.0, 1e6),
        ] {
            within(value, low, high).map_err(|expected| (name, format!("{value}: {expected}")))?;
        }
        Ok(())
    }
}

/// A count that belongs to a street.
#[derive(Debug, Clone, PartialEq)]
pub struct CountMatch {
    /// The count: annual average daily traffic of the road, vehicles per day, of both directions
    /// unless the road is one-way.
    pub aadt_veh_per_day: f64,
    /// Mean distance of the street from the counted line, metres.
    pub distance_m: f64,
    /// Mean angle between their axes, degrees; 0 for a station without a bearing.
    pub angle_deg: f64,
    /// Id of the counted line or station, or else its number in the file, such as `feature 7`.
    pub id: String,
}

/// Where something was counted.
#[derive(Debug, Clone, PartialEq)]
enum Shape {
    /// Along lines.
    Lines(Vec<Vec<Place>>),
    /// At a station, with the axis of its road in degrees clockwise from north if it is known.
    Station(Place, Option<f64>),
}

/// A line or station with its count.
#[derive(Debug, Clone, PartialEq)]
struct Counted {
    id: String,
    aadt_veh_per_day: f64,
    shape: Shape,
}

/// What a reader finds in a file.
struct Found {
    counted: Vec<Counted>,
    field: String,
    oddities: Oddities,
}

/// The counts of a file, to be joined to streets; at least one.
#[derive(Debug)]
pub struct Counts {
    index: Index,
    settings: CountSettings,
    field: String,
    oddities: Oddities,
}

impl Counts {
    /// Reads counts: GeoJSON with LineString and MultiLineString features in WGS 84, or CSV with
    /// latitude, longitude, aadt and, where they are known, bearing_deg (the axis of the street)
    /// and id. Which of the two a file is shows in its content.
    ///
    /// # Errors
    ///
    /// [`OsmError`] naming the file and the place: neither of the two, no property or column with
    /// counts, coordinates outside the world, no usable count at all, an unusable setting.
    pub fn read(path: &Path, settings: &CountSettings) -> Result<Self, OsmError> {
        Self::from_bytes(&table::bytes(path)?, path, settings)
    }

    /// Reads counts from the bytes of a file; `path` is for messages only.
    ///
    /// # Errors
    ///
    /// As [`Counts::read`].
    pub fn from_bytes(
        bytes: &[u8],
        path: &Path,
        settings: &CountSettings,
    ) -> Result<Self, OsmError> {
        settings.check().map_err(|(place, reason)| OsmError::Malformed {
            path: PathBuf::from(path),
            place: place.to_owned(),
            reason,
        })?;
        let text = table::text(bytes, path)?;
        let text = text.trim_start();
        let ending =
            path.extension().is_some_and(|e| JSON.iter().any(|j| e.eq_ignore_ascii_case(j)));
        let json = text.starts_with(['{', '[', '<']) || (text.is_empty() && ending);
        let field = settings.field.as_deref();
        let Found { counted, field, oddities } =
            if json { geojson::read(bytes, path, field)? } else { csv::read(bytes, path, field)? };
        let nothing = || {
            let skipped: Vec<_> = oddities
                .iter()
                .map(|(reason, o)| format!("{} ({} times, first {})", reason, o.count, o.example))
                .collect();
            let skipped = if skipped.is_empty() { "none".to_owned() } else { skipped.join(", ") };
            let reason = format!(
                "no usable count in {}; skipped: {skipped}; give lines or stations with a \
                 number of vehicles per day",
                brief(&field)
            );
            OsmError::Nothing { path: PathBuf::from(path), reason }
        };
        let index = Index::new(counted).ok_or_else(nothing)?;
        Ok(Self { index, settings: settings.clone(), field, oddities })
    }

    /// Returns the count of a street, if one belongs to it.
    ///
    /// # Arguments
    ///
    /// * `street`: its places from the junction outwards, at least two.
    /// * `lanes_both_directions`: its lanes; tells which counts are possible.
    ///
    /// Of the street's first 150 m a place every 10 m is compared with the counted lines; a line
    /// has to be near at least half of them and to run in the same axis there. Of several lines
    /// the one wins that is near most of them, each weighted with how near it is.
    /// A station has to be beside the street and not where it meets others; the nearest one wins.
    pub fn along(&self, street: &[Place], lanes_both_directions: u32) -> Option<CountMatch> {
        self.index.along(street, lanes_both_directions, &self.settings)
    }

    /// Returns how many counts lay along a street that was asked for but are above what its lanes
    /// can carry ([`CountSettings::max_veh_per_day_per_lane`]), each once. If they are many, the
    /// setting is too small or the field is no daily traffic.
    pub fn over_cap(&self) -> usize {
        self.index.over_cap()
    }

    /// Returns how many lines or stations have a count.
    pub fn len(&self) -> usize {
        self.index.len()
    }

    /// Returns `false`: a file without any count is an error.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the property or column that was read.
    pub fn field(&self) -> &str {
        &self.field
    }

    /// Returns what was skipped and why.
    pub fn oddities(&self) -> &Oddities {
        &self.oddities
    }

    /// Returns the smallest box around all counts: x is the longitude and y the latitude, degrees.
    pub fn bounds(&self) -> Rect<f64> {
        self.index.bounds()
    }
}

#[cfg(test)]
mod tests;

//! Traffic counts (AADT) and their join to streets.
//!
//! Counts come as GeoJSON, a line per counted stretch of road, or as CSV, a row per count
//! station. A count is the traffic of a road in both directions, of a one-way road in its one.
//!
//! The join looks along a street, from its junction outwards, for counted lines that run beside it. Taking the nearest line
//! instead gives a street the traffic of a freeway that crosses above it (which happened in the embedded family: 200,403
//! vehicles per day on one lane) or of the street that it meets; so a line has to have the street's direction, has to stay
//! near it, and its count has to be possible on the street's lanes.
//!
//! Of different counts of one place none is taken: they are left out and named.

mod conflicts;
mod csv;
mod geojson;
mod index;
mod settings;

use std::path::Path;

use geo::Rect;

use self::index::Index;
pub use self::settings::CountSettings;
use super::error::{OsmError, brief};
use super::extract::Place;
use super::file;
use super::oddities::Oddities;
use super::table;

/// Usual names of the column or property with the direction of travel.
const DIRECTION: [&str; 5] =
    ["direction", "dir", "travel_direction", "direction_of_travel", "travel_dir"];

/// What a reader finds: the counts, the property or column that they stand in, and what is odd.
type Found = (Vec<Counted>, String, Oddities);

/// What names of counts have in common.
const AADT: &str = "aadt";

/// What names have that are not of the vehicles of a day: when a count is from (`DOT_AADTYR`), only trucks
/// (`AADT_SINGLE_UNIT`), another year's forecast.
const OTHER: [&str; 12] = [
    "yr", "year", "date", "truck", "heavy", "single", "combination", "peak", "future", "forecast",
    "proj", "design",
];

/// Years that a name can mean.
const YEARS: std::ops::RangeInclusive<u32> = 1950..=2099;

/// Year of this version: a count of a later year is a forecast. It is not the year of the clock, so that a file is read
/// alike on every day.
const THIS_YEAR: u32 = 2026;

/// Usual names of the column or property with the year of a count.
const YEAR: [&str; 7] =
    ["year", "yr", "aadt_year", "aadt_yr", "aadtyr", "count_year", "year_record"];

/// Most names that a message lists.
const LISTED: usize = 30;

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

#[derive(Debug, Clone, PartialEq)]
enum Shape {
    Lines(Vec<Vec<Place>>),
    /// At a station, with the axis of its road in degrees clockwise from north if it is known.
    Station(Place, Option<f64>),
}

#[derive(Debug, Clone, PartialEq)]
struct Counted {
    id: String,
    aadt_veh_per_day: f64,
    /// Direction of travel that was counted, in capital letters, if the file says it.
    direction: Option<String>,
    shape: Shape,
}

/// The counts of a file, to be joined to streets; at least one.
#[derive(Debug)]
pub struct Counts {
    index: Index,
    settings: CountSettings,
    /// How many lines or stations have a count.
    pub count: usize,
    /// Property or column that was read.
    pub field: String,
    /// What was skipped and why.
    pub oddities: Oddities,
    /// The smallest box around all counts: x is the longitude and y the latitude, degrees.
    pub bounds: Rect<f64>,
}

impl Counts {
    /// Reads counts: GeoJSON with LineString and MultiLineString features in WGS 84, or CSV with
    /// latitude, longitude, aadt and, where they are known, bearing_deg (the axis of the street)
    /// and id. Which of the two a file is shows in its content.
    ///
    /// Errors name the file and the place.
    pub fn read(path: &Path, settings: &CountSettings) -> Result<Self, OsmError> {
        Self::from_bytes(&file::bytes(path)?, path, settings)
    }

    /// Reads counts from the bytes of a file; `path` is for messages only.
    pub fn from_bytes(
        bytes: &[u8],
        path: &Path,
        settings: &CountSettings,
    ) -> Result<Self, OsmError> {
        let wrong = |reason| OsmError::Nothing { path: path.to_path_buf(), reason };
        settings.check().map_err(wrong)?;
        let text = table::text(bytes, path)?;
        let text = text.trim_start();
        let json = text.starts_with(['{', '[', '<']);
        let field = settings.field.as_deref();
        let (counted, field, mut oddities) =
            if json { geojson::read(bytes, path, field)? } else { csv::read(bytes, path, field)? };
        let counted = conflicts::settled(counted, settings.match_deg, &mut oddities);
        let nothing = || {
            let skipped: Vec<_> = oddities
                .iter()
                .map(|(reason, o)| format!("{} ({} times, first {})", reason, o.count, o.example))
                .collect();
            let reason = format!(
                "no usable count in {}; skipped: {}; give lines or stations with a number of vehicles per day",
                brief(&field),
                skipped.join(", ")
            );
            wrong(reason)
        };
        let count = counted.len();
        let (index, bounds) = Index::new(counted).ok_or_else(nothing)?;
        Ok(Self { index, settings: settings.clone(), count, field, oddities, bounds })
    }

    /// Returns the count of a street, if one belongs to it.
    ///
    /// `street` are its places from the junction outwards, at least two; its lanes tell which counts are possible.
    ///
    /// Of the street's first 150 m a place every 10 m is compared with the counted lines; a line
    /// has to be near at least half of them and to run in the same axis there. Of several lines
    /// the one wins that is near most of them, each weighted with how near it is.
    /// A station has to be beside the street and not where it meets others; the nearest one wins.
    pub fn along(&self, street: &[Place], lanes_both_directions: u32) -> Option<CountMatch> {
        self.index.along(street, lanes_both_directions, &self.settings)
    }
}

fn direction(text: &str) -> Option<String> {
    Some(text.trim().to_uppercase()).filter(|direction| !direction.is_empty())
}

/// Returns the name of the counts among all names: the one given, or that with AADT in it, of several that of the latest
/// year, and of these `AADT` or `AADT2021` itself.
fn choose(names: &[&str], given: Option<&str>) -> Result<String, String> {
    let plain = |name: &str| name.to_lowercase().replace('_', "");
    let is = |name: &&&str| {
        let lower = name.to_lowercase();
        let is_past = year(name).is_none_or(|year| year <= THIS_YEAR);
        lower.contains(AADT) && is_past && !OTHER.iter().any(|word| lower.contains(word))
    };
    let named: Vec<&&str> = match given {
        Some(given) => names.iter().filter(|name| name.eq_ignore_ascii_case(given)).collect(),
        None => names.iter().filter(is).collect(),
    };
    let latest = named.iter().filter_map(|name| year(name)).max();
    let of_latest: Vec<&&str> = named.into_iter().filter(|name| year(name) == latest).collect();
    let best = given.map_or_else(
        || latest.map_or_else(|| AADT.to_owned(), |year| format!("{AADT}{year}")),
        str::to_owned,
    );
    let exact = |name: &&&&str| ***name == best || (given.is_none() && plain(name) == best);
    let mut exact = of_latest.iter().filter(exact);
    match (&of_latest[..], exact.next(), exact.next()) {
        ([only], ..) | (_, Some(only), None) => Ok((**only).to_owned()),
        (several, ..) => {
            let what =
                if several.is_empty() { "no name is that of" } else { "several names could be" };
            let shown: Vec<_> = names.iter().take(LISTED).map(|name| brief(name)).collect();
            let given = brief(given.unwrap_or("AADT"));
            Err(format!(
                "{what} the count ({given}); the names are {}; give that of the counts as `field`",
                shown.join(", ")
            ))
        }
    }
}

/// Of what is written as no number `number` is NaN; the error is why nothing was counted.
fn usable(number: Option<f64>, of_year: Option<&str>) -> Result<f64, &'static str> {
    if of_year.and_then(year).is_some_and(|year| year > THIS_YEAR) {
        return Err("forecast of a year to come");
    }
    match number {
        None => Err("missing count"),
        Some(number) if !number.is_finite() => Err("count that is no number"),
        Some(number) if number < 0.0 => Err("negative count"),
        // Some agencies write 0 where nothing was counted, and no street has no traffic at all.
        Some(0.0) => Err("count of 0"),
        Some(number) => Ok(number),
    }
}

fn is_separated(text: &str) -> bool {
    text.contains([',', '.']) && text.chars().all(|c| c.is_ascii_digit() || "+-.,".contains(c))
}

/// Of several the last one.
fn year(name: &str) -> Option<u32> {
    name.split(|c: char| !c.is_ascii_digit())
        .filter_map(|digits| digits.parse().ok())
        .rfind(|year| YEARS.contains(year))
}

#[cfg(test)]
mod tests;

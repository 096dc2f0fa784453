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
//!
//! Of different counts of one place none is taken: they are left out and named.

mod conflicts;
mod counted;
mod csv;
mod field;
mod geojson;
mod index;
mod samples;
mod settings;

use std::path::{Path, PathBuf};

use geo::Rect;

pub use self::counted::CountMatch;
use self::counted::Found;
use self::index::Index;
pub use self::settings::CountSettings;
use super::error::{OsmError, brief};
use super::extract::Place;
use super::file;
use super::oddities::Oddities;
use super::table;

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
        Self::from_bytes(&file::bytes(path)?, path, settings)
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
        settings.check().map_err(|e| OsmError::Malformed {
            path: PathBuf::from(path),
            reason: e.reason,
            place: e.setting,
        })?;
        let text = table::text(bytes, path)?;
        let text = text.trim_start();
        let json = text.starts_with(['{', '[', '<']);
        let field = settings.field.as_deref();
        let Found { counted, field, mut oddities } =
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

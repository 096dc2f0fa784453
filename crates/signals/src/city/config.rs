//! Settings of `build-networks --osm`: a TOML file of which every field has a default.

use std::collections::BTreeMap;
use std::path::Path;

use osm_signals::counts::CountSettings;
use osm_signals::error::shortened;
use osm_signals::settings::{IntersectionSettings, StreetSettings, TrafficSettings};
use osm_signals::signals::SignalColumns;
use osm_signals::tags::Highway;
use osm_signals::{Settings, file};
use serde::{Deserialize, Serialize};

use super::error::CityError;
use crate::settings::{EVEN_SPLIT, NORTH_EAST_DEG};
use evaluation::settings::within;

/// Most characters of what the parser says, which quotes whole lines.
const PARSER_CHARS: usize = 500;

/// Everything that decides how an extract becomes a family.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CityConfig {
    /// How the extract and what a city knows of it are read.
    pub settings: Settings,
    /// Which hour is simulated.
    pub hour: DesignHour,
    /// Settings for the scenario that is written: the tables of a scenario file, such as
    /// `[scenario.family]` with `hourly_share`.
    pub scenario: toml::Table,
}

/// Which hour of the day is simulated; written to the scenario.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DesignHour {
    /// Share of the day's traffic in it (the factor K).
    ///
    /// Source: a design hour on urban streets, Highway Capacity Manual; FDOT's standard K factor of
    /// urban arterials.
    pub hourly_share: f64,
    /// Share of that hour that goes in the peak direction of a two-way street (the factor D); only where
    /// counts are totals of both directions, else directions are as counted.
    pub directional_split: f64,
    /// Heading around which the peak direction of all streets lies, degrees clockwise from north: see
    /// [`crate::settings::InflowSources`] for the rule.
    pub peak_heading_deg: f64,
}

impl Default for DesignHour {
    fn default() -> Self {
        Self { hourly_share: 0.09, directional_split: 0.55, peak_heading_deg: NORTH_EAST_DEG }
    }
}

/// The sections of a file.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Sections {
    streets: StreetSettings,
    intersections: IntersectionSettings,
    signals: SignalColumns,
    counts: CountSettings,
    traffic: TrafficSection,
    scenario: toml::Table,
}

/// The section `[traffic]`: how much traffic arms carry, and the design hour.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
struct TrafficSection {
    both_directions: bool,
    default_aadt_per_lane: BTreeMap<Highway, f64>,
    hourly_share: f64,
    directional_split: f64,
    peak_heading_deg: f64,
}

impl Default for TrafficSection {
    fn default() -> Self {
        let TrafficSettings { both_directions, default_aadt_per_lane } = TrafficSettings::default();
        let DesignHour { hourly_share, directional_split, peak_heading_deg } =
            DesignHour::default();
        Self {
            both_directions,
            default_aadt_per_lane,
            hourly_share,
            directional_split,
            peak_heading_deg,
        }
    }
}

impl From<Sections> for CityConfig {
    fn from(sections: Sections) -> Self {
        let Sections { streets, intersections, signals, counts, traffic: section, scenario } =
            sections;
        let traffic = TrafficSettings {
            both_directions: section.both_directions,
            default_aadt_per_lane: section.default_aadt_per_lane,
        };
        let hour = DesignHour {
            hourly_share: section.hourly_share,
            directional_split: section.directional_split,
            peak_heading_deg: section.peak_heading_deg,
        };
        let settings = Settings { streets, intersections, signals, counts, traffic };
        Self { settings: settings.completed(), hour, scenario }
    }
}

impl CityConfig {
    /// Reads settings from a file.
    ///
    /// # Errors
    ///
    /// [`CityError::Input`] if it cannot be read, [`CityError::Settings`] naming line or field.
    pub fn read(path: &Path) -> Result<Self, CityError> {
        let bytes = file::bytes(path)?;
        let at = |place: &str, reason: String| CityError::Settings {
            path: path.to_path_buf(),
            place: place.to_owned(),
            reason,
        };
        let text = String::from_utf8(bytes)
            .map_err(|_| at("text", "not UTF-8; save the file as UTF-8".to_owned()))?;
        let sections = toml::from_str::<Sections>(&text);
        let config = Self::from(sections.map_err(|e| at("settings", parser_message(&e)))?);
        config.settings.check().map_err(|e| at(&e.setting, e.reason.clone()))?;
        config.hour.check().map_err(|(field, reason)| at(field, reason))?;
        Ok(config)
    }
}

impl DesignHour {
    /// Returns the first field that is out of range and why.
    fn check(&self) -> Result<(), (&'static str, String)> {
        for (field, value, low, high) in [
            ("traffic.hourly_share", self.hourly_share, 1e-6, 1.0),
            ("traffic.directional_split", self.directional_split, EVEN_SPLIT, 1.0),
            ("traffic.peak_heading_deg", self.peak_heading_deg, 0.0, 360.0),
        ] {
            within(value, low, high).map_err(|expected| (field, format!("{value}: {expected}")))?;
        }
        Ok(())
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

    fn config(text: &str) -> Result<CityConfig, CityError> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        CityConfig::read(file.path())
    }

    #[test]
    fn the_commented_file_has_the_defaults() {
        let text = include_str!("../../../../scenarios/openstreetmap.toml");
        assert_eq!(config(text).unwrap(), CityConfig::default());
        assert_eq!(config("").unwrap(), CityConfig::default());
    }

    #[test]
    fn classes_that_a_file_leaves_out_keep_their_defaults() {
        let config = config("[streets.default_lanes]\nprimary = 3\n").unwrap();
        assert_eq!(config.settings.streets.default_lanes[&Highway::Primary], 3);
        assert_eq!(config.settings.streets.default_lanes[&Highway::Trunk], 2);
    }

    #[test]
    fn a_value_out_of_range_is_named_with_its_range() {
        let error = config("[traffic]\ndirectional_split = nan\n").unwrap_err().to_string();
        assert!(error.contains("traffic.directional_split: NaN: expected a number from 0.5 to 1"));
        let error = config("[counts]\nmatch_m = inf\n").unwrap_err().to_string();
        assert!(error.ends_with("counts.match_m: inf: expected a number from 1 to 1000"));
    }
}

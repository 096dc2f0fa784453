//! Settings of `build-networks --osm`: a TOML file of which every field has a default.

use std::path::Path;

use osm_signals::Settings;
use osm_signals::error::shortened;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::CityError;
use crate::settings::{EVEN_SPLIT, NORTH_EAST_DEG};
use basics::files::{self, limits};
use evaluation::settings::within;

/// Most characters of what the parser says, which quotes whole lines.
const PARSER_CHARS: usize = 500;

/// Settings of the design hour, which the section `[traffic]` has beside those of `osm_signals`.
const OF_HOUR: [&str; 3] = ["hourly_share", "directional_split", "peak_heading_deg"];

/// Everything that decides how an extract becomes a family.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CityConfig {
    /// How the extract and what a city knows of it are read.
    pub settings: Settings,
    /// Which hour is simulated.
    pub hour: DesignHour,
    /// Settings for the scenario that is written: the tables of a scenario file, such as
    /// `[scenario.family]` with `hourly_share`.
    pub scenario: Table,
}

/// Which hour of the day is simulated; written to the scenario.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
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

impl CityConfig {
    /// Reads settings from a file.
    ///
    /// # Errors
    ///
    /// [`CityError::Io`] if it cannot be read, [`CityError::Unfit`] naming line or field.
    pub fn read(path: &Path) -> Result<Self, CityError> {
        let text = files::read_text(path, limits::DOCUMENT)?;
        let config = Self::parse(&text).map_err(|e| {
            CityError::unfit(path, shortened(e.to_string().trim_end(), PARSER_CHARS))
        })?;
        let checked = config.settings.check().and_then(|()| config.hour.check());
        checked.map_err(|e| CityError::unfit(path, e))?;
        Ok(config)
    }

    fn parse(text: &str) -> Result<Self, toml::de::Error> {
        let mut settings: Table = toml::from_str(text)?;
        let scenario = settings.remove("scenario").map(Value::try_into).transpose()?;
        let mut hour = Table::new();
        if let Some(traffic) = settings.get_mut("traffic").and_then(Value::as_table_mut) {
            hour.extend(OF_HOUR.iter().filter_map(|field| traffic.remove_entry(*field)));
        }
        let settings = settings.try_into::<Settings>()?.completed();
        Ok(Self { settings, hour: hour.try_into()?, scenario: scenario.unwrap_or_default() })
    }
}

impl DesignHour {
    fn check(&self) -> Result<(), String> {
        let values = [self.hourly_share, self.directional_split, self.peak_heading_deg];
        let ranges = [(1e-6, 1.0), (EVEN_SPLIT, 1.0), (0.0, 360.0)];
        for ((field, value), (low, high)) in OF_HOUR.into_iter().zip(values).zip(ranges) {
            within(value, low, high).map_err(|e| format!("traffic.{field}: {value}: {e}"))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use osm_signals::tags::Highway;

    fn config(text: &str) -> Result<CityConfig, CityError> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        CityConfig::read(file.path())
    }

    #[test]
    fn the_commented_file_has_the_defaults_and_classes_that_a_file_leaves_out_keep_theirs() {
        let text = include_str!("../../../../scenarios/openstreetmap.toml");
        assert_eq!(config(text).unwrap(), CityConfig::default());
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

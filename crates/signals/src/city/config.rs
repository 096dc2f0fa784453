//! Settings of `build-networks --osm`: a TOML file of which every field has a default.

use std::path::Path;

use osm_signals::Settings;
use osm_signals::error::shortened;
use toml::{Table, Value};

use super::CityError;
use basics::files::{self, limits};

/// Most characters of what the parser says, which quotes whole lines.
const PARSER_CHARS: usize = 500;

/// Everything that decides how an extract becomes a family.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CityConfig {
    /// How the extract and what a city knows of it are read.
    pub settings: Settings,
    /// Settings for the scenario that is written: the tables of a scenario file, such as
    /// `[scenario.family]` with `hourly_share`.
    pub scenario: Table,
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
        config.settings.check().map_err(|e| CityError::unfit(path, e))?;
        Ok(config)
    }

    fn parse(text: &str) -> Result<Self, toml::de::Error> {
        let mut settings: Table = toml::from_str(text)?;
        let scenario = settings.remove("scenario").map(Value::try_into).transpose()?;
        let settings = settings.try_into::<Settings>()?.completed();
        Ok(Self { settings, scenario: scenario.unwrap_or_default() })
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
        let error = config("[counts]\nmatch_m = inf\n").unwrap_err().to_string();
        assert!(error.ends_with("counts.match_m: inf: expected a number from 1 to 1000"));
    }
}

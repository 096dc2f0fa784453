//! What an episode simulates: a SUMO configuration, its time span, and where its vehicles come from.

use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

use quick_xml::Reader;
use quick_xml::events::Event;

use crate::error::{FileError, SimError};

/// Writes the vehicles of an episode, given its seed, into a route file.
pub type RouteWriter = Box<dyn Fn(u64, &Path) -> Result<(), FileError>>;

/// What an episode simulates.
#[derive(Default)]
pub struct World {
    /// SUMO's configuration file.
    pub config: PathBuf,
    /// Start, seconds.
    pub begin_s: f64,
    /// End, seconds.
    pub end_s: f64,
    /// Makes the vehicles of an episode; `None` keeps the configuration's own.
    pub routes: Option<RouteWriter>,
    /// How vehicles turn, where the demand says so.
    pub turn_shares: Vec<TurnShare>,
}

/// Share of the vehicles of one edge that go to another.
#[derive(Debug, Clone, PartialEq)]
pub struct TurnShare {
    /// SUMO's id of the edge that leads to a signal.
    pub from: String,
    /// SUMO's id of the edge behind it.
    pub to: String,
    /// Share; those of one edge sum to 1.
    pub share: f64,
}

impl fmt::Debug for World {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("World")
            .field("config", &self.config)
            .field("begin_s", &self.begin_s)
            .field("end_s", &self.end_s)
            .field("routes", &self.routes.is_some())
            .finish()
    }
}

impl World {
    /// Reads the time span of a SUMO configuration.
    ///
    /// # Errors
    ///
    /// [`SimError::NoConfig`] when there is no such file, [`SimError::Config`] when it is not XML,
    /// names no network or no end.
    pub fn from_sumocfg(config: &Path) -> Result<Self, SimError> {
        let settings = SumoConfig::read(config)?;
        let fail = |reason: &str| SimError::Config { path: config.into(), reason: reason.into() };
        let end_s = settings.end_s.ok_or_else(|| {
            fail("no end; add `<time><end value=\"3600\"/></time>` so that an episode ends")
        })?;
        if settings.begin_s >= end_s {
            return Err(fail("the end is not after the begin"));
        }
        Ok(Self {
            config: config.to_path_buf(),
            begin_s: settings.begin_s,
            end_s,
            ..Self::default()
        })
    }
}

/// What is read of a SUMO configuration.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SumoConfig {
    /// Start, seconds.
    pub begin_s: f64,
    /// End, seconds.
    pub end_s: Option<f64>,
    /// Files that define the scenario (network, routes, additional files): name as written, path.
    pub files: Vec<(String, PathBuf)>,
}

impl SumoConfig {
    /// Reads a SUMO configuration; paths are relative to its folder.
    ///
    /// # Errors
    ///
    /// [`SimError::NoConfig`] when there is no such file, [`SimError::Config`] when it is not XML,
    /// has a time that is no number, or names no network.
    pub fn read(config: &Path) -> Result<Self, SimError> {
        if !config.is_file() {
            return Err(SimError::NoConfig(config.to_path_buf()));
        }
        let fail = |reason: String| SimError::Config { path: config.to_path_buf(), reason };
        let text = fs::read_to_string(config).map_err(FileError::at("read", config))?;
        let folder = config.parent().unwrap_or(Path::new(""));
        let mut settings = Self::default();
        let mut has_network = false;
        let mut reader = Reader::from_str(&text);
        loop {
            let event = match reader.read_event() {
                Ok(Event::Eof) => break,
                Ok(event) => event,
                Err(e) => return Err(fail(e.to_string())),
            };
            let (Event::Start(element) | Event::Empty(element)) = event else { continue };
            let Some(value) = attribute(&element, "value") else { continue };
            let seconds = |value: &str| {
                value
                    .parse::<f64>()
                    .map_err(|_| fail(format!("{value:?} is not a time in seconds")))
            };
            match element.name().as_ref() {
                "begin" => settings.begin_s = seconds(&value)?,
                "end" => settings.end_s = Some(seconds(&value)?).filter(|e| *e >= 0.0),
                name @ ("net-file" | "route-files" | "additional-files") => {
                    has_network |= name == "net-file";
                    let files = value.split([',', ' ']).filter(|f| !f.is_empty());
                    settings.files.extend(files.map(|f| (f.to_owned(), folder.join(f))));
                }
                _ => {}
            }
        }
        if !has_network {
            return Err(fail("no `<net-file>`; is it a SUMO configuration?".into()));
        }
        Ok(settings)
    }
}

fn attribute(element: &quick_xml::events::BytesStart, name: &str) -> Option<String> {
    let attribute = element.attributes().flatten().find(|a| a.key.as_ref() == name)?;
    Some(attribute.value.into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<World, SimError> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.sumocfg");
        fs::write(&path, text).unwrap();
        World::from_sumocfg(&path)
    }

    #[test]
    fn begin_and_end_are_read() {
        let text = "<configuration><input><net-file value=\"n\"/></input>\
            <time><begin value=\"57600\"/><end value=\"61200\"/></time></configuration>";
        let world = read(text).unwrap();
        assert_eq!((world.begin_s, world.end_s), (57600.0, 61200.0));
    }

    #[test]
    fn a_configuration_without_end_says_what_to_add() {
        let e = read("<configuration><net-file value=\"n\"/></configuration>").unwrap_err();
        assert!(e.to_string().contains("add `<time><end"), "{e}");
    }

    #[test]
    fn a_file_that_is_no_configuration_is_refused() {
        assert!(read("<routes/>").unwrap_err().to_string().contains("no `<net-file>`"));
        assert!(read("<configuration><net-file").is_err());
    }
}

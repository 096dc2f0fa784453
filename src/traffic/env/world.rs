//! What an episode simulates: a SUMO configuration, its time span, and where its vehicles come from.

use std::fmt;
use std::path::{Path, PathBuf};

use osm_signals::DrivingSide;

use super::side::driving_side;
use crate::files::FileError;
use crate::traffic::sim::error::SimError;
use crate::traffic::sim::sumocfg::SumoConfig;

/// How far the steps of a second may be from a whole number.
const STEPS_TOLERANCE: f64 = 1e-6;

/// Most steps per second: SUMO counts milliseconds.
const MOST_STEPS: f64 = 1000.0;

/// Writes the vehicles of an episode, given its seed, into a route file.
pub type RouteWriter = Box<dyn Fn(u64, &Path) -> Result<(), FileError>>;

/// What an episode simulates.
pub struct World {
    /// SUMO's configuration file.
    pub config: PathBuf,
    /// Start, seconds.
    pub begin_s: f64,
    /// End, seconds.
    pub end_s: f64,
    /// Steps of the simulation per second; decisions are made at whole seconds.
    pub steps_per_second: u32,
    /// Makes the vehicles of an episode; `None` keeps the configuration's own.
    pub routes: Option<RouteWriter>,
    /// Side of the street that traffic keeps to.
    pub side: DrivingSide,
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
            .field("steps_per_second", &self.steps_per_second)
            .field("routes", &self.routes.is_some())
            .finish()
    }
}

impl World {
    /// Reads the time span and the step length of a SUMO configuration.
    ///
    /// # Errors
    ///
    /// [`SimError::NoConfig`] when there is no such file, [`SimError::Config`] when it is not XML,
    /// names no network or no end, or when its steps do not divide a second.
    pub fn from_sumocfg(config: &Path) -> Result<Self, SimError> {
        let settings = SumoConfig::read(config)?;
        let fail = |reason: &str| SimError::Config { path: config.into(), reason: reason.into() };
        let end_s = settings.end_s.ok_or_else(|| {
            fail("no end; add `<time><end value=\"3600\"/></time>` so that an episode ends")
        })?;
        if settings.begin_s >= end_s {
            return Err(fail("the end is not after the begin"));
        }
        let steps = 1.0 / settings.step_length_s;
        let divides = (steps - steps.round()).abs() < STEPS_TOLERANCE;
        if !((1.0 - STEPS_TOLERANCE..=MOST_STEPS).contains(&steps) && divides) {
            return Err(fail(&format!(
                "a step-length of {} s does not divide a second, at which signals are decided; give \
                 one such as 1, 0.5 or 0.1",
                settings.step_length_s
            )));
        }
        Ok(Self {
            config: config.to_path_buf(),
            begin_s: settings.begin_s,
            end_s,
            steps_per_second: steps.round() as u32,
            routes: None,
            side: driving_side(&settings),
            turn_shares: Vec::new(),
        })
    }

    /// Returns the length of a step, seconds.
    pub fn step_length_s(&self) -> f64 {
        1.0 / f64::from(self.steps_per_second)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

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

    /// Steps per second of a configuration with this step length.
    fn steps(step_length: &str) -> Result<u32, String> {
        let text = format!(
            "<configuration><net-file value=\"n\"/><end value=\"9\"/>\
             <step-length value=\"{step_length}\"/></configuration>"
        );
        read(&text).map(|w| w.steps_per_second).map_err(|e| e.to_string())
    }

    #[test]
    fn a_step_length_that_divides_a_second_is_kept() {
        assert_eq!(["1", "0.5", "0.1", "0:00:00.2"].map(steps), [Ok(1), Ok(2), Ok(10), Ok(5)]);
        assert_eq!(steps("0.001"), Ok(1000));
        assert!(read("<c><n v=\"n\"/><e v=\"9\"/></c>").unwrap().steps_per_second == 1);
    }

    #[test]
    fn a_step_length_that_does_not_divide_a_second_is_refused() {
        for length in ["0.3", "2", "1.5", "0", "-1"] {
            let e = steps(length).unwrap_err();
            assert!(e.contains(&format!("a step-length of {length} s does not divide")), "{e}");
        }
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

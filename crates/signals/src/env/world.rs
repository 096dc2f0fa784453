//! What an episode simulates: a SUMO configuration, its time span, and where its vehicles come from.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use osm_signals::DrivingSide;

use super::by_movement::{Bays, Ways};
use super::side::driving_side;
use crate::existing::ExistingPlan;
use crate::sim::SignalInfo;
use crate::sim::error::SimError;
use crate::sim::intake::Intake;
use crate::sim::obstacle::Given;
use crate::sim::sources::{Sources, copy};
use crate::sim::sumocfg::SumoConfig;
use basics::files::FileError;

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
    /// Ways of the vehicles of an episode; `None` where results by movement are not asked for.
    pub ways: Option<Ways>,
    /// Side of the street that traffic keeps to.
    pub side: DrivingSide,
    /// How vehicles turn, where the demand says so: the edge that leads to a signal, the one behind it, and the share; those
    /// of one edge sum to 1.
    pub turn_shares: Vec<(String, String, f64)>,
    /// Turn lanes that are shorter than their street.
    pub bays: Bays,
    /// People per hour who cross the street of an edge at the signal, where they were counted.
    pub pedestrians: BTreeMap<String, f64>,
    /// The plan that its signal has today, where somebody brought one.
    pub existing: Option<ExistingPlan>,
    /// Its files, of which SUMO may get private copies; `None` reads them as they are.
    pub files: Option<(SumoConfig, Sources)>,
    /// Whether programs change by the clock as they do in the scenario, which would take signals away from whoever
    /// decides them.
    pub day_plan: bool,
}

impl World {
    /// Reads a SUMO scenario, of which nothing is said on a command line.
    ///
    /// # Errors
    ///
    /// [`SimError::NoConfig`] when there is no such file, [`SimError::Config`] when it is no configuration,
    /// [`SimError::Obstacles`] with all that is in the way.
    pub fn from_sumocfg(config: &Path) -> Result<Self, SimError> {
        Self::of(Intake::read(config, &Given::default())?)
    }

    /// Returns the world of a SUMO scenario; programs do not change by the clock.
    ///
    /// # Errors
    ///
    /// [`SimError::Obstacles`] with all that is in the way.
    pub fn of(intake: Intake) -> Result<Self, SimError> {
        let intake = intake.passed()?;
        Ok(Self {
            config: intake.path,
            begin_s: intake.begin_s,
            end_s: intake.end_s,
            steps_per_second: intake.steps_per_second,
            routes: None,
            ways: None,
            side: driving_side(&intake.config),
            turn_shares: Vec::new(),
            bays: Bays::new(),
            pedestrians: BTreeMap::new(),
            existing: None,
            files: Some((intake.config, intake.sources)),
            day_plan: false,
        })
    }

    /// Returns the plan that its signal has today.
    pub(super) fn existing(&self, signal: &SignalInfo) -> Result<&ExistingPlan, SimError> {
        self.existing.as_ref().ok_or_else(|| SimError::Signal {
            signal: signal.id.clone(),
            reason:
                "no existing plan was given for it; give one with --existing, or run other methods"
                    .to_owned(),
        })
    }

    /// Writes private copies of its files into a folder, where they are needed, and returns the arguments that have SUMO
    /// read them.
    pub(super) fn copied(&self, folder: &Path, day_plan: bool) -> Result<Vec<String>, FileError> {
        let Some((config, sources)) = &self.files else { return Ok(Vec::new()) };
        Ok(as_arguments(copy(config, sources, folder, day_plan)?))
    }
}

/// Returns options as arguments: names and values in turn.
pub fn as_arguments(options: Vec<(String, String)>) -> Vec<String> {
    options.into_iter().flat_map(|(name, value)| [format!("--{name}"), value]).collect()
}

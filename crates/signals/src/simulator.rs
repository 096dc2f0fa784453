//! The simulator itself: its version, and what it makes of somebody's scenario.

use std::collections::BTreeMap;

use super::env::derive::{DerivedSignal, derive};
use super::env::on_red::OnRed;
use super::env::side::{as_right_hand, driving_side};
use super::env::warnings::{Warning, of_signals, warnings};
use super::env::world::as_arguments;
use super::settings::SignalSettings;
use super::sim::intake::Intake;
use super::sim::libsumo::{SWITCHED_OFF, SumoSim};
pub use super::sim::net_file::signals_in;
use super::sim::obstacle::{Accept, Obstacle};
use super::sim::sources::copy;
use super::sim::topology::Topology;
use super::sim::{Scene, Sim, SimError, StartOptions};
use basics::files::FileError;

/// What SUMO 1.15 says where it has written its reason to standard error.
const SAID_BEFORE: [&str; 3] = ["Process Error", "Could not parse commandline options.", ""];

/// What is wrong with a signal that is off at the start of a scenario whose programs change by the clock.
const OFF_AT_START: &str = "the program that runs at the start never shows green to cars, and a <WAUT> may switch to another \
                            one later; pass --begin with the time of that switch, or remove the <WAUT>";

/// A SUMO scenario as SUMO has loaded it, once.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// Its signals, as right-hand traffic sees its own.
    pub scene: Scene,
    /// Its lanes.
    pub topology: Topology,
    /// What is derived of every signal.
    pub signals: Vec<DerivedSignal>,
    /// Signals that no method controls: why, and SUMO's id.
    pub left_alone: Vec<(&'static str, String)>,
    /// The simulator's version.
    pub version: String,
}

impl Loaded {
    /// Returns lines on the signals that no method controls.
    pub fn left_alone(&self) -> Vec<String> {
        let mut ids = BTreeMap::<&str, Vec<&str>>::new();
        self.left_alone.iter().for_each(|(why, id)| ids.entry(why).or_default().push(id));
        ids.into_iter().map(|(why, ids)| format!("{why}: {}", ids.join(", "))).collect()
    }

    /// Returns what is to be said of a scenario that was loaded.
    pub fn warnings(&self, intake: &Intake) -> Vec<String> {
        let mut lines = intake.notes.clone();
        lines.extend(self.left_alone());
        let signals: Vec<(&str, Vec<Warning>)> =
            self.signals.iter().map(|signal| (signal.spec.id.as_str(), warnings(signal))).collect();
        lines.extend(of_signals(&signals));
        let config = intake.path.display().to_string();
        lines.iter().map(|line| format!("{config}: {line}")).collect()
    }
}

/// Looks at a scenario: returns what else is in its way than what was found in its files, and what is to be said of it.
/// Fails with [`SimError`] when SUMO cannot be used.
pub fn examine(
    intake: &Intake,
    settings: &SignalSettings,
) -> Result<(Vec<Obstacle>, Vec<String>), SimError> {
    // What could not be followed is not given to SUMO.
    if !intake.may_load() {
        return Ok((Vec::new(), Vec::new()));
    }
    Ok(match load(intake, settings)? {
        Ok(loaded) => (Vec::new(), loaded.warnings(intake)),
        Err(obstacles) => (obstacles, Vec::new()),
    })
}

/// Loads a scenario, in whose files nothing is in the way that no option passes, and derives its signals; returns what
/// is in the way of that.
/// Fails with [`SimError`] when SUMO cannot be used.
pub fn load(
    intake: &Intake,
    settings: &SignalSettings,
) -> Result<Result<Loaded, Vec<Obstacle>>, SimError> {
    let folder = tempfile::tempdir().map_err(FileError::at("create", &std::env::temp_dir()))?;
    let copies = copy(&intake.config, &intake.sources, &folder.path().join("copies"), true)?;
    let step_s = 1.0 / f64::from(intake.steps_per_second);
    let until = |end_s: f64| {
        let times = [("begin", intake.begin_s), ("end", end_s), ("step-length", step_s)];
        let times = times.map(|(name, value)| (name.to_owned(), value.to_string()));
        StartOptions {
            config: intake.path.clone(),
            args: as_arguments(copies.iter().cloned().chain(times).collect()),
            trace_m: settings.detection_m,
            ..StartOptions::default()
        }
    };
    let first_end_s = intake.begin_s + step_s;
    let mut sim = SumoSim::new()?;
    let version = sim.version()?;
    let obstacle = |reason: String| Obstacle::new(intake.path.display().to_string(), reason, None);
    // One without an end is loaded all the same.
    let scene = match sim.start(&until(intake.end_s.max(first_end_s))) {
        Ok(scene) => as_right_hand(scene, driving_side(&intake.config)),
        Err(SimError::Fatal { message, .. } | SimError::Traci { message, .. }) => {
            return Ok(Err(vec![not_loaded(intake, &message)]));
        }
        Err(SimError::Config { reason, .. }) => return Ok(Err(vec![obstacle(reason)])),
        Err(e @ SimError::Signal { .. }) => return Ok(Err(vec![obstacle(e.to_string())])),
        Err(other) => return Err(other),
    };
    let (topology, left_alone) = (sim.topology()?, sim.left_alone.clone());
    sim.close()?;
    let (mut signals, mut obstacles) = (Vec::new(), Vec::new());
    if intake.sources.has_day_plan() {
        let off = left_alone.iter().filter(|(why, _)| *why == SWITCHED_OFF);
        obstacles.extend(off.map(|(_, id)| obstacle(format!("signal {id}: {OFF_AT_START}"))));
    }
    // Phases are those that controllers choose from, where turns on red are no green.
    let mut seen = scene.clone();
    if settings.turn_on_red {
        seen.signals.iter_mut().for_each(|signal| drop(OnRed::take(signal)));
    }
    for signal in &seen.signals {
        match derive(&seen, signal, settings) {
            Ok(derived) => signals.push(derived),
            Err(e @ SimError::Signal { .. }) => obstacles.push(obstacle(e.to_string())),
            Err(other) => return Err(other),
        }
    }
    Ok(match obstacles.is_empty() {
        true => Ok(Loaded { scene, topology, signals, left_alone, version }),
        false => Err(obstacles),
    })
}

/// Says why SUMO cannot load a scenario.
fn not_loaded(intake: &Intake, message: &str) -> Obstacle {
    let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
    let is_above = SAID_BEFORE.contains(&message.as_str());
    let mut files = intake.sources.files.iter().map(|file| &file.scanned.newer_classes);
    let has_newer = files.any(|classes| !classes.is_empty());
    let accept = Accept::NewerClasses;
    let accept = (has_newer && !intake.given.accept.contains(&accept)).then_some(accept);
    let message = match (is_above, accept) {
        (true, Some(_)) => "its reason is above, and may be a vehicle class of a newer SUMO",
        (true, None) => "its reason is above",
        (false, _) => message.as_str(),
    };
    let reason = format!("SUMO cannot load it: {message}");
    Obstacle::new(intake.path.display().to_string(), reason, accept)
}

/// Returns the simulator's version.
/// Fails with [`SimError::Unavailable`] when it is missing.
pub fn version() -> Result<String, SimError> {
    SumoSim::version_unloaded()
}

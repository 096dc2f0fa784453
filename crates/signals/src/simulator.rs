//! The simulator itself: its version, and what it makes of somebody's scenario.

use super::env::derive::DerivedSignal;
use super::env::warnings::{Warning, of_signals, warnings};
use super::settings::SignalSettings;
use super::sim::intake::Intake;
pub use super::sim::lights::signals_in;
use super::sim::obstacle::Obstacle;
use super::sim::topology::Topology;
use super::sim::{Scene, SimError};

/// A SUMO scenario as SUMO has loaded it, once.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// Its signals, as right-hand traffic sees its own.
    pub scene: Scene,
    /// Its lanes.
    pub topology: Topology,
    /// What is derived of every signal.
    pub signals: Vec<DerivedSignal>,
    /// Ids of level crossings and the like, which are no signals to control.
    pub railways: Vec<String>,
    /// Ids of signals that no program makes green for cars.
    pub dark: Vec<String>,
    /// The simulator's version.
    pub version: String,
}

impl Loaded {
    /// Returns lines on the signals that no method controls.
    pub fn left_alone(&self) -> Vec<String> {
        let groups = [
            (&self.railways, "trains steer these level crossings, and no method controls them"),
            (
                &self.dark,
                "no program of these signals is ever green for cars, since they flash or are dark or closed; they keep it \
                 under every method",
            ),
        ];
        let there = groups.iter().filter(|(ids, _)| !ids.is_empty());
        there.map(|(ids, what)| format!("{what}: {}", ids.join(", "))).collect()
    }

    /// Returns what is to be said of a scenario that was loaded.
    pub fn warnings(&self, intake: &Intake) -> Vec<String> {
        let mut lines = intake.notes.clone();
        lines.extend(intake.newer_than(&self.version));
        lines.extend(self.left_alone());
        let signals: Vec<(&str, Vec<Warning>)> =
            self.signals.iter().map(|signal| (signal.spec.id.as_str(), warnings(signal))).collect();
        lines.extend(of_signals(&signals));
        let config = intake.path.display().to_string();
        lines.iter().map(|line| format!("{config}: {line}")).collect()
    }
}

/// Looks at a scenario: returns what else is in its way than what was found in its files, and what is to be said of it.
///
/// # Errors
///
/// [`SimError`] when SUMO cannot be used.
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
///
/// # Errors
///
/// [`SimError`] when SUMO cannot be used.
#[cfg(feature = "libsumo")]
pub fn load(
    intake: &Intake,
    settings: &SignalSettings,
) -> Result<Result<Loaded, Vec<Obstacle>>, SimError> {
    use super::env::derive::derive;
    use super::env::on_red::OnRed;
    use super::env::side::{as_right_hand, driving_side};
    use super::env::world::as_arguments;
    use super::sim::copies::copy;
    use super::sim::libsumo::SumoSim;
    use super::sim::obstacle::Way;
    use super::sim::{Sim, StartOptions};
    use basics::files::FileError;

    let folder = tempfile::tempdir().map_err(FileError::at("create", &std::env::temp_dir()))?;
    let mut options = copy(&intake.config, &intake.sources, &folder.path().join("copies"), true)?;
    let step_s = 1.0 / f64::from(intake.steps_per_second);
    // One without an end is loaded all the same.
    let end_s = intake.end_s.max(intake.begin_s + 1.0);
    for (name, value) in [("begin", intake.begin_s), ("end", end_s), ("step-length", step_s)] {
        options.push((name.to_owned(), value.to_string()));
    }
    let options = StartOptions {
        config: intake.path.clone(),
        args: as_arguments(options),
        trace_m: settings.detection_m,
        ..StartOptions::default()
    };
    let mut sim = SumoSim::new()?;
    let version = sim.version()?;
    let obstacle = |reason: String| {
        let place = intake.path.display().to_string();
        Obstacle { place, reason, way: Way::Change("") }
    };
    let failed = |e: SimError| match e {
        SimError::Fatal { message, .. } | SimError::Traci { message, .. } => {
            let newer =
                intake.newer_than(&version).map_or_else(String::new, |said| format!("; {said}"));
            let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
            let reason = format!("SUMO cannot load it ({message}); its reason is above{newer}");
            Ok(Err(vec![obstacle(reason)]))
        }
        SimError::NoSignals(_) => Ok(Err(vec![obstacle(
            "it has no traffic signal; give a scenario with at least one tlLogic".to_owned(),
        )])),
        SimError::Signal { signal, reason } => {
            Ok(Err(vec![obstacle(format!("signal {signal}: {reason}"))]))
        }
        other => Err(other),
    };
    let scene = match sim.start(&options) {
        Ok(scene) => as_right_hand(scene, driving_side(&intake.config)),
        Err(e) => return failed(e),
    };
    let topology = sim.topology()?;
    let (railways, dark) = (sim.railways().to_vec(), sim.dark().to_vec());
    sim.close()?;
    let (mut signals, mut obstacles) = (Vec::new(), Vec::new());
    // Phases are those that controllers choose from, where turns on red are no green.
    let mut seen = scene.clone();
    if settings.turn_on_red {
        seen.signals.iter_mut().for_each(|signal| drop(OnRed::take(signal)));
    }
    for signal in &seen.signals {
        match derive(&seen, signal, settings) {
            Ok(derived) => signals.push(derived),
            Err(SimError::Signal { signal, reason }) => {
                obstacles.push(obstacle(format!("signal {signal}: {reason}")));
            }
            Err(other) => return Err(other),
        }
    }
    Ok(match obstacles.is_empty() {
        true => Ok(Loaded { scene, topology, signals, railways, dark, version }),
        false => Err(obstacles),
    })
}

/// Loads a SUMO scenario, which this build cannot.
///
/// # Errors
///
/// [`SimError::Unavailable`].
#[cfg(not(feature = "libsumo"))]
pub fn load(_: &Intake, _: &SignalSettings) -> Result<Result<Loaded, Vec<Obstacle>>, SimError> {
    Err(SimError::Unavailable("built without the feature `libsumo`".into()))
}

/// Returns the simulator's version.
///
/// # Errors
///
/// [`SimError::Unavailable`] when it is missing.
#[cfg(feature = "libsumo")]
pub fn version() -> Result<String, SimError> {
    super::sim::libsumo::SumoSim::new()?.version()
}

/// Returns the simulator's version, which this build cannot have.
///
/// # Errors
///
/// [`SimError::Unavailable`].
#[cfg(not(feature = "libsumo"))]
pub fn version() -> Result<String, SimError> {
    Err(SimError::Unavailable("built without the feature `libsumo`".into()))
}

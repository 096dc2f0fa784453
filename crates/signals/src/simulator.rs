//! The simulator itself: its version, and what it makes of somebody's scenario.

#[cfg(feature = "libsumo")]
mod first_load;

use super::env::derive::DerivedSignal;
use super::env::warnings::{Warning, of_signals, warnings};
use super::settings::SignalSettings;
use super::sim::intake::Intake;
pub use super::sim::net_file::signals_in;
use super::sim::obstacle::Obstacle;
use super::sim::topology::Topology;
use super::sim::{Scene, SimError};

/// What SUMO 1.15 says where it has written its reason to standard error.
#[cfg(feature = "libsumo")]
const SAID_BEFORE: [&str; 3] = ["Process Error", "Could not parse commandline options.", ""];

/// Words of an error about something that SUMO does not know.
#[cfg(feature = "libsumo")]
const UNKNOWN: [&str; 3] = ["nknown", "vehicle class", "attribute"];

/// What is wrong with a signal that is off at the start of a scenario whose programs change by the clock.
#[cfg(feature = "libsumo")]
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
    /// Ids of level crossings and the like, which are no signals to control.
    pub railways: Vec<String>,
    /// Ids of signals that no program makes green for cars.
    pub dark: Vec<String>,
    /// Ids of signals that the program at the start never makes green for cars, and nothing switches later.
    pub switched_off: Vec<String>,
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
            (
                &self.switched_off,
                "the program of these signals that runs at the start never shows green to cars, and nothing switches to \
                 another one; they keep it under every method, and methods control them where it is removed",
            ),
        ];
        let there = groups.iter().filter(|(ids, _)| !ids.is_empty());
        there.map(|(ids, what)| format!("{what}: {}", ids.join(", "))).collect()
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
    use super::sim::obstacle::{Accept, Way};
    use super::sim::{Sim, StartOptions};
    use basics::files::FileError;

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
    // One without an end is loaded all the same.
    let options = until(intake.end_s.max(first_end_s));
    let mut sim = SumoSim::new()?;
    let version = sim.version()?;
    let obstacle = |reason: String| {
        let place = intake.path.display().to_string();
        Obstacle { place, reason, way: Way::Change("") }
    };
    let said = first_load::first_load(&SumoSim::command_line(&until(first_end_s))?, &version);
    if let Some(last_line) = &said.crash {
        return Ok(Err(vec![obstacle(format!(
            "SUMO crashes on it ({last_line}); take another version of SUMO, or leave out parts of the files to find the one \
             that it crashes on"
        ))]));
    }
    let failed = |e: SimError| match e {
        SimError::Fatal { message, .. } | SimError::Traci { message, .. } => {
            let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
            let reason = match SAID_BEFORE.contains(&message.as_str()) {
                false => message,
                true if said.errors.is_empty() => "its reason is above".to_owned(),
                true => said.errors.clone(),
            };
            // What an older version does not know is of another version, whatever else is wrong is not.
            let is_unknown = UNKNOWN.iter().any(|word| reason.contains(word));
            let newer = intake.newer_than(&version).filter(|_| is_unknown);
            let newer = newer.map_or_else(String::new, |said| format!("; {said}"));
            let reason = format!("SUMO cannot load it: {reason}{newer}");
            let mut said = obstacle(reason);
            let accepted = intake.given.accept.contains(&Accept::NewerClasses);
            if is_unknown && intake.sources.has_newer_classes() && !accepted {
                said.way = Way::Accept(Accept::NewerClasses);
            }
            Ok(Err(vec![said]))
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
    let switched_off = sim.switched_off().to_vec();
    sim.close()?;
    let (mut signals, mut obstacles) = (Vec::new(), Vec::new());
    if intake.sources.has_day_plan() {
        let off = |id: &String| obstacle(format!("signal {id}: {OFF_AT_START}"));
        obstacles.extend(switched_off.iter().map(off));
    }
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
        true => Ok(Loaded { scene, topology, signals, railways, dark, switched_off, version }),
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

//! SUMO inside this process, through libsumo; all `unsafe` is in the private module `api`.
//!
//! Choices:
//! - **Loaded at run time.** The shim is embedded in the binary and loaded when the first
//!   [`SumoSim`] is created, so that everything but simulating works without SUMO. Where SUMO moves
//!   with its user, as in Python, [`look_for`] says where it is.
//! - **One call per decision.** [`Sim::observe`] reads all vehicles and phases at once; ids cross
//!   the boundary only when an episode starts or a program is changed.
//! - **Traced once.** The lanes of the whole network are read when a scenario is started for the first
//!   time; as long as its signals stay the same, so do the pieces upstream of them.
//! - **SUMO's reasons are on standard error.** Under 1.15 a failed start says only
//!   `Process Error` here; whoever runs a worker keeps its standard error.

mod api;
pub mod place;
mod unpacked;

use std::collections::HashMap;
use std::ffi::{CStr, CString};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use libsumo_sys::{SumoVehicle, TRAFFICLIGHT_TYPE_ACTUATED, TRAFFICLIGHT_TYPE_STATIC};

use self::api::Api;
use super::net_file::{Mutual, mutual, refused};
use super::sumocfg::SumoConfig;
use super::topology::Topology;
use super::trace::Tracing;
use super::{
    Program, ProgramKind, Scene, Sim, SimError, Snapshot, StartOptions, StepCounts, VehicleState,
};
use basics::heartbeat;

pub use libsumo_sys::{INCLUDE_DIR, KIND, LIBRARY};
pub use place::{library, look_for};

/// Options of every episode, unless [`StartOptions::args`] has its own value for one.
///
/// Without validation, because SUMO 1.15 asks a web site for the schema when `SUMO_HOME` is unset
/// and fails without an answer. Vehicles with a device for safety measures would each write a file.
const DEFAULTS: [(&str, &str); 5] = [
    ("--xml-validation", "never"),
    ("--no-step-log", "true"),
    ("--duration-log.disable", "true"),
    ("--no-warnings", "true"),
    ("--device.ssm.file", "NUL"),
];

/// What is wrong with a scenario in which there is nothing to control.
const NO_SIGNAL: &str = "it has no traffic signal that gives green, under its program at the start, to a lane that passenger cars \
                         may use; give a scenario with a signalised road intersection, or another --begin";

/// Why signals are left alone.
const TRAINS: &str = "trains steer these level crossings, and no method controls them";
const DARK: &str = "no program of these signals is ever green for cars, since they flash or are dark or closed; they keep it \
                    under every method";
/// See `TRAINS`; a day plan may switch these on.
pub const SWITCHED_OFF: &str = "the program of these signals that runs at the start never shows green to cars, and nothing switches \
                                to another one; they keep it under every method, and methods control them where it is removed";

/// Whether some [`SumoSim`] of this process has an episode.
static RUNNING: AtomicBool = AtomicBool::new(false);

/// A scene that was traced, and what it was traced from.
#[derive(Debug, Clone)]
struct Traced {
    config: PathBuf,
    trace_m: f64,
    plain: Scene,
    scene: Scene,
    tracing: Tracing,
}

/// A simulation by SUMO; at most one per process runs at a time.
#[derive(Debug)]
pub struct SumoSim {
    api: Api,
    running: bool,
    traced: Option<Traced>,
    signals: Vec<CString>,
    left_alone: Vec<(&'static str, String)>,
    /// A configuration with the links of its network that yield to each other.
    mutual: Option<(PathBuf, Mutual)>,
    vehicles: Vec<SumoVehicle>,
    phases: Vec<i32>,
    /// libsumo may be called from one thread only.
    not_send: PhantomData<*const ()>,
}

impl SumoSim {
    /// Loads SUMO; nothing is simulated yet.
    /// Fails with [`SimError::Unavailable`] when libsumo or a library that it needs is missing.
    pub fn new() -> Result<Self, SimError> {
        Ok(Self {
            api: Api::load()?,
            running: false,
            traced: None,
            signals: Vec::new(),
            left_alone: Vec::new(),
            mutual: None,
            vehicles: Vec::new(),
            phases: Vec::new(),
            not_send: PhantomData,
        })
    }

    /// Returns SUMO's version, such as `SUMO 1.15.0`.
    /// Fails with [`SimError`] when the library cannot answer.
    pub fn version(&self) -> Result<String, SimError> {
        self.api.version()
    }

    /// Returns the command line with which SUMO is started for an episode, its name first.
    /// Fails with [`SimError`] when the configuration cannot be read.
    pub fn command_line(options: &StartOptions) -> Result<Vec<CString>, SimError> {
        arguments(options, &SumoConfig::read(&options.config)?)
    }

    /// Returns the lanes of the network that is simulated.
    /// Fails with [`SimError`] when nothing runs.
    pub fn topology(&mut self) -> Result<Topology, SimError> {
        self.api.topology()
    }

    /// Returns the signals of the episode that was started last that are no part of its scene and keep their own program:
    /// why, and SUMO's id.
    pub fn left_alone(&self) -> &[(&'static str, String)] {
        &self.left_alone
    }

    /// Reads the scene and tells the shim which signals and lanes matter.
    fn describe(&mut self, options: &StartOptions) -> Result<Scene, SimError> {
        let (plain, mut lanes) = self.plain_scene(&options.config)?;
        let known = |t: &Traced| {
            t.config == options.config && t.trace_m == options.trace_m && t.plain == plain
        };
        let traced = match self.traced.take().filter(known) {
            Some(traced) => traced,
            None => {
                let (config, trace_m) = (options.config.clone(), options.trace_m);
                let mut scene = plain.clone();
                let tracing = Tracing::new(&mut scene, &self.api.topology()?, trace_m);
                Traced { config, trace_m, plain, scene, tracing }
            }
        };
        for piece in traced.tracing.pieces() {
            lanes.push(text(piece.as_str())?);
        }
        self.phases.resize(self.signals.len(), 0);
        self.api.watch(&self.signals, &lanes)?;
        Ok(self.traced.insert(traced).scene.clone())
    }

    /// Reads the scene without what tracing adds, and the ids of its lanes.
    fn plain_scene(&mut self, config: &Path) -> Result<(Scene, Vec<CString>), SimError> {
        let mut ids = self.api.signals()?;
        ids.sort_unstable();
        let mut scene = Scene::default();
        let mut lanes = Vec::new();
        let mut index_of = HashMap::new();
        self.left_alone.clear();
        for id in ids {
            let name = text(id.as_str())?;
            let (mut signal, from_lanes, is_railway) = self.api.signal(&name)?;
            // Signals of foot paths alone have nothing to decide for cars.
            if from_lanes.is_empty() {
                continue;
            }
            // Another program would hold a gate open to cars while trains pass. The lanes of all of these stay signalled
            // where lanes are traced: nobody sees through a gate.
            let why = match () {
                () if is_railway => Some(TRAINS),
                () if !signal.may_be_green() => Some(DARK),
                () => signal.is_switched_off().then_some(SWITCHED_OFF),
            };
            if let Some(why) = why {
                self.left_alone.push((why, id));
                continue;
            }
            let mut from_lanes = from_lanes.into_iter();
            for link in signal.links.iter_mut().flatten() {
                let from = from_lanes.next().expect("one incoming lane per link");
                link.from_lane = match index_of.get(&from) {
                    Some(&index) => index,
                    None => {
                        let lane = text(from.as_str())?;
                        scene.lanes.push(self.api.lane(&lane)?);
                        lanes.push(lane);
                        index_of.insert(from, scene.lanes.len() - 1);
                        scene.lanes.len() - 1
                    }
                };
            }
            self.signals.push(name);
            scene.signals.push(signal);
        }
        if scene.signals.is_empty() {
            let (path, reason) = (config.to_path_buf(), NO_SIGNAL.to_owned());
            return Err(SimError::Config { path, reason });
        }
        Ok((scene, lanes))
    }

    /// Refuses an actuated program with which SUMO may ask for memory without bounds.
    fn check_actuated(&mut self, signal: usize, program: &Program) -> Result<(), SimError> {
        let Some(config) = self.traced.as_ref().map(|traced| traced.config.clone()) else {
            return Ok(());
        };
        let known = match self.mutual.take().filter(|(of, _)| *of == config) {
            Some((_, known)) => known,
            None => mutual(&SumoConfig::read(&config)?)?,
        };
        let (_, known) = self.mutual.insert((config, known));
        let Some(id) = self.signals.get(signal) else { return Ok(()) };
        let id = id.to_string_lossy().into_owned();
        let states = program.phases.iter().map(|phase| phase.state.as_str());
        let Some((a, b)) = refused(known, &id, states) else { return Ok(()) };
        let reason = format!(
            "SUMO cannot run its actuated program, which shows the links {a} and {b} green together although each yields to \
             the other; leave this method out, or build the network again with netconvert --sumo-net-file OLD.net.xml \
             --tls.ignore-internal-junction-jam --output-file NEW.net.xml"
        );
        Err(SimError::Signal { signal: id, reason })
    }

    fn signal(&self, signal: usize) -> Result<&CStr, SimError> {
        match self.signals.get(signal) {
            Some(id) => Ok(id),
            None if self.running => Err(rejected(format!("there is no signal {signal}"))),
            None => Err(SimError::NotRunning),
        }
    }
}

impl Sim for SumoSim {
    fn start(&mut self, options: &StartOptions) -> Result<Scene, SimError> {
        // Whoever needs the old episode's outputs has closed it and seen the error, if any.
        let _ = self.close();
        if !options.config.is_file() {
            return Err(SimError::Missing(options.config.clone()));
        }
        let argv = Self::command_line(options)?;
        if RUNNING.swap(true, Ordering::Acquire) {
            return Err(SimError::AlreadyRunning);
        }
        self.running = true;
        let scene = self.api.start(&argv).and_then(|()| self.describe(options));
        heartbeat::beat(1);
        if scene.is_err() {
            // The first error is the one that explains.
            let _ = self.close();
        }
        scene
    }

    fn step(&mut self, steps: u32) -> Result<StepCounts, SimError> {
        heartbeat::beat(steps);
        self.api.step(steps)
    }

    fn install(&mut self, signal: usize, program: &Program) -> Result<(), SimError> {
        let kind = match program.kind {
            ProgramKind::Static => TRAFFICLIGHT_TYPE_STATIC,
            ProgramKind::Actuated => TRAFFICLIGHT_TYPE_ACTUATED,
            ProgramKind::Other | ProgramKind::DualRing => {
                let message = format!("program {} is neither static nor actuated", program.id);
                return Err(rejected(message));
            }
        };
        if program.kind == ProgramKind::Actuated {
            self.check_actuated(signal, program)?;
        }
        let states: Result<Vec<_>, _> =
            program.phases.iter().map(|phase| text(phase.state.as_str())).collect();
        let id = text(program.id.as_str())?;
        self.api.install(self.signal(signal)?, &id, kind, &program.phases, &states?)
    }

    fn select(&mut self, signal: usize, program_id: &str) -> Result<(), SimError> {
        self.api.select(self.signal(signal)?, &text(program_id)?)
    }

    fn enter(&mut self, signal: usize, phase: u32, left_s: f64) -> Result<(), SimError> {
        self.api.enter(self.signal(signal)?, phase.cast_signed(), left_s)
    }

    fn show(&mut self, signal: usize, state: &str) -> Result<(), SimError> {
        self.api.show(self.signal(signal)?, &text(state)?)
    }

    fn set_phases(&mut self, phases: &[Option<u32>]) -> Result<(), SimError> {
        self.phases.clear();
        self.phases.extend(phases.iter().map(|phase| phase.map_or(-1, u32::cast_signed)));
        let result = self.api.set_phases(&self.phases);
        self.phases.resize(self.signals.len(), 0);
        result
    }

    fn observe(&mut self, snapshot: &mut Snapshot) -> Result<(), SimError> {
        let count = self.api.observe(&mut self.vehicles, &mut self.phases)?;
        let traced = self.traced.as_ref().ok_or(SimError::NotRunning)?;
        snapshot.vehicles.clear();
        snapshot.vehicles.extend(self.vehicles[..count].iter().filter_map(|v| {
            let next = u32::try_from(v.signal).ok().zip(u32::try_from(v.link).ok());
            let next = next.map(|(signal, link)| (signal, link, v.way));
            let (lane, link) = traced.tracing.attribute(v.lane, next)?;
            Some(VehicleState {
                lane,
                link,
                way: v.way,
                vehicle: v.vehicle,
                position_m: v.position_m,
                speed_mps: v.speed_mps,
                waiting_s: v.waiting_s,
                distance_m: v.distance_m,
            })
        }));
        snapshot.phases.clear();
        snapshot.phases.extend(self.phases.iter().map(|phase| phase.cast_unsigned()));
        Ok(())
    }

    fn close(&mut self) -> Result<(), SimError> {
        if !self.running {
            return Ok(());
        }
        self.running = false;
        self.signals.clear();
        self.phases.clear();
        let result = self.api.close();
        RUNNING.store(false, Ordering::Release);
        result
    }
}

impl Drop for SumoSim {
    fn drop(&mut self) {
        // An error has no one left to go to.
        let _ = self.close();
    }
}

/// Returns SUMO's command line, which has the configuration's options but not the configuration.
fn arguments(options: &StartOptions, config: &SumoConfig) -> Result<Vec<CString>, SimError> {
    let mut argv = vec![text("sumo")?];
    // SUMO refuses an option that is given twice.
    let given = |name: &str| options.args.iter().any(|arg| arg.split('=').next() == Some(name));
    for (name, value) in DEFAULTS {
        if !given(name) {
            argv.extend([text(name)?, text(value)?]);
        }
    }
    for (name, value) in config.options() {
        if !given(&format!("--{name}")) {
            argv.push(text(format!("--{name}={value}"))?);
        }
    }
    for arg in &options.args {
        argv.push(text(arg.as_str())?);
    }
    if !options.tripinfo.as_os_str().is_empty() {
        argv.extend([text("--tripinfo-output")?, path_text(&options.tripinfo)?]);
        for name in ["--tripinfo-output.write-unfinished", "--tripinfo-output.write-undeparted"] {
            argv.extend([text(name)?, text("true")?]);
        }
    }
    Ok(argv)
}

fn text(value: impl Into<Vec<u8>>) -> Result<CString, SimError> {
    CString::new(value).map_err(|e| rejected(format!("a text has a null byte: {e}")))
}

fn path_text(path: &Path) -> Result<CString, SimError> {
    text(path.as_os_str().as_encoded_bytes())
}

/// Returns the error of a call that is refused before it reaches SUMO.
fn rejected(message: String) -> SimError {
    SimError::Traci { call: "SumoSim", message }
}

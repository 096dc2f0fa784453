//! SUMO inside this process, through libsumo.
//!
//! Two facts justify the calls of its shim, and each `SAFETY` comment names what else is needed:
//! - **One thread.** [`SumoSim`] is not `Send`, and of several only one has an episode.
//! - **Whose memory.** Texts and arrays that the shim returns stay as they are until the same
//!   function is called again; all of them are copied before that.
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
#![expect(unsafe_code, reason = "libsumo is C++; every call is one documented unsafe block")]

pub mod place;
mod unpacked;

use std::collections::HashMap;
use std::ffi::{CStr, CString, c_char};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::{error::Error, fmt, io, ptr, slice};

use libsumo_sys::{
    Library, SHIM, SUMO_LANE_CARS, SUMO_LANE_FOOT, SUMO_LANE_INNER, SUMO_NOT_RUNNING, SUMO_OK,
    SUMO_REJECTED, SUMO_TOO_SMALL, Shim, SumoCounts, SumoLane, SumoPhase, SumoProgram, SumoSignal,
    SumoStreetLane, SumoTopology, SumoVehicle, TRAFFICLIGHT_TYPE_ACTUATED,
    TRAFFICLIGHT_TYPE_STATIC,
};
use osm_signals::angle::normalise_degrees;

use self::unpacked::unpacked;
use super::net_file::{Mutual, mutual, refused};
use super::sumocfg::SumoConfig;
use super::topology::{StreetLane, Topology, Way};
use super::trace::Tracing;
use super::{
    Direction, Lane, Link, Program, ProgramKind, ProgramPhase, Scene, SignalInfo, Sim, SimError,
    Snapshot, StartOptions, StepCounts, VehicleState,
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

/// Vehicles that the first buffer has room for; it doubles until they fit.
const FIRST_CAPACITY: usize = 16;

/// The loaded shim, for the rest of the process: SUMO cannot be unloaded safely.
static LOADED: OnceLock<Result<Shim, String>> = OnceLock::new();

/// The functions of the loaded shim.
#[derive(Clone, Copy)]
struct Api(&'static Shim);

impl fmt::Debug for Api {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Api")
    }
}

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
    /// The signals of the episode that was started last that are no part of its scene and keep their own program: why, and
    /// SUMO's id.
    pub left_alone: Vec<(&'static str, String)>,
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
        let (mut api, mut name) = (0, ptr::null());
        // SAFETY: both point to writable variables.
        let code = unsafe { self.api.0.sumo_version(&raw mut api, &raw mut name) };
        self.api.check("sumo_version", code)?;
        // SAFETY: the call above succeeded and set a text of the shim.
        Ok(unsafe { owned(name) })
    }

    /// Returns SUMO's version, and loads it only where it is not the file of the build.
    /// Fails with [`SimError`] when the library is missing or cannot answer.
    pub fn version_unloaded() -> Result<String, SimError> {
        let of_build = place::library().is_ok_and(|library| library.as_os_str() == LIBRARY);
        match libsumo_sys::version().filter(|_| of_build) {
            Some(version) => Ok(version.to_owned()),
            None => Self::new()?.version(),
        }
    }

    /// Returns the lanes of the network that is simulated.
    /// Fails with [`SimError`] when nothing runs.
    pub fn topology(&mut self) -> Result<Topology, SimError> {
        self.api.topology()
    }

    /// Reads the scene and tells the shim which signals and lanes matter.
    fn describe(&mut self, options: &StartOptions) -> Result<Scene, SimError> {
        let (plain, mut names) = self.plain_scene(&options.config)?;
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
        for piece in &traced.tracing.pieces {
            names.push(text(piece.as_str())?);
        }
        self.phases.resize(self.signals.len(), 0);
        let (signals, lanes) = (pointers(&self.signals), pointers(&names));
        // SAFETY: both vectors have `len` pointers to texts that live in this function.
        let code = unsafe {
            self.api.0.sumo_watch(signals.as_ptr(), signals.len(), lanes.as_ptr(), lanes.len())
        };
        self.api.check("sumo_watch", code)?;
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
            return Err(SimError::NoConfig(options.config.clone()));
        }
        let argv = arguments(options, &SumoConfig::read(&options.config)?)?;
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
        let mut counts = SumoCounts::default();
        // SAFETY: `counts` is writable.
        let code = unsafe { self.api.0.sumo_step(steps, &raw mut counts) };
        self.api.check("sumo_step", code)?;
        Ok(StepCounts { teleports: counts.teleports, collisions: counts.colliding })
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
        let states = program.phases.iter().map(|phase| text(phase.state.as_str()));
        let states = states.collect::<Result<Vec<_>, _>>()?;
        let phase = |(phase, state): (&ProgramPhase, &CString)| SumoPhase {
            duration_s: phase.duration_s,
            min_s: phase.min_s,
            max_s: phase.max_s,
            state: state.as_ptr(),
            reached: 1,
        };
        let phases: Vec<SumoPhase> = program.phases.iter().zip(&states).map(phase).collect();
        let (signal, id) = (self.signal(signal)?.as_ptr(), text(program.id.as_str())?);
        let (first, count) = (phases.as_ptr(), phases.len());
        let gap_s = program.max_gap_s.unwrap_or(-1.0);
        // SAFETY: all texts end with a null byte and `phases` has `count` elements.
        let code =
            unsafe { self.api.0.sumo_install(signal, id.as_ptr(), kind, first, count, gap_s) };
        self.api.check("sumo_install", code)
    }

    fn select(&mut self, signal: usize, program_id: &str) -> Result<(), SimError> {
        let (signal, program) = (self.signal(signal)?.as_ptr(), text(program_id)?);
        // SAFETY: both texts end with a null byte.
        let code = unsafe { self.api.0.sumo_select(signal, program.as_ptr()) };
        self.api.check("sumo_select", code)
    }

    fn enter(&mut self, signal: usize, phase: u32, left_s: f64) -> Result<(), SimError> {
        let signal = self.signal(signal)?.as_ptr();
        // SAFETY: the text ends with a zero and outlives the call.
        let code = unsafe { self.api.0.sumo_enter(signal, phase.cast_signed(), left_s) };
        self.api.check("sumo_enter", code)
    }

    fn show(&mut self, signal: usize, state: &str) -> Result<(), SimError> {
        let (signal, state) = (self.signal(signal)?.as_ptr(), text(state)?);
        // SAFETY: both texts end with a null byte.
        let code = unsafe { self.api.0.sumo_show(signal, state.as_ptr()) };
        self.api.check("sumo_show", code)
    }

    fn set_phases(&mut self, phases: &[Option<u32>]) -> Result<(), SimError> {
        // -1 leaves a signal alone.
        let phases: Vec<i32> =
            phases.iter().map(|phase| phase.map_or(-1, u32::cast_signed)).collect();
        // SAFETY: the vector has `len` elements.
        let code = unsafe { self.api.0.sumo_set_phases(phases.as_ptr(), phases.len()) };
        self.api.check("sumo_set_phases", code)
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
        // SAFETY: needs nothing but the one thread.
        let result = self.api.check("sumo_close", unsafe { self.api.0.sumo_close() });
        RUNNING.store(false, Ordering::Release);
        result
    }
}

impl SignalInfo {
    /// Whether some program has a green for a link.
    fn may_be_green(&self) -> bool {
        self.programs.iter().any(|program| self.has_green(program))
    }

    /// Whether the program that runs at the start has no green for any link, as SUMO's program `off`.
    fn is_switched_off(&self) -> bool {
        let active = self.programs.iter().find(|program| program.id == self.active_program);
        active.is_some_and(|program| !self.has_green(program))
    }

    fn has_green(&self, program: &Program) -> bool {
        let green =
            |(letter, links): (char, &Vec<Link>)| matches!(letter, 'G' | 'g') && !links.is_empty();
        program.phases.iter().any(|phase| phase.state.chars().zip(&self.links).any(green))
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
    for (name, value) in &config.options {
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

impl Api {
    /// Loads the shim, once per process.
    fn load() -> Result<Self, SimError> {
        let library = place::library().map_err(SimError::Absent)?;
        LOADED
            .get_or_init(|| load(&library).map_err(|e| format!("{e} (built with {LIBRARY})")))
            .as_ref()
            .map(Self)
            .map_err(|reason| SimError::Unavailable(reason.clone()))
    }

    /// Starts a simulation with the command line `argv`.
    fn start(self, argv: &[CString]) -> Result<(), SimError> {
        let argv = pointers(argv);
        // SAFETY: `argv` has `len` pointers to texts that live in the caller's slice.
        let code = unsafe { self.0.sumo_start(argv.as_ptr(), argv.len()) };
        match self.check("sumo_start", code) {
            // Nothing runs after a failed start, whatever SUMO threw.
            Err(SimError::Traci { call, message }) => Err(SimError::Fatal { call, message }),
            other => other,
        }
    }

    /// Returns the ids of all signals.
    fn signals(self) -> Result<Vec<String>, SimError> {
        let (mut ids, mut count) = (ptr::null(), 0);
        // SAFETY: both point to writable variables.
        self.check("sumo_signals", unsafe { self.0.sumo_signals(&raw mut ids, &raw mut count) })?;
        // SAFETY: the call above succeeded and set an array of the shim.
        let ids = unsafe { array(ids, count) };
        // SAFETY: each element is a text of the shim.
        Ok(ids.iter().map(|&id| unsafe { owned(id) }).collect())
    }

    /// Returns a signal and, in the order of its links, the ids of their incoming lanes; the
    /// links' lane indices are left for the caller to fill in. Last, whether it is a railway's.
    fn signal(self, id: &CStr) -> Result<(SignalInfo, Vec<String>, bool), SimError> {
        let mut raw = SumoSignal::default();
        // SAFETY: `id` ends with a null byte and `raw` is writable.
        let code = unsafe { self.0.sumo_signal(id.as_ptr(), &raw mut raw) };
        self.check("sumo_signal", code)?;
        let id = id.to_string_lossy().into_owned();
        let mut links: Vec<Vec<Link>> = vec![Vec::new(); raw.index_count];
        let mut from_lanes = Vec::new();
        // SAFETY: the call above succeeded and set an array of the shim.
        for link in unsafe { array(raw.links, raw.link_count) } {
            // SAFETY: a link's lanes are texts of the shim.
            let from = unsafe { owned(link.from) };
            // SAFETY: as above.
            let to_lane = unsafe { owned(link.to) };
            let letter = char::from(link.direction.cast_unsigned());
            let direction = Direction::from_letter(letter).ok_or_else(|| SimError::Signal {
                signal: id.clone(),
                reason: format!(
                    "the connection from {from} to {to_lane} has no direction; give it one in \
                     the network's <connection dir=...>"
                ),
            })?;
            links[link.index as usize].push(Link::new(0, to_lane, direction));
            from_lanes.push(from);
        }
        // SAFETY: the call above succeeded and set an array of the shim.
        let programs = unsafe { array(raw.programs, raw.program_count) };
        // SAFETY: each element is a program of the shim.
        let programs = programs.iter().map(|p| unsafe { owned_program(p) }).collect();
        // SAFETY: the call above succeeded and set a text of the shim.
        let active_program = unsafe { owned(raw.active_program) };
        let count = raw.index_count;
        // SAFETY: the call above succeeded and set an array of the shim with a row per link index.
        let meets = unsafe { array(raw.meets, count * count) };
        let meets = meets.chunks(count.max(1)).map(|row| row.iter().map(|m| *m != 0).collect());
        let info = SignalInfo { id, links, programs, active_program, meets: meets.collect() };
        Ok((info, from_lanes, raw.railway))
    }

    fn lane(self, id: &CStr) -> Result<Lane, SimError> {
        let mut raw = SumoLane::default();
        // SAFETY: `id` ends with a null byte and `raw` is writable.
        let code = unsafe { self.0.sumo_lane(id.as_ptr(), &raw mut raw) };
        self.check("sumo_lane", code)?;
        let (east_m, north_m) = (raw.to_x_m - raw.from_x_m, raw.to_y_m - raw.from_y_m);
        Ok(Lane {
            id: id.to_string_lossy().into_owned(),
            length_m: raw.length_m,
            speed_mps: raw.speed_mps,
            heading_deg: normalise_degrees(east_m.atan2(north_m).to_degrees()),
            ..Lane::default()
        })
    }

    /// Returns the lanes of the whole network.
    fn topology(self) -> Result<Topology, SimError> {
        let mut raw = SumoTopology::default();
        // SAFETY: `raw` is writable.
        self.check("sumo_topology", unsafe { self.0.sumo_topology(&raw mut raw) })?;
        // SAFETY: the call above succeeded and set an array of the shim.
        let lanes = unsafe { array(raw.lanes, raw.lane_count) };
        // SAFETY: each element is a lane of the shim.
        let mut lanes: Vec<_> = lanes.iter().map(|lane| unsafe { owned_lane(lane) }).collect();
        // SAFETY: as for the lanes.
        let inner = unsafe { array(raw.inner, raw.inner_count) };
        // SAFETY: as for the lanes.
        for way in unsafe { array(raw.ways, raw.way_count) } {
            let first = way.inner_first as usize;
            let inner = &inner[first..first + way.inner_count as usize];
            lanes[way.from as usize].ways.push(Way {
                to: way.to as usize,
                inner: inner.iter().map(|lane| *lane as usize).collect(),
                direction: Direction::from_letter(char::from(way.direction.cast_unsigned())),
                controlled: way.controlled,
            });
        }
        Ok(Topology::new(lanes))
    }

    /// Fills both buffers and returns the number of vehicles; grows the first one as needed.
    fn observe(
        self,
        vehicles: &mut Vec<SumoVehicle>,
        phases: &mut [i32],
    ) -> Result<usize, SimError> {
        if vehicles.is_empty() {
            vehicles.resize(FIRST_CAPACITY, SumoVehicle::default());
        }
        loop {
            let mut count = 0;
            // SAFETY: the buffers have the lengths that are given and `count` is writable.
            let code = unsafe {
                self.0.sumo_observe(
                    vehicles.as_mut_ptr(),
                    vehicles.len(),
                    &raw mut count,
                    phases.as_mut_ptr(),
                    phases.len(),
                )
            };
            if code != SUMO_TOO_SMALL {
                return self.check("sumo_observe", code).map(|()| count);
            }
            vehicles.resize(count.next_power_of_two(), SumoVehicle::default());
        }
    }

    fn check(self, call: &'static str, code: i32) -> Result<(), SimError> {
        if code == SUMO_OK {
            return Ok(());
        }
        // SAFETY: needs nothing but the one thread.
        let message = unsafe { self.0.sumo_last_error() };
        // SAFETY: a text of the shim.
        let message = unsafe { owned(message) };
        Err(match code {
            SUMO_REJECTED => SimError::Traci { call, message },
            SUMO_NOT_RUNNING => SimError::NotRunning,
            _ => SimError::Fatal { call, message },
        })
    }
}

/// Returns why something could not be loaded: the error itself says only that, its source names what is missing.
fn cause(error: &dyn Error) -> String {
    let said = error.source().map_or_else(|| error.to_string(), ToString::to_string);
    match said.contains("undefined symbol") {
        true => {
            format!("{said}: it is another libsumo than the one that this program was built with")
        }
        false => said,
    }
}

/// Loads the embedded shim, and before it the library that it needs where that lies elsewhere than it did when the
/// shim was built: the system's loader takes the one of that name that is there.
fn load(library: &Path) -> io::Result<Shim> {
    if library != Path::new(LIBRARY) {
        // SAFETY: libsumo, as whoever named its place vouches; loading it runs nothing but static constructors.
        let loaded = unsafe { Library::new(library) }.map_err(|e| io::Error::other(cause(&e)))?;
        Box::leak(Box::new(loaded));
    }
    unpacked(SHIM, |path| {
        // SAFETY: the file is the shim that the declarations were generated from; loading it runs
        // nothing but the static constructors of SUMO and of the libraries that SUMO needs.
        unsafe { Shim::new(path) }.map_err(|e| cause(&e))
    })
}

fn pointers(texts: &[CString]) -> Vec<*const c_char> {
    texts.iter().map(|text| text.as_ptr()).collect()
}

/// Copies a text of the shim.
///
/// # Safety
///
/// `text` must be a text that the shim returned and that is still valid.
unsafe fn owned(text: *const c_char) -> String {
    // SAFETY: the shim's texts end with a null byte; the caller vouches for the rest.
    unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
}

/// Borrows an array of the shim.
///
/// # Safety
///
/// `first` and `count` must be an array that the shim returned; it must stay valid for `'a`.
unsafe fn array<'a, T>(first: *const T, count: usize) -> &'a [T] {
    // An empty vector's address in C++ may be null, which a slice's must not.
    if count == 0 {
        return &[];
    }
    // SAFETY: the caller vouches for it.
    unsafe { slice::from_raw_parts(first, count) }
}

/// Copies a lane of the shim's topology, without its ways.
///
/// # Safety
///
/// The lane must be one that the shim returned and that is still valid.
unsafe fn owned_lane(lane: &SumoStreetLane) -> StreetLane {
    let has = |flag: i32| lane.flags & flag.cast_unsigned() != 0;
    // SAFETY: part of a lane of the shim.
    let shape = unsafe { array(lane.shape, lane.shape_count) };
    StreetLane {
        // SAFETY: part of a lane of the shim.
        id: unsafe { owned(lane.id) },
        length_m: lane.length_m,
        width_m: lane.width_m,
        cars: has(SUMO_LANE_CARS),
        foot: has(SUMO_LANE_FOOT),
        inner: has(SUMO_LANE_INNER),
        shape: shape.iter().map(|point| [point.x_m, point.y_m]).collect(),
        ways: Vec::new(),
    }
}

/// Copies a program of the shim.
///
/// # Safety
///
/// The program must be one that the shim returned and that is still valid.
unsafe fn owned_program(program: &SumoProgram) -> Program {
    let kind = match program.type_ {
        TRAFFICLIGHT_TYPE_STATIC => ProgramKind::Static,
        TRAFFICLIGHT_TYPE_ACTUATED => ProgramKind::Actuated,
        _ => ProgramKind::Other,
    };
    // SAFETY: part of a program of the shim.
    let phases = unsafe { array(program.phases, program.phase_count) };
    Program {
        // SAFETY: part of a program of the shim.
        id: unsafe { owned(program.id) },
        kind,
        // SAFETY: each element is part of a program of the shim.
        phases: phases.iter().map(|phase| unsafe { owned_phase(phase, kind) }).collect(),
        max_gap_s: Some(program.max_gap_s)
            .filter(|gap_s| kind == ProgramKind::Actuated && gap_s.is_finite() && *gap_s >= 0.0),
    }
}

/// Copies a phase of the shim.
///
/// # Safety
/// The phase must be one that the shim returned and that is still valid.
unsafe fn owned_phase(phase: &SumoPhase, kind: ProgramKind) -> ProgramPhase {
    // SUMO fills limits that are not given with values that it never uses.
    let limit = |limit_s: f64| {
        if kind == ProgramKind::Static || limit_s < 0.0 { phase.duration_s } else { limit_s }
    };
    ProgramPhase {
        duration_s: phase.duration_s,
        min_s: limit(phase.min_s),
        max_s: limit(phase.max_s),
        // SAFETY: part of a phase of the shim.
        state: unsafe { owned(phase.state) },
        is_reached: phase.reached != 0,
    }
}

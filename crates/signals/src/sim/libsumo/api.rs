//! The shim's functions with Rust's types: the only module with `unsafe`.
//!
//! Two facts justify the calls, and each `SAFETY` comment names what else is needed:
//! - **One thread.** An [`Api`] lives in a `SumoSim`, which is not `Send`, and of several only
//!   one has an episode.
//! - **Whose memory.** Texts and arrays that the shim returns stay as they are until the same
//!   function is called again; all of them are copied before that.
#![expect(unsafe_code, reason = "libsumo is C++; every call is one documented unsafe block")]

use std::ffi::{CStr, CString, c_char};
use std::fmt;
use std::io;
use std::path::Path;
use std::ptr;
use std::slice;
use std::sync::OnceLock;

use libsumo_sys::{
    LIBRARY, Library, SHIM, SUMO_LANE_CARS, SUMO_LANE_FOOT, SUMO_LANE_INNER, SUMO_NOT_RUNNING,
    SUMO_OK, SUMO_REJECTED, SUMO_TOO_SMALL, Shim, SumoCounts, SumoLane, SumoPhase, SumoProgram,
    SumoSignal, SumoStreetLane, SumoTopology, SumoVehicle, TRAFFICLIGHT_TYPE_ACTUATED,
    TRAFFICLIGHT_TYPE_STATIC,
};
use osm_signals::angle::normalise_degrees;

use super::place::{cause, library};
use super::unpacked::unpacked;
use crate::sim::topology::{StreetLane, Topology, Way};
use crate::sim::{
    Direction, Lane, Link, Program, ProgramKind, ProgramPhase, SignalInfo, SimError, StepCounts,
};

/// Vehicles that the first buffer has room for; it doubles until they fit.
const FIRST_CAPACITY: usize = 16;

/// The loaded shim, for the rest of the process: SUMO cannot be unloaded safely.
static LOADED: OnceLock<Result<Shim, String>> = OnceLock::new();

/// The functions of the loaded shim.
#[derive(Clone, Copy)]
pub(super) struct Api(&'static Shim);

impl fmt::Debug for Api {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Api")
    }
}

impl Api {
    /// Loads the shim, once per process.
    pub(super) fn load() -> Result<Self, SimError> {
        let library = library().map_err(SimError::Absent)?;
        LOADED
            .get_or_init(|| load(&library).map_err(|e| format!("{e} (built with {LIBRARY})")))
            .as_ref()
            .map(Self)
            .map_err(|reason| SimError::Unavailable(reason.clone()))
    }

    pub(super) fn version(self) -> Result<String, SimError> {
        let (mut api, mut name) = (0, ptr::null());
        // SAFETY: both point to writable variables.
        self.check("sumo_version", unsafe { self.0.sumo_version(&raw mut api, &raw mut name) })?;
        // SAFETY: the call above succeeded and set a text of the shim.
        Ok(unsafe { owned(name) })
    }

    /// Starts a simulation with the command line `argv`.
    pub(super) fn start(self, argv: &[CString]) -> Result<(), SimError> {
        let argv = pointers(argv);
        // SAFETY: `argv` has `len` pointers to texts that live in the caller's slice.
        let code = unsafe { self.0.sumo_start(argv.as_ptr(), argv.len()) };
        match self.check("sumo_start", code) {
            // Nothing runs after a failed start, whatever SUMO threw.
            Err(SimError::Traci { call, message }) => Err(SimError::Fatal { call, message }),
            other => other,
        }
    }

    pub(super) fn close(self) -> Result<(), SimError> {
        // SAFETY: needs nothing but the one thread.
        self.check("sumo_close", unsafe { self.0.sumo_close() })
    }

    pub(super) fn step(self, steps: u32) -> Result<StepCounts, SimError> {
        let mut counts = SumoCounts::default();
        // SAFETY: `counts` is writable.
        self.check("sumo_step", unsafe { self.0.sumo_step(steps, &raw mut counts) })?;
        Ok(StepCounts { teleports: counts.teleports, collisions: counts.colliding })
    }

    /// Returns the ids of all signals.
    pub(super) fn signals(self) -> Result<Vec<String>, SimError> {
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
    pub(super) fn signal(self, id: &CStr) -> Result<(SignalInfo, Vec<String>, bool), SimError> {
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

    pub(super) fn lane(self, id: &CStr) -> Result<Lane, SimError> {
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
    pub(super) fn topology(self) -> Result<Topology, SimError> {
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

    pub(super) fn install(
        self,
        signal: &CStr,
        program: &CStr,
        kind: i32,
        phases: &[ProgramPhase],
        states: &[CString],
    ) -> Result<(), SimError> {
        let phases: Vec<SumoPhase> = phases
            .iter()
            .zip(states)
            .map(|(phase, state)| SumoPhase {
                duration_s: phase.duration_s,
                min_s: phase.min_s,
                max_s: phase.max_s,
                state: state.as_ptr(),
                reached: 1,
            })
            .collect();
        // SAFETY: all texts end with a null byte and `phases` has `len` elements.
        let code = unsafe {
            self.0.sumo_install(
                signal.as_ptr(),
                program.as_ptr(),
                kind,
                phases.as_ptr(),
                phases.len(),
            )
        };
        self.check("sumo_install", code)
    }

    pub(super) fn select(self, signal: &CStr, program: &CStr) -> Result<(), SimError> {
        // SAFETY: both texts end with a null byte.
        self.check("sumo_select", unsafe { self.0.sumo_select(signal.as_ptr(), program.as_ptr()) })
    }

    /// Lets a signal show a state.
    pub(super) fn show(self, signal: &CStr, state: &CStr) -> Result<(), SimError> {
        // SAFETY: both texts end with a null byte.
        self.check("sumo_show", unsafe { self.0.sumo_show(signal.as_ptr(), state.as_ptr()) })
    }

    /// Enters a phase and ends it after some time.
    pub(super) fn enter(self, signal: &CStr, phase: i32, left_s: f64) -> Result<(), SimError> {
        // SAFETY: the text ends with a zero and outlives the call.
        self.check("sumo_enter", unsafe { self.0.sumo_enter(signal.as_ptr(), phase, left_s) })
    }

    /// Sets what [`Self::set_phases`] and [`Self::observe`] are about.
    pub(super) fn watch(self, signals: &[CString], lanes: &[CString]) -> Result<(), SimError> {
        let (signals, lanes) = (pointers(signals), pointers(lanes));
        // SAFETY: both vectors have `len` pointers to texts that live in the caller's slices.
        let code = unsafe {
            self.0.sumo_watch(signals.as_ptr(), signals.len(), lanes.as_ptr(), lanes.len())
        };
        self.check("sumo_watch", code)
    }

    /// Sets one phase per watched signal; -1 leaves a signal alone.
    pub(super) fn set_phases(self, phases: &[i32]) -> Result<(), SimError> {
        // SAFETY: the slice has `len` elements.
        let code = unsafe { self.0.sumo_set_phases(phases.as_ptr(), phases.len()) };
        self.check("sumo_set_phases", code)
    }

    /// Fills both buffers and returns the number of vehicles; grows the first one as needed.
    pub(super) fn observe(
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

//! The signals of a world, driven step by step: reset, drive, step, finish.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use crate::control::{Drive, GreenPhase, Observation, Onward, RingGreens, SignalSpec};
use crate::existing::Control;
use crate::existing::ran::{greens, starts};
use crate::program::{self, SignalProgram};
use crate::settings::{SignalSettings, SimulationSettings};
use crate::sim::error::SimError;
use crate::sim::sources::Sources;
use crate::sim::{Program, ProgramPhase, Scene, SignalInfo, Sim, Snapshot, StartOptions, tripinfo};
use crate::timing::{Change, Timing};
use basics::units::SECONDS_PER_HOUR;

use super::along::Along;
use super::by_movement::{ByMovement, link_names};
use super::cabinet::Cabinet;
use super::derive::{DerivedSignal, approach_edges, derive, onward, share_turns};
use super::dual_ring::{DualRing, cycle_of, fixed_cycle};
use super::metrics::EpisodeMetrics;
use super::observe::Observer;
use super::on_red::OnRed;
use super::pedestrians::{PedestrianTotals, Pedestrians};
use super::side::as_right_hand;
use super::signal::{aligned, fixed, program};
use super::standing::standing;
use super::world::World;

/// A program that runs on a signal without a controller's decisions.
#[derive(Debug, Clone, PartialEq)]
struct Running {
    /// SUMO's id of the signal.
    signal: String,
    /// Whether it is the network's own, untouched.
    own: bool,
    /// When its first phase begins, seconds after time 0 and its multiples of the cycle.
    offset_s: f64,
    /// The program.
    program: Program,
}

/// The signals of a world as a decision process.
pub struct SignalEnv<S> {
    sim: S,
    world: World,
    pub(crate) signal_settings: SignalSettings,
    simulation_settings: SimulationSettings,
    scratch: PathBuf,
    scene: Scene,
    /// By signal, which links may be used on red.
    on_red: Vec<OnRed>,
    signals: Vec<DerivedSignal>,
    specs: Vec<SignalSpec>,
    /// Of the signals that a controller decides.
    cabinets: Vec<Option<Cabinet>>,
    /// Of the signals that run in two rings.
    rings: Vec<Option<DualRing>>,
    /// By signal, the greens with which `retime` drives it, and what it may choose where it keeps those that it has.
    retimed: Vec<Vec<f64>>,
    ring_greens: Vec<Option<RingGreens>>,
    /// Who wants to cross at each signal, where they push buttons; on recall what WALK they have.
    pedestrians: Vec<Option<Pedestrians>>,
    seed: u64,
    /// What signals that run no program show.
    shown: Vec<String>,
    /// What the others run.
    programs: Vec<Option<Running>>,
    /// Arguments that have SUMO read private copies; `None` before the first episode.
    copies: Option<Vec<String>>,
    /// Programs that are active at the beginning where others come by the clock, by signal.
    at_begin: BTreeMap<String, String>,
    observer: Observer,
    snapshot: Snapshot,
    observations: Vec<Observation>,
    request: Vec<Option<u32>>,
    /// Distance of the first vehicle of each lane to the stop line, metres.
    nearest_m: Vec<f64>,
    time_s: f64,
    /// Whether the next episodes collect their movements, which takes the routes of all their vehicles, and who drives along
    /// streets.
    pub(crate) collects_movements: bool,
    by_movement: Option<ByMovement>,
    along: Option<Along>,
    /// By signal, what SUMO was told to show, with since when, seconds; whoever asks for it sets this before an episode.
    pub(crate) told: Option<Vec<Vec<(f64, String)>>>,
    /// What is known of the episode before its end; of the queue the sum over decisions.
    metrics: EpisodeMetrics,
    decisions: u32,
    /// Wall-clock time spent within the simulator so far.
    pub simulator: Duration,
}

impl<S: Sim> SignalEnv<S> {
    /// Returns an environment; `scratch` is a folder for its route and tripinfo files.
    pub fn new(
        sim: S,
        world: World,
        signal_settings: SignalSettings,
        simulation_settings: SimulationSettings,
        scratch: PathBuf,
    ) -> Self {
        Self {
            sim,
            time_s: world.begin_s,
            world,
            signal_settings,
            simulation_settings,
            scratch,
            scene: Scene::default(),
            on_red: Vec::new(),
            signals: Vec::new(),
            specs: Vec::new(),
            cabinets: Vec::new(),
            rings: Vec::new(),
            retimed: Vec::new(),
            ring_greens: Vec::new(),
            pedestrians: Vec::new(),
            seed: 0,
            shown: Vec::new(),
            programs: Vec::new(),
            copies: None,
            at_begin: BTreeMap::new(),
            observer: Observer::default(),
            snapshot: Snapshot::default(),
            observations: Vec::new(),
            request: Vec::new(),
            nearest_m: Vec::new(),
            collects_movements: false,
            by_movement: None,
            along: None,
            told: None,
            metrics: EpisodeMetrics::default(),
            decisions: 0,
            simulator: Duration::ZERO,
        }
    }

    /// Starts an episode; [`Self::drive`] comes next.
    ///
    /// # Errors
    ///
    /// [`SimError`] when the world cannot be simulated or has no signal that can be controlled.
    pub fn reset(&mut self, seed: u64) -> Result<(), SimError> {
        if self.copies.is_none() {
            self.copies = Some(self.copy_files()?);
        }
        let mut args = self.arguments(seed);
        args.extend(self.copies.iter().flatten().cloned());
        if let Some(write) = &self.world.routes {
            let path = self.scratch.join("episode.rou.xml");
            write(seed, &path)?;
            args.extend(["--route-files".to_owned(), path.display().to_string()]);
        }
        let tripinfo = self.scratch.join("tripinfo.xml");
        let mut scene = self.begin(args, tripinfo)?;
        for signal in &mut scene.signals {
            if let Some(program) = self.at_begin.get(&signal.id) {
                signal.active_program.clone_from(program);
            }
        }
        if scene != self.scene {
            self.describe(scene)?;
        }
        self.observer = Observer::new(
            &self.scene,
            &self.signals,
            self.signal_settings.detection_m,
            f64::from(self.signal_settings.delta_time_s),
        );
        self.cabinets = vec![None; self.signals.len()];
        self.rings = vec![None; self.signals.len()];
        self.retimed = vec![Vec::new(); self.signals.len()];
        self.ring_greens = vec![None; self.signals.len()];
        self.seed = seed;
        self.pedestrians = self.draw_pedestrians();
        self.shown = vec![String::new(); self.signals.len()];
        self.programs = vec![None; self.signals.len()];
        self.time_s = self.world.begin_s;
        let by_movement = || ByMovement::new(&self.scene, self.world.side, &self.world.bays);
        self.by_movement = (self.collects_movements && self.world.ways.is_some()).then(by_movement);
        let along = || Along::new(&self.scene, (&self.signals, &self.specs), self.world.side);
        self.along = self.collects_movements.then(along).flatten();
        (self.metrics, self.decisions) = (EpisodeMetrics::default(), 0);
        self.told.iter_mut().for_each(|told| *told = vec![Vec::new(); self.signals.len()]);
        Ok(())
    }

    /// Returns what each signal was told to show in the episode that has just ended, as a program that shows it once.
    pub fn shown_programs(&self) -> Vec<SignalProgram> {
        let program = |(info, told): (&SignalInfo, &Vec<(f64, String)>)| {
            let ends = told.iter().skip(1).map(|(from_s, _)| *from_s).chain([self.time_s]);
            let phase = |((from_s, state), until_s): (&(f64, String), f64)| {
                program::ProgramPhase::fixed(state, until_s - from_s)
            };
            let phases = told.iter().zip(ends).map(phase).collect();
            let offset_s = told.first()?.0;
            let kind = program::ProgramKind::Static;
            Some(SignalProgram { offset_s, ..SignalProgram::new(&info.id, kind, phases) })
        };
        self.scene.signals.iter().zip(self.told.iter().flatten()).filter_map(program).collect()
    }

    /// Returns who wants to cross at each signal; on recall only for evaluation, as nobody then pushes a button.
    fn draw_pedestrians(&self) -> Vec<Option<Pedestrians>> {
        let pushes = self.signal_settings.pedestrian_calls_per_h;
        let (per_hour, span_s) = (pushes.unwrap_or(0.0), (self.world.begin_s, self.world.end_s));
        let of = |(info, signal): (&SignalInfo, &DerivedSignal)| {
            if signal.timing.crossings() == 0 || pushes.is_none() && !self.collects_movements {
                return None;
            }
            let of_edge =
                |edge: &str| self.world.pedestrians.get(edge).copied().unwrap_or(per_hour);
            let may_wait = |crossing: usize| {
                let serves = |green: &String| signal.timing.serves_crossing(green, crossing);
                !signal.timing.closed[crossing] && !signal.own_greens.iter().all(serves)
            };
            let edges = approach_edges(&self.scene, info);
            let edges = edges.iter().enumerate().map(|(i, (edge, _))| may_wait(i).then_some(*edge));
            let crossings: Vec<Option<(&str, f64)>> =
                edges.map(|edge| edge.map(|edge| (edge, of_edge(edge)))).collect();
            Some(Pedestrians::new(&crossings, &info.id, self.seed, span_s, pushes.is_none()))
        };
        self.scene.signals.iter().zip(&self.signals).map(of).collect()
    }

    /// Starts the simulator.
    fn begin(&mut self, args: Vec<String>, tripinfo: PathBuf) -> Result<Scene, SimError> {
        let config = self.world.config.clone();
        let trace_m = self.signal_settings.detection_m;
        let start = Instant::now();
        let scene = self.sim.start(&StartOptions { config, args, trace_m, tripinfo })?;
        self.simulator += start.elapsed();
        let mut scene = as_right_hand(scene, self.world.side);
        self.on_red = vec![OnRed::default(); scene.signals.len()];
        if self.signal_settings.turn_on_red {
            self.on_red = scene.signals.iter_mut().map(OnRed::take).collect();
        }
        Ok(scene)
    }

    /// Writes private copies of the scenario's files where they are needed. Where they have no programs that change by
    /// the clock, looks first which are active at the beginning with them.
    fn copy_files(&mut self) -> Result<Vec<String>, SimError> {
        let has_day_plan = |(_, sources): &(_, Sources)| sources.has_day_plan();
        if !self.world.day_plan && self.world.files.as_ref().is_some_and(has_day_plan) {
            let mut args = self.arguments(0);
            args.extend(self.world.copied(&self.scratch.join("by-the-clock"), true)?);
            let scene = self.begin(args, PathBuf::new())?;
            self.sim.close()?;
            let programs = scene.signals.into_iter().map(|s| (s.id, s.active_program));
            self.at_begin = programs.collect();
        }
        Ok(self.world.copied(&self.scratch.join("copies"), self.world.day_plan)?)
    }

    /// Returns what SUMO is started with in every episode.
    fn arguments(&self, seed: u64) -> Vec<String> {
        [
            ("--seed", seed.to_string()),
            // A scenario that asks for a seed from the clock would make the run unrepeatable.
            ("--random", "false".to_owned()),
            ("--begin", self.world.begin_s.to_string()),
            ("--end", self.world.end_s.to_string()),
            ("--step-length", (1.0 / f64::from(self.world.steps_per_second)).to_string()),
            ("--time-to-teleport", self.simulation_settings.time_to_teleport_s.to_string()),
            ("--xml-validation", "never".to_owned()),
        ]
        .into_iter()
        .flat_map(|(name, value)| [name.to_owned(), value])
        .collect()
    }

    fn describe(&mut self, scene: Scene) -> Result<(), SimError> {
        self.signals = scene
            .signals
            .iter()
            .map(|signal| derive(&scene, signal, &self.signal_settings))
            .collect::<Result<_, _>>()?;
        for (signal, info) in self.signals.iter_mut().zip(&scene.signals) {
            let DerivedSignal { spec, movement_ways, .. } = signal;
            share_turns(spec, movement_ways, (&scene, info), &self.world.turn_shares);
        }
        let onward: Vec<Vec<Onward>> =
            (0..self.signals.len()).map(|i| onward(&scene, &self.signals, i)).collect();
        for (signal, onward) in self.signals.iter_mut().zip(onward) {
            signal.spec.onward = onward;
        }
        self.specs = self.signals.iter().map(|s| s.spec.clone()).collect();
        self.observations = vec![Observation::default(); self.signals.len()];
        self.request = vec![None; self.signals.len()];
        self.scene = scene;
        Ok(())
    }

    #[cfg(test)]
    pub(super) fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    /// Returns the simulator.
    pub fn sim_mut(&mut self) -> &mut S {
        &mut self.sim
    }

    /// Returns what controllers may know of the signals; empty before the first reset.
    pub fn signals(&self) -> &[SignalSpec] {
        &self.specs
    }

    /// Returns the observation of every signal.
    pub fn observations(&self) -> &[Observation] {
        &self.observations
    }

    /// Returns how many decisions an episode has.
    pub fn decisions_per_episode(&self) -> u32 {
        let span_s = self.world.end_s - self.world.begin_s;
        (span_s / f64::from(self.signal_settings.delta_time_s)).ceil() as u32
    }

    /// Says what drives each signal for the rest of the episode, and takes the first observation,
    /// before any step; to be called once, right after a reset.
    ///
    /// # Errors
    ///
    /// [`SimError`] when SUMO rejects a program.
    pub fn drive(&mut self, drives: &[Drive]) -> Result<(), SimError> {
        for (i, (signal, drive)) in self.signals.iter().zip(drives).enumerate() {
            // Where one green is all there is for cars, nobody decides anything; whoever its program stops them
            // for keeps his time.
            let drive = if signal.has_one_green() { &Drive::OwnProgram } else { drive };
            let info = &self.scene.signals[i];
            let failed = |reason| SimError::Signal { signal: info.id.clone(), reason };
            let existing = match drive {
                Drive::Existing => Some(self.world.existing(info)?.clone()),
                Drive::Retimed(_, greens_s) => {
                    self.world.existing.as_ref().map(|plan| plan.retimed(greens_s))
                }
                _ => None,
            };
            if let Drive::Retimed(config, greens_s) = drive {
                let greens =
                    || DualRing::ring_greens(&self.scene, info, signal, existing.as_ref(), config);
                self.ring_greens[i] =
                    greens_s.is_empty().then(greens).transpose().map_err(failed)?;
                self.retimed[i].clone_from(greens_s);
            }
            let free = |config, greens_s: &[f64]| {
                Some(DualRing::new(&self.scene, info, signal, config, greens_s))
            };
            let mut recorded = None;
            let mut rings = match drive {
                Drive::DualRing(config) => free(config, &[]),
                Drive::Retimed(config, greens_s) if existing.is_none() => free(config, greens_s),
                Drive::CoordinatedRings(config, stages) => {
                    let told = (config, stages);
                    let rings = DualRing::coordinated(&self.scene, info, signal, told, self.time_s);
                    if rings.is_none() {
                        let cycle = cycle_of(stages, &signal.timing);
                        recorded = Some(Drive::Recorded(cycle, stages.offset_s.into()));
                    }
                    rings
                }
                _ => None,
            };
            let drive = recorded.as_ref().unwrap_or(drive);
            let offset_s = if let Drive::Recorded(_, offset_s) = drive { *offset_s } else { 0.0 };
            self.cabinets[i] = (*drive == Drive::Decisions)
                .then(|| Cabinet::new(signal, self.signal_settings.yellow_time_s));
            let installed = match (&self.cabinets[i], &existing) {
                (Some(cabinet), _) => Some(cabinet.table.program.clone()),
                (None, Some(plan)) if plan.control == Control::Pretimed => {
                    Some(fixed(fixed_cycle(plan, &self.scene, info).map_err(failed)?))
                }
                (None, Some(_)) => None,
                (None, None) => program(signal, drive)?,
            };
            let installed = installed.map(|program| self.on_red[i].program(program));
            match &installed {
                Some(installed) => {
                    self.sim.install(i, installed)?;
                    if let Some((phase, left_s)) = aligned(installed, offset_s, self.time_s) {
                        self.sim.enter(i, phase, left_s)?;
                    }
                }
                None => self.sim.select(i, &info.active_program)?,
            }
            if let Some(plan) = existing.filter(|_| installed.is_none()) {
                let own = DualRing::existing(&self.scene, info, signal, &plan).map_err(failed)?;
                rings = Some(own);
            }
            if let Some(cabinet) = &self.cabinets[i] {
                self.shown[i].clone_from(&cabinet.table.program.phases[0].state);
            }
            if let Some(rings) = rings {
                self.shown[i].clone_from(&rings.shown);
                self.sim.show(i, &self.on_red[i].shown(&rings.shown))?;
                self.rings[i] = Some(rings);
            } else if self.cabinets[i].is_none() {
                let (signal, own) = (info.id.clone(), installed.is_none());
                let of_network = || self.on_red[i].own(info, &info.active_program).cloned();
                let program = installed.or_else(of_network);
                self.programs[i] =
                    program.map(|program| Running { signal, own, offset_s, program });
            }
        }
        self.observe()
    }

    /// Returns what the signals run since [`Self::drive`], as records keep it: programs, unless a controller decides one of
    /// them, whose behaviour is then no program, and what those in two rings are told.
    pub fn programs(&self) -> Vec<SignalProgram> {
        let signals = || self.scene.signals.iter().zip(&self.signals);
        let names = |signal: &SignalInfo| link_names(&self.scene, signal, self.world.side);
        let sheet = |((signal, _), rings): ((&SignalInfo, _), &Option<DualRing>)| {
            Some(rings.as_ref()?.program(&signal.id, &names(signal)))
        };
        let sheets: Vec<SignalProgram> = signals().zip(&self.rings).filter_map(sheet).collect();
        let kept = |((signal, derived), running): ((_, &DerivedSignal), &Option<Running>)| {
            let names = if self.world.routes.is_none() { names(signal) } else { Vec::new() };
            let names = names.iter().map(|names| names.join(" ")).collect();
            Some(kept(&derived.timing, names, running.clone()?))
        };
        // Within a common cycle, signals without rings have a fixed cycle that belongs to it.
        let is_whole = self.programs.iter().all(Option::is_some)
            || sheets.iter().any(|sheet| sheet.cycle_s.is_some());
        let running = signals().zip(&self.programs).filter(|_| is_whole);
        let mut programs: Vec<SignalProgram> = running.filter_map(kept).chain(sheets).collect();
        for (spec, greens_s) in self.specs.iter().zip(&self.retimed) {
            let own = programs.iter_mut().filter(|program| program.signal == spec.id);
            own.for_each(|program| program.greens_s.clone_from(greens_s));
        }
        programs
    }

    /// Returns the phases of the signals that run in two rings, in words, by signal.
    pub fn dual_rings(&self) -> impl Iterator<Item = (&str, String)> {
        let rings = self.specs.iter().zip(&self.rings);
        rings.filter_map(|(spec, rings)| Some((spec.id.as_str(), rings.as_ref()?.describe())))
    }

    /// Asks for one green phase per signal for the next interval, and lets it go by: a signal that
    /// changes shows yellow and all-red first. Signals keep to their limits, see [`Cabinet`]; those with
    /// a program of their own ignore their entry. Returns whether the time span of the world is over; signal control has no
    /// terminal state.
    ///
    /// # Errors
    ///
    /// [`SimError`] when the simulation fails or a phase does not exist.
    pub fn step(&mut self, actions: &[GreenPhase]) -> Result<bool, SimError> {
        let mut left_s = self.signal_settings.delta_time_s;
        for ((cabinet, action), pedestrians) in
            self.cabinets.iter_mut().zip(actions).zip(&self.pedestrians)
        {
            if let Some(cabinet) = cabinet {
                cabinet.decide(*action, left_s, pedestrians.as_ref())?;
            }
        }
        while left_s > 0 {
            for (i, (request, cabinet)) in
                self.request.iter_mut().zip(&mut self.cabinets).enumerate()
            {
                *request = cabinet.as_mut().and_then(Cabinet::due);
                if let (Some(phase), Some(cabinet)) = (&request, cabinet) {
                    self.shown[i].clone_from(&cabinet.table.program.phases[*phase as usize].state);
                }
            }
            if self.request.iter().any(Option::is_some) {
                self.sim.set_phases(&self.request)?;
            }
            let next = self.cabinets.iter().flatten().filter_map(Cabinet::next_s).min();
            let mut seconds = next.map_or(left_s, |next| next.min(left_s));
            if self.rings.iter().any(Option::is_some)
                || self.pedestrians.iter().any(Option::is_some)
                || self.along.is_some()
                || self.told.is_some()
                || (self.by_movement.is_some() && self.programs.iter().any(Option::is_some))
            {
                seconds = seconds.min(1);
            }
            // Pedestrians come to the signals that a controller decides, and those go who see WALK.
            for (cabinet, own) in self.cabinets.iter_mut().zip(&mut self.pedestrians) {
                if let (Some(cabinet), Some(own)) = (cabinet, own) {
                    cabinet.second(self.time_s, own);
                }
            }
            self.run(seconds)?;
            self.let_pedestrians_follow_programs(seconds)?;
            self.note(seconds)?;
            if let Some(along) = &mut self.along {
                self.sim.observe(&mut self.snapshot)?;
                along.second(&self.snapshot, self.time_s);
            }
            self.advance_rings(seconds)?;
            self.cabinets.iter_mut().flatten().for_each(|cabinet| cabinet.elapse(seconds));
            left_s -= seconds;
        }
        self.observe()?;
        self.decisions += 1;
        if let Some(by_movement) = &mut self.by_movement {
            by_movement.decide(&self.observer.lanes);
        }
        let queue = f64::from(self.observer.halting);
        self.metrics.queue_veh += queue;
        self.metrics.max_queue_veh = self.metrics.max_queue_veh.max(queue);
        Ok(self.time_s >= self.world.end_s)
    }

    /// Lets pedestrians come to the signals that run a program, and those go who saw WALK in the second that has just gone
    /// by: only now SUMO says what its programs showed in it.
    fn let_pedestrians_follow_programs(&mut self, seconds: u32) -> Result<(), SimError> {
        let has_both = |(program, pedestrians): (&Option<Running>, &Option<Pedestrians>)| {
            program.is_some() && pedestrians.is_some()
        };
        if seconds == 0 || !self.programs.iter().zip(&self.pedestrians).any(has_both) {
            return Ok(());
        }
        self.sim.observe(&mut self.snapshot)?;
        let at_s = self.time_s - f64::from(seconds);
        for (i, pedestrians) in self.pedestrians.iter_mut().enumerate() {
            let (Some(pedestrians), Some(running)) = (pedestrians, &self.programs[i]) else {
                continue;
            };
            pedestrians.arrive(at_s);
            let phase = self.snapshot.phases[i] as usize;
            let timing = &self.signals[i].timing;
            pedestrians.second_of_program(phase, &running.program, timing, at_s);
        }
        Ok(())
    }

    /// Lets the dual rings see what is on their detectors, and shows what they make of it.
    fn advance_rings(&mut self, seconds: u32) -> Result<(), SimError> {
        if seconds == 0 || self.rings.iter().all(Option::is_none) {
            return Ok(());
        }
        self.sim.observe(&mut self.snapshot)?;
        self.nearest_m.clear();
        self.nearest_m.resize(self.scene.lanes.len(), f64::INFINITY);
        for vehicle in &self.snapshot.vehicles {
            let nearest_m = &mut self.nearest_m[vehicle.lane as usize];
            *nearest_m = nearest_m.min(vehicle.distance_m);
        }
        let time_s = self.time_s;
        for (i, rings) in self.rings.iter_mut().enumerate() {
            let pedestrians = self.pedestrians[i].as_mut().map(|p| (time_s, p));
            if let Some(state) = rings.as_mut().and_then(|r| r.second(&self.nearest_m, pedestrians))
            {
                self.sim.show(i, &self.on_red[i].shown(state))?;
                state.clone_into(&mut self.shown[i]);
            }
        }
        Ok(())
    }

    /// Notes what was shown for some seconds, where results by movement are asked for, and what SUMO was told, where
    /// somebody asks for it.
    fn note(&mut self, seconds: u32) -> Result<(), SimError> {
        if self.by_movement.is_none() && self.told.is_none() {
            return Ok(());
        }
        if self.programs.iter().any(Option::is_some) {
            self.sim.observe(&mut self.snapshot)?;
        }
        for (i, spec) in self.specs.iter().enumerate() {
            let state = lights(&self.programs, &self.shown, &self.snapshot.phases, i);
            let Some(state) = state else { continue };
            if let Some(by_movement) = &mut self.by_movement {
                by_movement.show(&spec.id, state, seconds);
            }
            let Some(told) = self.told.as_mut().filter(|_| seconds > 0) else { continue };
            // A program was told to SUMO as it is here.
            let is_program = self.programs[i].is_some();
            let state = if is_program { state.clone() } else { self.on_red[i].shown(state) };
            if told[i].last().is_none_or(|last| last.1 != state) {
                told[i].push((self.time_s - f64::from(seconds), state));
            }
        }
        Ok(())
    }

    fn run(&mut self, seconds: u32) -> Result<(), SimError> {
        // An episode may end within a second, but not within a step, whatever rounding says.
        let left_s = (self.world.end_s - self.time_s).max(0.0);
        let left = (left_s * f64::from(self.world.steps_per_second) - 1e-6).ceil() as u32;
        let steps = (seconds * self.world.steps_per_second).min(left);
        let start = Instant::now();
        self.metrics.counts += self.sim.step(steps)?;
        self.simulator += start.elapsed();
        self.time_s += f64::from(seconds.min(left_s.ceil() as u32));
        Ok(())
    }

    fn observe(&mut self) -> Result<(), SimError> {
        self.sim.observe(&mut self.snapshot)?;
        self.observer.update(&self.snapshot);
        let never_moves = self.simulation_settings.time_to_teleport_s < 0.0;
        if self.metrics.standing.is_none() && never_moves && self.world.files.is_some() {
            let state = |i: usize| lights(&self.programs, &self.shown, &self.snapshot.phases, i);
            self.metrics.standing = standing(&self.scene, &self.snapshot, self.time_s, state);
        }
        for (i, signal) in self.signals.iter().enumerate() {
            let phase = match &self.cabinets[i] {
                Some(cabinet) => cabinet.phase.0,
                None if signal.has_one_green() => 0,
                None => self.snapshot.phases[i] as usize,
            };
            self.observer.write(i, signal, phase, &mut self.observations[i]);
        }
        Ok(())
    }

    /// Ends the episode and returns what it is judged by.
    ///
    /// # Errors
    ///
    /// [`SimError`] when SUMO fails to finish or its output is not complete.
    pub fn finish(&mut self) -> Result<EpisodeMetrics, SimError> {
        let start = Instant::now();
        self.sim.close()?;
        self.simulator += start.elapsed();
        let mut people = PedestrianTotals::default();
        for (info, of_signal) in self.scene.signals.iter().zip(&mut self.pedestrians) {
            let own = of_signal.iter_mut().flat_map(|own| own.finish(self.time_s));
            for ((edge, _), own) in approach_edges(&self.scene, info).into_iter().zip(own) {
                people += own;
                if let Some(by_movement) = &mut self.by_movement {
                    by_movement.cross(&info.id, edge, own);
                }
            }
        }
        let pushes = self.signal_settings.pedestrian_calls_per_h.is_some()
            && self.pedestrians.iter().any(Option::is_some);
        let path = self.scratch.join("tripinfo.xml");
        let (totals, trips) = tripinfo::read(&path)?;
        let movements = match (&mut self.by_movement, &self.world.ways) {
            (Some(by_movement), Some(ways)) => by_movement.finish(&trips, &ways(self.seed)),
            _ => Vec::new(),
        };
        let hours = (self.time_s - self.world.begin_s) / SECONDS_PER_HOUR;
        let flow = |lane: &usize| f64::from(self.observer.counts[*lane]) / hours;
        let flows = self.signals.iter().map(|s| s.lanes.iter().map(flow).collect());
        Ok(EpisodeMetrics {
            trips: totals,
            movements,
            streets: self.along.take().map(Along::finish).unwrap_or_default(),
            pedestrians: pushes.then_some(people.count),
            people,
            queue_veh: self.metrics.queue_veh / f64::from(self.decisions.max(1)),
            rings: self.ring_greens.clone(),
            lane_flow_vph: flows.collect(),
            ..std::mem::take(&mut self.metrics)
        })
    }
}

/// Returns a program as records keep it.
/// * `links` — per link the names of its movements.
fn kept(timing: &Timing, links: Vec<String>, running: Running) -> SignalProgram {
    let (kind, max_gap_s) = (running.program.kind, running.program.max_gap_s);
    let bounds = |p: &ProgramPhase| {
        let varies = kind != program::ProgramKind::Static
            && (p.min_s, p.max_s) != (p.duration_s, p.duration_s);
        // JSON has no infinities.
        [p.min_s, p.max_s].map(|s| Some(s).filter(|s| varies && s.is_finite()))
    };
    let shortest_s = |p: &ProgramPhase| bounds(p)[0].unwrap_or(p.duration_s);
    let phases = &running.program.phases;
    let shown: Vec<(&str, f64)> =
        phases.iter().map(|p| (p.state.as_str(), shortest_s(p))).collect();
    let walks = timing.longest_walks(&shown);
    let phase = |(p, people): (ProgramPhase, Option<[u32; 2]>)| {
        let [min_s, max_s] = bounds(&p);
        program::ProgramPhase {
            state: p.state,
            duration_s: p.duration_s,
            min_s,
            max_s,
            walk_s: people.map(|[walk_s, _]| walk_s),
            clearance_s: people.map(|[_, clearance_s]| clearance_s),
            exact_s: None,
        }
    };
    let phases = running.program.phases.into_iter().zip(walks).map(phase).collect();
    let Running { signal, own, offset_s, .. } = running;
    let mut kept = SignalProgram {
        own,
        offset_s,
        max_gap_s,
        links,
        ..SignalProgram::new(signal, kind, phases)
    };
    let (starts, greens) = (starts(&kept), greens(&kept));
    for (k, green) in greens.iter().enumerate() {
        let next = &greens[(k + 1) % greens.len()].state;
        let Some(exact_s) = timing.exact_change_s(&green.state, next) else { continue };
        let ours = Change::holding(exact_s);
        // A program of the network may have other changes.
        if f64::from(ours.total_s()) == green.yellow_s + green.all_red_s {
            kept.phases[starts[k]].exact_s = ours.unless_exact(exact_s);
        }
    }
    kept
}

/// Returns what the `i`-th signal shows: what it was made to show, or the state of the phase in which its program is; `None` for a
/// phase that the program does not have.
fn lights<'a>(
    programs: &'a [Option<Running>],
    shown: &'a [String],
    phases: &[u32],
    i: usize,
) -> Option<&'a String> {
    let Some(running) = &programs[i] else { return Some(&shown[i]) };
    running.program.phases.get(phases[i] as usize).map(|phase| &phase.state)
}

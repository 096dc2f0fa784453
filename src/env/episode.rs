//! One episode after the other: reset, step, finish.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use crate::control::{Controller, Drive, EpisodeOutcome, GreenPhase, Observation, SignalSpec};
use crate::error::SimError;
use crate::family::scenario::{SignalSettings, SimulationSettings};
use crate::sim::tripinfo::{self, TripTotals};
use crate::sim::{Scene, Sim, Snapshot, StartOptions, StepCounts};
use crate::units::SECONDS_PER_HOUR;

use super::derive::{DerivedSignal, derive};
use super::observe::Observer;
use super::signal::{DecisionProgram, program};
use super::world::World;

/// State of the decision process after a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// The process has reached a terminal state; signal control has none.
    pub terminated: bool,
    /// The time span of the world is over.
    pub truncated: bool,
}

/// What an episode is judged by.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EpisodeMetrics {
    /// Sums over vehicles.
    pub trips: TripTotals,
    /// Events during the episode.
    pub counts: StepCounts,
    /// Mean over decisions of the halting vehicles on all incoming lanes.
    pub queue_veh: f64,
    /// Largest number of halting vehicles at a decision.
    pub max_queue_veh: f64,
    /// Vehicles seen per hour, per signal and lane of the signal.
    pub lane_flow_vph: Vec<Vec<f64>>,
}

impl EpisodeMetrics {
    /// Mean delay per vehicle, seconds; 0 without vehicles.
    ///
    /// Source: RESCO, utils/readXML.py: time loss plus departure delay over all vehicles.
    pub fn delay_s(&self) -> f64 {
        self.per_vehicle(self.trips.delay_s)
    }

    /// Mean waiting time per vehicle, seconds; 0 without vehicles.
    pub fn waiting_s(&self) -> f64 {
        self.per_vehicle(self.trips.waiting_s)
    }

    fn per_vehicle(&self, sum: f64) -> f64 {
        if self.trips.vehicles == 0 { 0.0 } else { sum / f64::from(self.trips.vehicles) }
    }
}

/// The signals of a world as a decision process.
#[derive(Debug)]
pub struct SignalEnv<S> {
    sim: S,
    world: World,
    signal_settings: SignalSettings,
    simulation_settings: SimulationSettings,
    scratch: PathBuf,
    scene: Scene,
    signals: Vec<DerivedSignal>,
    specs: Vec<SignalSpec>,
    tables: Vec<Option<DecisionProgram>>,
    current: Vec<GreenPhase>,
    observer: Observer,
    snapshot: Snapshot,
    observations: Vec<Observation>,
    request: Vec<Option<u32>>,
    time_s: f64,
    counts: StepCounts,
    queue_sum: f64,
    queue_max: f64,
    decisions: u32,
    simulator: Duration,
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
            signals: Vec::new(),
            specs: Vec::new(),
            tables: Vec::new(),
            current: Vec::new(),
            observer: Observer::default(),
            snapshot: Snapshot::default(),
            observations: Vec::new(),
            request: Vec::new(),
            counts: StepCounts::default(),
            queue_sum: 0.0,
            queue_max: 0.0,
            decisions: 0,
            simulator: Duration::ZERO,
        }
    }

    /// Starts an episode. The first observation is taken before any step.
    ///
    /// # Errors
    ///
    /// [`SimError`] when the world cannot be simulated or has no signal that can be controlled.
    pub fn reset(&mut self, seed: u64) -> Result<(), SimError> {
        let mut args: Vec<String> = [
            ("--seed", seed.to_string()),
            ("--begin", self.world.begin_s.to_string()),
            ("--end", self.world.end_s.to_string()),
            ("--step-length", "1".to_owned()),
            ("--time-to-teleport", self.simulation_settings.time_to_teleport_s.to_string()),
            ("--xml-validation", "never".to_owned()),
        ]
        .into_iter()
        .flat_map(|(name, value)| [name.to_owned(), value])
        .collect();
        if let Some(write) = &self.world.routes {
            let path = self.scratch.join("episode.rou.xml");
            write(seed, &path)?;
            args.extend(["--route-files".to_owned(), path.display().to_string()]);
        }
        let config = self.world.config.clone();
        let tripinfo = self.scratch.join("tripinfo.xml");
        let start = Instant::now();
        let scene = self.sim.start(&StartOptions { config, args, tripinfo })?;
        self.simulator += start.elapsed();
        if scene != self.scene {
            self.describe(scene)?;
        }
        self.observer = Observer::new(
            &self.scene,
            self.signal_settings.detection_m,
            f64::from(self.signal_settings.delta_time_s),
        );
        self.tables = vec![None; self.signals.len()];
        self.current = vec![GreenPhase(0); self.signals.len()];
        self.time_s = self.world.begin_s;
        self.counts = StepCounts::default();
        (self.queue_sum, self.queue_max, self.decisions) = (0.0, 0.0, 0);
        self.observe()
    }

    fn describe(&mut self, scene: Scene) -> Result<(), SimError> {
        let yellow_s = f64::from(self.signal_settings.yellow_time_s);
        self.signals = scene
            .signals
            .iter()
            .map(|signal| derive(&scene, signal, yellow_s))
            .collect::<Result<_, _>>()?;
        self.specs = self.signals.iter().map(|s| s.spec.clone()).collect();
        self.observations = vec![Observation::default(); self.signals.len()];
        self.request = vec![None; self.signals.len()];
        self.scene = scene;
        Ok(())
    }

    /// Returns what controllers may know of the signals; empty before the first reset.
    pub fn signals(&self) -> &[SignalSpec] {
        &self.specs
    }

    /// Returns the observation of every signal.
    pub fn observations(&self) -> &[Observation] {
        &self.observations
    }

    /// Returns the wall-clock time spent within the simulator so far.
    pub fn simulator_time(&self) -> Duration {
        self.simulator
    }

    /// Says what drives each signal for the rest of the episode; to be called right after a reset.
    ///
    /// # Errors
    ///
    /// [`SimError`] when SUMO rejects a program.
    pub fn drive(&mut self, drives: &[Drive]) -> Result<(), SimError> {
        for (i, (signal, drive)) in self.signals.iter().zip(drives).enumerate() {
            match program(signal, drive)? {
                Some(installed) => self.sim.install(i, &installed)?,
                None => self.sim.select(i, &self.scene.signals[i].active_program)?,
            }
            self.tables[i] =
                matches!(drive, Drive::Decisions).then(|| DecisionProgram::new(signal));
        }
        self.observe()
    }

    /// Applies one green phase per signal for the next interval: yellow where the phase changes,
    /// then green. Signals with a program of their own ignore their entry.
    ///
    /// # Errors
    ///
    /// [`SimError`] when the simulation fails or a phase does not exist.
    pub fn step(&mut self, actions: &[GreenPhase]) -> Result<Step, SimError> {
        let yellow_s = self.signal_settings.yellow_time_s;
        let delta_s = self.signal_settings.delta_time_s;
        if self.tables.iter().any(Option::is_some) {
            for (i, (table, action)) in self.tables.iter().zip(actions).enumerate() {
                self.request[i] = table.as_ref().and_then(|t| t.yellow(self.current[i], *action));
            }
            self.set_phases()?;
            self.run(yellow_s)?;
            for (i, (table, action)) in self.tables.iter().zip(actions).enumerate() {
                self.request[i] = table.as_ref().map(|_| action.0 as u32);
            }
            self.set_phases()?;
            self.current.copy_from_slice(actions);
            self.run(delta_s - yellow_s)?;
        } else {
            self.run(delta_s)?;
        }
        self.observe()?;
        self.decisions += 1;
        let queue = f64::from(self.observer.halting());
        self.queue_sum += queue;
        self.queue_max = self.queue_max.max(queue);
        Ok(Step { terminated: false, truncated: self.time_s >= self.world.end_s })
    }

    fn set_phases(&mut self) -> Result<(), SimError> {
        if self.request.iter().any(Option::is_some) {
            self.sim.set_phases(&self.request)?;
        }
        Ok(())
    }

    fn run(&mut self, seconds: u32) -> Result<(), SimError> {
        let left = (self.world.end_s - self.time_s).max(0.0).ceil() as u32;
        let steps = seconds.min(left);
        let start = Instant::now();
        self.counts += self.sim.step(steps)?;
        self.simulator += start.elapsed();
        self.time_s += f64::from(steps);
        Ok(())
    }

    fn observe(&mut self) -> Result<(), SimError> {
        self.sim.observe(&mut self.snapshot)?;
        self.observer.update(&self.snapshot);
        for (i, signal) in self.signals.iter().enumerate() {
            let phase = self.snapshot.phases[i] as usize;
            self.observer.write(signal, phase, &mut self.observations[i]);
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
        let trips = tripinfo::read(&self.scratch.join("tripinfo.xml"))?;
        let hours = (self.time_s - self.world.begin_s) / SECONDS_PER_HOUR;
        let flow = |lane: &usize| f64::from(self.observer.counts()[*lane]) / hours;
        Ok(EpisodeMetrics {
            trips,
            counts: self.counts,
            queue_veh: self.queue_sum / f64::from(self.decisions.max(1)),
            max_queue_veh: self.queue_max,
            lane_flow_vph: self
                .signals
                .iter()
                .map(|s| s.lanes.iter().map(flow).collect())
                .collect(),
        })
    }
}

/// Why an episode with a controller failed.
#[derive(Debug, thiserror::Error)]
pub enum EpisodeError {
    /// The simulation failed.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// The controller cannot control a signal.
    #[error(transparent)]
    Control(#[from] crate::control::ControlError),
}

/// Runs one episode of a controller from reset to the end.
///
/// # Errors
///
/// [`EpisodeError`] when the simulation or the controller fails.
pub fn run_episode<S: Sim>(
    env: &mut SignalEnv<S>,
    controller: &mut dyn Controller,
    seed: u64,
) -> Result<EpisodeMetrics, EpisodeError> {
    env.reset(seed)?;
    let drives = controller.begin(env.signals())?;
    env.drive(&drives)?;
    let decides = drives.contains(&Drive::Decisions);
    let mut phases = vec![GreenPhase(0); drives.len()];
    loop {
        if decides {
            controller.act(env.observations(), &mut phases);
        }
        if env.step(&phases)?.truncated {
            break;
        }
    }
    Ok(env.finish()?)
}

impl EpisodeMetrics {
    /// Returns what training may use of the episode.
    pub fn outcome(&self) -> EpisodeOutcome {
        EpisodeOutcome { delay_s: self.delay_s(), lane_flow_vph: self.lane_flow_vph.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::ControlError;
    use crate::sim::mock::MockSim;
    use crate::sim::{Direction, Lane, Link, Program, ProgramKind, ProgramPhase, SignalInfo};

    /// Two crossing one-lane roads; `arrivals` are `(second, lane)`.
    fn env(arrivals: Vec<(f64, u32)>, scratch: &std::path::Path) -> SignalEnv<MockSim> {
        let lane = |id: &str, heading_deg| Lane {
            id: id.into(),
            length_m: 100.0,
            speed_mps: 14.0,
            heading_deg,
        };
        let link = |from_lane| {
            vec![Link {
                from_lane,
                to_lane: "x_0".into(),
                downstream: None,
                direction: Direction::Straight,
            }]
        };
        let phases = vec![
            ProgramPhase::fixed("Gr", 20.0),
            ProgramPhase::fixed("yr", 3.0),
            ProgramPhase::fixed("rG", 20.0),
            ProgramPhase::fixed("ry", 3.0),
        ];
        let scene = Scene {
            lanes: vec![lane("s_0", 180.0), lane("w_0", 270.0)],
            signals: vec![SignalInfo {
                id: "c".into(),
                links: vec![link(0), link(1)],
                programs: vec![Program { id: "0".into(), kind: ProgramKind::Static, phases }],
                active_program: "0".into(),
            }],
        };
        let world = World { config: "m".into(), begin_s: 0.0, end_s: 60.0, routes: None };
        SignalEnv::new(
            MockSim::new(scene, arrivals),
            world,
            SignalSettings::default(),
            SimulationSettings::default(),
            scratch.to_path_buf(),
        )
    }

    /// Plays a fixed list of phases, the last one for ever.
    struct Script(Vec<usize>, usize);

    impl Controller for Script {
        fn name(&self) -> &'static str {
            "script"
        }
        fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
            Ok(vec![Drive::Decisions; signals.len()])
        }
        fn act(&mut self, _: &[Observation], phases: &mut [GreenPhase]) {
            phases[0] = GreenPhase(self.0[self.1.min(self.0.len() - 1)]);
            self.1 += 1;
        }
    }

    fn letters(env: &SignalEnv<MockSim>) -> String {
        env.sim
            .history
            .iter()
            .map(|s| if s[0].contains('y') { 'y' } else { s[0].chars().next().unwrap() })
            .collect()
    }

    #[test]
    fn a_change_costs_three_seconds_of_yellow_and_staying_costs_none() {
        let dir = tempfile::tempdir().unwrap();
        let mut env = env(vec![], dir.path());
        run_episode(&mut env, &mut Script(vec![0, 1, 1, 0], 0), 1).unwrap();
        assert_eq!(letters(&env), "GGGGGGGGGGyyyrrrrrrrrrrrrrrrrryyyGGGGGGGGGGGGGGGGGGGGGGGGGGG");
    }

    #[test]
    fn the_own_program_runs_untouched() {
        let dir = tempfile::tempdir().unwrap();
        let mut env = env(vec![], dir.path());
        run_episode(&mut env, &mut crate::control::program::Program, 1).unwrap();
        assert!(letters(&env).starts_with("GGGGGGGGGGGGGGGGGGGGyyyrrrrrrrrrrrrrrrrrrrryyyGG"));
    }

    #[test]
    fn delay_counts_vehicles_that_never_leave() {
        let dir = tempfile::tempdir().unwrap();
        let mut env = env(vec![(10.0, 1), (20.0, 1)], dir.path());
        let metrics = run_episode(&mut env, &mut Script(vec![0], 0), 1).unwrap();
        assert_eq!(metrics.delay_s(), 45.0);
        assert_eq!((metrics.trips.arrived, metrics.trips.running), (0, 2));
        assert_eq!(metrics.max_queue_veh, 2.0);
        assert_eq!(metrics.lane_flow_vph, [[0.0, 120.0]]);
    }

    #[test]
    fn an_episode_is_truncated_at_the_end_and_never_terminated() {
        let dir = tempfile::tempdir().unwrap();
        let mut env = env(vec![], dir.path());
        env.reset(1).unwrap();
        env.drive(&[Drive::Decisions]).unwrap();
        let steps: Vec<_> = (0..6).map(|_| env.step(&[GreenPhase(0)]).unwrap()).collect();
        assert!(steps.iter().all(|s| !s.terminated));
        assert_eq!(
            steps.iter().map(|s| s.truncated).collect::<Vec<_>>(),
            [false, false, false, false, false, true]
        );
    }

    #[test]
    fn max_pressure_serves_the_road_with_the_queue() {
        let dir = tempfile::tempdir().unwrap();
        let mut env = env(vec![(1.0, 1), (2.0, 1), (3.0, 1)], dir.path());
        let mut controller = crate::control::max_pressure::MaxPressure::default();
        let metrics = run_episode(&mut env, &mut controller, 1).unwrap();
        assert_eq!(metrics.trips.arrived, 3);
        assert!(letters(&env).starts_with("GGGGGGGGGGyyyrrrrrrr"));
    }

    #[test]
    fn a_failing_simulation_is_an_error_and_the_next_episode_runs() {
        let dir = tempfile::tempdir().unwrap();
        let mut env = env(vec![], dir.path());
        env.sim.fails_at_s = Some(25.0);
        let e = run_episode(&mut env, &mut Script(vec![0], 0), 1).unwrap_err();
        assert_eq!(e.to_string(), "sumo failed in `step`: the mock fails");
        env.sim.fails_at_s = None;
        run_episode(&mut env, &mut Script(vec![0], 0), 1).unwrap();
    }
}

//! A simulator without SUMO: queues that grow by a schedule and drain when their light is green.
//!
//! Vehicles appear at the stop line of a lane at scheduled times and leave one per second while
//! the lane's link is green. It obeys the trait to the letter, so that everything above the
//! simulator is tested without SUMO.

use std::fs;

use super::{
    Link, Program, ProgramKind, ProgramPhase, Scene, SignalInfo, Sim, SimError, Snapshot,
    StartOptions, StepCounts, VehicleState,
};
use basics::files::FileError;

/// A vehicle of the mock.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Vehicle {
    lane: u32,
    depart_s: f64,
    left_s: Option<f64>,
}

/// The mock simulator.
#[derive(Debug, Clone, Default)]
pub struct MockSim {
    scene: Scene,
    arrivals: Vec<(f64, u32)>,
    vehicles: Vec<Vehicle>,
    programs: Vec<Program>,
    phases: Vec<usize>,
    phase_left_s: Vec<f64>,
    time_s: f64,
    running: Option<StartOptions>,
    /// Phases of every signal, second by second, for tests.
    pub history: Vec<Vec<String>>,
    /// Time at which `step` fails, for tests of failure.
    pub fails_at_s: Option<f64>,
}

impl MockSim {
    /// Returns a mock of a scene with arrivals `(time in seconds, lane)`.
    pub fn new(scene: Scene, arrivals: Vec<(f64, u32)>) -> Self {
        Self { scene, arrivals, ..Self::default() }
    }

    fn state(&self, signal: usize) -> &str {
        &self.programs[signal].phases[self.phases[signal]].state
    }

    fn is_green(&self, lane: u32) -> bool {
        self.scene.signals.iter().enumerate().any(|(s, signal)| {
            signal.links.iter().zip(self.state(s).chars()).any(|(links, letter)| {
                matches!(letter, 'G' | 'g') && links.iter().any(|l| l.from_lane as u32 == lane)
            })
        })
    }

    /// Returns the first link of a lane at its signal.
    fn link(&self, lane: u32) -> Option<u32> {
        let starts = |links: &Vec<Link>| links.iter().any(|l| l.from_lane as u32 == lane);
        self.scene.signals.iter().find_map(|s| s.links.iter().position(starts)).map(|l| l as u32)
    }

    fn ensure_running(&self) -> Result<(), SimError> {
        if self.running.is_some() { Ok(()) } else { Err(SimError::NotRunning) }
    }

    fn begin_phase(&mut self, signal: usize, phase: usize) {
        self.phases[signal] = phase;
        self.phase_left_s[signal] = self.programs[signal].phases[phase].duration_s;
    }

    fn one_second(&mut self) {
        for s in 0..self.programs.len() {
            if self.phase_left_s[s] <= 0.0 {
                let next = (self.phases[s] + 1) % self.programs[s].phases.len();
                self.begin_phase(s, next);
            }
            self.phase_left_s[s] -= 1.0;
        }
        self.history.push((0..self.programs.len()).map(|s| self.state(s).to_owned()).collect());
        for lane in 0..self.scene.lanes.len() as u32 {
            if !self.is_green(lane) {
                continue;
            }
            let waiting = |v: &&mut Vehicle| v.lane == lane && v.left_s.is_none();
            if let Some(first) = self.vehicles.iter_mut().find(waiting) {
                first.left_s = Some(self.time_s);
            }
        }
        self.time_s += 1.0;
        for &(time, lane) in &self.arrivals {
            if time <= self.time_s && time > self.time_s - 1.0 {
                self.vehicles.push(Vehicle { lane, depart_s: time, left_s: None });
            }
        }
    }
}

impl Sim for MockSim {
    fn start(&mut self, options: &StartOptions) -> Result<Scene, SimError> {
        self.close()?;
        self.time_s = 0.0;
        self.vehicles.clear();
        self.history.clear();
        let active = |s: &SignalInfo| {
            let active = s.programs.iter().find(|p| p.id == s.active_program);
            active.expect("a mock's active program exists").clone()
        };
        self.programs = self.scene.signals.iter().map(active).collect();
        self.phases = vec![0; self.programs.len()];
        self.phase_left_s = self.programs.iter().map(|p| p.phases[0].duration_s).collect();
        self.running = Some(options.clone());
        Ok(self.scene.clone())
    }

    fn step(&mut self, steps: u32) -> Result<StepCounts, SimError> {
        self.ensure_running()?;
        for _ in 0..steps {
            if self.fails_at_s.is_some_and(|t| self.time_s >= t) {
                return Err(SimError::Fatal { call: "step", message: "the mock fails".into() });
            }
            self.one_second();
        }
        Ok(StepCounts::default())
    }

    fn install(&mut self, signal: usize, program: &Program) -> Result<(), SimError> {
        self.ensure_running()?;
        self.programs[signal] = program.clone();
        self.begin_phase(signal, 0);
        Ok(())
    }

    fn select(&mut self, signal: usize, program_id: &str) -> Result<(), SimError> {
        self.ensure_running()?;
        let programs = &self.scene.signals[signal].programs;
        let program = programs.iter().find(|p| p.id == program_id).expect("it has it").clone();
        self.install(signal, &program)
    }

    fn enter(&mut self, signal: usize, phase: u32, left_s: f64) -> Result<(), SimError> {
        self.ensure_running()?;
        self.begin_phase(signal, phase as usize);
        self.phase_left_s[signal] = left_s;
        Ok(())
    }

    fn show(&mut self, signal: usize, state: &str) -> Result<(), SimError> {
        let phases = vec![ProgramPhase::fixed(state, f64::INFINITY)];
        self.install(signal, &Program::new("shown", ProgramKind::Static, phases))
    }

    fn set_phases(&mut self, phases: &[Option<u32>]) -> Result<(), SimError> {
        self.ensure_running()?;
        for (signal, phase) in phases.iter().enumerate() {
            if let Some(phase) = phase {
                self.begin_phase(signal, *phase as usize);
            }
        }
        Ok(())
    }

    fn observe(&mut self, snapshot: &mut Snapshot) -> Result<(), SimError> {
        self.ensure_running()?;
        snapshot.vehicles.clear();
        for lane in 0..self.scene.lanes.len() as u32 {
            for (number, vehicle) in self.vehicles.iter().enumerate() {
                if vehicle.lane == lane && vehicle.left_s.is_none() {
                    snapshot.vehicles.push(VehicleState {
                        lane,
                        link: self.link(lane),
                        way: 0,
                        vehicle: number as u32,
                        position_m: self.scene.lanes[lane as usize].length_m,
                        speed_mps: 0.0,
                        waiting_s: self.time_s - vehicle.depart_s,
                        distance_m: 0.0,
                    });
                }
            }
        }
        snapshot.phases.clear();
        snapshot.phases.extend(self.phases.iter().map(|p| *p as u32));
        Ok(())
    }

    fn close(&mut self) -> Result<(), SimError> {
        let Some(options) = self.running.take() else { return Ok(()) };
        if options.tripinfo.as_os_str().is_empty() {
            return Ok(());
        }
        let rows: String = self
            .vehicles
            .iter()
            .map(|v| {
                let wait = v.left_s.unwrap_or(self.time_s) - v.depart_s;
                format!(
                    "<tripinfo depart=\"{}\" arrival=\"{}\" departDelay=\"0\" \
                     waitingTime=\"{wait}\" timeLoss=\"{wait}\"/>\n",
                    v.depart_s,
                    v.left_s.unwrap_or(-1.0)
                )
            })
            .collect();
        fs::write(&options.tripinfo, format!("<tripinfos>\n{rows}</tripinfos>\n"))
            .map_err(FileError::at("write", &options.tripinfo))?;
        Ok(())
    }
}

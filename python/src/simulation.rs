//! A simulation that Python steps: one place, its signals, episode after episode.
//!
//! There is one at a time in a process: SUMO's library keeps its state in statics. What a place is like is kept, so
//! that a second object of the same place has its spaces while the first one simulates.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use tempfile::TempDir;
use tsc_family::cli::point::unknown_point;
use tsc_family::settings::overrides::Override;
use tsc_family::traffic::city::default_folder;
use tsc_family::traffic::control::{Drive, GreenPhase, Observation, SignalSpec};
use tsc_family::traffic::env::{SignalEnv, World};
use tsc_family::traffic::environment::{environment, generated_world, hash_scenario};
use tsc_family::traffic::family::load::{LoadedScenario, load_with};
use tsc_family::traffic::problem::networks;
use tsc_family::traffic::sim::intake::Intake;
use tsc_family::traffic::sim::libsumo::SumoSim;
use tsc_family::traffic::sim::obstacle::Given;
use tsc_family::traffic::sim::{Sim, SimError};
use tsc_family::traffic::trial::named;

use crate::error::{Error, raised};
use crate::observation::{Frame, PyObservation};
use crate::signals::{PySignal, Sizes, signals};
use crate::view;

/// What places are like that were simulated in this process.
static KNOWN: Mutex<Option<HashMap<String, Vec<SignalSpec>>>> = Mutex::new(None);

/// The seed of the look at a place that only says what it is like.
const LOOK_SEED: u64 = 0;

/// A place whose signals are simulated, episode after episode.
#[pyclass(unsendable, module = "tsc_family._native")]
pub(crate) struct Simulation {
    env: SignalEnv<SumoSim>,
    specs: Vec<SignalSpec>,
    frames: Vec<Option<Frame>>,
    sizes: Sizes,
    decides: Vec<bool>,
    phases: Vec<GreenPhase>,
    episode: Option<u64>,
    delta_time_s: u32,
    _scratch: TempDir,
}

#[pymethods]
impl Simulation {
    /// Looks at a place: a point MDP of a scenario, whose network is built if it is missing, or a SUMO configuration.
    #[new]
    #[pyo3(signature = (point, sumocfg, scenario, settings, networks))]
    fn new(
        py: Python<'_>,
        point: Option<String>,
        sumocfg: Option<PathBuf>,
        scenario: &str,
        settings: Vec<String>,
        networks: Option<PathBuf>,
    ) -> PyResult<Self> {
        let loaded = load(scenario, &settings)?;
        let world = match (&point, &sumocfg) {
            (Some(point), None) => generated(&loaded, scenario, point, networks.as_deref())?,
            (None, Some(config)) => World::from_sumocfg(config).map_err(raised)?,
            _ => return Err(raised("give either `point` or `sumocfg`")),
        };
        let settings = &loaded.scenario;
        let key = key(&world, settings).map_err(raised)?;
        let scratch = tempfile::Builder::new().prefix("tsc-family-").tempdir().map_err(raised)?;
        let sim = SumoSim::new().map_err(raised)?;
        let mut env = environment(sim, world, settings, scratch.path());
        let specs = match known(&key) {
            Some(specs) => specs,
            None => {
                env.reset(LOOK_SEED).map_err(explained)?;
                env.sim_mut().close().map_err(raised)?;
                remember(key, env.signals())
            }
        };
        let mut made = Self {
            env,
            sizes: Sizes::of(&specs),
            decides: vec![true; specs.len()],
            phases: vec![GreenPhase(0); specs.len()],
            frames: Vec::new(),
            specs,
            episode: None,
            delta_time_s: settings.signal.delta_time_s,
            _scratch: scratch,
        };
        made.frame(py)?;
        Ok(made)
    }

    /// Room that the signals need, by name.
    fn sizes(&self) -> BTreeMap<&'static str, usize> {
        Sizes::of(&self.decided()).named()
    }

    /// Gives arrays more room than the signals need.
    fn resize(&mut self, py: Python<'_>, sizes: BTreeMap<String, usize>) -> PyResult<()> {
        let least = self.sizes();
        let size = |name: &str| match sizes.get(name) {
            Some(size) if *size < least[name] => Err(raised(format!(
                "sizes: {name} = {size}, but a signal here has {}; give at least that",
                least[name]
            ))),
            size => Ok(size.copied().unwrap_or(least[name])),
        };
        if let Some(name) = sizes.keys().find(|name| !least.contains_key(name.as_str())) {
            let known: Vec<_> = least.keys().copied().collect();
            return Err(raised(format!(
                "sizes: there is no {name:?}; there are {}",
                known.join(", ")
            )));
        }
        self.sizes = Sizes {
            lanes: size("lanes")?,
            phases: size("phases")?,
            movements: size("movements")?,
            downstream: size("downstream")?,
            slots: size("slots")?,
        };
        self.frame(py)
    }

    /// Ids of all signals.
    fn ids(&self) -> Vec<String> {
        self.specs.iter().map(|s| s.id.clone()).collect()
    }

    /// What may be known of the signals that are decided before the first observation.
    fn signals(&self, py: Python<'_>) -> PyResult<Vec<Py<PySignal>>> {
        signals(py, &self.decided(), self.sizes)
    }

    /// Says which one signal is decided; the others run their own program.
    fn decide_only(&mut self, py: Python<'_>, signal: usize) -> PyResult<()> {
        self.decides = (0..self.specs.len()).map(|i| i == signal).collect();
        self.sizes = Sizes::of(&self.decided());
        self.frame(py)
    }

    /// Simulated seconds between two decisions.
    #[getter]
    fn delta_time_s(&self) -> u32 {
        self.delta_time_s
    }

    /// Decisions of an episode.
    #[getter]
    fn decisions(&self) -> u32 {
        self.env.decisions_per_episode()
    }

    /// Starts an episode with the vehicles of a seed.
    fn reset(&mut self, seed: u64) -> PyResult<()> {
        self.episode = None;
        self.env.reset(seed).map_err(explained)?;
        let drive = |decides: &bool| if *decides { Drive::Decisions } else { Drive::OwnProgram };
        let drives: Vec<Drive> = self.decides.iter().map(drive).collect();
        self.env.drive(&drives).map_err(raised)?;
        self.episode = Some(seed);
        Ok(())
    }

    /// Asks for a phase of every signal and lets the interval go by; says whether the episode is over.
    fn step(&mut self, phases: Vec<usize>) -> PyResult<bool> {
        if self.episode.is_none() {
            return Err(raised("no episode goes on; call reset() first"));
        }
        if phases.len() != self.specs.len() {
            let (given, signals) = (phases.len(), self.specs.len());
            return Err(raised(format!("{given} phases for {signals} signals")));
        }
        for (i, phase) in phases.iter().enumerate().filter(|(i, _)| self.decides[*i]) {
            let (id, count) = (&self.specs[i].id, self.specs[i].phases.len());
            if *phase >= count {
                let reason = format!("signal {id} has no phase {phase}; it has 0 to {}", count - 1);
                return Err(raised(reason));
            }
            self.phases[i] = GreenPhase(*phase);
        }
        self.env.step(&self.phases).map_err(raised)
    }

    /// The green that a signal shows or changes to.
    fn phase(&self, signal: usize) -> PyResult<usize> {
        Ok(self.observation(signal)?.phase)
    }

    /// What a signal's detectors tell.
    fn observe<'py>(&self, py: Python<'py>, signal: usize) -> PyResult<Bound<'py, PyObservation>> {
        let frame =
            self.frames[signal].as_ref().expect("only signals that are decided are asked for");
        frame.observe(py, std::slice::from_ref(self.observation(signal)?))
    }

    /// What IDQN sees of a signal: a row per lane or phase, whichever are more.
    fn idqn<'py>(&self, py: Python<'py>, signal: usize) -> PyResult<Bound<'py, PyArray2<f32>>> {
        view::idqn(py, self.seen(signal)?, self.sizes)
    }

    /// What MPLight sees of a signal: its phase, and the pressure of every movement.
    fn mplight<'py>(&self, py: Python<'py>, signal: usize) -> PyResult<Bound<'py, PyArray1<f32>>> {
        Ok(view::mplight(py, self.seen(signal)?, self.sizes))
    }

    /// What IDQN is paid for: waiting times, scaled and cut.
    fn wait(&self, signal: usize) -> PyResult<f32> {
        Ok(view::wait(self.observation(signal)?))
    }

    /// What MPLight is paid for: queues at the signal less those at the next ones.
    fn pressure(&self, signal: usize) -> PyResult<f32> {
        Ok(view::pressure(self.observation(signal)?))
    }

    /// Ends the episode and returns what a record has of it.
    fn finish(&mut self) -> PyResult<BTreeMap<String, f64>> {
        let seed = self.episode.take().ok_or_else(|| raised("no episode goes on"))?;
        let metrics = self.env.finish().map_err(raised)?;
        let metrics = named(&metrics, seed).map_err(raised)?;
        Ok(metrics.iter().map(|(name, value)| (name.clone(), *value)).collect())
    }

    /// Ends the episode, if one goes on, so that another simulation may begin in this process.
    fn close(&mut self) -> PyResult<()> {
        self.episode = None;
        self.env.sim_mut().close().map_err(raised)
    }
}

impl Simulation {
    fn frame(&mut self, py: Python<'_>) -> PyResult<()> {
        let frame = |(spec, decides): (&SignalSpec, &bool)| {
            decides.then(|| Frame::new(py, std::slice::from_ref(spec), self.sizes)).transpose()
        };
        self.frames = self.specs.iter().zip(&self.decides).map(frame).collect::<PyResult<_>>()?;
        Ok(())
    }

    fn seen(&self, signal: usize) -> PyResult<(&SignalSpec, &Observation)> {
        Ok((&self.specs[signal], self.observation(signal)?))
    }

    /// What a signal's detectors tell; there is nothing before the first episode.
    fn observation(&self, signal: usize) -> PyResult<&Observation> {
        let none = || raised("no episode goes on; call reset() first");
        self.env.observations().get(signal).ok_or_else(none)
    }

    fn decided(&self) -> Vec<SignalSpec> {
        let decided = self.specs.iter().zip(&self.decides).filter(|(_, decides)| **decides);
        decided.map(|(spec, _)| spec.clone()).collect()
    }
}

pub(crate) fn load(scenario: &str, settings: &[String]) -> PyResult<LoadedScenario> {
    let overrides: Result<Vec<Override>, _> = settings.iter().map(|s| s.parse()).collect();
    load_with(scenario, &overrides.map_err(raised)?).map_err(raised)
}

/// Returns the world of a point MDP, whose network is built if it is missing.
fn generated(
    loaded: &LoadedScenario,
    scenario: &str,
    point: &str,
    folder: Option<&Path>,
) -> PyResult<World> {
    let index = loaded.family.position(point);
    let index = index.ok_or_else(|| raised(unknown_point(point, loaded, scenario)))?;
    let id = loaded.family.points[index].id.as_str();
    let folder = folder.map_or_else(|| default_folder(scenario, loaded), Path::to_path_buf);
    let mut files = networks(loaded, &BTreeSet::from([id]), &folder, &|_| ()).map_err(raised)?;
    let files = files.remove(id).expect("what is not built is an error");
    generated_world(&files).map_err(raised)
}

fn key(
    world: &World,
    settings: &tsc_family::traffic::settings::Scenario,
) -> Result<String, tsc_family::traffic::error::TrafficError> {
    let intake = Intake::read(&world.config, &Given::default())?;
    Ok(format!("{:?} {:?} {:?}", world.config, hash_scenario(&intake)?, settings.signal))
}

fn known(key: &str) -> Option<Vec<SignalSpec>> {
    KNOWN.lock().unwrap_or_else(PoisonError::into_inner).as_ref()?.get(key).cloned()
}

fn remember(key: String, specs: &[SignalSpec]) -> Vec<SignalSpec> {
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    known.get_or_insert_default().insert(key, specs.to_vec());
    specs.to_vec()
}

fn explained(error: SimError) -> PyErr {
    match error {
        SimError::AlreadyRunning => Error::new_err(
            "another simulation goes on in this process, and SUMO's library can run only one; close() the other \
             environment, or give each a process of its own: tsc_family.make_vec(points, num_envs)",
        ),
        other => raised(other),
    }
}

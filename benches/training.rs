//! What training costs beside the simulation.
//!
//! Trains every learner for as many episodes as `TSC_FAMILY_BENCH_EPISODES` says (100 if it is not set)
//! on a generated intersection, and on the SUMO scenario that `TSC_FAMILY_BENCH_SUMOCFG` names, if it is
//! set. After every episode the plain `sumo` binary plays the same vehicles and the same switches of the
//! signals, written as a fixed program. So the two alternate, and both see the traffic that the
//! learner's exploration makes.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark may panic and print")]

mod common;

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use common::{env, median, network, sumo};
use tsc_family::traffic::control::{
    ControlError, Controller, Drive, EpisodeOutcome, GreenPhase, Observation, SignalSpec, Trainer,
};
use tsc_family::traffic::controllers::create;
use tsc_family::traffic::env::{SignalEnv, World, run_episode};
use tsc_family::traffic::family::load::load;
use tsc_family::traffic::settings::{SignalSettings, SimulationSettings};
use tsc_family::traffic::sim::libsumo::SumoSim;
use tsc_family::traffic::sim::tripinfo;
use tsc_family::traffic::timing::yellow;

/// Methods and RESCO's ratios to the plain binary with libsumo, on cologne1 and ingolstadt1.
const METHODS: [(&str, &str); 5] = [
    ("max-pressure", "0.96 / 0.89"),
    ("idqn", "4.9 / 4.2"),
    ("ippo", "2.7 / 1.9"),
    ("mplight", "7.8 / 7.1"),
    ("mplight-star", "6.8 / 7.1"),
];

/// Vehicles per hour and approach of the generated intersection.
const INFLOW_VPH: f64 = 500.0;

/// Largest relative difference between the delay of an episode and that of its replay.
const SAME_DELAY: f64 = 1e-6;

fn main() {
    // `cargo test --benches` builds and starts this too; only `cargo bench` passes `--bench`.
    if !std::env::args().any(|a| a == "--bench") {
        return;
    }
    let episodes = std::env::var("TSC_FAMILY_BENCH_EPISODES").map_or(100, |n| n.parse().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let config = network(folder.path(), INFLOW_VPH);
    println!("### Training\n");
    println!(
        "{episodes} episodes each. \"ours / steps\" is all time of the training over the time within the \
         simulator's start, steps and end; \"ours / sumo\" over the plain binary playing the same \
         vehicles and switches, whole process, after every episode; medians over episodes in brackets.\n"
    );
    println!(
        "| scenario | method | training, s | ours / steps | ours / sumo | RESCO / sumo (cologne1 / \
         ingolstadt1) |\n| --- | --- | ---: | ---: | ---: | ---: |"
    );
    let inflow = format!("four arms, {INFLOW_VPH:.0} veh/h per approach");
    for (method, resco) in METHODS {
        let (signal, routes) = (env(&config, folder.path()), true);
        row(
            &inflow,
            method,
            resco,
            training(signal, &config, routes, folder.path(), method, episodes),
        );
    }
    if let Some(config) = std::env::var_os("TSC_FAMILY_BENCH_SUMOCFG").map(PathBuf::from) {
        let name = config.file_stem().unwrap().to_string_lossy().into_owned();
        for (method, resco) in METHODS {
            let world = World::from_sumocfg(&config).unwrap();
            let signal = SignalEnv::new(
                SumoSim::new().unwrap(),
                world,
                SignalSettings::default(),
                SimulationSettings::default(),
                folder.path().to_path_buf(),
            );
            let costs = training(signal, &config, false, folder.path(), method, episodes);
            row(&name, method, resco, costs);
        }
    }
    println!();
}

fn row(scenario: &str, method: &str, resco: &str, costs: Vec<Cost>) {
    let total =
        |part: fn(&Cost) -> Duration| costs.iter().map(part).sum::<Duration>().as_secs_f64();
    let middle = |part: fn(&Cost) -> Duration| {
        let ratio = |c: &Cost| c.ours.as_secs_f64() / part(c).as_secs_f64();
        median(&mut costs.iter().map(ratio).collect::<Vec<_>>())
    };
    let (ours, steps, plain) = (total(|c| c.ours), total(|c| c.steps), total(|c| c.plain));
    println!(
        "| {scenario} | {method} | {ours:.1} | {:.3} ({:.3}) | {:.3} ({:.3}) | {resco} |",
        ours / steps,
        middle(|c| c.steps),
        ours / plain,
        middle(|c| c.plain),
    );
}

/// What an episode took.
#[derive(Debug, Clone, Copy)]
struct Cost {
    ours: Duration,
    steps: Duration,
    plain: Duration,
}

/// Trains a method, or runs it as often where it does not learn.
fn training(
    env: SignalEnv<SumoSim>,
    config: &Path,
    routes: bool,
    folder: &Path,
    method: &str,
    episodes: u32,
) -> Vec<Cost> {
    let mut scenario = load("smoke").unwrap().scenario;
    scenario.training.episodes = episodes;
    let mut controller = create(method, &scenario, false, 1).unwrap();
    let world = World::from_sumocfg(config).unwrap();
    let span = (world.begin_s as u32, world.end_s as u32);
    let (config, folder) = (config.to_path_buf(), folder.to_path_buf());
    let mut bench = Bench { env, config, folder, routes, span, costs: Vec::new() };
    controller.train(&mut bench).unwrap();
    if bench.costs.is_empty() {
        (0..episodes).for_each(|k| drop(bench.episode(controller.as_mut(), k).unwrap()));
    }
    bench.costs
}

struct Bench {
    env: SignalEnv<SumoSim>,
    config: PathBuf,
    folder: PathBuf,
    /// Whether the environment makes its own vehicles.
    routes: bool,
    span: (u32, u32),
    costs: Vec<Cost>,
}

impl Trainer for Bench {
    fn episode(
        &mut self,
        controller: &mut dyn Controller,
        seed: u32,
    ) -> Result<EpisodeOutcome, ControlError> {
        let before = self.env.simulator_time();
        let start = Instant::now();
        let mut recorder = Recorder { controller, phases: Vec::new() };
        let metrics = run_episode(&mut self.env, &mut recorder, u64::from(seed)).unwrap();
        let phases = recorder.phases;
        let ours = start.elapsed();
        let steps = self.env.simulator_time() - before;
        let replay = self.folder.join("replay.add.xml");
        fs::write(&replay, program(&self.env.signals()[0], &phases)).unwrap();
        let replay = replay.display().to_string();
        let vehicles = self.folder.join("episode.rou.xml").display().to_string();
        let mut args = vec!["--additional-files", replay.as_str()];
        if self.routes {
            args.extend(["--route-files", vehicles.as_str()]);
        }
        let plain = sumo(&self.config, &args, u64::from(seed), self.span, &self.folder);
        let trips = tripinfo::read(&self.folder.join("plain.xml")).unwrap();
        let replayed = trips.delay_s / f64::from(trips.vehicles);
        let outcome = metrics.outcome().unwrap();
        let difference = (replayed - outcome.delay_s).abs() / replayed;
        assert!(difference < SAME_DELAY, "{replayed} {}", outcome.delay_s);
        self.costs.push(Cost { ours, steps, plain });
        Ok(outcome)
    }

    fn decisions_per_episode(&self) -> u32 {
        self.env.decisions_per_episode()
    }
}

/// A controller whose phases of the first signal are written down.
struct Recorder<'a> {
    controller: &'a mut dyn Controller,
    phases: Vec<GreenPhase>,
}

impl Controller for Recorder<'_> {
    fn name(&self) -> &'static str {
        self.controller.name()
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        self.controller.begin(signals)
    }

    fn act(
        &mut self,
        observations: &[Observation],
        phases: &mut [GreenPhase],
    ) -> Result<(), ControlError> {
        self.controller.act(observations, phases)?;
        self.phases.push(phases[0]);
        Ok(())
    }

    fn observe(&mut self, observations: &[Observation], truncated: bool) {
        self.controller.observe(observations, truncated);
    }
}

/// Returns the phases as a fixed program that lasts for the episode.
fn program(signal: &SignalSpec, phases: &[GreenPhase]) -> String {
    let settings = SignalSettings::default();
    let mut text = format!(
        "<additional><tlLogic id=\"{}\" type=\"static\" programID=\"~replay\" offset=\"0\">",
        signal.id
    );
    let mut phase = |state: &str, seconds: u32| {
        write!(text, "<phase duration=\"{seconds}\" state=\"{state}\"/>").unwrap();
    };
    let mut current = GreenPhase(0);
    for next in phases {
        let (from, to) = (&signal.phases[current.0].state, &signal.phases[next.0].state);
        let first = if current == *next { to.clone() } else { yellow(from, to) };
        phase(&first, settings.yellow_time_s);
        phase(to, settings.delta_time_s - settings.yellow_time_s);
        current = *next;
    }
    text.push_str("</tlLogic></additional>");
    text
}

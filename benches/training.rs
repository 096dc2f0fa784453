//! What training costs beside the simulation.
//!
//! Trains every learner for as many episodes as `TSC_FAMILY_BENCH_EPISODES` says (100 if it is not set) on a generated
//! intersection, and on the SUMO scenario that `TSC_FAMILY_BENCH_SUMOCFG` names, if it is set.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark may panic and print")]

mod common;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use common::{env, median, network};
use tsc_family::traffic::control::{ControlError, Controller, EpisodeOutcome, Trainer};
use tsc_family::traffic::controllers::create;
use tsc_family::traffic::env::{SignalEnv, World, run_episode};
use tsc_family::traffic::family::load::load;
use tsc_family::traffic::settings::{SignalSettings, SimulationSettings};
use tsc_family::traffic::sim::libsumo::SumoSim;

const METHODS: [&str; 5] = ["max-pressure", "idqn", "ippo", "mplight", "mplight-star"];

/// Vehicles per hour and approach of the generated intersection.
const INFLOW_VPH: f64 = 500.0;

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
        "{episodes} episodes each. The ratio is all time of the training over the time within the simulator's start, steps \
         and end, of all and, in brackets, of the median episode.\n"
    );
    println!("| scenario | method | training, s | ratio |\n| --- | --- | ---: | ---: |");
    let inflow = format!("four arms, {INFLOW_VPH:.0} veh/h per approach");
    for method in METHODS {
        row(&inflow, method, training(env(&config, folder.path()), method, episodes));
    }
    if let Some(config) = std::env::var_os("TSC_FAMILY_BENCH_SUMOCFG").map(PathBuf::from) {
        let name = config.file_stem().unwrap().to_string_lossy().into_owned();
        for method in METHODS {
            let signal = SignalEnv::new(
                SumoSim::new().unwrap(),
                World::from_sumocfg(&config).unwrap(),
                SignalSettings::default(),
                SimulationSettings::default(),
                folder.path().to_path_buf(),
            );
            row(&name, method, training(signal, method, episodes));
        }
    }
    println!();
}

/// What an episode took, all and within the simulator.
type Cost = [Duration; 2];

fn row(scenario: &str, method: &str, costs: Vec<Cost>) {
    let [all, steps] = [0, 1].map(|i| costs.iter().map(|cost| cost[i].as_secs_f64()).sum::<f64>());
    let ratio = |[all, steps]: &Cost| all.as_secs_f64() / steps.as_secs_f64();
    let middle = median(&mut costs.iter().map(ratio).collect::<Vec<_>>());
    println!("| {scenario} | {method} | {all:.1} | {:.3} ({middle:.3}) |", all / steps);
}

/// Trains a method, or runs it as often where it does not learn.
fn training(env: SignalEnv<SumoSim>, method: &str, episodes: u32) -> Vec<Cost> {
    let mut scenario = load("smoke").unwrap().scenario;
    scenario.training.episodes = episodes;
    let mut controller = create(method, &scenario, false, 1).unwrap();
    let mut bench = Bench { env, costs: Vec::new() };
    controller.train(&mut bench).unwrap();
    if bench.costs.is_empty() {
        (0..episodes).for_each(|k| drop(bench.episode(controller.as_mut(), k).unwrap()));
    }
    bench.costs
}

struct Bench {
    env: SignalEnv<SumoSim>,
    costs: Vec<Cost>,
}

impl Trainer for Bench {
    fn episode(
        &mut self,
        controller: &mut dyn Controller,
        seed: u32,
    ) -> Result<EpisodeOutcome, ControlError> {
        let (before, start) = (self.env.simulator, Instant::now());
        let metrics = run_episode(&mut self.env, controller, u64::from(seed)).unwrap();
        self.costs.push([start.elapsed(), self.env.simulator - before]);
        Ok(metrics.outcome().unwrap())
    }

    fn decisions_per_episode(&self) -> u32 {
        self.env.decisions_per_episode()
    }
}

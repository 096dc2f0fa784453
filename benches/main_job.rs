//! The benchmarks of the main job: control overhead, throughput of the family.
//!
//! Run with `make bench`; prints Markdown. What is compared is interleaved in one run, and ratios
//! are of medians, because machines are shared and noisy.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark may panic and print")]

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

mod common;

use common::{env, median, network};
use tsc_family::traffic::control::{Drive, GreenPhase};
use tsc_family::traffic::env::SignalEnv;
use tsc_family::traffic::sim::Sim;
use tsc_family::traffic::sim::libsumo::SumoSim;

/// Interleaved pairs per inflow.
const PAIRS: usize = 11;

/// Vehicles per hour and approach of the intersections that control overhead is measured on.
const INFLOWS_VPH: [f64; 3] = [250.0, 500.0, 1000.0];

/// Interleaved rounds of the family benchmark.
const ROUNDS: usize = 3;

/// What a family benchmark runs.
const FAMILY: &str = "run --budget 8 --eval-seeds 2 --methods max-pressure,actuated --quiet";

/// Point MDPs in [`FAMILY`].
const FAMILY_POINTS: f64 = 8.0;

fn main() {
    // `cargo test --benches` builds and starts this too; only `cargo bench` passes `--bench`.
    if !std::env::args().any(|a| a == "--bench") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    control_overhead(folder.path());
    family_throughput(folder.path());
}

/// Returns the lowest and the highest value in words.
fn spread(values: &[f64]) -> String {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(0.0, f64::max);
    format!("{low:.3} to {high:.3}")
}

/// An episode of the unchanged program through our loop, with a full observation at every
/// decision, against the plain `sumo` binary on the same files and seed.
fn control_overhead(folder: &Path) {
    println!("### Control overhead\n");
    println!(
        "One 3600 s episode of the unchanged program, {PAIRS} interleaved pairs. Start-up aside: of \
         the binary the time of the same command with `--end 1` is taken off; ours is timed from \
         the first step to the metrics, so without `reset`, which loads the same network and routes. \
         Bare libsumo steps through the episode in one call and observes nothing: what Debian's or \
         the wheel's shared library costs against the binary, whatever we do.\n"
    );
    println!(
        "| inflow, veh/h per approach | sumo, s | bare libsumo, s | ours, s | ours / sumo | range | \
         ours / bare libsumo | range |"
    );
    println!("| ---: | ---: | ---: | ---: | ---: | --- | ---: | --- |");
    for inflow in INFLOWS_VPH {
        let config = network(folder, inflow);
        let mut env = env(&config, folder);
        let seed = 1;
        episode(&mut env, seed);
        // The episode has left its vehicles behind; the binary gets the same.
        let routes = folder.join("episode.rou.xml").display().to_string();
        let routes = routes.as_str();
        let (mut plain, mut bare, mut ours) = (Vec::new(), Vec::new(), Vec::new());
        let (mut to_plain, mut to_bare) = (Vec::new(), Vec::new());
        for _ in 0..PAIRS {
            let start_up = sumo(&config, &["--route-files", routes], seed, (0, 1), folder);
            let full = sumo(&config, &["--route-files", routes], seed, (0, 3600), folder);
            let net = (full - start_up).as_secs_f64();
            let stepped = bare_episode(&mut env, seed).as_secs_f64();
            let own = episode(&mut env, seed).as_secs_f64();
            to_plain.push(own / net);
            to_bare.push(own / stepped);
            plain.push(net);
            bare.push(stepped);
            ours.push(own);
        }
        let (plain, bare, ours) = (median(&mut plain), median(&mut bare), median(&mut ours));
        println!(
            "| {inflow:.0} | {plain:.3} | {bare:.3} | {ours:.3} | {:.3} | {} | {:.3} | {} |",
            ours / plain,
            spread(&to_plain),
            ours / bare,
            spread(&to_bare)
        );
    }
    println!();
}

/// Returns the time of an episode from its first step to its metrics.
fn episode(env: &mut SignalEnv<SumoSim>, seed: u64) -> Duration {
    env.reset(seed).unwrap();
    let start = Instant::now();
    env.drive(&[Drive::OwnProgram]).unwrap();
    while !env.step(&[GreenPhase(0)]).unwrap() {}
    env.finish().unwrap();
    start.elapsed()
}

/// Returns the time of an episode that is only stepped through.
fn bare_episode(env: &mut SignalEnv<SumoSim>, seed: u64) -> Duration {
    env.reset(seed).unwrap();
    let start = Instant::now();
    env.sim_mut().step(3600).unwrap();
    env.sim_mut().close().unwrap();
    start.elapsed()
}

/// Point MDPs per minute and core with one and with two workers.
fn family_throughput(folder: &Path) {
    tsc_family(folder, "build-networks --quiet");
    let (mut one, mut two) = (Vec::new(), Vec::new());
    for round in 0..ROUNDS {
        for (jobs, times) in [(1, &mut one), (2, &mut two)] {
            let out = format!("results/{jobs}-{round}");
            let time = tsc_family(folder, &format!("{FAMILY} --jobs {jobs} --out {out}"));
            times.push(time.as_secs_f64());
        }
    }
    let (spread_one, spread_two) = (spread(&one), spread(&two));
    let (one, two) = (median(&mut one), median(&mut two));
    println!("### Whole family\n");
    println!("`tsc-family {FAMILY}`, {ROUNDS} interleaved rounds (baseline included).\n");
    println!("| workers | median, s | range, s | point MDPs per minute and core |");
    println!("| ---: | ---: | --- | ---: |");
    for (jobs, time, spread) in [(1.0, one, spread_one), (2.0, two, spread_two)] {
        let rate = FAMILY_POINTS * 60.0 / time / jobs;
        println!("| {jobs} | {time:.2} | {spread} | {rate:.1} |");
    }
    println!("\nScaling from one to two workers: {:.2}\n", one / two);
}

/// Runs the program and returns its wall-clock time.
fn tsc_family(folder: &Path, args: &str) -> Duration {
    let start = Instant::now();
    let status = Command::new(env!("CARGO_BIN_EXE_tsc-family"))
        .current_dir(folder)
        .args(args.split_whitespace())
        .status()
        .unwrap();
    assert!(status.success(), "{args}");
    start.elapsed()
}

/// Returns the wall-clock time of the plain binary with the same outputs, in `folder/plain.xml`.
fn sumo(
    config: &Path,
    args: &[&str],
    seed: u64,
    (begin, end): (u32, u32),
    folder: &Path,
) -> Duration {
    let binary = std::env::var_os("SUMO_HOME")
        .map(|home| PathBuf::from(home).join("bin/sumo"))
        .filter(|path| path.exists())
        .unwrap_or_else(|| "sumo".into());
    let start = Instant::now();
    let status = Command::new(binary)
        .arg("-c")
        .arg(config)
        .args(args)
        .args(["--seed", &seed.to_string()])
        .args(["--begin", &begin.to_string(), "--end", &end.to_string()])
        .args(["--step-length", "1", "--time-to-teleport", "-1", "--xml-validation", "never"])
        .args(["--no-step-log", "true", "--no-warnings", "true", "--duration-log.disable", "true"])
        .arg("--tripinfo-output")
        .arg(folder.join("plain.xml"))
        .args(["--tripinfo-output.write-unfinished", "--tripinfo-output.write-undeparted"])
        .stdout(Stdio::null())
        .status()
        .unwrap();
    assert!(status.success());
    start.elapsed()
}

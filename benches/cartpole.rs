//! Whole trainings on gymnasium's own cart and pole: what they take, and whether they solve it.
//!
//! `cargo bench --bench cartpole`, without SUMO. Ten trainings per method and preset, each evaluated greedily
//! over 100 held-out episodes; one solves the task that comes to a mean return of 475 (gymnasium's
//! threshold). On a machine that is not idle, the median says more than the slowest.
#![expect(clippy::print_stdout, reason = "a benchmark prints")]

use std::time::Instant;

use tsc_family::cartpole::dynamics::{Context, Dynamics, Variant};
use tsc_family::cartpole::environment::{CartPole, GYMNASIUM_START};
use tsc_family::cartpole::{dqn, ppo};
use tsc_family::rl::environment::play;
use tsc_family::rl::sb3::Trainer;
use tsc_family::rl::sb3::dqn::Dqn;
use tsc_family::rl::sb3::ppo::Ppo;
use tsc_family::seed;

/// Trainings per method and preset.
const TRAININGS: u64 = 10;

/// Episodes that evaluate a training.
const EPISODES: u32 = 100;

/// Mean return from which the task is solved.
const SOLVED: f64 = 475.0;

fn cart_pole() -> CartPole {
    CartPole::new(Dynamics::new(Context::default(), Variant::CarlCompat), GYMNASIUM_START)
}

/// Returns seconds of a training and the mean return afterwards.
fn measure(trainer: &mut dyn Trainer, seed: u64) -> (f64, f64) {
    let start = Instant::now();
    trainer.advance(u64::MAX, &mut |k| seed::training(seed, k));
    let seconds = start.elapsed().as_secs_f64();
    let mut environment = cart_pole();
    let mut total = 0.0;
    for k in 0..EPISODES {
        let mut policy = |observation: &[f32]| trainer.act(observation);
        total += play(&mut environment, seed::evaluation(seed, k), &mut policy).total;
    }
    (seconds, total / f64::from(EPISODES))
}

fn row(name: &str, steps: u64, trainer: &dyn Fn(u64) -> Box<dyn Trainer>) {
    let (mut seconds, mut returns): (Vec<f64>, Vec<f64>) =
        (0..TRAININGS).map(|seed| measure(&mut *trainer(seed), seed)).unzip();
    let solved = returns.iter().filter(|r| **r >= SOLVED).count();
    seconds.sort_by(f64::total_cmp);
    returns.sort_by(f64::total_cmp);
    let middle = (seconds[seconds.len() / 2] + seconds[(seconds.len() - 1) / 2]) / 2.0;
    let (fastest, slowest) = (seconds[0], seconds[seconds.len() - 1]);
    let worst: Vec<_> = returns.iter().map(|r| format!("{r:.0}")).collect();
    println!(
        "| {name} | {steps} | {middle:.2} ({fastest:.2} to {slowest:.2}) | {solved} of {TRAININGS} | {} |",
        worst.join(" ")
    );
}

fn main() {
    // `cargo test --benches` builds and starts this too; only `cargo bench` passes `--bench`.
    if !std::env::args().any(|a| a == "--bench") {
        return;
    }
    println!("### CartPole\n");
    println!(
        "Seconds of whole trainings on one core, median (fastest to slowest); solved: mean return of at least \
         {SOLVED} over {EPISODES} held-out episodes.\n"
    );
    println!("| method, preset | steps | seconds | solved | mean returns |");
    println!("|---|---|---|---|---|");
    for (name, settings) in [("ppo, sb3", ppo::default()), ("ppo, tuned", ppo::tuned())] {
        row(name, settings.total_steps, &|seed| {
            Box::new(Ppo::new(settings.clone(), cart_pole, seed))
        });
    }
    for (name, settings) in [("dqn, sb3", dqn::default()), ("dqn, tuned", dqn::tuned())] {
        row(name, settings.total_steps, &|seed| {
            Box::new(Dqn::new(settings.clone(), cart_pole(), seed))
        });
    }
    println!();
}

//! Whole trainings on gymnasium's own cart and pole: what they take, and whether they solve it.
//!
//! `cargo bench --bench cartpole`, without SUMO. Ten trainings per method and preset, each evaluated greedily
//! over 100 held-out episodes; one solves the task that comes to a mean return of 475 (gymnasium's
//! threshold). On a machine that does other work too, the processor's time is what an idle one takes.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark may panic and print")]

use std::time::Instant;

use rustix::time::{ClockId, clock_gettime};
use tsc_family::cartpole::{CartPole, Context, Dynamics, GYMNASIUM_START, Scenario, Variant};
use tsc_family::control_tasks::task::scenario::Settings as _;
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

/// Returns the processor time of this program, seconds.
fn processor_s() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Times of a training, seconds, and the mean return afterwards.
struct Measured {
    processor_s: f64,
    wall_s: f64,
    mean_return: f64,
}

fn measure(trainer: &mut dyn Trainer, seed: u64) -> Measured {
    let (start, processor) = (Instant::now(), processor_s());
    trainer.advance(u64::MAX, &mut |k| seed::training(seed, k));
    let (wall_s, processor_s) = (start.elapsed().as_secs_f64(), processor_s() - processor);
    let mut environment = cart_pole();
    let mut total = 0.0;
    for k in 0..EPISODES {
        let mut policy = |observation: &[f32], action: &mut [f32]| trainer.act(observation, action);
        total += play(&mut environment, seed::evaluation(seed, k), &mut policy).total;
    }
    Measured { processor_s, wall_s, mean_return: total / f64::from(EPISODES) }
}

/// Returns the least, the median and the largest number.
fn spread(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    let last = values.len() - 1;
    [values[0], (values[last / 2] + values[values.len() / 2]) / 2.0, values[last]]
}

fn row(name: &str, steps: u64, trainer: &dyn Fn(u64) -> Box<dyn Trainer>) {
    let measured: Vec<_> = (0..TRAININGS).map(|seed| measure(&mut *trainer(seed), seed)).collect();
    let solved = measured.iter().filter(|m| m.mean_return >= SOLVED).count();
    let returns: Vec<_> = measured.iter().map(|m| format!("{:.0}", m.mean_return)).collect();
    let [least, middle, largest] = spread(measured.iter().map(|m| m.processor_s).collect());
    let [_, wall, _] = spread(measured.iter().map(|m| m.wall_s).collect());
    println!(
        "| {name} | {steps} | {middle:.2} ({least:.2} to {largest:.2}) | {wall:.2} | {solved} of {TRAININGS} | {} |",
        returns.join(" ")
    );
}

fn main() {
    // `cargo test --benches` builds and starts this too; only `cargo bench` passes `--bench`.
    if !std::env::args().any(|a| a == "--bench") {
        return;
    }
    println!("### CartPole\n");
    println!(
        "Whole trainings on one core: processor time and wall-clock time, medians (least to largest); solved: a \
         mean return of at least {SOLVED} over {EPISODES} held-out episodes.\n"
    );
    println!("| method, preset | steps | processor, s | wall, s | solved | mean returns |");
    println!("|---|---|---|---|---|---|");
    for (preset, text) in [("sb3", ""), ("tuned", "preset = \"tuned\"")] {
        let Scenario { ppo, dqn, .. } = Scenario::read(text, preset, &[]).unwrap();
        row(&format!("ppo, {preset}"), ppo.total_steps, &|seed| {
            Box::new(Ppo::new(ppo.clone(), cart_pole(), seed))
        });
        row(&format!("dqn, {preset}"), dqn.total_steps, &|seed| {
            Box::new(Dqn::new(dqn.clone(), cart_pole(), seed))
        });
    }
    println!();
}

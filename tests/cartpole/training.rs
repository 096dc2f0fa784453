//! Trainings on gymnasium's own cart and pole; `cargo bench --bench cartpole` makes ten of each.

use tsc_family::cartpole::{CartPole, Context, Dynamics, GYMNASIUM_START, Scenario, Variant};
use tsc_family::control_tasks::task::scenario::Settings as _;
use tsc_family::nn::archive::Archive;
use tsc_family::rl::environment::play;
use tsc_family::rl::sb3::Trainer;
use tsc_family::rl::sb3::dqn::Dqn;
use tsc_family::rl::sb3::ppo::Ppo;
use tsc_family::seed;

fn cart_pole() -> CartPole {
    CartPole::new(Dynamics::new(Context::default(), Variant::CarlCompat), GYMNASIUM_START)
}

fn mean_return(trainer: &mut dyn Trainer) -> f64 {
    let total: f64 = (0..100)
        .map(|k| {
            let mut policy =
                |observation: &[f32], action: &mut [f32]| trainer.act(observation, action);
            play(&mut cart_pole(), seed::evaluation(0, k), &mut policy).total
        })
        .sum();
    total / 100.0
}

fn sb3() -> Scenario {
    Scenario::default()
}

fn tuned() -> Scenario {
    Scenario::read("preset = \"tuned\"", "tuned", &[]).unwrap()
}

/// The hash of what was learned.
fn learned(trainer: &dyn Trainer) -> String {
    let mut archive = Archive::default();
    trainer.learned("", &mut archive);
    archive.checksum()
}

#[test]
fn ppo_with_the_defaults_solves_it_in_100_000_steps() {
    for replicate in 0..2 {
        let mut trainer = Ppo::new(sb3().ppo, cart_pole(), replicate);
        let before = mean_return(&mut trainer);
        trainer.advance(u64::MAX, &mut |k| seed::training(replicate, k));
        let after = mean_return(&mut trainer);
        assert!(before < 100.0 && after >= 475.0, "{replicate}: {before} to {after}");
    }
}

#[test]
fn dqn_with_the_defaults_learns() {
    let mut trainer = Dqn::new(sb3().dqn, cart_pole(), 0);
    let before = mean_return(&mut trainer);
    trainer.advance(u64::MAX, &mut |k| seed::training(0, k));
    let after = mean_return(&mut trainer);
    assert!(before < 100.0 && after > 150.0, "{before} to {after}");
}

/// Arithmetic has one order and is fused on every processor, and no function of the platform's library is called:
/// what is learned has the same bytes with AVX-512, with AVX2 and with neither.
#[test]
fn what_is_learned_has_the_same_bytes_on_every_processor() {
    let seeds = &mut |k| seed::training(7, k);
    let mut ppo = Ppo::new(sb3().ppo, cart_pole(), 7);
    ppo.advance(3000, seeds);
    let mut dqn = Dqn::new(tuned().dqn, cart_pole(), 7);
    dqn.advance(1100, seeds);
    let known = [
        "de8fb373955146411158161412b908e99c2c0638bb5351da6b5dbc92f684f726",
        "5ed83b72e1e0b58b7cf12bf1bdb2c1f7f2c91fb3acbb3e25c0971f2e897fa363",
    ];
    assert_eq!([learned(&ppo), learned(&dqn)], known);
}

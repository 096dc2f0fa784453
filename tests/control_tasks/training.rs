//! Trainings on gymnasium's own environments. What each algorithm computes is held to the byte at every change; of those
//! that learn for many seconds, some are left to `make nightly`.

use crate::nightly::is_nightly;
use tsc_family::cartpole::{self, CartPole, Context, Dynamics, GYMNASIUM_START, Variant};
use tsc_family::control_tasks::episodes::Episodes;
use tsc_family::control_tasks::pendulum::{self, Pendulum};
use tsc_family::control_tasks::task::scenario::Settings as _;
use tsc_family::nn::archive::Archive;
use tsc_family::rl::environment::{Environment, play};
use tsc_family::rl::sb3::Trainer;
use tsc_family::rl::sb3::ars::Ars;
use tsc_family::rl::sb3::dqn::Dqn;
use tsc_family::rl::sb3::ppo::{self, Ppo};
use tsc_family::rl::sb3::sac::{self, Sac};
use tsc_family::rl::sb3::td3::{self, Td3};
use tsc_family::rl::sb3::trpo::Trpo;
use tsc_family::seed;

fn pendulum() -> Episodes<Pendulum> {
    Episodes::of(Pendulum { mass_kg: 1.0, length_m: 1.0, gravity_mps2: 10.0, max_torque_nm: 2.0 })
}

fn cart_pole() -> CartPole {
    CartPole::new(Dynamics::new(Context::default(), Variant::CarlCompat), GYMNASIUM_START)
}

fn mean_return(trainer: &mut dyn Trainer, environment: &mut dyn Environment, count: u32) -> f64 {
    let mut policy = |observation: &[f32], action: &mut [f32]| trainer.act(observation, action);
    let mut total = |k| play(environment, seed::evaluation(0, k), &mut policy).total;
    (0..count).map(&mut total).sum::<f64>() / f64::from(count)
}

/// Trains until held-out episodes have this mean return, before a release to the end.
fn learns(mut trainer: impl Trainer, mut environment: impl Environment, count: u32, least: f64) {
    let part = if is_nightly() { u64::MAX } else { 2500 };
    let mut found = f64::NEG_INFINITY;
    while !trainer.finished() && found <= least {
        let steps = trainer.steps().saturating_add(part);
        trainer.advance(steps, &mut |k| seed::training(0, k));
        found = mean_return(&mut trainer, &mut environment, count);
    }
    assert!(found > least, "{found}");
}

/// The hash of what was learned in so many steps.
fn learned(mut trainer: impl Trainer, steps: u64) -> String {
    trainer.advance(steps, &mut |k| seed::training(7, k));
    let mut archive = Archive::default();
    trainer.learned("", &mut archive);
    archive.checksum()
}

#[test]
fn small_networks_swing_a_pendulum_up_with_sac_and_td3() {
    let pendulum::Scenario { sac, td3, .. } = pendulum::Scenario::default();
    let settings =
        sac::Settings { total_steps: 5000, batch_size: 64, hidden: 64, learning_rate: 1e-3, ..sac };
    learns(Sac::new(settings, pendulum(), 0), pendulum(), 20, -200.0);
    if !is_nightly() {
        return;
    }
    let settings = td3::Settings {
        total_steps: 8000,
        batch_size: 64,
        learning_starts: 1000,
        hidden: 128,
        second_hidden: 128,
        action_noise: 0.1,
        ..td3
    };
    learns(Td3::new(settings, pendulum(), 0), pendulum(), 20, -250.0);
}

#[test]
fn trpo_and_ppo_with_the_defaults_balance_a_pole() {
    let cartpole::Scenario { trpo, ppo, .. } = cartpole::Scenario::default();
    learns(Trpo::new(trpo, cart_pole(), 0), cart_pole(), 20, 475.0);
    let mut untrained = Ppo::new(ppo, cart_pole(), 0);
    assert!(mean_return(&mut untrained, &mut cart_pole(), 100) < 100.0);
    learns(untrained, cart_pole(), 100, 475.0);
}

#[test]
fn random_search_and_dqn_with_the_defaults_learn_to_balance_a_pole() {
    let cartpole::Scenario { ars, dqn, .. } = cartpole::Scenario::default();
    learns(Ars::new(ars, cart_pole(), 0), cart_pole(), 20, 475.0);
    learns(Dqn::new(dqn, cart_pole(), 0), cart_pole(), 100, 150.0);
}

#[test]
fn trpo_and_ppo_swing_a_pendulum_up() {
    if !is_nightly() {
        return;
    }
    let pendulum::Scenario { trpo, ppo, .. } = pendulum::Scenario::default();
    learns(Trpo::new(trpo, pendulum(), 0), pendulum(), 20, -300.0);
    let tuned =
        ppo::Settings { environments: 4, num_steps: 1024, gamma: 0.9, learning_rate: 1e-3, ..ppo };
    learns(Ppo::new(tuned, pendulum(), 0), pendulum(), 20, -300.0);
}

/// Arithmetic has one order and is fused on every processor, and no function of the platform's library is called:
/// what is learned has the same bytes with AVX-512, with AVX2 and with neither.
#[test]
fn what_is_learned_has_the_same_bytes_on_every_processor() {
    let on_poles = cartpole::Scenario::default().ppo;
    let tuned = cartpole::Scenario::read("preset = \"tuned\"", "tuned", &[]).unwrap().dqn;
    let config = pendulum::Scenario::default();
    let known = [
        "de8fb373955146411158161412b908e99c2c0638bb5351da6b5dbc92f684f726",
        "5ed83b72e1e0b58b7cf12bf1bdb2c1f7f2c91fb3acbb3e25c0971f2e897fa363",
        "8e158090d3e6ebd97d02e0ae720fb1c405c62b5704e0fa5e02f396fd73a37f5f",
        "7e12190ba41a89e99c5c192d0c6033197ad2a3b8584d3ba2569d9b236840739f",
        "e335fc4331d1d0cafba27d161dc68c3604b2d522edf010ee98285aceb22e100f",
        "235cb263833f5f5bf76ac866b06282d6362b122ca568c64dabfa3cce952c7187",
        "4dba6126deda8531eb1d16090e424fecc43c32a669ca6d6765b964282c518882",
    ];
    let found = [
        learned(Ppo::new(on_poles, cart_pole(), 7), 3000),
        learned(Dqn::new(tuned, cart_pole(), 7), 1100),
        learned(Sac::new(config.sac, pendulum(), 7), 150),
        learned(Td3::new(config.td3, pendulum(), 7), 150),
        learned(Ppo::new(config.ppo, pendulum(), 7), 3000),
        learned(Trpo::new(config.trpo, pendulum(), 7), 3000),
        learned(Ars::new(config.ars, pendulum(), 7), 9000),
    ];
    assert_eq!(found, known);
}

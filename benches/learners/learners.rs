//! Micro-benchmarks of the learners: what one decision costs beside the simulation.
//!
//! `cargo bench --package tsc-family-benches`, without SUMO.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use tsc_family::nn::Activation;
use tsc_family::nn::Network;
use tsc_family::nn::frap::{Frap, HEAD, PhaseLayout};
use tsc_family::nn::init::Init;
use tsc_family::nn::sequential::Sequential;
use tsc_family::rl::dqn::{Dqn, Settings};
use tsc_family::rl::ppo::{self, End, Ppo};
use tsc_family::rl::random::Generator;
use tsc_family::rl::replay::Transition;

/// Numbers per lane of a state.
const LANE: usize = 5;

/// Phases of a full intersection.
const PHASES: usize = 8;

/// Transitions that fill the replay buffer before measuring.
const FILL: usize = 10_000;

fn lanes(lanes: usize, outputs: usize) -> Sequential {
    Sequential::new(lanes * LANE)
        .convolution(LANE, 64, Activation::Relu)
        .linear(64, Activation::Relu)
        .linear(64, Activation::Relu)
        .linear(outputs, Activation::None)
}

fn frap(width: usize) -> Frap {
    let pairs = [[1, 7], [2, 8], [1, 2], [7, 8], [4, 10], [5, 11], [10, 11], [4, 5]];
    let pairs: Vec<Vec<usize>> = pairs.iter().map(|p| p.to_vec()).collect();
    Frap::new(vec![PhaseLayout::new(&pairs, width)], width, 12 * width)
}

/// A learner whose replay buffer is full, and states to feed it; the first `head` numbers are 0.
fn dqn<N: Network>(network: N, parameters: Vec<f32>, head: usize) -> (Dqn<N>, Vec<Vec<f32>>) {
    let settings = Settings {
        learning_rate: 1e-3,
        adam_epsilon: 1e-8,
        gamma: 0.99,
        buffer_size: FILL,
        batch_size: 32,
        learning_starts: FILL,
        train_frequency: 1,
        target_network_frequency: 500,
        double_dqn: false,
    };
    let width = network.inputs();
    let mut generator = Generator::new(1, &["states"]);
    let mut state = || -> Vec<f32> {
        (0..width).map(|i| if i < head { 0.0 } else { generator.unit() as f32 }).collect()
    };
    let states: Vec<_> = (0..256).map(|_| state()).collect();
    let mut dqn = Dqn::new(network, parameters, settings, 1, &[]);
    for t in 0..FILL - 1 {
        observe(&mut dqn, &states, t);
    }
    (dqn, states)
}

fn observe<N: Network>(dqn: &mut Dqn<N>, states: &[Vec<f32>], t: usize) {
    let at = |t: usize| states[t % states.len()].as_slice();
    let transition = Transition {
        state: at(t),
        action: t % PHASES,
        reward: -1.0,
        next: at(t + 1),
        terminal: t % 360 == 359,
    };
    dqn.observe(&transition);
}

fn updates(c: &mut Criterion) {
    let mut group = c.benchmark_group("update");
    for count in [8, 16] {
        let network = lanes(count, PHASES);
        let mut generator = Generator::new(1, &["initial"]);
        let parameters = network.initial(&|_| Init::Uniform, generator.rng());
        let (mut learner, states) = dqn(network, parameters, 0);
        let mut t = 0;
        group.bench_function(format!("idqn, {count} lanes, batch 32"), |b| {
            b.iter(|| {
                observe(&mut learner, &states, t);
                t += 1;
            });
        });
    }
    for (name, width) in [("mplight", 1), ("mplight-star", 4)] {
        let network = frap(width);
        let mut generator = Generator::new(1, &["initial"]);
        let parameters = network.initial(Init::Uniform, generator.rng());
        let (mut learner, states) = dqn(network, parameters, HEAD);
        let mut t = 0;
        group.bench_function(format!("{name}, 8 phases, batch 32"), |b| {
            b.iter(|| {
                observe(&mut learner, &states, t);
                t += 1;
            });
        });
    }
    group.finish();
    let mut group = c.benchmark_group("update of 1024 steps");
    group.sample_size(20);
    for count in [8, 16] {
        let network = lanes(count, PHASES + 1);
        let mut generator = Generator::new(1, &["initial"]);
        let parameters = network.initial(&|_| Init::Normal(1.0), generator.rng());
        let settings = ppo::Settings {
            learning_rate: 2.5e-4,
            adam_epsilon: 1e-5,
            gamma: 0.99,
            gae_lambda: 0.95,
            num_steps: 1024,
            update_epochs: 4,
            minibatch_size: 256,
            clip_range: 0.1,
            value_coefficient: 1.0,
            entropy_coefficient: 0.001,
            max_grad_norm: 0.5,
        };
        let states: Vec<Vec<f32>> = (0..256)
            .map(|_| (0..count * LANE).map(|_| generator.unit() as f32).collect())
            .collect();
        let mut learner = Ppo::new(network, parameters, settings, 1, &[]);
        group.bench_function(format!("ippo, {count} lanes"), |b| {
            b.iter(|| {
                for t in 0..1024 {
                    let (state, next) = (&states[t % 256], &states[(t + 1) % 256]);
                    learner.observe(state, t % PHASES, -1.0, next, End::None);
                }
            });
        });
    }
    group.finish();
}

fn actions(c: &mut Criterion) {
    let mut group = c.benchmark_group("action");
    for count in [8, 16] {
        let mut network = lanes(count, PHASES);
        let mut generator = Generator::new(1, &["initial"]);
        let parameters = network.initial(&|_| Init::Uniform, generator.rng());
        let state: Vec<f32> = (0..count * LANE).map(|_| generator.unit() as f32).collect();
        group.bench_function(format!("idqn, {count} lanes"), |b| {
            b.iter(|| network.single(&parameters, black_box(&state))[0]);
        });
    }
    let mut network = frap(1);
    let mut generator = Generator::new(1, &["initial"]);
    let parameters = network.initial(Init::Uniform, generator.rng());
    let mut state: Vec<f32> = (0..12 + HEAD).map(|_| generator.unit() as f32).collect();
    state[..HEAD].fill(0.0);
    group.bench_function("mplight, 8 phases", |b| {
        b.iter(|| network.single(&parameters, black_box(&state))[0]);
    });
    group.finish();
}

criterion_group!(benches, updates, actions);
criterion_main!(benches);

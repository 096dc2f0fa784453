//! What Stable-Baselines3's algorithms for continuous actions share: one environment, a replay buffer of what happened in
//! it, and twin critics.
//!
//! Choices where implementations differ:
//! - **Actions** are learned between -1 and 1, and scaled to the environment's limit when they are done.
//! - **The first steps** ([`Play::learning_starts`]) have uniform actions.
//! - **Batches** are drawn with replacement.
//! - **Updates** come in blocks: after every [`Play::train_frequency`] steps as many as [`Play::gradient_steps`] says.
//! - **A cut episode** has the value of the state after it.
//! - **Critics** are two networks of state and action (Fujimoto et al., 2018), with ReLU and PyTorch's uniform weights;
//!   their targets follow them by a share after an update.

use super::{Lanes, Progress, Trainer};
use crate::nn::init::Init;
use crate::nn::sequential::Sequential;
use crate::nn::state::{Learned, State, kept};
use crate::nn::{Activation, Network};
use crate::rl::Followed;
use crate::rl::Losses;
use crate::rl::depends_on_state;
use crate::rl::environment::{Actions, Environment};
use crate::rl::persist::Persist;
use crate::rl::random::Generator;
use crate::rl::replay::{Replay, Transition};

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Play {
    pub total_steps: u64,
    pub learning_rate: f32,
    pub adam_epsilon: f32,
    pub gamma: f32,
    pub tau: f32,
    pub buffer_size: usize,
    pub batch_size: usize,
    pub learning_starts: u64,
    pub train_frequency: u64,
    pub gradient_steps: u32,
}

#[derive(Debug, Clone, Default)]
pub(super) struct Batch {
    /// Observations, and the same beside the actions that were taken.
    pub(super) states: Vec<f32>,
    pub(super) pairs: Vec<f32>,
    pub(super) nexts: Vec<f32>,
    pub(super) rewards: Vec<f32>,
    /// 1, or 0 where nothing can follow.
    pub(super) follows: Vec<f32>,
}

/// What an algorithm learns, with actions from -1 to 1.
pub trait Learner: State + Learned {
    fn explore(&mut self, observation: &[f32], draws: &mut Generator, action: &mut [f32]);

    fn best(&mut self, observation: &[f32], action: &mut [f32]);

    /// Returns what the policy says of states, a row each, to see whether it says anything.
    fn outputs(&mut self, observations: &[f32]) -> &[f32];

    /// Learns from a batch and returns the loss of the critics.
    #[expect(private_interfaces, reason = "only algorithms of this folder are learners")]
    fn update(&mut self, batch: &Batch, draws: &mut Generator) -> f64;

    fn is_finite(&self) -> bool;
}

/// A training of an algorithm that learns from a replay buffer.
#[derive(Debug, Clone)]
pub struct OffPolicy<E, L> {
    play: Play,
    pub(super) learner: L,
    lane: Lanes<E>,
    /// A stored state is what a critic sees: an observation, then the action taken in it. In a stored next state the
    /// place of the action is empty.
    replay: Replay,
    limit: f32,
    places: Generator,
    draws: Generator,
    steps: u64,
    batch: Batch,
    pair: Vec<f32>,
    next: Vec<f32>,
    done: Vec<f32>,
}

impl<E: Environment, L: Learner> OffPolicy<E, L> {
    /// Returns a training that has not begun; `learner` makes what learns for observations of a width and actions of a
    /// width; panics when actions are numbered.
    pub(super) fn start(
        play: Play,
        environment: E,
        seed: u64,
        learner: impl FnOnce(usize, usize) -> L,
    ) -> Self {
        let lane = Lanes::new(vec![environment]);
        let Actions::Continuous { count, limit } = lane.actions() else {
            panic!("this algorithm needs continuous actions");
        };
        let width = lane.width();
        Self {
            learner: learner(width, count),
            replay: Replay::new(play.buffer_size, width + count),
            limit,
            places: Generator::new(seed, &["replay"]),
            draws: Generator::new(seed, &["exploration"]),
            steps: 0,
            batch: Batch::default(),
            pair: vec![0.0; width + count],
            next: vec![0.0; width + count],
            done: vec![0.0; count],
            lane,
            play,
        }
    }

    fn step(&mut self, seeds: &mut dyn FnMut(u32) -> u64) {
        self.lane.begin(seeds);
        let width = self.lane.width();
        let (observation, action) = self.pair.split_at_mut(width);
        observation.copy_from_slice(self.lane.observation(0));
        if self.steps < self.play.learning_starts {
            action.iter_mut().for_each(|a| *a = (2.0 * self.draws.unit() - 1.0) as f32);
        } else {
            self.learner.explore(observation, &mut self.draws, action);
        }
        self.done.iter_mut().zip(&*action).for_each(|(done, a)| *done = self.limit * a);
        let step = self.lane.step(0, &self.done, &mut self.next[..width], seeds);
        let (state, next) = (&self.pair, &self.next);
        let terminal = step.terminated;
        self.replay.push(&Transition { state, action: 0, reward: step.reward, next, terminal });
        self.steps += 1;
    }

    pub(super) fn update(&mut self) -> f64 {
        let width = self.lane.width();
        let Batch { states, pairs, nexts, rewards, follows } = &mut self.batch;
        [&mut *states, pairs, nexts, rewards, follows].into_iter().for_each(Vec::clear);
        for _ in 0..self.play.batch_size {
            let row = self.replay.get(self.places.below(self.replay.len()));
            states.extend_from_slice(&row.state[..width]);
            pairs.extend_from_slice(row.state);
            nexts.extend_from_slice(&row.next[..width]);
            rewards.push(row.reward);
            follows.push(if row.terminal { 0.0 } else { 1.0 });
        }
        self.learner.update(&self.batch, &mut self.draws)
    }
}

impl<E: Environment, L: Learner> Trainer for OffPolicy<E, L> {
    fn advance(&mut self, steps: u64, seeds: &mut dyn FnMut(u32) -> u64) -> Progress {
        let mut losses = Losses::default();
        while !self.finished() && self.steps < steps {
            (0..self.play.train_frequency).for_each(|_| self.step(seeds));
            if self.steps > self.play.learning_starts {
                (0..self.play.gradient_steps).for_each(|_| losses.add(self.update(), 0.0));
            }
        }
        Progress { steps: self.steps, loss: losses.take().0, ..self.lane.report() }
    }

    fn steps(&self) -> u64 {
        self.steps
    }

    fn finished(&self) -> bool {
        self.steps >= self.play.total_steps
    }

    fn act(&mut self, observation: &[f32], action: &mut [f32]) {
        self.learner.best(observation, action);
        action.iter_mut().for_each(|a| *a *= self.limit);
    }
}

impl<E: Environment, L: Learner> Persist for OffPolicy<E, L> {
    fn is_finite(&self) -> bool {
        self.learner.is_finite()
    }

    fn is_alive(&mut self) -> bool {
        let (width, actions) = (self.lane.width(), self.done.len());
        let probes = self.replay.probes();
        let states: Vec<f32> =
            probes.chunks(width + actions).flat_map(|row| &row[..width]).copied().collect();
        let rows = (states.len() / width).max(1);
        let outputs = self.learner.outputs(&states);
        depends_on_state(outputs, outputs.len() / rows)
    }
}

impl<E, L: Learner> Learned for OffPolicy<E, L> {
    kept! { Learned { "": learner } }
}

impl<E: Environment, L: Learner> State for OffPolicy<E, L> {
    kept! { State {
        "steps": steps, "": learner, "replay.": replay, "places": places, "draws": draws, "": lane,
    } }
}

/// Returns a network of hidden layers with ReLU, as Stable-Baselines3's for these algorithms.
pub(super) fn network(
    inputs: usize,
    hidden: &[usize],
    outputs: usize,
    last: Activation,
) -> Sequential {
    let layer = |network: Sequential, units: &usize| network.linear(*units, Activation::Relu);
    hidden.iter().fold(Sequential::new(inputs), layer).linear(outputs, last)
}

/// With PyTorch's uniform weights, drawn for a name.
pub(super) fn followed(
    network: Sequential,
    learning_rate: f32,
    adam_epsilon: f32,
    seed: u64,
    name: &str,
) -> Followed<Sequential> {
    let mut draw = Generator::new(seed, &["initial", name]);
    let parameters = network.initial(&|_| Init::Uniform, draw.rng());
    Followed::new(network, parameters, learning_rate, adam_epsilon)
}

#[derive(Debug, Clone)]
pub(super) struct Critics {
    pub(super) both: [Followed<Sequential>; 2],
    /// What both are to become for a batch.
    targets: Vec<f32>,
    by_outputs: Vec<f32>,
    by_inputs: Vec<f32>,
    by_actions: Vec<f32>,
    values: Vec<f32>,
    seen: Vec<f32>,
}

impl Critics {
    pub(super) fn new(
        inputs: usize,
        hidden: &[usize],
        learning_rate: f32,
        adam_epsilon: f32,
        seed: u64,
    ) -> Self {
        let one = |name| {
            let network = network(inputs, hidden, 1, Activation::None);
            followed(network, learning_rate, adam_epsilon, seed, name)
        };
        Self {
            both: [one("critic0"), one("critic1")],
            targets: Vec::new(),
            by_outputs: Vec::new(),
            by_inputs: Vec::new(),
            by_actions: Vec::new(),
            values: Vec::new(),
            seen: Vec::new(),
        }
    }

    /// One step of both towards reward plus `gamma` times the smaller of the slow copies' values of the pairs afterwards,
    /// less `costs`, where anything follows; returns the sum of both mean squared errors.
    /// `weight` is that of each squared error in the loss.
    pub(super) fn learn(
        &mut self,
        batch: &Batch,
        after: &[f32],
        costs: &[f32],
        gamma: f32,
        weight: f32,
    ) -> f64 {
        let count = batch.rewards.len();
        let Self { both, targets, by_outputs, .. } = self;
        let [first, second] = both;
        let a = first.network.forward(&first.target, after);
        let b = second.network.forward(&second.target, after);
        targets.clear();
        targets
            .extend((0..count).map(|i| {
                batch.rewards[i] + batch.follows[i] * gamma * (a[i].min(b[i]) - costs[i])
            }));
        let mut squares = 0.0;
        for critic in both {
            let values = critic.network.forward(&critic.parameters, &batch.pairs);
            by_outputs.clear();
            for (value, target) in values.iter().zip(&*targets) {
                let error = value - target;
                squares += f64::from(error * error) / count as f64;
                by_outputs.push(weight * 2.0 * error / count as f32);
            }
            critic.descend(&batch.pairs, by_outputs, None);
        }
        squares
    }

    /// Returns the smaller value of each of some pairs and its gradient by the action, rows of `actions` numbers; with
    /// `first_only`, the first critic's.
    pub(super) fn by_actions(
        &mut self,
        pairs: &[f32],
        actions: usize,
        first_only: bool,
    ) -> (&[f32], &[f32]) {
        let Self { both, by_outputs, by_inputs, by_actions, values, seen, .. } = self;
        let width = both[0].network.inputs();
        let count = pairs.len() / width;
        by_inputs.resize(pairs.len(), 0.0);
        by_actions.resize(count * actions, 0.0);
        by_outputs.clear();
        by_outputs.resize(count, 1.0);
        values.clear();
        values.resize(count, f32::INFINITY);
        for critic in &mut both[..if first_only { 1 } else { 2 }] {
            seen.clear();
            seen.extend_from_slice(critic.network.forward(&critic.parameters, pairs));
            critic.network.backward_to_inputs(&critic.parameters, by_outputs, by_inputs);
            let rows = by_inputs.chunks_exact(width).zip(by_actions.chunks_exact_mut(actions));
            for ((i, least), (from, to)) in values.iter_mut().enumerate().zip(rows) {
                if seen[i] < *least {
                    *least = seen[i];
                    to.copy_from_slice(&from[width - actions..]);
                }
            }
        }
        (values, by_actions)
    }

    pub(super) fn follow(&mut self, tau: f32) {
        self.both.iter_mut().for_each(|critic| critic.follow(tau));
    }

    pub(super) fn is_finite(&self) -> bool {
        self.both.iter().all(Followed::is_finite)
    }
}

impl Learned for Critics {
    kept! { Learned { "critic": both } }
}

impl State for Critics {
    kept! { State { "critic": both } }
}

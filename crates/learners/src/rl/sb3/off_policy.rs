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

use super::lanes::Lanes;
use super::{Progress, Trainer};
use crate::nn::adam::Adam;
use crate::nn::archive::{Archive, ArchiveError};
use crate::nn::init::Init;
use crate::nn::sequential::Sequential;
use crate::nn::{self, Activation, Network};
use crate::rl::environment::{Actions, Environment};
use crate::rl::persist::{Persist, depends_on_state};
use crate::rl::random::Generator;
use crate::rl::replay::{Replay, Transition};

/// How steps and updates alternate.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Play {
    /// Steps of the training.
    pub total_steps: u64,
    /// Steps in the replay buffer.
    pub buffer_size: usize,
    /// Steps per update.
    pub batch_size: usize,
    /// Steps before the first update, whose actions are uniform.
    pub learning_starts: u64,
    /// Steps between two blocks of updates.
    pub train_frequency: u64,
    /// Updates of a block.
    pub gradient_steps: u32,
}

/// Steps of an update; rows belong together.
#[derive(Debug, Clone, Default)]
pub(super) struct Batch {
    /// Observations, and the same beside the actions that were taken.
    pub(super) states: Vec<f32>,
    pub(super) pairs: Vec<f32>,
    /// Observations afterwards.
    pub(super) nexts: Vec<f32>,
    pub(super) rewards: Vec<f32>,
    /// 1, or 0 where nothing can follow.
    pub(super) follows: Vec<f32>,
}

/// What an algorithm learns, with actions from -1 to 1.
pub trait Learner {
    /// Writes the action of a state while learning.
    fn explore(&mut self, observation: &[f32], draws: &mut Generator, action: &mut [f32]);

    /// Writes the action that is thought best.
    fn best(&mut self, observation: &[f32], action: &mut [f32]);

    /// Returns what the policy says of states, a row each, to see whether it says anything.
    fn outputs(&mut self, observations: &[f32]) -> &[f32];

    /// Learns from a batch and returns the loss of the critics.
    #[expect(private_interfaces, reason = "only algorithms of this folder are learners")]
    fn update(&mut self, batch: &Batch, draws: &mut Generator) -> f64;

    /// Whether all that was learned are numbers.
    fn is_finite(&self) -> bool;

    /// As [`Trainer::learned`].
    fn learned(&self, prefix: &str, archive: &mut Archive);

    /// As [`Trainer::load`].
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] when it does not fit.
    fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError>;

    /// As [`Trainer::save`].
    fn save(&self, prefix: &str, archive: &mut Archive);

    /// As [`Trainer::restore`].
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] when it does not fit.
    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError>;
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
    /// width.
    ///
    /// # Panics
    ///
    /// When actions are numbered.
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

    /// Plays one step.
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

    /// One update; returns the loss of the critics.
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
        let (mut loss, mut losses) = (0.0, 0u32);
        while !self.finished() && self.steps < steps {
            for _ in 0..self.play.train_frequency {
                self.step(seeds);
            }
            if self.steps > self.play.learning_starts {
                for _ in 0..self.play.gradient_steps {
                    loss += self.update();
                    losses += 1;
                }
            }
        }
        let loss = (losses > 0).then(|| loss / f64::from(losses));
        Progress { steps: self.steps, loss, ..self.lane.report() }
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

    fn learned(&self, prefix: &str, archive: &mut Archive) {
        self.learner.learned(prefix, archive);
    }

    fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        self.learner.load(prefix, archive)
    }

    fn save(&self, prefix: &str, archive: &mut Archive) {
        archive.put(&format!("{prefix}steps"), self.steps);
        self.learner.save(prefix, archive);
        self.replay.save(prefix, archive);
        self.places.save(&format!("{prefix}places"), archive);
        self.draws.save(&format!("{prefix}draws"), archive);
        self.lane.save(prefix, archive);
    }

    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        self.steps = archive.get(&format!("{prefix}steps"))?;
        self.learner.restore(prefix, archive)?;
        self.replay.restore(prefix, archive)?;
        self.places.restore(&format!("{prefix}places"), archive)?;
        self.draws.restore(&format!("{prefix}draws"), archive)?;
        self.lane.restore(prefix, archive)
    }
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

/// A network's parameters and those of its slow copy, with an optimiser.
#[derive(Debug, Clone)]
pub(super) struct Followed {
    pub(super) network: Sequential,
    pub(super) parameters: Vec<f32>,
    pub(super) target: Vec<f32>,
    pub(super) gradient: Vec<f32>,
    adam: Adam,
}

impl Followed {
    pub(super) fn new(
        network: Sequential,
        learning_rate: f32,
        adam_epsilon: f32,
        seed: u64,
        labels: &[&str],
    ) -> Self {
        let mut draw = Generator::new(seed, labels);
        let parameters = network.initial(&|_| Init::Uniform, draw.rng());
        Self {
            network,
            target: parameters.clone(),
            gradient: vec![0.0; parameters.len()],
            adam: Adam::new(parameters.len(), learning_rate, adam_epsilon),
            parameters,
        }
    }

    /// One step of Adam against the gradient by the outputs of the last forward pass of these inputs, cut to a norm.
    pub(super) fn descend(&mut self, inputs: &[f32], by_outputs: &[f32], max_norm: Option<f32>) {
        self.network.backward(&self.parameters, inputs, by_outputs, &mut self.gradient);
        self.adam.step(&mut self.parameters, &self.gradient, max_norm);
    }

    /// Returns the outputs of one row of inputs.
    pub(super) fn values(&mut self, inputs: &[f32]) -> &[f32] {
        self.network.single(&self.parameters, inputs)
    }

    /// Moves the slow copy by a share.
    pub(super) fn follow(&mut self, tau: f32) {
        self.target
            .iter_mut()
            .zip(&self.parameters)
            .for_each(|(t, p)| *t = tau.mul_add(*p - *t, *t));
    }

    pub(super) fn is_finite(&self) -> bool {
        self.parameters.iter().all(|p| p.is_finite()) && self.adam.is_finite()
    }

    pub(super) fn learned(&self, prefix: &str, archive: &mut Archive) {
        nn::save(&self.network, &self.parameters, prefix, archive);
    }

    pub(super) fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        self.parameters = nn::load(&self.network, prefix, archive)?;
        self.target.copy_from_slice(&self.parameters);
        Ok(())
    }

    pub(super) fn save(&self, prefix: &str, archive: &mut Archive) {
        let shape = [self.parameters.len()];
        archive.put_f32(format!("{prefix}parameters"), &shape, &self.parameters);
        archive.put_f32(format!("{prefix}target"), &shape, &self.target);
        self.adam.save(prefix, archive);
    }

    pub(super) fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        let shape = [self.parameters.len()];
        self.parameters.copy_from_slice(archive.f32(&format!("{prefix}parameters"), &shape)?);
        self.target.copy_from_slice(archive.f32(&format!("{prefix}target"), &shape)?);
        self.adam.restore(prefix, archive)
    }
}

/// Two critics.
#[derive(Debug, Clone)]
pub(super) struct Critics {
    pub(super) both: [Followed; 2],
    /// What both are to become for a batch.
    targets: Vec<f32>,
    by_outputs: Vec<f32>,
    /// Gradients by the inputs, of one critic and of the one that counts.
    by_inputs: Vec<f32>,
    by_actions: Vec<f32>,
    /// Values of pairs, of the critic that counts and of one.
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
            Followed::new(network, learning_rate, adam_epsilon, seed, &["initial", name])
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
    ///
    /// # Arguments
    ///
    /// * `weight` — of each squared error in the loss.
    pub(super) fn learn(
        &mut self,
        batch: &Batch,
        after: &[f32],
        costs: &[f32],
        gamma: f32,
        weight: f32,
    ) -> f64 {
        let count = batch.rewards.len();
        let [first, second] = &mut self.both;
        let a = first.network.forward(&first.target, after);
        let b = second.network.forward(&second.target, after);
        self.targets.clear();
        self.targets
            .extend((0..count).map(|i| {
                batch.rewards[i] + batch.follows[i] * gamma * (a[i].min(b[i]) - costs[i])
            }));
        let mut squares = 0.0;
        for critic in &mut self.both {
            let values = critic.network.forward(&critic.parameters, &batch.pairs);
            self.by_outputs.clear();
            for (value, target) in values.iter().zip(&self.targets) {
                let error = value - target;
                squares += f64::from(error * error) / count as f64;
                self.by_outputs.push(weight * 2.0 * error / count as f32);
            }
            critic.descend(&batch.pairs, &self.by_outputs, None);
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
        let width = self.both[0].network.inputs();
        let count = pairs.len() / width;
        self.by_inputs.resize(pairs.len(), 0.0);
        self.by_actions.resize(count * actions, 0.0);
        self.by_outputs.clear();
        self.by_outputs.resize(count, 1.0);
        self.values.clear();
        self.values.resize(count, f32::INFINITY);
        for critic in &mut self.both[..if first_only { 1 } else { 2 }] {
            self.seen.clear();
            self.seen.extend_from_slice(critic.network.forward(&critic.parameters, pairs));
            critic
                .network
                .backward_to_inputs(&critic.parameters, &self.by_outputs, &mut self.by_inputs);
            let rows =
                self.by_inputs.chunks_exact(width).zip(self.by_actions.chunks_exact_mut(actions));
            for ((i, least), (from, to)) in self.values.iter_mut().enumerate().zip(rows) {
                if self.seen[i] < *least {
                    *least = self.seen[i];
                    to.copy_from_slice(&from[width - actions..]);
                }
            }
        }
        (&self.values, &self.by_actions)
    }

    pub(super) fn follow(&mut self, tau: f32) {
        self.both.iter_mut().for_each(|critic| critic.follow(tau));
    }

    pub(super) fn is_finite(&self) -> bool {
        self.both.iter().all(Followed::is_finite)
    }

    pub(super) fn each(&self, mut what: impl FnMut(&Followed, &str)) {
        self.both
            .iter()
            .zip(["critic0.", "critic1."])
            .for_each(|(critic, name)| what(critic, name));
    }

    pub(super) fn try_each(
        &mut self,
        mut what: impl FnMut(&mut Followed, &str) -> Result<(), ArchiveError>,
    ) -> Result<(), ArchiveError> {
        self.both
            .iter_mut()
            .zip(["critic0.", "critic1."])
            .try_for_each(|(critic, name)| what(critic, name))
    }
}

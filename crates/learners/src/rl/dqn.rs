//! Deep Q-learning (Mnih et al., 2015): what PFRL's and Stable-Baselines3's have in common, and what they differ in.
//!
//! - **Loss**: mean Huber loss (delta 1).
//! - **Target network**: copied every so many transitions, before the update of that transition.
//! - **Ties** go to the first action.
//!
//! PFRL's, which RESCO uses, is fed step by step ([`Dqn::observe`]); Stable-Baselines3's is [`super::sb3::dqn`].

use basics::setting::settings;

use super::Followed;
use super::depends_on_both;
use super::persist::Persist;
use super::random::Generator;
use super::replay::{Replay, Transition};
use super::{Losses, huber, largest};
use crate::nn::archive::{Archive, ArchiveError};
use crate::nn::state::{Learned, State, kept};
use crate::nn::{Network, TILE};

settings! {
    /// Hyper-parameters of `dqn`; the defaults are Stable-Baselines3's, which hardly learn this task.
    pub struct Settings, source "Stable-Baselines3 2.9, DQN" {
        /// Steps of the training.
        total_steps: u64 = 100_000, in 1.0..=1e9, unit "steps",
            source "Jayawardana et al., 2022, give none for this task";
        /// Step size of Adam.
        learning_rate: f32 = 1e-4, in 1e-8..=1.0;
        /// Adam's epsilon, added to the root of the second moment.
        adam_epsilon: f32 = 1e-8, in 1e-12..=1.0;
        /// Discount per step.
        gamma: f32 = 0.99, in 0.0..=1.0;
        /// Steps in the replay buffer.
        buffer_size: usize = 1_000_000, in 1.0..=1e8, unit "steps";
        /// Steps per update, drawn with replacement.
        batch_size: usize = 32, in 1.0..=4096.0, unit "steps";
        /// Steps before the first update, in which actions are random.
        learning_starts: u64 = 100, in 0.0..=1e9, unit "steps";
        /// Steps between two blocks of updates.
        train_frequency: u64 = 4, in 1.0..=1e6, unit "steps";
        /// Updates of a block.
        gradient_steps: u32 = 1, in 1.0..=1e6, unit "updates";
        /// Steps between two copies into the target network.
        target_network_frequency: u64 = 10_000, in 1.0..=1e9, unit "steps";
        /// Share of random actions at the beginning.
        start_epsilon: f64 = 1.0, in 0.0..=1.0;
        /// Share of random actions at the end.
        end_epsilon: f64 = 0.05, in 0.0..=1.0;
        /// Share of the training over which the share of random actions falls linearly.
        exploration_fraction: f64 = 0.1, in 0.0..=1.0;
        /// Largest Euclidean norm of the gradient.
        max_grad_norm: f32 = 10.0, in 1e-6..=1e9;
        /// Units of both hidden layers.
        hidden: usize = 64, in 1.0..=1024.0, unit "units";
    }
}

/// Whose choices are made where implementations differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flavour {
    /// Batches without repetition, and gradients that are not cut.
    Pfrl {
        /// Whether the online network chooses the action that the target network values (Van Hasselt et al., 2016).
        double: bool,
    },
    /// Batches with repetition, and gradients cut to a norm.
    StableBaselines3,
}

/// A learner of action values.
#[derive(Debug, Clone)]
pub struct Dqn<N> {
    settings: Settings,
    flavour: Flavour,
    pub(super) learned: Followed<N>,
    target: Target,
    pub(super) replay: Replay,
    pub(super) transitions: u64,
    draws: Generator,
    exploration: Generator,
    losses: Losses,
    places: Vec<usize>,
    states: Vec<f32>,
    output_gradient: Vec<f32>,
}

impl<N: Network> Dqn<N> {
    /// Returns a learner that starts from these parameters; `seed` and `labels` name its randomness.
    pub fn new(
        network: N,
        parameters: Vec<f32>,
        settings: Settings,
        flavour: Flavour,
        seed: u64,
        labels: &[&str],
    ) -> Self {
        let generator = |last: &'static str| Generator::new(seed, &[labels, &[last]].concat());
        let Settings { learning_rate, adam_epsilon, buffer_size, batch_size, .. } = settings;
        Self {
            replay: Replay::new(buffer_size, network.inputs()),
            learned: Followed::new(network, parameters, learning_rate, adam_epsilon),
            target: Target::default(),
            transitions: 0,
            draws: generator("replay"),
            exploration: generator("exploration"),
            losses: Losses::default(),
            places: vec![0; batch_size],
            states: Vec::new(),
            output_gradient: Vec::new(),
            settings,
            flavour,
        }
    }

    /// Returns the values of the actions in a state.
    pub fn values(&mut self, state: &[f32]) -> &[f32] {
        self.learned.values(state)
    }

    /// Returns the action of the highest value.
    pub fn greedy(&mut self, state: &[f32]) -> usize {
        largest(self.values(state))
    }

    /// Returns a random one of `actions` actions with probability `epsilon`, otherwise the greedy one.
    pub fn explore(&mut self, state: &[f32], actions: usize, epsilon: f64) -> usize {
        if self.exploration.unit() < epsilon {
            self.exploration.below(actions)
        } else {
            self.greedy(state)
        }
    }

    /// Stores a transition, and updates when it is time.
    pub fn observe(&mut self, transition: &Transition<'_>) {
        self.store(transition);
        let enough = self.settings.learning_starts.max(self.settings.batch_size as u64);
        if self.replay.len() as u64 >= enough
            && self.transitions.is_multiple_of(self.settings.train_frequency)
        {
            self.update();
        }
    }

    /// Copies into the target network when it is time.
    pub(super) fn store(&mut self, transition: &Transition<'_>) {
        self.target.forget(self.replay.push(transition));
        self.transitions += 1;
        if self.transitions.is_multiple_of(self.settings.target_network_frequency) {
            self.learned.target.copy_from_slice(&self.learned.parameters);
            self.target.forget_all();
        }
    }

    pub(super) fn update(&mut self) {
        let Self { settings, learned, target, replay, places, states, output_gradient, .. } = self;
        let is_double = self.flavour == Flavour::Pfrl { double: true };
        let max_norm = match self.flavour {
            Flavour::Pfrl { .. } => {
                replay.draw(places, &mut self.draws);
                None
            }
            Flavour::StableBaselines3 => {
                places.fill_with(|| self.draws.below(replay.len()));
                Some(settings.max_grad_norm)
            }
        };
        target.value(places, replay, learned, is_double);
        states.clear();
        places.iter().for_each(|p| states.extend_from_slice(replay.get(*p).state));
        let actions = learned.network.outputs();
        output_gradient.clear();
        output_gradient.resize(places.len() * actions, 0.0);
        let values = learned.forward(states);
        let share = 1.0 / places.len() as f32;
        let mut loss = 0.0;
        for (row, place) in places.iter().enumerate() {
            let Transition { action, reward, .. } = replay.get(*place);
            let at = row * actions + action;
            let error = values[at] - (reward + settings.gamma * target.values[*place]);
            loss += f64::from(huber(error) * share);
            output_gradient[at] = error.clamp(-1.0, 1.0) * share;
        }
        learned.descend(states, output_gradient, max_norm);
        self.losses.add(loss, 0.0);
    }

    /// Returns the mean loss of the updates since it was last asked for; `None` without an update.
    pub fn take_loss(&mut self) -> Option<f64> {
        self.losses.take().0
    }

    /// Returns the number of transitions observed.
    pub fn transitions(&self) -> u64 {
        self.transitions
    }
}

impl<N: Network> Persist for Dqn<N> {
    fn is_finite(&self) -> bool {
        self.learned.is_finite()
    }

    fn is_alive(&mut self) -> bool {
        let actions = self.learned.network.outputs();
        depends_on_both(self.learned.forward(&self.replay.probes()), actions)
    }
}

impl<N: Network> Learned for Dqn<N> {
    fn learned(&self, prefix: &str, archive: &mut Archive) {
        self.learned.learned(prefix, archive);
    }

    fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        self.target.forget_all();
        self.learned.load(prefix, archive)
    }
}

impl<N: Network> State for Dqn<N> {
    kept! { State {
        "transitions": transitions, "": learned, "replay.": replay, "": target, "draws": draws,
        "exploration": exploration,
    } }
}

/// What the target network says of stored transitions. Until its next copy that stays the same, so that it is computed once.
#[derive(Debug, Clone, Default)]
struct Target {
    values: Vec<f32>,
    /// Place up to which the network has been asked ahead.
    ahead: usize,
    states: Vec<f32>,
    asked: Vec<usize>,
    choices: Vec<usize>,
}

impl Target {
    fn forget_all(&mut self) {
        self.values.clear();
        self.ahead = 0;
    }

    fn forget(&mut self, place: usize) {
        if let Some(value) = self.values.get_mut(place) {
            *value = f32::NAN;
        }
    }

    /// Asks the target network for what it has not been asked since its last copy; where `is_double`, the online network
    /// chooses the action that it values, and has changed.
    fn value<N: Network>(
        &mut self,
        places: &[usize],
        replay: &Replay,
        learned: &mut Followed<N>,
        is_double: bool,
    ) {
        let Self { values, ahead, states, asked, choices } = self;
        values.resize(replay.len(), f32::NAN);
        states.clear();
        asked.clear();
        for place in places.iter().copied() {
            let transition = replay.get(place);
            if transition.terminal {
                values[place] = 0.0;
            } else if is_double || values[place].is_nan() {
                asked.push(place);
                states.extend_from_slice(transition.next);
            }
        }
        if asked.is_empty() {
            return;
        }
        // A tile costs the same however few rows it has: ask ahead for what will be drawn later.
        while !is_double && !asked.len().is_multiple_of(TILE) && *ahead < replay.len() {
            let transition = replay.get(*ahead);
            if values[*ahead].is_nan() && !transition.terminal && !asked.contains(ahead) {
                asked.push(*ahead);
                states.extend_from_slice(transition.next);
            }
            *ahead += 1;
        }
        let Followed { network, parameters, target, .. } = learned;
        let actions = network.outputs();
        choices.clear();
        if is_double {
            choices.extend(network.forward(parameters, states).chunks_exact(actions).map(largest));
        }
        let rows = network.forward(target, states).chunks_exact(actions);
        for (i, (place, row)) in asked.iter().zip(rows).enumerate() {
            values[*place] = row[choices.get(i).copied().unwrap_or_else(|| largest(row))];
        }
    }
}

/// It is computed again.
impl State for Target {
    fn save(&self, _: &str, _: &mut Archive) {}

    fn restore(&mut self, _: &str, _: &Archive) -> Result<(), ArchiveError> {
        self.forget_all();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::schedule::linear_epsilon;
    use super::*;
    use crate::nn::Activation;
    use crate::nn::init::Init;
    use crate::nn::sequential::Sequential;

    fn settings() -> Settings {
        Settings {
            learning_rate: 1e-3,
            adam_epsilon: 1e-8,
            gamma: 0.9,
            buffer_size: 500,
            batch_size: 16,
            learning_starts: 16,
            train_frequency: 1,
            target_network_frequency: 50,
            ..Settings::default()
        }
    }

    const FLAVOURS: [Flavour; 3] = [
        Flavour::Pfrl { double: false },
        Flavour::Pfrl { double: true },
        Flavour::StableBaselines3,
    ];

    fn learner(units: usize, flavour: Flavour) -> Dqn<Sequential> {
        let network =
            Sequential::new(5).linear(units, Activation::Relu).linear(2, Activation::None);
        let mut draw = Generator::new(3, &["initial"]);
        let parameters = network.initial(&|_| Init::Uniform, draw.rng());
        Dqn::new(network, parameters, settings(), flavour, 3, &[])
    }

    /// A value per action that is the parameter itself: `Q(s, a) = w_a s + b_a` with one input.
    fn table(flavour: Flavour) -> Dqn<Sequential> {
        let network = Sequential::new(1).linear(2, Activation::None);
        let settings = Settings {
            batch_size: 1,
            learning_starts: 1,
            buffer_size: 1,
            target_network_frequency: 2,
            ..settings()
        };
        Dqn::new(network, vec![1.0, 2.0, 0.0, 0.0], settings, flavour, 1, &[])
    }

    #[test]
    fn loss_and_target_are_those_computed_by_hand() {
        for flavour in FLAVOURS {
            // Q(s, .) = (s, 2 s): at s = 3 the best is 6, so y = -1 + 0.9 * 6 = 4.4; Q(2, 0) = 2;
            // the error of -2.4 is on the linear part of the Huber loss: 1.9.
            let mut dqn = table(flavour);
            let transition = Transition {
                state: &[2.0],
                action: 0,
                reward: -1.0,
                next: &[3.0],
                terminal: false,
            };
            dqn.observe(&transition);
            assert!((dqn.take_loss().unwrap() - 1.9).abs() < 1e-6);
            // Adam's first step is the learning rate, in the direction of the sign.
            let moved = [1.001, 2.0, 0.001, 0.0];
            let parameters = dqn.learned.parameters.iter();
            parameters.zip(moved).for_each(|(p, m)| assert!((p - m).abs() < 1e-6));
            // A terminal state is worth nothing: y = -1, and Q(2, 1) = 4; the loss is 4.5.
            let mut dqn = table(flavour);
            dqn.observe(&Transition { action: 1, terminal: true, ..transition });
            assert!((dqn.take_loss().unwrap() - 4.5).abs() < 1e-6);
        }
    }

    #[test]
    fn the_target_network_lags_until_its_copy() {
        let (state, next) = (&[2.0], &[1.0]);
        let transition = Transition { state, action: 0, reward: 0.0, next, terminal: false };
        let mut dqn = table(FLAVOURS[0]);
        dqn.observe(&transition);
        assert_eq!(dqn.learned.target, [1.0, 2.0, 0.0, 0.0]);
        let after_one = dqn.learned.parameters.clone();
        // The copy of the second transition comes before its update.
        dqn.observe(&transition);
        assert_eq!(dqn.learned.target, after_one);
        assert_ne!(dqn.learned.parameters, after_one);
    }

    #[test]
    fn double_learning_values_the_online_network_s_choice() {
        let mut dqn = table(FLAVOURS[1]);
        dqn.learned.target = vec![5.0, 3.0, 0.0, 0.0];
        // Online prefers action 1 at s = 1, which the target network values at 3, not at 5.
        let (state, next) = (&[0.0], &[1.0]);
        dqn.observe(&Transition { state, action: 0, reward: 0.0, next, terminal: false });
        assert!((dqn.target.values[0] - 3.0).abs() < 1e-6);
    }

    /// Five states in a row, two actions; the right end pays 1 and ends the episode.
    fn corridor(state: usize, action: usize) -> (usize, f32, bool) {
        let next = if action == 1 { state + 1 } else { state.saturating_sub(1) };
        (next.min(4), if next == 4 { 1.0 } else { 0.0 }, next == 4)
    }

    fn one_hot(state: usize) -> [f32; 5] {
        std::array::from_fn(|i| f32::from(u8::from(i == state)))
    }

    fn walk(dqn: &mut Dqn<Sequential>, decisions: u64, state: &mut usize) {
        for t in 0..decisions {
            let epsilon = linear_epsilon(1.0, 0.3, 2000, t);
            let action = dqn.explore(&one_hot(*state), 2, epsilon);
            let (next, reward, terminal) = corridor(*state, action);
            dqn.observe(&Transition {
                state: &one_hot(*state),
                action,
                reward,
                next: &one_hot(next),
                terminal,
            });
            *state = if terminal { 0 } else { next };
        }
    }

    #[test]
    fn a_tabular_problem_is_solved_to_its_exact_values() {
        for flavour in &FLAVOURS[..2] {
            let mut dqn = learner(32, *flavour);
            walk(&mut dqn, 6000, &mut 0);
            for state in 0..4 {
                let right = 0.9f32.powi(3 - state);
                let left = 0.9 * 0.9f32.powi(3 - (state - 1).max(0));
                let values = dqn.values(&one_hot(state as usize));
                assert!((values[1] - right).abs() < 0.05, "{state}: {values:?}, {right}");
                assert!((values[0] - left).abs() < 0.05, "{state}: {values:?}, {left}");
            }
        }
    }
}

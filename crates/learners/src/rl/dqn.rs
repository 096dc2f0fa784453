//! Deep Q-learning (Mnih et al., 2015).
//!
//! Choices where implementations differ, all PFRL's, which RESCO uses:
//! - **Loss**: mean Huber loss (delta 1), no clipping of gradients.
//! - **Target network**: copied every so many transitions, counted before the transition is stored and
//!   before the update of that transition.
//! - **Ties** go to the first action.
//!
//! What the target network says of a stored transition stays the same until its next copy, so it is
//! computed once and kept beside the transition.

mod persist;
mod target;

use self::target::Target;
use super::random::Generator;
use super::replay::{Replay, Transition};
use super::values::{huber, largest};
use crate::nn::Network;
use crate::nn::adam::Adam;

/// Settings of the algorithm.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Step size of Adam.
    pub learning_rate: f32,
    /// Adam's epsilon.
    pub adam_epsilon: f32,
    /// Discount per decision.
    pub gamma: f32,
    /// Transitions in the replay buffer.
    pub buffer_size: usize,
    /// Transitions per update.
    pub batch_size: usize,
    /// Transitions stored before the first update.
    pub learning_starts: usize,
    /// Transitions between two updates.
    pub train_frequency: u64,
    /// Transitions between two copies into the target network.
    pub target_network_frequency: u64,
    /// Whether the online network chooses the action that the target network values.
    pub double_dqn: bool,
}

/// A learner of action values.
#[derive(Debug, Clone)]
pub struct Dqn<N> {
    network: N,
    settings: Settings,
    parameters: Vec<f32>,
    target: Target,
    adam: Adam,
    replay: Replay,
    transitions: u64,
    draws: Generator,
    exploration: Generator,
    loss_sum: f64,
    losses: u32,
    buffers: Buffers,
}

/// Numbers of one update.
#[derive(Debug, Clone, Default)]
struct Buffers {
    places: Vec<usize>,
    states: Vec<f32>,
    output_gradient: Vec<f32>,
    gradient: Vec<f32>,
}

impl<N: Network> Dqn<N> {
    /// Returns a learner that starts from these parameters; `seed` and `labels` name its randomness.
    pub fn new(
        network: N,
        parameters: Vec<f32>,
        settings: Settings,
        seed: u64,
        labels: &[&str],
    ) -> Self {
        let label = |last: &'static str| [labels, &[last]].concat();
        Self {
            adam: Adam::new(parameters.len(), settings.learning_rate, settings.adam_epsilon),
            replay: Replay::new(settings.buffer_size, network.inputs()),
            target: Target::new(parameters.clone()),
            transitions: 0,
            draws: Generator::new(seed, &label("replay")),
            exploration: Generator::new(seed, &label("exploration")),
            loss_sum: 0.0,
            losses: 0,
            buffers: Buffers {
                places: vec![0; settings.batch_size],
                gradient: vec![0.0; parameters.len()],
                ..Buffers::default()
            },
            network,
            settings,
            parameters,
        }
    }

    /// Returns the values of the actions in a state.
    pub fn values(&mut self, state: &[f32]) -> &[f32] {
        self.network.single(&self.parameters, state)
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
        self.transitions += 1;
        if self.transitions.is_multiple_of(self.settings.target_network_frequency) {
            self.target.copy(&self.parameters);
        }
        let place = self.replay.push(transition);
        self.target.forget(place, self.replay.len());
        if self.replay.len() >= self.settings.learning_starts.max(self.settings.batch_size)
            && self.transitions.is_multiple_of(self.settings.train_frequency)
        {
            self.update();
        }
    }

    /// One gradient step on a batch of stored transitions.
    fn update(&mut self) {
        let mut places = std::mem::take(&mut self.buffers.places);
        self.replay.draw(&mut places, &mut self.draws);
        let Self { network, replay, parameters, settings, target, .. } = self;
        if settings.double_dqn {
            target.value_doubly(&places, replay, network, parameters);
        } else {
            target.value(&places, replay, network);
        }
        let Buffers { states, output_gradient, gradient, .. } = &mut self.buffers;
        states.clear();
        places.iter().for_each(|p| states.extend_from_slice(replay.get(*p).state));
        let outputs = network.outputs();
        output_gradient.clear();
        output_gradient.resize(places.len() * outputs, 0.0);
        let values = network.forward(parameters, states);
        let share = 1.0 / places.len() as f32;
        let mut loss = 0.0;
        for (row, place) in places.iter().enumerate() {
            let transition = replay.get(*place);
            let goal = transition.reward + settings.gamma * target.values[*place];
            let at = row * outputs + transition.action;
            let error = values[at] - goal;
            loss += f64::from(huber(error) * share);
            output_gradient[at] = error.clamp(-1.0, 1.0) * share;
        }
        network.backward(parameters, states, output_gradient, gradient);
        self.adam.step(parameters, gradient, None);
        self.loss_sum += loss;
        self.losses += 1;
        self.buffers.places = places;
    }

    /// Returns the mean loss of the updates since it was last asked for; `None` without an update.
    pub fn take_loss(&mut self) -> Option<f64> {
        let mean = (self.losses > 0).then(|| self.loss_sum / f64::from(self.losses));
        (self.loss_sum, self.losses) = (0.0, 0);
        mean
    }

    /// Returns the number of transitions observed.
    pub fn transitions(&self) -> u64 {
        self.transitions
    }
}

#[cfg(test)]
mod tests {
    use super::super::schedule::linear_epsilon;
    use super::*;
    use crate::nn::Activation;
    use crate::nn::archive::Archive;
    use crate::nn::init::Init;
    use crate::nn::sequential::Sequential;
    use crate::rl::persist::Persist;

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
            double_dqn: false,
        }
    }

    fn learner(network: Sequential, settings: Settings) -> Dqn<Sequential> {
        let mut draw = Generator::new(3, &["initial"]);
        let parameters = network.initial(&|_| Init::Uniform, draw.rng());
        Dqn::new(network, parameters, settings, 3, &[])
    }

    /// A value per action that is the parameter itself: `Q(s, a) = w_a s + b_a` with one input.
    fn table(double_dqn: bool, parameters: [f32; 4]) -> Dqn<Sequential> {
        let network = Sequential::new(1).linear(2, Activation::None);
        let settings = Settings {
            batch_size: 1,
            learning_starts: 1,
            buffer_size: 1,
            target_network_frequency: 2,
            double_dqn,
            ..settings()
        };
        Dqn::new(network, parameters.to_vec(), settings, 1, &[])
    }

    #[test]
    fn loss_and_target_are_those_computed_by_hand() {
        for double_dqn in [false, true] {
            // Q(s, .) = (s, 2 s): at s = 3 the best is 6, so y = -1 + 0.9 * 6 = 4.4; Q(2, 0) = 2;
            // the error of -2.4 is on the linear part of the Huber loss: 1.9.
            let mut dqn = table(double_dqn, [1.0, 2.0, 0.0, 0.0]);
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
            dqn.parameters.iter().zip(moved).for_each(|(p, m)| assert!((p - m).abs() < 1e-6));
            // A terminal state is worth nothing: y = -1, and Q(2, 1) = 4; the loss is 4.5.
            let mut dqn = table(double_dqn, [1.0, 2.0, 0.0, 0.0]);
            dqn.observe(&Transition { action: 1, terminal: true, ..transition });
            assert!((dqn.take_loss().unwrap() - 4.5).abs() < 1e-6);
        }
    }

    #[test]
    fn the_target_network_lags_until_its_copy() {
        let (state, next) = (&[2.0], &[1.0]);
        let transition = Transition { state, action: 0, reward: 0.0, next, terminal: false };
        let mut dqn = table(false, [1.0, 2.0, 0.0, 0.0]);
        dqn.observe(&transition);
        assert_eq!(dqn.target.parameters, [1.0, 2.0, 0.0, 0.0]);
        let after_one = dqn.parameters.clone();
        // The copy of the second transition comes before its update.
        dqn.observe(&transition);
        assert_eq!(dqn.target.parameters, after_one);
        assert_ne!(dqn.parameters, after_one);
    }

    #[test]
    fn double_learning_values_the_online_network_s_choice() {
        let mut dqn = table(true, [1.0, 2.0, 0.0, 0.0]);
        dqn.target.parameters = vec![5.0, 3.0, 0.0, 0.0];
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
        for double_dqn in [false, true] {
            let network =
                Sequential::new(5).linear(32, Activation::Relu).linear(2, Activation::None);
            let mut dqn = learner(network, Settings { double_dqn, ..settings() });
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

    #[test]
    fn a_restored_learner_goes_on_with_the_same_bytes() {
        let network = || Sequential::new(5).linear(8, Activation::Relu).linear(2, Activation::None);
        let mut one = learner(network(), settings());
        let mut state = 0;
        walk(&mut one, 700, &mut state);
        let mut archive = Archive::default();
        one.save("a.", &mut archive);
        let mut other = learner(network(), settings());
        other.restore("a.", &archive).unwrap();
        let mut same = state;
        walk(&mut one, 300, &mut state);
        walk(&mut other, 300, &mut same);
        let (mut a, mut b) = (Archive::default(), Archive::default());
        one.save("", &mut a);
        other.save("", &mut b);
        assert!(a.to_bytes() == b.to_bytes());
    }
}

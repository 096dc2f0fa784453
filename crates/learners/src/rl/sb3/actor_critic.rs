//! A policy and a value of states: two networks that share nothing but their inputs, and what the policy's outputs mean.

use super::HIDDEN_LAYERS;
use super::distribution::Distribution;
use crate::nn::adam::Adam;
use crate::nn::archive::{Archive, ArchiveError};
use crate::nn::init::Init;
use crate::nn::sequential::Sequential;
use crate::nn::{self, Activation, Network};
use crate::rl::environment::Actions;
use crate::rl::random::Generator;

/// Gains of the orthogonal weights: of hidden layers, of the policy's last and of the value's last.
const GAINS: [f32; 3] = [std::f32::consts::SQRT_2, 0.01, 1.0];

/// Both networks and their parameters: the policy's, the value's, the logarithms of the policy's deviations, which start
/// at 0.
#[derive(Debug, Clone)]
pub(super) struct ActorCritic {
    policy: Sequential,
    value: Sequential,
    pub(super) distribution: Distribution,
    pub(super) parameters: Vec<f32>,
    pub(super) gradient: Vec<f32>,
    adam: Adam,
}

/// What both networks say of some states.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outputs<'a> {
    /// Of the policy, a row per state; see [`Distribution`].
    pub(super) policy: &'a [f32],
    /// Logarithms of the deviations of actions.
    pub(super) log_std: &'a [f32],
    /// Values, one per state.
    pub(super) values: &'a [f32],
}

impl ActorCritic {
    /// Returns networks of hidden layers of these sizes with hyperbolic tangents.
    pub(super) fn new(
        width: usize,
        actions: Actions,
        hidden: usize,
        adam_epsilon: f32,
        seed: u64,
    ) -> Self {
        let network = |outputs| {
            let layer = |network: Sequential, _| network.linear(hidden, Activation::Tanh);
            let network = (0..HIDDEN_LAYERS).fold(Sequential::new(width), layer);
            network.linear(outputs, Activation::None)
        };
        let (policy, value) = (network(actions.outputs()), network(1));
        let mut parameters = Vec::new();
        for (name, network, gain) in [("policy", &policy, GAINS[1]), ("value", &value, GAINS[2])] {
            let init =
                |layer| Init::Orthogonal(if layer == HIDDEN_LAYERS { gain } else { GAINS[0] });
            let mut draw = Generator::new(seed, &["initial", name]);
            parameters.extend(network.initial(&init, draw.rng()));
        }
        parameters.extend(std::iter::repeat_n(0.0, Distribution::parameters(actions)));
        Self {
            policy,
            value,
            distribution: Distribution::new(actions),
            gradient: vec![0.0; parameters.len()],
            adam: Adam::new(parameters.len(), 0.0, adam_epsilon),
            parameters,
        }
    }

    /// Returns the parameters of the policy, of the value, and the logarithms of deviations.
    fn split(&self) -> (&[f32], &[f32], &[f32]) {
        let (policy, rest) = self.parameters.split_at(self.policy.parameters());
        let (value, log_std) = rest.split_at(self.value.parameters());
        (policy, value, log_std)
    }

    /// Returns where the parameters of the policy's network are, and where the logarithms of its deviations are.
    pub(super) fn of_policy(&self) -> [std::ops::Range<usize>; 2] {
        let (policy, value) = (self.policy.parameters(), self.value.parameters());
        [0..policy, policy + value..self.parameters.len()]
    }

    /// Draws an action in a state and returns the logarithm of its probability.
    pub(super) fn draw(
        &mut self,
        state: &[f32],
        generator: &mut Generator,
        action: &mut [f32],
    ) -> f32 {
        let (policy, rest) = self.parameters.split_at(self.policy.parameters());
        let log_std = &rest[self.value.parameters()..];
        self.distribution.draw(self.policy.single(policy, state), log_std, generator, action)
    }

    /// Writes the most likely action in a state.
    pub(super) fn best(&mut self, state: &[f32], action: &mut [f32]) {
        let policy = self.policy.parameters();
        self.distribution.best(self.policy.single(&self.parameters[..policy], state), action);
    }

    /// Whether the policy says something of the state.
    pub(super) fn is_alive(&mut self, states: &[f32]) -> bool {
        let policy = self.policy.parameters();
        self.distribution.is_alive(self.policy.forward(&self.parameters[..policy], states))
    }

    /// Returns the values of states.
    pub(super) fn values(&mut self, states: &[f32]) -> &[f32] {
        let (start, end) =
            (self.policy.parameters(), self.policy.parameters() + self.value.parameters());
        self.value.forward(&self.parameters[start..end], states)
    }

    /// Returns what both networks say of the states of a minibatch.
    pub(super) fn forward(&mut self, states: &[f32]) -> Outputs<'_> {
        let (policy, rest) = self.parameters.split_at(self.policy.parameters());
        let (value, log_std) = rest.split_at(self.value.parameters());
        let values = self.value.forward(value, states);
        Outputs { policy: self.policy.forward(policy, states), log_std, values }
    }

    /// Returns the numbers of an observation.
    pub(super) fn inputs(&self) -> usize {
        self.policy.inputs()
    }

    /// Returns what the policy says of states, the logarithms of its deviations, and what both mean.
    pub(super) fn say(&mut self, states: &[f32]) -> (&[f32], &[f32], &mut Distribution) {
        let (policy, rest) = self.parameters.split_at(self.policy.parameters());
        let log_std = &rest[self.value.parameters()..];
        (self.policy.forward(policy, states), log_std, &mut self.distribution)
    }

    /// One step of Adam against the value's gradient by values, after [`Self::values`] of these states; the policy stays.
    pub(super) fn descend_value(&mut self, states: &[f32], by_values: &[f32], learning_rate: f32) {
        let (start, end) =
            (self.policy.parameters(), self.policy.parameters() + self.value.parameters());
        // Where the gradient is always 0, Adam's moments are, and nothing moves.
        self.gradient.fill(0.0);
        let (value, gradient) = (&self.parameters[start..end], &mut self.gradient[start..end]);
        self.value.backward(value, states, by_values, gradient);
        self.descend(learning_rate, None);
    }

    /// Returns how the policy's outputs move when its parameters, those of the network, do, after [`Self::forward`].
    pub(super) fn tangent(&mut self, states: &[f32], direction: &[f32]) -> &[f32] {
        let policy = self.policy.parameters();
        self.policy.tangent(&self.parameters[..policy], states, direction)
    }

    /// Writes into `gradient` that of the policy's network by an outputs' gradient, after [`Self::forward`].
    pub(super) fn back_policy(&mut self, states: &[f32], by_outputs: &[f32], gradient: &mut [f32]) {
        let policy = self.policy.parameters();
        self.policy.backward(&self.parameters[..policy], states, by_outputs, gradient);
    }

    /// Writes the gradient of all parameters, after [`Self::forward`].
    pub(super) fn back(
        &mut self,
        states: &[f32],
        by_outputs: &[f32],
        by_log_std: &[f32],
        by_values: &[f32],
    ) {
        let (policy, rest) = self.parameters.split_at(self.policy.parameters());
        let (value, _) = rest.split_at(self.value.parameters());
        let (policy_gradient, rest) = self.gradient.split_at_mut(policy.len());
        let (value_gradient, log_std_gradient) = rest.split_at_mut(value.len());
        self.policy.backward(policy, states, by_outputs, policy_gradient);
        self.value.backward(value, states, by_values, value_gradient);
        log_std_gradient.copy_from_slice(by_log_std);
    }

    /// One step of Adam against the gradient, which may be cut to a norm.
    pub(super) fn descend(&mut self, learning_rate: f32, max_grad_norm: impl Into<Option<f32>>) {
        self.adam.set_learning_rate(learning_rate);
        self.adam.step(&mut self.parameters, &self.gradient, max_grad_norm.into());
    }

    pub(super) fn is_finite(&self) -> bool {
        self.parameters.iter().all(|p| p.is_finite()) && self.adam.is_finite()
    }

    pub(super) fn learned(&self, prefix: &str, archive: &mut Archive) {
        let (policy, value, log_std) = self.split();
        nn::save(&self.policy, policy, &format!("{prefix}policy."), archive);
        nn::save(&self.value, value, &format!("{prefix}value."), archive);
        if !log_std.is_empty() {
            archive.put_f32(format!("{prefix}policy.log_std"), &[log_std.len()], log_std);
        }
    }

    pub(super) fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        let mut parameters = nn::load(&self.policy, &format!("{prefix}policy."), archive)?;
        parameters.extend(nn::load(&self.value, &format!("{prefix}value."), archive)?);
        let free = self.parameters.len() - parameters.len();
        if free > 0 {
            let name = format!("{prefix}policy.log_std");
            let log_std = archive.f32(&name, &[free])?;
            if log_std.iter().any(|l| !l.is_finite()) {
                return Err(ArchiveError::NotFinite(name));
            }
            parameters.extend_from_slice(log_std);
        }
        self.parameters = parameters;
        Ok(())
    }

    pub(super) fn save(&self, prefix: &str, archive: &mut Archive) {
        let shape = [self.parameters.len()];
        archive.put_f32(format!("{prefix}parameters"), &shape, &self.parameters);
        self.adam.save(prefix, archive);
    }

    pub(super) fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        let shape = [self.parameters.len()];
        let parameters = archive.f32(&format!("{prefix}parameters"), &shape)?;
        self.parameters.copy_from_slice(parameters);
        self.adam.restore(prefix, archive)
    }
}

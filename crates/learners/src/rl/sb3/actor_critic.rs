//! A policy and a value of states: two networks that share nothing but their inputs.

use super::HIDDEN_LAYERS;
use crate::nn::adam::Adam;
use crate::nn::archive::{Archive, ArchiveError};
use crate::nn::init::Init;
use crate::nn::sequential::Sequential;
use crate::nn::{self, Activation, Network};
use crate::rl::random::Generator;

/// Gains of the orthogonal weights: of hidden layers, of the policy's last and of the value's last.
const GAINS: [f32; 3] = [std::f32::consts::SQRT_2, 0.01, 1.0];

/// Both networks and their parameters, the policy's first.
#[derive(Debug, Clone)]
pub(super) struct ActorCritic {
    policy: Sequential,
    value: Sequential,
    parameters: Vec<f32>,
    gradient: Vec<f32>,
    adam: Adam,
}

impl ActorCritic {
    /// Returns networks of hidden layers of these sizes with hyperbolic tangents.
    pub(super) fn new(
        width: usize,
        actions: usize,
        hidden: usize,
        adam_epsilon: f32,
        seed: u64,
    ) -> Self {
        let network = |outputs| {
            let layer = |network: Sequential, _| network.linear(hidden, Activation::Tanh);
            let network = (0..HIDDEN_LAYERS).fold(Sequential::new(width), layer);
            network.linear(outputs, Activation::None)
        };
        let (policy, value) = (network(actions), network(1));
        let mut parameters = Vec::new();
        for (name, network, gain) in [("policy", &policy, GAINS[1]), ("value", &value, GAINS[2])] {
            let init =
                |layer| Init::Orthogonal(if layer == HIDDEN_LAYERS { gain } else { GAINS[0] });
            let mut draw = Generator::new(seed, &["initial", name]);
            parameters.extend(network.initial(&init, draw.rng()));
        }
        Self {
            policy,
            value,
            gradient: vec![0.0; parameters.len()],
            adam: Adam::new(parameters.len(), 0.0, adam_epsilon),
            parameters,
        }
    }

    /// Returns the logits of the actions in one state.
    pub(super) fn logits(&mut self, state: &[f32]) -> &[f32] {
        let policy = self.policy.parameters();
        self.policy.single(&self.parameters[..policy], state)
    }

    /// Returns the values of states.
    pub(super) fn values(&mut self, states: &[f32]) -> &[f32] {
        let policy = self.policy.parameters();
        self.value.forward(&self.parameters[policy..], states)
    }

    /// Returns the logits and the values of the states of a minibatch.
    pub(super) fn forward(&mut self, states: &[f32]) -> (&[f32], &[f32]) {
        let (policy, value) = self.parameters.split_at(self.policy.parameters());
        (self.policy.forward(policy, states), self.value.forward(value, states))
    }

    /// One step of Adam against the gradients by logits and values, after [`Self::forward`].
    pub(super) fn descend(
        &mut self,
        states: &[f32],
        by_logits: &[f32],
        by_values: &[f32],
        learning_rate: f32,
        max_grad_norm: f32,
    ) {
        let count = self.policy.parameters();
        let (policy, value) = self.parameters.split_at(count);
        let (policy_gradient, value_gradient) = self.gradient.split_at_mut(count);
        self.policy.backward(policy, states, by_logits, policy_gradient);
        self.value.backward(value, states, by_values, value_gradient);
        self.adam.set_learning_rate(learning_rate);
        self.adam.step(&mut self.parameters, &self.gradient, Some(max_grad_norm));
    }

    pub(super) fn is_finite(&self) -> bool {
        self.parameters.iter().all(|p| p.is_finite()) && self.adam.is_finite()
    }

    pub(super) fn learned(&self, prefix: &str, archive: &mut Archive) {
        let (policy, value) = self.parameters.split_at(self.policy.parameters());
        nn::save(&self.policy, policy, &format!("{prefix}policy."), archive);
        nn::save(&self.value, value, &format!("{prefix}value."), archive);
    }

    pub(super) fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        let mut parameters = nn::load(&self.policy, &format!("{prefix}policy."), archive)?;
        parameters.extend(nn::load(&self.value, &format!("{prefix}value."), archive)?);
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

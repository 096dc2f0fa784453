//! A policy and a value of states: two networks that share nothing but their inputs, and what the policy's outputs mean.

use std::ops::Range;

use super::HIDDEN_LAYERS;
use super::distribution::{Distribution, Flavour};
use crate::nn::adam::Adam;
use crate::nn::archive::{Archive, ArchiveError};
use crate::nn::init::Init;
use crate::nn::sequential::Sequential;
use crate::nn::state::{Learned, State, kept};
use crate::nn::{self, Activation, Network};
use crate::rl::environment::Actions;
use crate::rl::random::Generator;

/// Gains of the orthogonal weights: of hidden layers, of the policy's last and of the value's last.
const GAINS: [f32; 3] = [std::f32::consts::SQRT_2, 0.01, 1.0];

/// Both networks and their parameters: the policy's, the value's, the logarithms of the policy's deviations, first 0.
#[derive(Debug, Clone)]
pub(in crate::rl) struct ActorCritic {
    policy: Sequential,
    /// `None` where the policy's last output is the value.
    value: Option<Sequential>,
    pub(super) distribution: Distribution,
    pub(in crate::rl) parameters: Vec<f32>,
    pub(super) gradient: Vec<f32>,
    adam: Adam,
    /// Of one network for both: its outputs, without the values and the values, and their gradient.
    outputs: Vec<f32>,
    values: Vec<f32>,
    joined: Vec<f32>,
}

/// What both networks say of some states: the policy a row per state, see [`Distribution`], the logarithms of the deviations
/// of actions, and the values of the states.
pub(super) type Outputs<'a> = [&'a [f32]; 3];

impl ActorCritic {
    /// Hidden layers have hyperbolic tangents.
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
        let distribution = Distribution::new(actions, Flavour::StableBaselines3);
        Self::of(policy, Some(value), distribution, parameters, adam_epsilon)
    }

    /// Returns one network for both, as PFRL's: logits of numbered actions, then the value.
    pub(in crate::rl) fn joint(
        network: Sequential,
        parameters: Vec<f32>,
        adam_epsilon: f32,
    ) -> Self {
        let actions = Actions::Numbered(network.outputs() - 1);
        let distribution = Distribution::new(actions, Flavour::Pfrl);
        Self::of(network, None, distribution, parameters, adam_epsilon)
    }

    fn of(
        policy: Sequential,
        value: Option<Sequential>,
        distribution: Distribution,
        parameters: Vec<f32>,
        adam_epsilon: f32,
    ) -> Self {
        Self {
            policy,
            value,
            distribution,
            gradient: vec![0.0; parameters.len()],
            adam: Adam::new(parameters.len(), 0.0, adam_epsilon),
            parameters,
            outputs: Vec::new(),
            values: Vec::new(),
            joined: Vec::new(),
        }
    }

    fn places(&self) -> [Range<usize>; 3] {
        let policy = self.policy.parameters();
        let end = policy + self.value.as_ref().map_or(0, Network::parameters);
        [0..policy, policy..end, end..self.parameters.len()]
    }

    pub(super) fn of_policy(&self) -> [Range<usize>; 2] {
        let [policy, _, log_std] = self.places();
        [policy, log_std]
    }

    pub(in crate::rl) fn draw(
        &mut self,
        state: &[f32],
        generator: &mut Generator,
        action: &mut [f32],
    ) -> f32 {
        let [policy, _, log_std] = self.places().map(|place| &self.parameters[place]);
        let outputs = &self.policy.single(policy, state)[..self.distribution.outputs()];
        self.distribution.draw(outputs, log_std, generator, action)
    }

    pub(in crate::rl) fn best(&mut self, state: &[f32], action: &mut [f32]) {
        let [policy, ..] = self.places().map(|place| &self.parameters[place]);
        let outputs = &self.policy.single(policy, state)[..self.distribution.outputs()];
        self.distribution.best(outputs, action);
    }

    pub(in crate::rl) fn is_alive(&mut self, states: &[f32]) -> bool {
        let outputs = self.forward(states)[0].to_vec();
        self.distribution.is_alive(&outputs)
    }

    pub(in crate::rl) fn values(&mut self, states: &[f32]) -> &[f32] {
        if self.value.is_none() {
            return self.forward(states)[2];
        }
        let [_, of_value, _] = self.places();
        let value = self.value.as_mut().expect("it is there");
        value.forward(&self.parameters[of_value], states)
    }

    /// Writes the logarithms of the probabilities of actions in the states of the last [`Self::values`], where one network
    /// gives both; those of PFRL's are computed before an update, not when an action is drawn.
    pub(super) fn logs(&mut self, actions: &[f32], logs: &mut [f32]) {
        if self.value.is_none() {
            let rows = self.outputs.chunks_exact(self.distribution.outputs());
            for ((row, action), log) in rows.zip(actions).zip(logs) {
                *log = self.distribution.log(row, &[], &[*action]);
            }
        }
    }

    pub(super) fn forward(&mut self, states: &[f32]) -> Outputs<'_> {
        let [policy, of_value, log_std] = self.places().map(|place| &self.parameters[place]);
        let policy = self.policy.forward(policy, states);
        let Some(value) = &mut self.value else {
            self.outputs.clear();
            self.values.clear();
            let actions = self.distribution.outputs();
            for row in policy.chunks_exact(actions + 1) {
                self.outputs.extend_from_slice(&row[..actions]);
                self.values.push(row[actions]);
            }
            return [&self.outputs, log_std, &self.values];
        };
        [policy, log_std, value.forward(of_value, states)]
    }

    pub(super) fn say(&mut self, states: &[f32]) -> (&[f32], &[f32], &mut Distribution) {
        let [policy, _, log_std] = self.places().map(|place| &self.parameters[place]);
        (self.policy.forward(policy, states), log_std, &mut self.distribution)
    }

    /// One step of Adam against the value's gradient by values, after [`Self::values`] of these states; the policy stays.
    pub(super) fn descend_value(&mut self, states: &[f32], by_values: &[f32], learning_rate: f32) {
        // Where the gradient is always 0, Adam's moments are, and nothing moves.
        self.gradient.fill(0.0);
        let [_, place, _] = self.places();
        if let Some(value) = &mut self.value {
            let gradient = &mut self.gradient[place.clone()];
            value.backward(&self.parameters[place], states, by_values, gradient);
        }
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

    pub(super) fn back(
        &mut self,
        states: &[f32],
        by_outputs: &[f32],
        by_log_std: &[f32],
        by_values: &[f32],
    ) {
        let [policy, of_value, log_std] = self.places();
        let mut by_policy = by_outputs;
        match &mut self.value {
            Some(value) => {
                let gradient = &mut self.gradient[of_value.clone()];
                value.backward(&self.parameters[of_value], states, by_values, gradient);
            }
            None => {
                self.joined.clear();
                let rows = by_outputs.chunks_exact(self.distribution.outputs()).zip(by_values);
                rows.for_each(|(row, value)| self.joined.extend(row.iter().chain([value])));
                by_policy = &self.joined;
            }
        }
        let gradient = &mut self.gradient[policy.clone()];
        self.policy.backward(&self.parameters[policy], states, by_policy, gradient);
        self.gradient[log_std].copy_from_slice(by_log_std);
    }

    /// One step of Adam against the gradient, which may be cut to a norm.
    pub(super) fn descend(&mut self, learning_rate: f32, max_grad_norm: impl Into<Option<f32>>) {
        self.adam.learning_rate = learning_rate;
        self.adam.step(&mut self.parameters, &self.gradient, max_grad_norm.into());
    }

    pub(in crate::rl) fn is_finite(&self) -> bool {
        self.parameters.iter().all(|p| p.is_finite()) && self.adam.is_finite()
    }
}

/// One network for both has no names of parts.
impl Learned for ActorCritic {
    fn learned(&self, prefix: &str, archive: &mut Archive) {
        let [policy, of_value, log_std] = self.places().map(|place| &self.parameters[place]);
        let Some(value) = &self.value else {
            return nn::save(&self.policy, policy, prefix, archive);
        };
        nn::save(&self.policy, policy, &format!("{prefix}policy."), archive);
        nn::save(value, of_value, &format!("{prefix}value."), archive);
        if !log_std.is_empty() {
            archive.put_f32(format!("{prefix}policy.log_std"), &[log_std.len()], log_std);
        }
    }

    fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        let Some(value) = &self.value else {
            self.parameters = nn::load(&self.policy, prefix, archive)?;
            return Ok(());
        };
        let mut parameters = nn::load(&self.policy, &format!("{prefix}policy."), archive)?;
        parameters.extend(nn::load(value, &format!("{prefix}value."), archive)?);
        let free = self.parameters.len() - parameters.len();
        if free > 0 {
            parameters.extend(archive.finite(&format!("{prefix}policy.log_std"), &[free])?);
        }
        self.parameters = parameters;
        Ok(())
    }
}

impl State for ActorCritic {
    kept! { State { "parameters": parameters, "": adam } }
}

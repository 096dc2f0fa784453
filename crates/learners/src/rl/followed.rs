//! A network's parameters with their optimiser, and a copy of them that lags behind.

use crate::nn::adam::Adam;
use crate::nn::archive::{Archive, ArchiveError};
use crate::nn::state::{Learned, State, kept};
use crate::nn::{self, Network};

/// A network, its parameters and those of its slow copy.
#[derive(Debug, Clone)]
pub(super) struct Followed<N> {
    pub(super) network: N,
    pub(super) parameters: Vec<f32>,
    pub(super) target: Vec<f32>,
    pub(super) gradient: Vec<f32>,
    adam: Adam,
}

impl<N: Network> Followed<N> {
    pub(super) fn new(network: N, parameters: Vec<f32>, rate: f32, adam_epsilon: f32) -> Self {
        Self {
            network,
            target: parameters.clone(),
            gradient: vec![0.0; parameters.len()],
            adam: Adam::new(parameters.len(), rate, adam_epsilon),
            parameters,
        }
    }

    /// One step of Adam against the gradient by the outputs of the last forward pass of these inputs, cut to a norm.
    pub(super) fn descend(&mut self, inputs: &[f32], by_outputs: &[f32], max_norm: Option<f32>) {
        self.network.backward(&self.parameters, inputs, by_outputs, &mut self.gradient);
        self.adam.step(&mut self.parameters, &self.gradient, max_norm);
    }

    /// Returns the outputs of rows of inputs.
    pub(super) fn forward(&mut self, inputs: &[f32]) -> &[f32] {
        self.network.forward(&self.parameters, inputs)
    }

    /// Returns the outputs of one row of inputs.
    pub(super) fn values(&mut self, inputs: &[f32]) -> &[f32] {
        self.network.single(&self.parameters, inputs)
    }

    /// Moves the slow copy by a share.
    pub(super) fn follow(&mut self, tau: f32) {
        let both = self.target.iter_mut().zip(&self.parameters);
        both.for_each(|(t, p)| *t = tau.mul_add(*p - *t, *t));
    }

    pub(super) fn is_finite(&self) -> bool {
        self.parameters.iter().all(|p| p.is_finite()) && self.adam.is_finite()
    }
}

impl<N: Network> Learned for Followed<N> {
    fn learned(&self, prefix: &str, archive: &mut Archive) {
        nn::save(&self.network, &self.parameters, prefix, archive);
    }

    fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        self.parameters = nn::load(&self.network, prefix, archive)?;
        self.target.copy_from_slice(&self.parameters);
        Ok(())
    }
}

impl<N> State for Followed<N> {
    kept! { State { "parameters": parameters, "target": target, "": adam } }
}

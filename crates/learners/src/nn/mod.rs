//! Small neural networks on one thread: what the learners need and nothing else.
//!
//! A [`Network`] knows shapes and keeps the buffers of its last pass; its parameters are one flat vector that the caller
//! holds. So a target network is a second vector, and saving, copying and optimising are one line each. Backward passes are
//! derived by hand and checked against finite differences.

pub mod adam;
pub mod archive;
pub mod frap;
pub mod init;
mod kernel;
mod product;
pub mod sequential;
pub mod state;

use std::ops::Range;

pub use kernel::Activation;
pub use sequential::TILE;

use archive::{Archive, ArchiveError};

/// A named part of a network's flat vector of parameters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// Name, such as `layer0.weight`.
    pub name: String,
    /// Shape, row-major; weights are `[inputs, outputs]`.
    pub shape: Vec<usize>,
    /// Place in the flat vector.
    pub range: Range<usize>,
}

/// A differentiable function of a batch of rows, with its parameters outside.
pub trait Network {
    /// Numbers per row that go in.
    fn inputs(&self) -> usize;

    /// Numbers per row that come out.
    fn outputs(&self) -> usize;

    /// Number of parameters.
    fn parameters(&self) -> usize;

    /// Returns the parts of the vector of parameters, which together are all of it.
    fn parts(&self) -> Vec<Part>;

    /// Returns the outputs, shape `[rows, outputs]`, of inputs of shape `[rows, inputs]`, and keeps
    /// what [`Self::backward`] needs.
    fn forward(&mut self, parameters: &[f32], inputs: &[f32]) -> &[f32];

    /// Returns the outputs of a single row, as acting needs them; there is no backward pass of it.
    fn single(&mut self, parameters: &[f32], inputs: &[f32]) -> &[f32];

    /// Writes the gradient of `sum(outputs * output_gradient)` by the parameters into `gradient`.
    /// Belongs to the last [`Self::forward`], with the same parameters and inputs.
    fn backward(
        &mut self,
        parameters: &[f32],
        inputs: &[f32],
        output_gradient: &[f32],
        gradient: &mut [f32],
    );
}

/// Adds the parameters of a network to an archive, part by part.
pub fn save(network: &impl Network, parameters: &[f32], prefix: &str, archive: &mut Archive) {
    for part in network.parts() {
        archive.put_f32(format!("{prefix}{}", part.name), &part.shape, &parameters[part.range]);
    }
}

/// Returns the parameters of a network; fails where a part is missing, has another shape, or a number in it is none.
pub fn load(
    network: &impl Network,
    prefix: &str,
    archive: &Archive,
) -> Result<Vec<f32>, ArchiveError> {
    let mut parameters = vec![0.0; network.parameters()];
    for part in network.parts() {
        let values = archive.finite(&format!("{prefix}{}", part.name), &part.shape)?;
        parameters[part.range].copy_from_slice(&values);
    }
    Ok(parameters)
}

fn linear_parts(name: &str, offset: usize, inputs: usize, outputs: usize) -> [Part; 2] {
    let (middle, end) = (offset + inputs * outputs, offset + (inputs + 1) * outputs);
    [
        Part {
            name: format!("{name}.weight"),
            shape: vec![inputs, outputs],
            range: offset..middle,
        },
        Part { name: format!("{name}.bias"), shape: vec![outputs], range: middle..end },
    ]
}

/// Makes room for `length` numbers; only ever grows, so that a steady loop does not allocate.
fn room(buffer: &mut Vec<f32>, length: usize) -> &mut [f32] {
    if buffer.len() < length {
        buffer.resize(length, 0.0);
    }
    &mut buffer[..length]
}

#[cfg(test)]
pub(crate) mod testing {
    //! Gradient checks.

    use super::Network;

    /// Checks that the parts of a network are its whole vector, in order.
    pub(crate) fn check_parts(network: &impl Network) {
        let mut end = 0;
        for part in network.parts() {
            assert_eq!(part.range.start, end, "{}", part.name);
            assert_eq!(part.range.len(), part.shape.iter().product::<usize>(), "{}", part.name);
            end = part.range.end;
        }
        assert_eq!(end, network.parameters());
    }

    /// Checks the gradient of every part against central differences, in a direction of the outputs: the length of the
    /// difference must be small against that of the gradient, so that
    /// a part with small gradients counts as much as one with large ones.
    pub(crate) fn check_gradient(
        network: &mut impl Network,
        parameters: &[f32],
        inputs: &[f32],
        direction: &[f32],
    ) {
        let mut gradient = vec![f32::NAN; network.parameters()];
        network.forward(parameters, inputs);
        network.backward(parameters, inputs, direction, &mut gradient);
        let parts = network.parts();
        let mut value = |p: &[f32]| -> f64 {
            let outputs = network.forward(p, inputs);
            let terms = outputs.iter().zip(direction).filter(|(_, d)| **d != 0.0);
            terms.map(|(y, d)| f64::from(*y) * f64::from(*d)).sum()
        };
        let step = 1e-3f32;
        for part in parts {
            let (mut length, mut difference) = (0.0, 0.0);
            for i in part.range {
                let mut p = parameters.to_vec();
                p[i] = parameters[i] + step;
                let up = value(&p);
                p[i] = parameters[i] - step;
                let slope = (up - value(&p)) / (2.0 * f64::from(step));
                length += slope * slope;
                difference += (slope - f64::from(gradient[i])).powi(2);
            }
            // A ReLU that switches within the step bends the function there.
            assert!(length.sqrt() > 0.01, "{}: nothing to check, {}", part.name, length.sqrt());
            let error = (difference / length).sqrt();
            assert!(error < 0.05, "{}: off by {error}", part.name);
        }
    }
}

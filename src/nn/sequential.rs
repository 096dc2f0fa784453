//! Networks of layers one after the other: linear maps, and a 2 x 2 convolution in front.

use rand_chacha::ChaCha8Rng;

use super::init::Init;
use super::kernel::{Activation, add_bias_gradient, add_weight_gradient, affine, input_gradient};
use super::{Network, Part, linear_parts, room};

/// Pixels of a 2 x 2 kernel.
const KERNEL: usize = 4;

/// What a layer does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Map {
    /// All inputs to all outputs.
    Linear,
    /// A 2 x 2 kernel over an image of one channel, stride 1, no padding; outputs are ordered by
    /// position, then channel.
    Convolution { width: usize, positions: usize, channels: usize },
}

#[derive(Debug, Clone)]
struct Layer {
    map: Map,
    inputs: usize,
    outputs: usize,
    activation: Activation,
    /// Where its weights, then its biases, begin in the flat vector.
    offset: usize,
    values: Vec<f32>,
    gradient: Vec<f32>,
}

impl Layer {
    /// Inputs and outputs of the matrix of weights.
    fn shape(&self) -> (usize, usize) {
        match self.map {
            Map::Linear => (self.inputs, self.outputs),
            Map::Convolution { channels, .. } => (KERNEL, channels),
        }
    }

    fn parameters(&self) -> usize {
        let (inputs, outputs) = self.shape();
        (inputs + 1) * outputs
    }

    /// Returns weights and biases.
    fn split<'a>(&self, parameters: &'a [f32]) -> (&'a [f32], &'a [f32]) {
        let (inputs, outputs) = self.shape();
        parameters[self.offset..][..self.parameters()].split_at(inputs * outputs)
    }
}

/// Layers one after the other.
#[derive(Debug, Clone)]
pub struct Sequential {
    layers: Vec<Layer>,
    inputs: usize,
    outputs: usize,
    parameters: usize,
    /// Patches of images, shape `[rows * positions, 4]`.
    patches: Vec<f32>,
}

impl Sequential {
    /// Returns a network without layers for rows of `inputs` numbers.
    pub fn new(inputs: usize) -> Self {
        Self { layers: vec![], inputs, outputs: inputs, parameters: 0, patches: vec![] }
    }

    /// Adds a linear map.
    #[must_use]
    pub fn linear(self, outputs: usize, activation: Activation) -> Self {
        self.layer(Map::Linear, outputs, activation)
    }

    /// Adds a 2 x 2 convolution of an image of one channel with `width` columns; only in front.
    ///
    /// # Panics
    ///
    /// When it is not the first layer or the image is smaller than the kernel.
    #[must_use]
    pub fn convolution(self, width: usize, channels: usize, activation: Activation) -> Self {
        let height = self.inputs / width;
        assert!(self.layers.is_empty() && width >= 2 && height >= 2, "no image of 2 x 2 or more");
        let positions = (height - 1) * (width - 1);
        let map = Map::Convolution { width, positions, channels };
        self.layer(map, positions * channels, activation)
    }

    fn layer(mut self, map: Map, outputs: usize, activation: Activation) -> Self {
        let layer = Layer {
            map,
            inputs: self.outputs,
            outputs,
            activation,
            offset: self.parameters,
            values: vec![],
            gradient: vec![],
        };
        self.outputs = outputs;
        self.parameters += layer.parameters();
        self.layers.push(layer);
        self
    }

    /// Returns parameters to start from; `init` says how for the layer of a number.
    pub fn initial(&self, init: &dyn Fn(usize) -> Init, rng: &mut ChaCha8Rng) -> Vec<f32> {
        let mut parameters = Vec::with_capacity(self.parameters);
        for (i, layer) in self.layers.iter().enumerate() {
            let (inputs, outputs) = layer.shape();
            init(i).layer(inputs, outputs, rng, &mut parameters);
        }
        parameters
    }
}

impl Network for Sequential {
    fn inputs(&self) -> usize {
        self.inputs
    }

    fn outputs(&self) -> usize {
        self.outputs
    }

    fn parameters(&self) -> usize {
        self.parameters
    }

    fn parts(&self) -> Vec<Part> {
        let parts = self.layers.iter().enumerate().map(|(i, layer)| {
            let (inputs, outputs) = layer.shape();
            linear_parts(&format!("layer{i}"), layer.offset, inputs, outputs)
        });
        parts.flatten().collect()
    }

    fn forward(&mut self, parameters: &[f32], inputs: &[f32]) -> &[f32] {
        let rows = inputs.len() / self.inputs;
        for i in 0..self.layers.len() {
            let (before, rest) = self.layers.split_at_mut(i);
            let layer = &mut rest[0];
            let x = before.last().map_or(inputs, |l| &l.values[..rows * l.outputs]);
            let (w, bias) = layer.split(parameters);
            let length = rows * layer.outputs;
            let (map, activation) = (layer.map, layer.activation);
            let x = match map {
                Map::Linear => x,
                Map::Convolution { width, positions, .. } => {
                    let patches = room(&mut self.patches, rows * positions * KERNEL);
                    cut_patches(x, width, layer.inputs, patches);
                    patches
                }
            };
            let y = room(&mut layer.values, length);
            affine(x, w, bias, y);
            activation.apply(y);
        }
        let last = self.layers.last().expect("a network has a layer");
        &last.values[..rows * last.outputs]
    }

    fn backward(
        &mut self,
        parameters: &[f32],
        inputs: &[f32],
        output_gradient: &[f32],
        gradient: &mut [f32],
    ) {
        gradient.fill(0.0);
        let rows = inputs.len() / self.inputs;
        let last = self.layers.last_mut().expect("a network has a layer");
        room(&mut last.gradient, output_gradient.len()).copy_from_slice(output_gradient);
        for i in (0..self.layers.len()).rev() {
            let (before, rest) = self.layers.split_at_mut(i);
            let layer = &mut rest[0];
            let length = rows * layer.outputs;
            let dy = &mut layer.gradient[..length];
            layer.activation.gradient(&layer.values[..length], dy);
            let (x, batch) = match (before.last(), layer.map) {
                (_, Map::Convolution { positions, .. }) => {
                    (&self.patches[..rows * positions * KERNEL], rows * positions)
                }
                (Some(l), Map::Linear) => (&l.values[..rows * l.outputs], rows),
                (None, Map::Linear) => (inputs, rows),
            };
            let dy = &layer.gradient[..length];
            let (w, _) = layer.split(parameters);
            let (dw, dbias) = gradient[layer.offset..][..layer.parameters()].split_at_mut(w.len());
            add_weight_gradient(x, dy, dw, batch);
            add_bias_gradient(dy, dbias);
            if let Some(previous) = before.last_mut() {
                let dx = room(&mut previous.gradient, rows * layer.inputs);
                input_gradient(dy, w, dx, rows, 0.0);
            }
        }
    }
}

/// Cuts images of `size` numbers and `width` columns into their 2 x 2 patches.
fn cut_patches(images: &[f32], width: usize, size: usize, patches: &mut [f32]) {
    let mut patches = patches.chunks_exact_mut(KERNEL);
    for image in images.chunks_exact(size) {
        for (upper, lower) in image.chunks_exact(width).zip(image.chunks_exact(width).skip(1)) {
            for (up, low) in upper.windows(2).zip(lower.windows(2)) {
                let patch = patches.next().expect("there is room for every patch");
                patch.copy_from_slice(&[up[0], up[1], low[0], low[1]]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::super::testing::{check_gradient, check_parts};
    use super::*;

    fn random(count: usize, seed: u64) -> Vec<f32> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..count).map(|_| rng.random_range(-1.0..1.0)).collect()
    }

    /// IDQN's network for a signal of four lanes.
    fn idqn() -> Sequential {
        Sequential::new(20)
            .convolution(5, 6, Activation::Relu)
            .linear(7, Activation::Relu)
            .linear(3, Activation::None)
    }

    #[test]
    fn gradients_are_those_of_finite_differences() {
        for rows in [1, 5] {
            let mut network = idqn();
            let parameters = random(network.parameters(), 1);
            let inputs = random(rows * 20, 2);
            check_gradient(&mut network, &parameters, &inputs, &random(rows * 3, 3));
        }
    }

    #[test]
    fn a_convolution_is_a_sum_over_patches() {
        // Image 3 x 2, kernel (1, 10; 100, 1000), bias 0.5.
        let mut network = Sequential::new(6).convolution(2, 1, Activation::None);
        let outputs = network
            .forward(&[1.0, 10.0, 100.0, 1000.0, 0.5], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
            .to_vec();
        assert_eq!(outputs, [4321.5, 6543.5]);
    }

    #[test]
    fn rows_do_not_depend_on_each_other() {
        let mut network = idqn();
        let parameters = random(network.parameters(), 1);
        let inputs = random(8 * 20, 2);
        let all = network.forward(&parameters, &inputs).to_vec();
        for row in 0..8 {
            let one = network.forward(&parameters, &inputs[row * 20..][..20]).to_vec();
            for (a, b) in one.iter().zip(&all[row * 3..]) {
                assert!((a - b).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn as_many_parameters_are_drawn_as_there_are() {
        let network = idqn();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let parameters = network.initial(&|_| Init::Uniform, &mut rng);
        assert_eq!(parameters.len(), network.parameters());
        assert_eq!(network.parameters(), 5 * 6 + (72 + 1) * 7 + 8 * 3);
        check_parts(&network);
    }
}

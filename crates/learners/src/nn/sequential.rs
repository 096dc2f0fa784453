//! Networks of layers one after the other: linear maps, and a 2 x 2 convolution in front.

use rand_chacha::ChaCha8Rng;

use super::convolution::{Image, KERNEL};
use super::init::Init;
use super::kernel::{Activation, affine};
use super::tile::{
    TILE, bias_gradient, from_tile, input_gradient, linear, linear_more, to_tile, weight_gradient,
};
use super::{Network, Part, linear_parts, room};

/// What a layer does.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Map {
    /// All inputs to all outputs.
    Linear,
    /// A 2 x 2 kernel over an image of one channel, stride 1, no padding; outputs are ordered by
    /// channel, then position.
    Convolution(Image),
}

#[derive(Debug, Clone)]
struct Layer {
    map: Map,
    inputs: usize,
    outputs: usize,
    activation: Activation,
    /// Where its weights, then its biases, begin in the flat vector.
    offset: usize,
    /// Outputs of every tile of the last forward pass.
    values: Vec<f32>,
    /// Outputs of a single row.
    single: Vec<f32>,
}

impl Layer {
    /// Inputs and outputs of the matrix of weights.
    fn shape(&self) -> (usize, usize) {
        match &self.map {
            Map::Linear => (self.inputs, self.outputs),
            Map::Convolution(image) => (KERNEL, image.channels),
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
    /// Inputs of every tile.
    input: Vec<f32>,
    output: Vec<f32>,
    scratch: Vec<f32>,
    tangent: Vec<f32>,
}

impl Sequential {
    /// Returns a network without layers for rows of `inputs` numbers.
    pub fn new(inputs: usize) -> Self {
        Self {
            layers: vec![],
            inputs,
            outputs: inputs,
            parameters: 0,
            input: vec![],
            output: vec![],
            scratch: vec![],
            tangent: vec![],
        }
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
        let image = Image::new(height, width, channels);
        let outputs = image.positions() * channels;
        self.layer(Map::Convolution(image), outputs, activation)
    }

    fn layer(mut self, map: Map, outputs: usize, activation: Activation) -> Self {
        let layer = Layer {
            map,
            inputs: self.outputs,
            outputs,
            activation,
            offset: self.parameters,
            values: vec![],
            single: vec![],
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

impl Sequential {
    /// Returns how the outputs move when the parameters move in a direction: `J d`, shape `[rows, outputs]`.
    ///
    /// Belongs to the last [`Network::forward`], with the same parameters and inputs.
    pub fn tangent(&mut self, parameters: &[f32], inputs: &[f32], direction: &[f32]) -> &[f32] {
        let count = inputs.len() / self.inputs;
        let widest = self.layers.iter().map(|l| l.outputs).max().unwrap_or(0);
        room(&mut self.tangent, count * self.outputs);
        let (mut before_it, mut moved) =
            room(&mut self.scratch, 2 * widest * TILE).split_at_mut(widest * TILE);
        for tile in 0..count.div_ceil(TILE) {
            for i in 0..self.layers.len() {
                let (before, rest) = self.layers.split_at_mut(i);
                let layer = &mut rest[0];
                let x = match before.last_mut() {
                    Some(previous) => &*part(&mut previous.values, tile, previous.outputs),
                    None => &*part(&mut self.input, tile, self.inputs),
                };
                let (w, _) = layer.split(parameters);
                let (dw, dbias) = layer.split(direction);
                let y = &mut moved[..layer.outputs * TILE];
                match &layer.map {
                    Map::Linear => linear(x, dw, dbias, y),
                    // It is the first layer, whose inputs do not move.
                    Map::Convolution(image) => image.forward(x, dw, dbias, y),
                }
                if i > 0 {
                    linear_more(&before_it[..layer.inputs * TILE], w, layer.outputs, y);
                }
                layer.activation.gradient(part(&mut layer.values, tile, layer.outputs), y);
                std::mem::swap(&mut before_it, &mut moved);
            }
            let rows = (count - tile * TILE).min(TILE);
            let output = &mut self.tangent[tile * TILE * self.outputs..][..rows * self.outputs];
            from_tile(&before_it[..self.outputs * TILE], self.outputs, output);
        }
        &self.tangent[..count * self.outputs]
    }

    /// Writes the gradient of `sum(outputs * output_gradient)` by the inputs, shape `[rows, inputs]`, and by nothing else.
    ///
    /// Belongs to the last [`Network::forward`], with the same parameters and inputs.
    pub fn backward_to_inputs(
        &mut self,
        parameters: &[f32],
        output_gradient: &[f32],
        gradient: &mut [f32],
    ) {
        self.back(parameters, output_gradient, None, Some(gradient));
    }

    /// The backward pass, by parameters or inputs.
    fn back(
        &mut self,
        parameters: &[f32],
        output_gradient: &[f32],
        mut gradient: Option<&mut [f32]>,
        mut by_inputs: Option<&mut [f32]>,
    ) {
        let widest = self.layers.iter().map(|l| l.outputs).max().unwrap_or(0).max(self.inputs);
        let (head, tail) = (widest * TILE, widest * TILE);
        let scratch = room(&mut self.scratch, head + 2 * tail);
        let (rows, scratch) = scratch.split_at_mut(head);
        let (mut dy, mut dx) = scratch.split_at_mut(tail);
        for tile in 0..output_gradient.len().div_ceil(TILE * self.outputs) {
            let from = &output_gradient[tile * TILE * self.outputs..];
            let from = &from[..from.len().min(TILE * self.outputs)];
            to_tile(from, self.outputs, &mut dy[..self.outputs * TILE]);
            for i in (0..self.layers.len()).rev() {
                let (before, rest) = self.layers.split_at_mut(i);
                let layer = &mut rest[0];
                let length = layer.outputs * TILE;
                let activation = layer.activation;
                activation
                    .gradient(part(&mut layer.values, tile, layer.outputs), &mut dy[..length]);
                let (w, _) = layer.split(parameters);
                if let Some(gradient) = &mut gradient {
                    let (dw, dbias) =
                        gradient[layer.offset..][..layer.parameters()].split_at_mut(w.len());
                    let x = match before.last_mut() {
                        Some(previous) => &*part(&mut previous.values, tile, previous.outputs),
                        None => &*part(&mut self.input, tile, self.inputs),
                    };
                    match &layer.map {
                        Map::Linear => {
                            weight_gradient(x, &dy[..length], &mut rows[..length], dw, tile > 0);
                            bias_gradient(&dy[..length], dbias, tile > 0);
                        }
                        Map::Convolution(image) => {
                            image.backward(x, &dy[..length], dw, dbias, tile > 0)
                        }
                    }
                }
                if i > 0 || by_inputs.is_some() {
                    assert!(
                        i > 0 || layer.map == Map::Linear,
                        "no gradient by the inputs of a convolution"
                    );
                    input_gradient(&dy[..length], w, &mut dx[..layer.inputs * TILE], false);
                    std::mem::swap(&mut dy, &mut dx);
                }
            }
            if let Some(by_inputs) = &mut by_inputs {
                let rows = from.len() / self.outputs;
                let to = &mut by_inputs[tile * TILE * self.inputs..][..rows * self.inputs];
                from_tile(&dy[..self.inputs * TILE], self.inputs, to);
            }
        }
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
        let count = inputs.len() / self.inputs;
        let tiles = count.div_ceil(TILE);
        room(&mut self.input, tiles * self.inputs * TILE);
        for layer in &mut self.layers {
            room(&mut layer.values, tiles * layer.outputs * TILE);
        }
        room(&mut self.output, count * self.outputs);
        for (tile, rows) in inputs.chunks(TILE * self.inputs).enumerate() {
            let input = part(&mut self.input, tile, self.inputs);
            to_tile(rows, self.inputs, input);
            for i in 0..self.layers.len() {
                let (before, rest) = self.layers.split_at_mut(i);
                let layer = &mut rest[0];
                let x = match before.last_mut() {
                    Some(previous) => &*part(&mut previous.values, tile, previous.outputs),
                    None => &*part(&mut self.input, tile, self.inputs),
                };
                let (w, bias) = layer.split(parameters);
                let y = part(&mut layer.values, tile, layer.outputs);
                match &layer.map {
                    Map::Linear => linear(x, w, bias, y),
                    Map::Convolution(image) => image.forward(x, w, bias, y),
                }
                layer.activation.apply(y);
            }
            let last = self.layers.last_mut().expect("a network has a layer");
            let rows = rows.len() / self.inputs;
            let output = &mut self.output[tile * TILE * self.outputs..][..rows * self.outputs];
            from_tile(part(&mut last.values, tile, last.outputs), self.outputs, output);
        }
        &self.output[..count * self.outputs]
    }

    fn single(&mut self, parameters: &[f32], inputs: &[f32]) -> &[f32] {
        for i in 0..self.layers.len() {
            let (before, rest) = self.layers.split_at_mut(i);
            let layer = &mut rest[0];
            let x = before.last().map_or(inputs, |l| &l.single);
            let (w, bias) = layer.split(parameters);
            layer.single.resize(layer.outputs, 0.0);
            match &layer.map {
                Map::Linear => affine(x, w, bias, &mut layer.single),
                Map::Convolution(image) => image.single(x, w, bias, &mut layer.single),
            }
            layer.activation.apply(&mut layer.single);
        }
        &self.layers.last().expect("a network has a layer").single
    }

    fn backward(
        &mut self,
        parameters: &[f32],
        _: &[f32],
        output_gradient: &[f32],
        gradient: &mut [f32],
    ) {
        self.back(parameters, output_gradient, Some(gradient), None);
    }
}

/// Returns the tile of a number out of tiles of `width` numbers per row.
fn part(values: &mut [f32], tile: usize, width: usize) -> &mut [f32] {
    &mut values[tile * width * TILE..][..width * TILE]
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::super::testing::check_gradient;
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
        for rows in [1, 5, 70] {
            let mut network = idqn();
            let parameters = random(network.parameters(), 1);
            let inputs = random(rows * 20, 2);
            check_gradient(&mut network, &parameters, &inputs, &random(rows * 3, 3));
        }
    }

    #[test]
    fn tangents_and_gradients_by_inputs_are_those_of_finite_differences() {
        let rows = 40;
        let mut convolved = idqn();
        let mut plain = Sequential::new(5).linear(7, Activation::Tanh).linear(3, Activation::Tanh);
        for network in [&mut convolved, &mut plain] {
            let width = network.inputs();
            let parameters = random(network.parameters(), 1);
            let inputs = random(rows * width, 2);
            let direction = random(network.parameters(), 4);
            network.forward(&parameters, &inputs);
            let tangent = network.tangent(&parameters, &inputs, &direction).to_vec();
            let mut at = |step: f32| {
                let moved: Vec<f32> =
                    parameters.iter().zip(&direction).map(|(p, d)| p + step * d).collect();
                network.forward(&moved, &inputs).to_vec()
            };
            let (up, down) = (at(1e-3), at(-1e-3));
            let (mut length, mut difference) = (0.0f32, 0.0f32);
            for ((u, d), t) in up.iter().zip(&down).zip(&tangent) {
                let slope = (u - d) / 2e-3;
                length += slope * slope;
                difference += (slope - t) * (slope - t);
            }
            assert!(
                length > 1.0 && (difference / length).sqrt() < 0.02,
                "{difference} of {length}"
            );
        }
        let (parameters, inputs) = (random(plain.parameters(), 1), random(rows * 5, 2));
        let weights = random(rows * 3, 3);
        let mut gradient = vec![0.0; rows * 5];
        plain.forward(&parameters, &inputs);
        plain.backward_to_inputs(&parameters, &weights, &mut gradient);
        for (i, gradient) in gradient.iter().enumerate() {
            let mut at = |step: f32| {
                let mut moved = inputs.clone();
                moved[i] += step;
                let outputs = plain.forward(&parameters, &moved);
                outputs.iter().zip(&weights).map(|(y, w)| f64::from(y * w)).sum::<f64>()
            };
            let slope = (at(1e-2) - at(-1e-2)) / 2e-2;
            assert!((slope - f64::from(*gradient)).abs() < 2e-3, "{i}: {slope} {gradient}");
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
}

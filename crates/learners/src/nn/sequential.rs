//! Networks of layers one after the other: linear maps, and a 2 x 2 convolution in front.
//!
//! Products of a tile with weights are what the time of an update goes into. A tile holds [`TILE`] rows of a batch side by
//! side, of shape `[numbers, TILE]`, so that a vector register holds the same number of several rows and a weight is read
//! once for all of them. Nothing is packed or allocated. Each result is summed in one order, whatever the processor, and
//! with fused multiply-add everywhere, so the bytes are the same on every machine. `pulp` chooses between AVX-512, AVX2 and
//! plain code at run time.

use pulp::{Arch, Simd, WithSimd};
use rand_chacha::ChaCha8Rng;

use super::init::Init;
use super::kernel::{Activation, affine};
use super::product::multiply;
use super::{Network, Part, linear_parts, room};

/// Rows of a batch that are computed together; fewer cost as much.
pub const TILE: usize = 32;

/// Inputs after which the sums of [`linear`] are put aside, so that their weights stay in the nearest cache.
const DEPTH: usize = 64;

/// Pixels of a 2 x 2 kernel.
const KERNEL: usize = 4;

#[derive(Debug, Clone)]
struct Layer {
    /// Of a 2 x 2 convolution over an image of one channel, stride 1, no padding, whose outputs are ordered by channel, then
    /// position; else all inputs go to all outputs.
    image: Option<Image>,
    inputs: usize,
    outputs: usize,
    activation: Activation,
    /// Where its weights, then its biases, begin in the flat vector.
    offset: usize,
    values: Vec<f32>,
    single: Vec<f32>,
}

impl Layer {
    fn shape(&self) -> (usize, usize) {
        match &self.image {
            None => (self.inputs, self.outputs),
            Some(image) => (KERNEL, image.channels),
        }
    }

    fn parameters(&self) -> usize {
        let (inputs, outputs) = self.shape();
        (inputs + 1) * outputs
    }

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
        self.layer(None, outputs, activation)
    }

    /// Adds a 2 x 2 convolution of an image of one channel with `width` columns; only in front.
    /// Panics when it is not the first layer or the image is smaller than the kernel.
    #[must_use]
    pub fn convolution(self, width: usize, channels: usize, activation: Activation) -> Self {
        let height = self.inputs / width;
        assert!(self.layers.is_empty() && width >= 2 && height >= 2, "no image of 2 x 2 or more");
        let image = Image::new(height, width, channels);
        let outputs = image.positions() * channels;
        self.layer(Some(image), outputs, activation)
    }

    fn layer(mut self, image: Option<Image>, outputs: usize, activation: Activation) -> Self {
        let layer = Layer {
            image,
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
                match &layer.image {
                    None => linear(x, dw, dbias, y),
                    // It is the first layer, whose inputs do not move.
                    Some(image) => image.forward(x, dw, dbias, y),
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
    /// Belongs to the last [`Network::forward`], with the same parameters and inputs.
    pub fn backward_to_inputs(
        &mut self,
        parameters: &[f32],
        output_gradient: &[f32],
        gradient: &mut [f32],
    ) {
        self.back(parameters, output_gradient, None, Some(gradient));
    }

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
                    match &layer.image {
                        None => {
                            weight_gradient(x, &dy[..length], &mut rows[..length], dw, tile > 0);
                            bias_gradient(&dy[..length], dbias, tile > 0);
                        }
                        Some(image) => image.backward(x, &dy[..length], dw, dbias, tile > 0),
                    }
                }
                if i > 0 || by_inputs.is_some() {
                    assert!(
                        i > 0 || layer.image.is_none(),
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
                match &layer.image {
                    None => linear(x, w, bias, y),
                    Some(image) => image.forward(x, w, bias, y),
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
            match &layer.image {
                None => affine(x, w, bias, &mut layer.single),
                Some(image) => image.single(x, w, bias, &mut layer.single),
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

fn part(values: &mut [f32], tile: usize, width: usize) -> &mut [f32] {
    &mut values[tile * width * TILE..][..width * TILE]
}

/// Copies up to [`TILE`] rows of `width` numbers into a tile; rows that are missing are zero.
fn to_tile(rows: &[f32], width: usize, tile: &mut [f32]) {
    for (i, numbers) in tile.chunks_exact_mut(TILE).enumerate() {
        numbers.fill(0.0);
        for (number, row) in numbers.iter_mut().zip(rows.chunks_exact(width)) {
            *number = row[i];
        }
    }
}

/// Copies a tile into up to [`TILE`] rows of `width` numbers.
fn from_tile(tile: &[f32], width: usize, rows: &mut [f32]) {
    for (r, row) in rows.chunks_exact_mut(width).enumerate() {
        for (number, numbers) in row.iter_mut().zip(tile.chunks_exact(TILE)) {
            *number = numbers[r];
        }
    }
}

/// `y = x w + bias` of shapes `[outputs, TILE]`, `[inputs, TILE]`, `[inputs, outputs]` and `[outputs]`.
fn linear(x: &[f32], w: &[f32], bias: &[f32], y: &mut [f32]) {
    for (y, bias) in y.chunks_exact_mut(TILE).zip(bias) {
        y.fill(*bias);
    }
    linear_more(x, w, bias.len(), y);
}

/// Adds `x w` to `y`, of `outputs` rows of a tile.
fn linear_more(x: &[f32], w: &[f32], outputs: usize, y: &mut [f32]) {
    for (x, w) in x.chunks(DEPTH * TILE).zip(w.chunks(DEPTH * outputs)) {
        Arch::new().dispatch(Product { x, w, outputs, across: 1, down: outputs, y, add: true });
    }
}

/// Writes `dx = dy w^T`, or adds it when `add` is set: the gradient of the inputs of [`linear`].
fn input_gradient(dy: &[f32], w: &[f32], dx: &mut [f32], add: bool) {
    let inputs = dx.len() / TILE;
    let across = dy.len() / TILE;
    Arch::new().dispatch(Product { x: dy, w, outputs: inputs, across, down: 1, y: dx, add });
}

/// `y[o] = sum_i x[i] w[i * down + o * across]`, over rows of a tile, or added when `add` is set.
struct Product<'a> {
    x: &'a [f32],
    w: &'a [f32],
    outputs: usize,
    across: usize,
    down: usize,
    y: &'a mut [f32],
    add: bool,
}

impl WithSimd for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        // As many sums as registers hold beside the inputs.
        match S::F32_LANES {
            16 => self.run::<S, 2, 8>(simd),
            8 => self.run::<S, 4, 3>(simd),
            4 => self.run::<S, 8, 1>(simd),
            _ => self.run::<S, TILE, 1>(simd),
        }
    }
}

impl Product<'_> {
    #[inline(always)]
    fn run<S: Simd, const V: usize, const B: usize>(self, simd: S) {
        let Self { x, w, outputs, across, down, y, add } = self;
        let x = S::as_simd_f32s(x).0.as_chunks::<V>().0;
        let y = S::as_mut_simd_f32s(y).0.as_chunks_mut::<V>().0;
        let whole = outputs / B * B;
        for o in (0..whole).step_by(B) {
            block::<S, V, B>(simd, x, &w[o * across..], across, down, &mut y[o..o + B], add);
        }
        for o in whole..outputs {
            block::<S, V, 1>(simd, x, &w[o * across..], across, down, &mut y[o..o + 1], add);
        }
    }
}

#[inline(always)]
fn block<S: Simd, const V: usize, const B: usize>(
    simd: S,
    x: &[[S::f32s; V]],
    w: &[f32],
    across: usize,
    down: usize,
    y: &mut [[S::f32s; V]],
    add: bool,
) {
    let y: &mut [[S::f32s; V]; B] = y.try_into().expect("a block of outputs");
    let mut sums = if add { *y } else { [[simd.splat_f32s(0.0); V]; B] };
    if down == 1 {
        let rows: [&[f32]; B] = std::array::from_fn(|b| &w[b * across..][..x.len()]);
        for (i, x) in x.iter().enumerate() {
            for b in 0..B {
                let w = simd.splat_f32s(rows[b][i]);
                for v in 0..V {
                    sums[b][v] = simd.mul_add_f32s(w, x[v], sums[b][v]);
                }
            }
        }
    } else {
        for (x, w) in x.iter().zip(w.chunks(down)) {
            let w: &[f32; B] = w[..B].try_into().expect("a block of weights");
            for b in 0..B {
                let w = simd.splat_f32s(w[b]);
                for v in 0..V {
                    sums[b][v] = simd.mul_add_f32s(w, x[v], sums[b][v]);
                }
            }
        }
    }
    *y = sums;
}

/// The gradient of the weights of [`linear`], `dw = x dy^T`, or added when `add` is set; `rows` has room for `dy`.
fn weight_gradient(x: &[f32], dy: &[f32], rows: &mut [f32], dw: &mut [f32], add: bool) {
    let outputs = dy.len() / TILE;
    from_tile(dy, outputs, rows);
    multiply((x, TILE, 1), rows, outputs, dw, add);
}

/// The sums over the rows of a tile, or added when `add` is set.
fn bias_gradient(dy: &[f32], dbias: &mut [f32], add: bool) {
    for (dbias, dy) in dbias.iter_mut().zip(dy.as_chunks::<TILE>().0) {
        *dbias = if add { *dbias + sum(dy) } else { sum(dy) };
    }
}

/// Always in the same order.
#[inline(always)]
fn sum(row: &[f32; TILE]) -> f32 {
    let mut sums = *row;
    let mut width = TILE / 2;
    while width > 0 {
        for i in 0..width {
            sums[i] += sums[i + width];
        }
        width /= 2;
    }
    sums[0]
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Image {
    /// The four pixels under a kernel at each position.
    patches: Vec<[usize; KERNEL]>,
    channels: usize,
}

impl Image {
    fn new(height: usize, width: usize, channels: usize) -> Self {
        let corners = (0..height - 1).flat_map(|row| (0..width - 1).map(move |c| row * width + c));
        let patches = corners.map(|at| [at, at + 1, at + width, at + width + 1]).collect();
        Self { patches, channels }
    }

    fn positions(&self) -> usize {
        self.patches.len()
    }

    /// Of a tile: `x` has shape `[pixels, TILE]`, `w` and `bias` `[4, channels]` and `[channels]`, `y`
    /// `[channels * positions, TILE]`.
    fn forward(&self, x: &[f32], w: &[f32], bias: &[f32], y: &mut [f32]) {
        Arch::new().dispatch(Forward { image: self, x, w, bias, y });
    }

    fn single(&self, x: &[f32], w: &[f32], bias: &[f32], y: &mut [f32]) {
        let positions = self.positions();
        for (channel, (bias, y)) in bias.iter().zip(y.chunks_exact_mut(positions)).enumerate() {
            let w: [f32; KERNEL] = std::array::from_fn(|j| w[j * self.channels + channel]);
            for (patch, y) in self.patches.iter().zip(y) {
                let x = patch.map(|p| x[p]);
                *y = bias + ((w[0] * x[0] + w[1] * x[1]) + (w[2] * x[2] + w[3] * x[3]));
            }
        }
    }

    /// Adds to the gradients when `add` is set.
    fn backward(&self, x: &[f32], dy: &[f32], dw: &mut [f32], dbias: &mut [f32], add: bool) {
        let (pixels, gradients) = (x.as_chunks::<TILE>().0, dy.as_chunks::<TILE>().0);
        let put = |to: &mut f32, sums: &[f32; TILE]| {
            *to = if add { *to + sum(sums) } else { sum(sums) };
        };
        Arch::new().dispatch(
            #[inline(always)]
            || {
                let channels = gradients.chunks_exact(self.positions()).zip(dbias);
                for (channel, (gradients, dbias)) in channels.enumerate() {
                    let (mut sums, mut bias) = ([[0.0; TILE]; KERNEL], [0.0; TILE]);
                    for (patch, dy) in self.patches.iter().zip(gradients) {
                        let x = patch.map(|p| &pixels[p]);
                        for r in 0..TILE {
                            bias[r] += dy[r];
                            for j in 0..KERNEL {
                                sums[j][r] = dy[r].mul_add(x[j][r], sums[j][r]);
                            }
                        }
                    }
                    put(dbias, &bias);
                    for (j, sums) in sums.iter().enumerate() {
                        put(&mut dw[j * self.channels + channel], sums);
                    }
                }
            },
        );
    }
}

struct Forward<'a> {
    image: &'a Image,
    x: &'a [f32],
    w: &'a [f32],
    bias: &'a [f32],
    y: &'a mut [f32],
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { image: Image { patches, channels }, x, w, bias, y } = self;
        let (pixels, y) = (S::as_simd_f32s(x).0, S::as_mut_simd_f32s(y).0);
        let registers = TILE / S::F32_LANES;
        for (c, y) in y.chunks_exact_mut(patches.len() * registers).enumerate() {
            let w: [_; KERNEL] = std::array::from_fn(|j| simd.splat_f32s(w[j * channels + c]));
            let bias = simd.splat_f32s(bias[c]);
            for (patch, y) in patches.iter().zip(y.chunks_exact_mut(registers)) {
                for v in 0..registers {
                    y[v] = bias;
                    for j in 0..KERNEL {
                        y[v] = simd.mul_add_f32s(w[j], pixels[patch[j] * registers + v], y[v]);
                    }
                }
            }
        }
    }
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

    fn numbers(count: usize, factor: usize) -> Vec<f32> {
        (0..count).map(|i| ((i * factor) % 17) as f32 * 0.25 - 2.0).collect()
    }

    fn close(a: &[f32], b: &[f32]) {
        assert_eq!(a.len(), b.len());
        for (i, (a, b)) in a.iter().zip(b).enumerate() {
            assert!((a - b).abs() <= 1e-3 * (1.0 + b.abs()), "{i}: {a} {b}");
        }
    }

    #[test]
    fn products_are_those_of_three_loops() {
        for (inputs, outputs) in [(1, 1), (64, 1), (5, 3), (130, 64), (7, 20), (64, 67), (3, 129)] {
            let (x, dy) = (numbers(inputs * TILE, 7), numbers(outputs * TILE, 5));
            let (w, bias) = (numbers(inputs * outputs, 3), numbers(outputs, 11));
            let (mut y, mut dx) = (vec![0.0; outputs * TILE], numbers(inputs * TILE, 13));
            let mut dw = numbers(inputs * outputs, 2);
            let (mut y0, mut dx0, mut dw0) = (y.clone(), dx.clone(), dw.clone());
            for o in 0..outputs {
                for r in 0..TILE {
                    y0[o * TILE + r] = bias[o];
                    for i in 0..inputs {
                        y0[o * TILE + r] += x[i * TILE + r] * w[i * outputs + o];
                        dx0[i * TILE + r] += dy[o * TILE + r] * w[i * outputs + o];
                        dw0[i * outputs + o] += dy[o * TILE + r] * x[i * TILE + r];
                    }
                }
            }
            linear(&x, &w, &bias, &mut y);
            close(&y, &y0);
            input_gradient(&dy, &w, &mut dx, true);
            close(&dx, &dx0);
            weight_gradient(&x, &dy, &mut vec![0.0; outputs * TILE], &mut dw, true);
            close(&dw, &dw0);
        }
    }

    #[test]
    fn a_tile_turns_back_into_its_rows() {
        let rows = numbers(5 * 3, 7);
        let mut tile = vec![9.0; 3 * TILE];
        to_tile(&rows, 3, &mut tile);
        assert_eq!(tile[TILE + 2], rows[2 * 3 + 1]);
        assert_eq!(tile[5..TILE], [0.0; TILE - 5]);
        let mut back = vec![0.0; 5 * 3];
        from_tile(&tile, 3, &mut back);
        assert_eq!(back, rows);
    }
}

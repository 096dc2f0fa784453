//! A 2 x 2 convolution of images of one channel, stride 1, no padding, on tiles.

use pulp::{Arch, Simd, WithSimd};

use super::tile::{TILE, sum};

/// Pixels of a 2 x 2 kernel.
pub(super) const KERNEL: usize = 4;

/// Where the kernels lie on the images, and how many there are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Image {
    /// The four pixels under a kernel at each position.
    patches: Vec<[usize; KERNEL]>,
    pub(super) channels: usize,
}

impl Image {
    /// Returns the image of a shape.
    pub(super) fn new(height: usize, width: usize, channels: usize) -> Self {
        let corners = (0..height - 1).flat_map(|row| (0..width - 1).map(move |c| row * width + c));
        let patches = corners.map(|at| [at, at + 1, at + width, at + width + 1]).collect();
        Self { patches, channels }
    }

    /// Returns the number of places of a kernel on the image.
    pub(super) fn positions(&self) -> usize {
        self.patches.len()
    }

    /// Writes the outputs of a tile.
    ///
    /// # Arguments
    ///
    /// * `x` — shape `[pixels, TILE]`.
    /// * `w`, `bias` — shapes `[4, channels]` and `[channels]`.
    /// * `y` — shape `[channels * positions, TILE]`.
    pub(super) fn forward(&self, x: &[f32], w: &[f32], bias: &[f32], y: &mut [f32]) {
        Arch::new().dispatch(Forward { image: self, x, w, bias, y });
    }

    /// Writes the outputs of a single image.
    pub(super) fn single(&self, x: &[f32], w: &[f32], bias: &[f32], y: &mut [f32]) {
        let positions = self.positions();
        for (channel, (bias, y)) in bias.iter().zip(y.chunks_exact_mut(positions)).enumerate() {
            let w: [f32; KERNEL] = std::array::from_fn(|j| w[j * self.channels + channel]);
            for (patch, y) in self.patches.iter().zip(y) {
                let x = patch.map(|p| x[p]);
                *y = bias + ((w[0] * x[0] + w[1] * x[1]) + (w[2] * x[2] + w[3] * x[3]));
            }
        }
    }

    /// Writes the gradients of weights and biases, or adds them when `add` is set.
    pub(super) fn backward(
        &self,
        x: &[f32],
        dy: &[f32],
        dw: &mut [f32],
        dbias: &mut [f32],
        add: bool,
    ) {
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

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
        Arch::new().dispatch(Backward { image: self, x, dy, dw, dbias, add });
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
        match S::F32_LANES {
            16 => self.run::<S, 2>(simd),
            8 => self.run::<S, 4>(simd),
            4 => self.run::<S, 8>(simd),
            _ => self.run::<S, TILE>(simd),
        }
    }
}

impl Forward<'_> {
    #[inline(always)]
    fn run<S: Simd, const V: usize>(self, simd: S) {
        let Self { image, x, w, bias, y } = self;
        let pixels = S::as_simd_f32s(x).0.as_chunks::<V>().0;
        let outputs = S::as_mut_simd_f32s(y).0.as_chunks_mut::<V>().0;
        let positions = image.positions();
        for (channel, outputs) in outputs.chunks_exact_mut(positions).enumerate() {
            let w: [_; KERNEL] =
                std::array::from_fn(|j| simd.splat_f32s(w[j * image.channels + channel]));
            let bias = simd.splat_f32s(bias[channel]);
            for (patch, y) in image.patches.iter().zip(outputs) {
                let x = patch.map(|p| &pixels[p]);
                for v in 0..V {
                    let mut sum = bias;
                    for j in 0..KERNEL {
                        sum = simd.mul_add_f32s(w[j], x[j][v], sum);
                    }
                    y[v] = sum;
                }
            }
        }
    }
}

struct Backward<'a> {
    image: &'a Image,
    x: &'a [f32],
    dy: &'a [f32],
    dw: &'a mut [f32],
    dbias: &'a mut [f32],
    add: bool,
}

impl WithSimd for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match S::F32_LANES {
            16 => self.run::<S, 2>(simd),
            8 => self.run::<S, 4>(simd),
            4 => self.run::<S, 8>(simd),
            _ => self.run::<S, TILE>(simd),
        }
    }
}

impl Backward<'_> {
    #[inline(always)]
    fn run<S: Simd, const V: usize>(self, simd: S) {
        let Self { image, x, dy, dw, dbias, add } = self;
        let pixels = S::as_simd_f32s(x).0.as_chunks::<V>().0;
        let gradients = S::as_simd_f32s(dy).0.as_chunks::<V>().0;
        let total = |registers: &[S::f32s; V]| {
            let mut row = [0.0; TILE];
            S::as_mut_simd_f32s(&mut row).0.copy_from_slice(registers);
            sum(&row)
        };
        for (channel, gradients) in gradients.chunks_exact(image.positions()).enumerate() {
            let mut sums = [[simd.splat_f32s(0.0); V]; KERNEL];
            let mut bias = [simd.splat_f32s(0.0); V];
            for (patch, dy) in image.patches.iter().zip(gradients) {
                let x = patch.map(|p| &pixels[p]);
                for v in 0..V {
                    bias[v] = simd.add_f32s(bias[v], dy[v]);
                    for j in 0..KERNEL {
                        sums[j][v] = simd.mul_add_f32s(dy[v], x[j][v], sums[j][v]);
                    }
                }
            }
            let put = |to: &mut f32, value: f32| *to = if add { *to + value } else { value };
            put(&mut dbias[channel], total(&bias));
            for (j, sums) in sums.iter().enumerate() {
                put(&mut dw[j * image.channels + channel], total(sums));
            }
        }
    }
}

//! Products of a tile with weights: what the time of an update goes into.
//!
//! A tile holds [`TILE`] rows of a batch side by side: of shape `[numbers, TILE]`, so that a vector
//! register holds the same number of several rows and a weight is read once for all of them. Nothing
//! is packed or allocated. Each result is summed in one order, whatever the processor, and with fused
//! multiply-add everywhere, so the bytes are the same on every machine.
//!
//! `pulp` chooses between AVX-512, AVX2 and plain code at run time.

use pulp::{Arch, Simd, WithSimd};

use super::product::{Matrix, multiply};

/// Rows of a batch that are computed together; fewer cost as much.
pub const TILE: usize = 32;

/// Inputs after which the sums of [`linear`] are put aside, so that their weights stay in the nearest
/// cache.
const DEPTH: usize = 64;

/// Copies up to [`TILE`] rows of `width` numbers into a tile; rows that are missing are zero.
pub(super) fn to_tile(rows: &[f32], width: usize, tile: &mut [f32]) {
    for (i, numbers) in tile.chunks_exact_mut(TILE).enumerate() {
        numbers.fill(0.0);
        for (number, row) in numbers.iter_mut().zip(rows.chunks_exact(width)) {
            *number = row[i];
        }
    }
}

/// Copies a tile into up to [`TILE`] rows of `width` numbers.
pub(super) fn from_tile(tile: &[f32], width: usize, rows: &mut [f32]) {
    for (r, row) in rows.chunks_exact_mut(width).enumerate() {
        for (number, numbers) in row.iter_mut().zip(tile.chunks_exact(TILE)) {
            *number = numbers[r];
        }
    }
}

/// Writes `y = x w + bias`.
///
/// # Arguments
///
/// * `x` — shape `[inputs, TILE]`.
/// * `w`, `bias` — shapes `[inputs, outputs]` and `[outputs]`.
/// * `y` — shape `[outputs, TILE]`.
pub(super) fn linear(x: &[f32], w: &[f32], bias: &[f32], y: &mut [f32]) {
    for (y, bias) in y.chunks_exact_mut(TILE).zip(bias) {
        y.fill(*bias);
    }
    linear_more(x, w, bias.len(), y);
}

/// Adds `x w` to `y`, of `outputs` rows of a tile.
pub(super) fn linear_more(x: &[f32], w: &[f32], outputs: usize, y: &mut [f32]) {
    for (x, w) in x.chunks(DEPTH * TILE).zip(w.chunks(DEPTH * outputs)) {
        Arch::new().dispatch(Product { x, w, outputs, across: 1, down: outputs, y, add: true });
    }
}

/// Writes `dx = dy w^T`, or adds it when `add` is set: the gradient of the inputs of [`linear`].
pub(super) fn input_gradient(dy: &[f32], w: &[f32], dx: &mut [f32], add: bool) {
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

/// `B` outputs of a product.
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

/// Writes the gradient of the weights of [`linear`], `dw = x dy^T`, or adds it when `add` is set.
///
/// # Arguments
///
/// * `x`, `dy` — shapes `[inputs, TILE]` and `[outputs, TILE]`.
/// * `rows` — room for `outputs * TILE` numbers.
/// * `dw` — shape `[inputs, outputs]`.
pub(super) fn weight_gradient(x: &[f32], dy: &[f32], rows: &mut [f32], dw: &mut [f32], add: bool) {
    let outputs = dy.len() / TILE;
    from_tile(dy, outputs, rows);
    let x = Matrix { numbers: x, down: TILE, across: 1 };
    multiply(x, rows, outputs, dw, add);
}

/// Writes the gradient of a bias, the sums over the rows of a tile, or adds it when `add` is set.
pub(super) fn bias_gradient(dy: &[f32], dbias: &mut [f32], add: bool) {
    for (dbias, dy) in dbias.iter_mut().zip(dy.as_chunks::<TILE>().0) {
        *dbias = if add { *dbias + sum(dy) } else { sum(dy) };
    }
}

/// Returns the sum of a tile's row, always in the same order.
#[inline(always)]
pub(super) fn sum(row: &[f32; TILE]) -> f32 {
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

#[cfg(test)]
mod tests {
    use super::*;

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

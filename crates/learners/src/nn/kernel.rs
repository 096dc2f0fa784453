//! Loops over numbers: products of row-major matrices and element-wise work, on one thread.
//!
//! Loops are compiled for several processors by `pulp`, which takes the best at run time, so that one
//! binary runs everywhere. Nothing here allocates.

use pulp::Arch;

use super::product::multiply;

/// Columns that [`one_row`] keeps in registers.
const BLOCK: usize = 64;

// The hyperbolic tangent by a quotient of polynomials, which vector units can compute. Coefficients are Eigen's
// (`generic_fast_tanh_float`). Arithmetic is the same on every processor, and so are the bytes; the error is below 4e-7.

/// Where the tangent reaches 1 in single precision.
const LIMIT: f32 = 7.905_311;

/// Coefficients of the odd powers of the numerator, the highest first.
const NUMERATOR: [f32; 7] = [
    -2.760_768_5e-16, 2.000_188e-13, -8.604_672e-11, 5.122_297_3e-8, 1.485_722_35e-5, 6.372_619e-4,
    4.893_524_6e-3,
];

const DENOMINATOR: [f32; 4] = [1.198_258_4e-6, 1.185_347_1e-4, 2.268_434_6e-3, 4.893_525e-3];

/// `y = x w + bias` with `x` of shape `[rows, inner]` and `w` of shape `[inner, columns]`.
pub(super) fn affine(x: &[f32], w: &[f32], bias: &[f32], y: &mut [f32]) {
    let columns = bias.len();
    let inner = w.len() / columns;
    if y.len() == columns {
        one_row(x, w, bias, y);
        return;
    }
    for row in y.chunks_exact_mut(columns) {
        row.copy_from_slice(bias);
    }
    multiply((x, inner, 1), w, columns, y, true);
}

/// One row of [`affine`]; inputs of zero, half of those behind a ReLU, cost nothing.
fn one_row(x: &[f32], w: &[f32], bias: &[f32], y: &mut [f32]) {
    let columns = bias.len();
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for start in (0..columns).step_by(BLOCK) {
                let width = BLOCK.min(columns - start);
                let mut sums = [0.0f32; BLOCK];
                sums[..width].copy_from_slice(&bias[start..start + width]);
                for (i, x) in x.iter().enumerate() {
                    if *x == 0.0 {
                        continue;
                    }
                    let w = &w[i * columns + start..][..width];
                    if let Ok(w) = <&[f32; BLOCK]>::try_from(w) {
                        for (sum, w) in sums.iter_mut().zip(w) {
                            *sum += x * w;
                        }
                    } else {
                        for (sum, w) in sums.iter_mut().zip(w) {
                            *sum += x * w;
                        }
                    }
                }
                y[start..start + width].copy_from_slice(&sums[..width]);
            }
        },
    );
}

/// `y = x w`, with `y` of `columns` columns.
pub(super) fn product(x: &[f32], w: &[f32], columns: usize, y: &mut [f32]) {
    let inner = w.len() / columns;
    multiply((x, inner, 1), w, columns, y, false);
}

/// `gradient += x^T dy`, the gradient of weights; both have `rows` rows.
pub(super) fn add_weight_gradient(x: &[f32], dy: &[f32], gradient: &mut [f32], rows: usize) {
    let (inner, columns) = (x.len() / rows, dy.len() / rows);
    multiply((x, 1, inner), dy, columns, gradient, true);
}

/// `dx = dy w^T`, the gradient of inputs, or added when `add` is set; `turned` has room for `w`.
pub(super) fn input_gradient(
    dy: &[f32],
    w: &[f32],
    columns: usize,
    turned: &mut [f32],
    dx: &mut [f32],
    add: bool,
) {
    let inner = w.len() / columns;
    let turned = &mut turned[..w.len()];
    for (i, row) in w.chunks_exact(columns).enumerate() {
        for (o, w) in row.iter().enumerate() {
            turned[o * inner + i] = *w;
        }
    }
    multiply((dy, columns, 1), turned, inner, dx, add);
}

/// `gradient += column sums of dy`, the gradient of a bias.
pub(super) fn add_bias_gradient(dy: &[f32], gradient: &mut [f32]) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for row in dy.chunks_exact(gradient.len()) {
                for (g, d) in gradient.iter_mut().zip(row) {
                    *g += d;
                }
            }
        },
    );
}

/// What follows a linear map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Activation {
    /// Nothing.
    None,
    /// The larger of 0 and x.
    Relu,
    /// The hyperbolic tangent.
    Tanh,
}

impl Activation {
    pub(super) fn apply(self, y: &mut [f32]) {
        match self {
            Self::None => {}
            Self::Relu => each(y, relu),
            Self::Tanh => each(y, tanh),
        }
    }

    /// Turns the gradient behind the activation, whose values are `y`, into that before it.
    pub(super) fn gradient(self, y: &[f32], dy: &mut [f32]) {
        match self {
            Self::None => {}
            Self::Relu => Arch::new().dispatch(
                #[inline(always)]
                || dy.iter_mut().zip(y).for_each(|(d, y)| *d = if *y > 0.0 { *d } else { 0.0 }),
            ),
            Self::Tanh => Arch::new().dispatch(
                #[inline(always)]
                || dy.iter_mut().zip(y).for_each(|(d, y)| *d *= 1.0 - y * y),
            ),
        }
    }
}

fn each(y: &mut [f32], function: impl Fn(f32) -> f32) {
    Arch::new().dispatch(
        #[inline(always)]
        || y.iter_mut().for_each(|y| *y = function(*y)),
    );
}

/// The larger of 0 and x; what is no number stays none, so that it is noticed.
#[inline(always)]
pub(super) fn relu(x: f32) -> f32 {
    if x < 0.0 { 0.0 } else { x }
}

#[inline(always)]
pub(super) fn sigmoid(x: f32) -> f32 {
    1.0 / (1.0 + (-x).exp())
}

#[inline(always)]
fn tanh(x: f32) -> f32 {
    let x = x.clamp(-LIMIT, LIMIT);
    let square = x * x;
    let polynomial =
        |coefficients: &[f32]| coefficients.iter().fold(0.0f32, |sum, c| sum.mul_add(square, *c));
    x * polynomial(&NUMERATOR) / polynomial(&DENOMINATOR)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_row_and_many_rows_give_the_same_product() {
        let (rows, inner, columns) = (5, 70, 130);
        let x: Vec<f32> = (0..rows * inner).map(|i| ((i * 7 % 13) as f32 - 6.0).max(0.0)).collect();
        let w: Vec<f32> = (0..inner * columns).map(|i| (i * 5 % 11) as f32 * 0.1 - 0.5).collect();
        let bias: Vec<f32> = (0..columns).map(|i| i as f32).collect();
        let mut many = vec![0.0; rows * columns];
        affine(&x, &w, &bias, &mut many);
        for row in 0..rows {
            let mut one = vec![0.0; columns];
            affine(&x[row * inner..][..inner], &w, &bias, &mut one);
            for (a, b) in one.iter().zip(&many[row * columns..]) {
                assert!((a - b).abs() < 1e-3, "{a} {b}");
            }
        }
    }

    #[test]
    fn the_tangent_is_right_to_single_precision_and_keeps_what_is_no_number() {
        for i in -100_000..=100_000 {
            let x = i as f32 * 1e-4;
            let exact = f64::from(x).tanh();
            assert!((f64::from(tanh(x)) - exact).abs() < 4e-7, "{x}: {} {exact}", tanh(x));
            assert_eq!(tanh(-x), -tanh(x));
        }
        assert!(tanh(f32::NAN).is_nan());
        assert!((tanh(f32::INFINITY) - 1.0).abs() < 4e-7);
        assert!((f64::from(tanh(1e-4)) / 1e-4f64.tanh() - 1.0).abs() < 1e-6);
    }
}

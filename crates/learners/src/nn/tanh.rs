//! The hyperbolic tangent by a quotient of polynomials, which vector units can compute.
//!
//! Coefficients are Eigen's (`generic_fast_tanh_float`); beyond [`LIMIT`] the tangent is 1 in single precision.
//! Arithmetic is the same on every processor, and so are the bytes; the error is below 4e-7.

/// Where the tangent reaches 1 in single precision.
const LIMIT: f32 = 7.905_311;

/// Coefficients of the odd powers of the numerator, the highest first.
const NUMERATOR: [f32; 7] = [
    -2.760_768_5e-16, 2.000_188e-13, -8.604_672e-11, 5.122_297_3e-8, 1.485_722_35e-5, 6.372_619e-4,
    4.893_524_6e-3,
];

/// Coefficients of the even powers of the denominator, the highest first.
const DENOMINATOR: [f32; 4] = [1.198_258_4e-6, 1.185_347_1e-4, 2.268_434_6e-3, 4.893_525e-3];

/// Returns the hyperbolic tangent; what is no number stays none.
#[inline(always)]
pub(super) fn tanh(x: f32) -> f32 {
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

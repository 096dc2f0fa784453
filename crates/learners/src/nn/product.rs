//! Products of matrices, row by row, for few columns.

use pulp::{Arch, Simd, WithSimd};

/// A matrix that is read number by number: its numbers, the distance between rows, and that between columns.
pub(super) type Matrix<'a> = (&'a [f32], usize, usize);

/// Writes `c = a b`, or adds it when `add` is set; `b` and `c` are row-major and have `columns` columns.
pub(super) fn multiply(a: Matrix<'_>, b: &[f32], columns: usize, c: &mut [f32], add: bool) {
    Arch::new().dispatch(Multiply { a, b, columns, c, add });
}

struct Multiply<'a> {
    a: Matrix<'a>,
    b: &'a [f32],
    columns: usize,
    c: &'a mut [f32],
    add: bool,
}

impl WithSimd for Multiply<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let mut start = 0;
        while start < self.columns {
            let left = self.columns - start;
            if left >= 4 * S::F32_LANES {
                self.strip::<S, 4, 4>(simd, start);
                start += 4 * S::F32_LANES;
            } else if left > S::F32_LANES {
                self.strip::<S, 2, 8>(simd, start);
                start += 2 * S::F32_LANES;
            } else {
                self.strip::<S, 1, 8>(simd, start);
                start += S::F32_LANES;
            }
        }
    }
}

impl Multiply<'_> {
    /// `V` registers of columns of the result, `B` rows at a time.
    #[inline(always)]
    fn strip<S: Simd, const V: usize, const B: usize>(&mut self, simd: S, start: usize) {
        let rows = self.c.len() / self.columns;
        let whole = rows / B * B;
        for row in (0..whole).step_by(B) {
            self.patch::<S, V, B>(simd, row, start);
        }
        for row in whole..rows {
            self.patch::<S, V, 1>(simd, row, start);
        }
    }

    #[inline(always)]
    fn patch<S: Simd, const V: usize, const B: usize>(
        &mut self,
        simd: S,
        row: usize,
        start: usize,
    ) {
        let (numbers, down, across) = self.a;
        let width = (self.columns - start).min(V * S::F32_LANES);
        let mut sums = [[simd.splat_f32s(0.0); V]; B];
        if self.add {
            for (b, sums) in sums.iter_mut().enumerate() {
                load(simd, &self.c[(row + b) * self.columns + start..][..width], sums);
            }
        }
        let a: [&[f32]; B] = std::array::from_fn(|b| &numbers[(row + b) * down..]);
        for (k, numbers) in self.b.chunks_exact(self.columns).enumerate() {
            let mut numbers_of_b = [simd.splat_f32s(0.0); V];
            load(simd, &numbers[start..start + width], &mut numbers_of_b);
            for b in 0..B {
                let a = simd.splat_f32s(a[b][k * across]);
                for v in 0..V {
                    sums[b][v] = simd.mul_add_f32s(a, numbers_of_b[v], sums[b][v]);
                }
            }
        }
        for (b, sums) in sums.iter().enumerate() {
            let c = &mut self.c[(row + b) * self.columns + start..][..width];
            for (c, sum) in c.chunks_mut(S::F32_LANES).zip(sums) {
                simd.partial_store_f32s(c, *sum);
            }
        }
    }
}

#[inline(always)]
fn load<S: Simd, const V: usize>(simd: S, from: &[f32], to: &mut [S::f32s; V]) {
    if let Ok(whole) = <&[S::f32s; V]>::try_from(S::as_simd_f32s(from).0) {
        *to = *whole;
        return;
    }
    for (to, from) in to.iter_mut().zip(from.chunks(S::F32_LANES)) {
        *to = simd.partial_load_f32s(from);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_those_of_three_loops() {
        let number = |i: usize| ((i * 7) % 13) as f32 - 6.0;
        for (rows, inner, columns) in [(1, 1, 1), (9, 4, 20), (13, 20, 16), (5, 33, 150)] {
            let a: Vec<f32> = (0..rows * inner).map(number).collect();
            let b: Vec<f32> = (0..inner * columns).map(|i| number(i + 3)).collect();
            for transposed in [false, true] {
                let (down, across) = if transposed { (1, rows) } else { (inner, 1) };
                for add in [false, true] {
                    let mut c: Vec<f32> = (0..rows * columns).map(number).collect();
                    let mut expected = c.clone();
                    for r in 0..rows {
                        for o in 0..columns {
                            let terms =
                                (0..inner).map(|k| a[r * down + k * across] * b[k * columns + o]);
                            let before = if add { expected[r * columns + o] } else { 0.0 };
                            expected[r * columns + o] = before + terms.sum::<f32>();
                        }
                    }
                    multiply((&a, down, across), &b, columns, &mut c, add);
                    assert_eq!(c, expected);
                }
            }
        }
    }
}

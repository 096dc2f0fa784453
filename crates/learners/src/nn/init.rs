//! How weights start.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, Uniform};

/// How the weights of a layer start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Init {
    /// Weights and biases uniform within `1 / sqrt(inputs)`: PyTorch's default for linear maps and convolutions.
    Uniform,
    /// Weights normal with deviation `gain / sqrt(inputs)`, biases zero (LeCun, 1998; PFRL's).
    Normal(f32),
    /// Weights orthogonal, times `gain`, biases zero (Saxe et al., 2014).
    Orthogonal(f32),
}

impl Init {
    /// Appends the weights, shape `[inputs, outputs]`, and then the biases of a layer.
    pub fn layer(
        self,
        inputs: usize,
        outputs: usize,
        rng: &mut ChaCha8Rng,
        parameters: &mut Vec<f32>,
    ) {
        match self {
            Self::Uniform => {
                let bound = 1.0 / (inputs as f32).sqrt();
                let uniform = Uniform::new_inclusive(-bound, bound).expect("the bound is finite");
                parameters.extend(uniform.sample_iter(rng).take((inputs + 1) * outputs));
            }
            Self::Normal(gain) => {
                let deviation = gain / (inputs as f32).sqrt();
                let draw = || -> f32 { rng.sample::<f32, _>(StandardNormal) * deviation };
                parameters.extend(std::iter::repeat_with(draw).take(inputs * outputs));
                parameters.extend(std::iter::repeat_n(0.0, outputs));
            }
            Self::Orthogonal(gain) => {
                parameters.extend(orthogonal(inputs, outputs, rng).iter().map(|w| gain * w));
                parameters.extend(std::iter::repeat_n(0.0, outputs));
            }
        }
    }
}

/// Returns a matrix of orthonormal rows or columns, whichever are fewer: normal numbers after Gram and Schmidt, twice.
fn orthogonal(rows: usize, columns: usize, rng: &mut ChaCha8Rng) -> Vec<f32> {
    let (count, length) = (rows.min(columns), rows.max(columns));
    let mut vectors: Vec<Vec<f64>> = Vec::with_capacity(count);
    for _ in 0..count {
        let mut vector: Vec<f64> = (0..length).map(|_| rng.sample(StandardNormal)).collect();
        for _ in 0..2 {
            for other in &vectors {
                let dot: f64 = vector.iter().zip(other).map(|(a, b)| a * b).sum();
                vector.iter_mut().zip(other).for_each(|(a, b)| *a -= dot * b);
            }
        }
        let norm = vector.iter().map(|a| a * a).sum::<f64>().sqrt();
        vector.iter_mut().for_each(|a| *a /= norm);
        vectors.push(vector);
    }
    let at = |row: usize, column: usize| {
        if rows <= columns { vectors[row][column] } else { vectors[column][row] }
    };
    (0..rows * columns).map(|i| at(i / columns, i % columns) as f32).collect()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    fn layer(init: Init, inputs: usize, outputs: usize) -> Vec<f32> {
        let mut parameters = Vec::new();
        init.layer(inputs, outputs, &mut ChaCha8Rng::seed_from_u64(1), &mut parameters);
        assert_eq!(parameters.len(), (inputs + 1) * outputs);
        parameters
    }

    #[test]
    fn uniform_weights_and_biases_stay_within_the_bound_and_reach_it() {
        let values = layer(Init::Uniform, 16, 200);
        let largest = values.iter().fold(0.0f32, |a, b| a.max(b.abs()));
        assert!(largest <= 0.25 && largest > 0.24, "{largest}");
    }

    #[test]
    fn orthogonal_weights_are_orthogonal_whichever_side_is_longer() {
        for (rows, columns) in [(3, 7), (7, 3)] {
            let values = layer(Init::Orthogonal(2.0), rows, columns);
            let at = |r: usize, c: usize| f64::from(values[r * columns + c]);
            let short = rows.min(columns);
            for i in 0..short {
                for j in 0..short {
                    let dot: f64 = if rows <= columns {
                        (0..columns).map(|c| at(i, c) * at(j, c)).sum()
                    } else {
                        (0..rows).map(|r| at(r, i) * at(r, j)).sum()
                    };
                    assert!((dot - if i == j { 4.0 } else { 0.0 }).abs() < 1e-5);
                }
            }
        }
    }
}

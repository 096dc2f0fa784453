//! The optimiser Adam (Kingma and Ba, 2015), as PyTorch computes it.

use pulp::Arch;

use crate::nn::state::{State, kept};

const BETA1: f32 = 0.9;

const BETA2: f32 = 0.999;

/// Added to the norm of a gradient before dividing by it, as PyTorch's `clip_grad_norm_` does.
const NORM_EPSILON: f32 = 1e-6;

/// Moments smaller than this become zero: arithmetic on subnormal numbers takes the processor many times longer.
const TINY: f32 = 1e-30;

/// Adam and its moments for one vector of parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Adam {
    /// May fall over a training.
    pub(crate) learning_rate: f32,
    epsilon: f32,
    first: Vec<f32>,
    second: Vec<f32>,
    steps: u32,
}

impl Adam {
    /// Returns an optimiser of `parameters` parameters.
    pub fn new(parameters: usize, learning_rate: f32, epsilon: f32) -> Self {
        let zeros = vec![0.0; parameters];
        Self { learning_rate, epsilon, first: zeros.clone(), second: zeros, steps: 0 }
    }

    /// Moves the parameters against the gradient, whose Euclidean norm is first cut to `max_norm`.
    pub fn step(&mut self, parameters: &mut [f32], gradient: &[f32], max_norm: Option<f32>) {
        self.steps += 1;
        let scale = max_norm.map_or(1.0, |max_norm| {
            (max_norm / (sum_of_squares(gradient).sqrt() + NORM_EPSILON)).min(1.0)
        });
        let correction = |beta: f32| 1.0 - f64::from(beta).powi(self.steps.cast_signed());
        let rate = (f64::from(self.learning_rate) / correction(BETA1)) as f32;
        let inverse = 1.0 / correction(BETA2).sqrt() as f32;
        let Self { first, second, epsilon, .. } = self;
        Arch::new().dispatch(
            #[inline(always)]
            || {
                let moments = first.iter_mut().zip(second);
                for ((p, g), (m, v)) in parameters.iter_mut().zip(gradient).zip(moments) {
                    let g = g * scale;
                    let first = BETA1 * *m + (1.0 - BETA1) * g;
                    let second = BETA2 * *v + (1.0 - BETA2) * g * g;
                    *m = if first.abs() < TINY { 0.0 } else { first };
                    *v = if second < TINY { 0.0 } else { second };
                    *p -= rate * *m / (v.sqrt() * inverse + *epsilon);
                }
            },
        );
    }

    /// Whether both moments are numbers.
    pub fn is_finite(&self) -> bool {
        self.first.iter().chain(&self.second).all(|m| m.is_finite())
    }
}

impl State for Adam {
    kept! { State { "adam.first": first, "adam.second": second, "adam.steps": steps } }
}

fn sum_of_squares(x: &[f32]) -> f32 {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            let mut sums = [0.0f32; 32];
            let (chunks, rest) = x.as_chunks::<32>();
            for chunk in chunks {
                for (sum, x) in sums.iter_mut().zip(chunk) {
                    *sum += x * x;
                }
            }
            sums.iter().sum::<f32>() + rest.iter().map(|x| x * x).sum::<f32>()
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nn::archive::Archive;

    #[test]
    fn the_first_steps_are_those_of_the_definition() {
        // First step: both moments are corrected to g and g^2, so the step is the learning rate.
        let mut adam = Adam::new(1, 0.1, 1e-8);
        let mut p = [1.0];
        adam.step(&mut p, &[4.0], None);
        assert!((p[0] - 0.9).abs() < 1e-6);
        // Second: m = 0.9*0.4 - 0.1*2 = 0.16, /0.19 = 0.842; v = 0.999*0.016 + 0.004 = 0.019984,
        // /0.001999 = 9.997; step 0.1 * 0.842 / 3.1618 = 0.02663.
        adam.step(&mut p, &[-2.0], None);
        assert!((p[0] - 0.87337).abs() < 1e-5, "{}", p[0]);
    }

    #[test]
    fn a_long_gradient_is_cut_and_a_short_one_is_not() {
        let moved = |gradient: f32, max_norm| {
            let mut adam = Adam::new(1, 0.1, 1.0);
            let mut p = [0.0];
            adam.step(&mut p, &[gradient], max_norm);
            p[0]
        };
        assert!((moved(10.0, Some(0.5)) - moved(0.5, None)).abs() < 1e-6);
        assert_eq!(moved(0.4, Some(0.5)), moved(0.4, None));
    }

    #[test]
    fn moments_never_become_subnormal() {
        let mut adam = Adam::new(1, 1e-3, 1e-8);
        (adam.first, adam.second) = (vec![1e-29], vec![1e-29]);
        let fine = |moment: f32| moment == 0.0 || moment.is_normal();
        for _ in 0..5000 {
            adam.step(&mut [1.0], &[0.0], None);
            assert!(fine(adam.first[0]) && fine(adam.second[0]));
        }
        assert_eq!((adam.first[0], adam.second[0]), (0.0, 0.0));
    }

    #[test]
    fn a_restored_optimiser_goes_on_as_before() {
        let mut one = Adam::new(2, 0.1, 1e-8);
        let mut p = [1.0, 2.0];
        one.step(&mut p, &[0.3, -0.2], None);
        let mut archive = Archive::default();
        one.save("x.", &mut archive);
        let mut other = Adam::new(2, 0.1, 1e-8);
        other.restore("x.", &archive).unwrap();
        assert_eq!(one, other);
        assert!(Adam::new(3, 0.1, 1e-8).restore("x.", &archive).is_err());
    }
}

//! Shifts and scales observations by their running mean and deviation.

use crate::nn::state::{State, kept};

/// Largest normalised value, in deviations.
const LIMIT: f32 = 10.0;

/// Added to the variance.
const EPSILON: f64 = 1e-8;

/// Running mean and variance of every number of an observation (Welford, 1962).
#[derive(Debug, Clone, PartialEq)]
pub struct Normaliser {
    mean: Vec<f64>,
    /// Sum of squared differences from the mean.
    squares: Vec<f64>,
    count: u64,
}

impl Normaliser {
    /// Returns a normaliser for observations of `width` numbers.
    pub fn new(width: usize) -> Self {
        Self { mean: vec![0.0; width], squares: vec![0.0; width], count: 0 }
    }

    fn update(&mut self, observation: &[f32]) {
        self.count += 1;
        let count = self.count as f64;
        for ((x, mean), squares) in observation.iter().zip(&mut self.mean).zip(&mut self.squares) {
            let x = f64::from(*x);
            let difference = x - *mean;
            *mean += difference / count;
            *squares += difference * (x - *mean);
        }
    }

    /// Normalises an observation in place, after taking it into account where it is to be learned from.
    pub fn take_in(&mut self, observation: &mut [f32], learn: bool) {
        if learn {
            self.update(observation);
        }
        self.apply(observation);
    }

    /// Normalises an observation in place.
    pub fn apply(&self, observation: &mut [f32]) {
        let count = self.count.max(1) as f64;
        for ((x, mean), squares) in observation.iter_mut().zip(&self.mean).zip(&self.squares) {
            let scaled = (f64::from(*x) - mean) / (squares / count + EPSILON).sqrt();
            *x = (scaled as f32).clamp(-LIMIT, LIMIT);
        }
    }
}

impl State for Normaliser {
    kept! { State {
        "normaliser.mean": mean, "normaliser.squares": squares, "normaliser.count": count,
    } }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nn::archive::Archive;

    #[test]
    fn observations_get_mean_zero_and_deviation_one() {
        let mut normaliser = Normaliser::new(2);
        let data = [[1.0, 100.0], [3.0, 100.0], [5.0, 100.0]];
        data.iter().for_each(|x| normaliser.update(x));
        let mut x = [5.0, 100.0];
        normaliser.apply(&mut x);
        assert!((x[0] - 1.5f32.sqrt()).abs() < 1e-5 && x[1] == 0.0, "{x:?}");
        let mut far = [1e6, 101.0];
        normaliser.apply(&mut far);
        assert_eq!(far, [10.0, 10.0]);
        let mut archive = Archive::default();
        normaliser.save("n.", &mut archive);
        let mut other = Normaliser::new(2);
        other.restore("n.", &archive).unwrap();
        assert_eq!(normaliser, other);
        assert!(Normaliser::new(3).restore("n.", &archive).is_err());
    }
}

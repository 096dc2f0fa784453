//! What is computed with the values of actions.

/// Returns the place of the largest number, the first of several.
pub(super) fn largest(values: &[f32]) -> usize {
    (1..values.len()).fold(0, |best, i| if values[i] > values[best] { i } else { best })
}

/// Returns Huber's loss of an error: half its square up to 1, a straight line beyond.
pub(super) fn huber(error: f32) -> f32 {
    let size = error.abs();
    if size <= 1.0 { 0.5 * error * error } else { size - 0.5 }
}

/// Sums over what an algorithm counts its losses by: gradient steps, or updates.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Losses {
    loss: f64,
    entropy: f64,
    pub(super) count: u32,
}

impl Losses {
    /// Adds a loss and an entropy.
    pub(super) fn add(&mut self, loss: f64, entropy: f64) {
        self.loss += loss;
        self.entropy += entropy;
        self.count += 1;
    }

    /// Returns the mean loss and the mean entropy, and begins anew; nothing of nothing.
    pub(super) fn take(&mut self) -> (Option<f64>, Option<f64>) {
        let Self { loss, entropy, count } = std::mem::take(self);
        let mean = |sum: f64| (count > 0).then(|| sum / f64::from(count));
        (mean(loss), mean(entropy))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_several_largest_numbers_is_taken() {
        assert_eq!(
            (largest(&[1.0, 3.0, 3.0]), largest(&[2.0]), largest(&[f32::NAN, 1.0])),
            (1, 0, 0)
        );
    }
}

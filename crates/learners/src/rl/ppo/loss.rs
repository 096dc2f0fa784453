//! The loss of one step and its gradient by what the network gives.

use super::settings::Settings;

/// Sums over a minibatch.
#[derive(Debug, Default)]
pub(super) struct Losses {
    pub(super) total: f32,
    pub(super) entropy: f32,
}

/// What the loss of a step needs, computed before the update.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub(super) action: usize,
    /// Of the action, before the update.
    pub(super) log_probability: f32,
    pub(super) advantage: f32,
    /// What the value is to become.
    pub(super) value: f32,
}

impl Sample {
    /// Adds the loss, and writes its gradient by logits and value.
    pub(super) fn loss(
        &self,
        output: &[f32],
        settings: &Settings,
        probabilities: &mut [f32],
        gradient: &mut [f32],
        sums: &mut Losses,
    ) {
        let actions = output.len() - 1;
        let (logits, value) = (&output[..actions], output[actions]);
        softmax(logits, probabilities);
        let log = log_probability(logits, self.action);
        let ratio = (log - self.log_probability).exp();
        let clipped = ratio.clamp(1.0 - settings.clip_range, 1.0 + settings.clip_range);
        let (free, cut) = (ratio * self.advantage, clipped * self.advantage);
        // Beyond the clip range the surrogate is flat.
        let slope = if free <= cut { -free } else { 0.0 };
        let logs = |i: usize| probabilities[i].max(f32::MIN_POSITIVE).ln();
        let entropy: f32 = (0..actions).map(|i| -probabilities[i] * logs(i)).sum();
        for (i, g) in gradient[..actions].iter_mut().enumerate() {
            let p = probabilities[i];
            let chosen = f32::from(u8::from(i == self.action));
            *g = slope * (chosen - p) + settings.entropy_coefficient * p * (logs(i) + entropy);
        }
        let error = value - self.value;
        gradient[actions] = 2.0 * settings.value_coefficient * error;
        sums.total += settings.value_coefficient * error * error
            - free.min(cut)
            - settings.entropy_coefficient * entropy;
        sums.entropy += entropy;
    }
}

pub(super) fn softmax(logits: &[f32], probabilities: &mut [f32]) {
    let largest = logits.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let mut sum = 0.0;
    for (p, logit) in probabilities.iter_mut().zip(logits) {
        *p = (logit - largest).exp();
        sum += *p;
    }
    probabilities.iter_mut().for_each(|p| *p /= sum);
}

pub(super) fn log_probability(logits: &[f32], action: usize) -> f32 {
    let largest = logits.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let sum: f32 = logits.iter().map(|l| (l - largest).exp()).sum();
    logits[action] - largest - sum.ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> Settings {
        Settings {
            learning_rate: 1e-3,
            adam_epsilon: 1e-5,
            gamma: 0.9,
            gae_lambda: 0.9,
            num_steps: 4,
            update_epochs: 1,
            minibatch_size: 4,
            clip_range: 0.1,
            value_coefficient: 0.7,
            entropy_coefficient: 0.3,
            max_grad_norm: 0.5,
        }
    }

    fn loss(sample: Sample, output: &[f32]) -> (f32, Vec<f32>) {
        let mut sums = Losses::default();
        let mut gradient = vec![0.0; output.len()];
        let mut probabilities = vec![0.0; output.len() - 1];
        sample.loss(output, &settings(), &mut probabilities, &mut gradient, &mut sums);
        (sums.total, gradient)
    }

    #[test]
    fn the_gradient_is_that_of_finite_differences() {
        let output = [0.3, -0.8, 0.5, 1.5];
        let log = log_probability(&output[..3], 2);
        for (advantage, shift) in [(1.3, 0.05), (-0.7, 0.05), (1.3, -0.3), (-0.7, -0.3), (2.0, 0.4)]
        {
            let sample = Sample { action: 2, log_probability: log - shift, advantage, value: -0.4 };
            let (_, gradient) = loss(sample, &output);
            for i in 0..4 {
                let moved = |step: f32| {
                    let mut output = output;
                    output[i] += step;
                    f64::from(loss(sample, &output).0)
                };
                let slope = (moved(1e-2) - moved(-1e-2)) / 2e-2;
                assert!((slope - f64::from(gradient[i])).abs() < 2e-3, "{i}: {slope}");
            }
        }
    }

    #[test]
    fn beyond_the_clip_range_an_advantage_pulls_no_further() {
        let output = [0.0, 0.0, 0.0];
        let sample = |shift: f32, advantage| Sample {
            action: 0,
            log_probability: 0.5f32.ln() - shift,
            advantage,
            value: 0.0,
        };
        // Twice as likely as before: too far for a good action, not for a bad one.
        assert_eq!(loss(sample(2f32.ln(), 1.0), &output).1[0], 0.0);
        assert!(loss(sample(2f32.ln(), -1.0), &output).1[0] > 0.0);
        // The loss by hand: ratio 2, clipped 1.1; entropy ln 2.
        let expected = -1.1 - 0.3 * 2f32.ln();
        assert!((loss(sample(2f32.ln(), 1.0), &output).0 - expected).abs() < 1e-6);
    }

    #[test]
    fn probabilities_of_huge_logits_are_finite() {
        let mut probabilities = [0.0; 2];
        softmax(&[1e30, -1e30], &mut probabilities);
        assert_eq!(probabilities, [1.0, 0.0]);
        assert_eq!(log_probability(&[1e4, 0.0], 0), 0.0);
    }
}

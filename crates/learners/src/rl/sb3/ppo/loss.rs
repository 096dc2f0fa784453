//! The loss of a minibatch and its gradients by what the networks give.

use super::Settings;
use crate::rl::sb3::actor_critic::Outputs;
use crate::rl::sb3::distribution::{Distribution, Flavour};
use crate::rl::sb3::rollout::Batch;
use crate::rl::values::Losses;

/// Added to the deviation that advantages are divided by.
const DEVIATION_EPSILON: f32 = 1e-8;

/// Steps of one gradient step, and the gradients of its loss.
#[derive(Debug, Clone, Default)]
pub(super) struct Minibatch {
    pub(super) batch: Batch,
    pub(super) by_outputs: Vec<f32>,
    pub(super) by_log_std: Vec<f32>,
    pub(super) by_values: Vec<f32>,
}

impl Minibatch {
    /// Computes the gradients of the loss, and adds it to the sums.
    pub(super) fn loss(
        &mut self,
        distribution: &mut Distribution,
        Outputs { policy, log_std, values }: Outputs<'_>,
        settings: &Settings,
        clip_range: f32,
        losses: &mut Losses,
    ) {
        let count = values.len();
        let Batch { actions, logs, advantages, returns, .. } = &self.batch;
        let (width, action_width) = (policy.len() / count, actions.len() / count);
        let share = 1.0 / count as f32;
        self.by_outputs.resize(policy.len(), 0.0);
        self.by_values.resize(count, 0.0);
        self.by_log_std.clear();
        self.by_log_std.resize(log_std.len(), 0.0);
        let Settings { value_coefficient, entropy_coefficient, .. } = *settings;
        let (mut surrogate, mut squares, mut entropies, mut in_turn) = (0.0, 0.0, 0.0, 0.0);
        let rows = policy.chunks_exact(width).zip(self.by_outputs.chunks_exact_mut(width));
        for (i, (outputs, gradient)) in rows.enumerate() {
            let action = &actions[i * action_width..][..action_width];
            let advantage = advantages[i];
            let log = distribution.log(outputs, log_std, action);
            let ratio = distribution.flavour.exp()(log - logs[i]);
            let clipped = ratio.clamp(1.0 - clip_range, 1.0 + clip_range);
            let (free, cut) = (ratio * advantage, clipped * advantage);
            surrogate -= free.min(cut);
            // Beyond the clip range the surrogate is flat.
            let slope = if free <= cut { -free } else { 0.0 };
            let entropy = distribution.gradient(
                outputs, log_std, action, slope, entropy_coefficient, share, gradient,
                &mut self.by_log_std,
            );
            entropies += entropy;
            let error = values[i] - returns[i];
            squares += error * error;
            self.by_values[i] = share * 2.0 * value_coefficient * error;
            in_turn +=
                value_coefficient * error * error - free.min(cut) - entropy_coefficient * entropy;
        }
        // The same up to rounding.
        let sum = match distribution.flavour {
            Flavour::Pfrl => in_turn,
            Flavour::StableBaselines3 => {
                surrogate + value_coefficient * squares - entropy_coefficient * entropies
            }
        };
        losses.add(f64::from(share * sum), f64::from(share * entropies));
    }
}

/// Shifts and scales numbers to mean 0 and deviation 1; its square is the sum of squares divided by `degrees`.
pub(in crate::rl::sb3) fn standardise(numbers: &mut [f32], degrees: f32) {
    let mean = numbers.iter().sum::<f32>() / numbers.len() as f32;
    let squares: f32 = numbers.iter().map(|a| (a - mean) * (a - mean)).sum();
    let scale = 1.0 / ((squares / degrees).sqrt() + DEVIATION_EPSILON);
    numbers.iter_mut().for_each(|a| *a = (*a - mean) * scale);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rl::environment::Actions;

    const CLIP: f32 = 0.2;

    #[test]
    fn the_loss_is_that_computed_by_hand() {
        for flavour in [Flavour::Pfrl, Flavour::StableBaselines3] {
            // One step, two equally likely actions, twice as likely as before: ratio 2 is cut to 1.2.
            let batch = Batch {
                actions: vec![0.0],
                logs: vec![0.25f32.ln()],
                advantages: vec![1.0],
                returns: vec![2.0],
                ..Batch::default()
            };
            let mut one = Minibatch { batch, ..Minibatch::default() };
            let mut distribution = Distribution::new(Actions::Numbered(2), flavour);
            let settings = Settings {
                entropy_coefficient: 0.3,
                value_coefficient: 0.7,
                ..Settings::default()
            };
            let outputs = Outputs { policy: &[0.0, 0.0], log_std: &[], values: &[1.0] };
            let mut losses = Losses::default();
            one.loss(&mut distribution, outputs, &settings, CLIP, &mut losses);
            let found = losses.take().0.unwrap();
            assert!((found - (-1.2 + 0.7 - 0.3 * 2f64.ln())).abs() < 1e-6, "{found}");
            assert_eq!((one.by_outputs[0], one.by_values[0]), (0.0, -1.4));
            one.batch.advantages = vec![-1.0];
            // A bad action is pushed down however likely it has become.
            one.loss(&mut distribution, outputs, &settings, CLIP, &mut losses);
            assert!((one.by_outputs[0] - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn advantages_get_mean_0_and_unbiased_deviation_1() {
        let mut numbers = [1.0, 2.0, 6.0];
        standardise(&mut numbers, 2.0);
        // Mean 3, squares 4 + 1 + 9, deviation sqrt(7).
        let expected = [-2.0, -1.0, 3.0].map(|x: f32| x / 7f32.sqrt());
        numbers.iter().zip(expected).for_each(|(a, b)| assert!((a - b).abs() < 1e-6));
    }
}

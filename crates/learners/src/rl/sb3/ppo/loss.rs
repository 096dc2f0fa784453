//! The loss of a minibatch and its gradients by what the networks give.

use super::Settings;
use crate::rl::environment::Actions;
use crate::rl::sb3::actor_critic::Outputs;
use crate::rl::sb3::distribution::Distribution;
use crate::rl::sb3::on_policy::Losses;
use crate::rl::sb3::rollout::Rollout;

/// Added to the deviation that advantages are divided by.
const DEVIATION_EPSILON: f32 = 1e-8;

/// Steps of one gradient step, and the gradients of its loss.
#[derive(Debug, Clone)]
pub(super) struct Minibatch {
    distribution: Distribution,
    action_width: usize,
    pub(super) states: Vec<f32>,
    actions: Vec<f32>,
    /// Logarithms of the probabilities that the actions had.
    before: Vec<f32>,
    advantages: Vec<f32>,
    /// What the values are to become.
    returns: Vec<f32>,
    pub(super) by_outputs: Vec<f32>,
    pub(super) by_log_std: Vec<f32>,
    pub(super) by_values: Vec<f32>,
}

impl Minibatch {
    pub(super) fn new(actions: Actions) -> Self {
        Self {
            distribution: Distribution::new(actions),
            action_width: actions.width(),
            states: Vec::new(),
            actions: Vec::new(),
            before: Vec::new(),
            advantages: Vec::new(),
            returns: Vec::new(),
            by_outputs: Vec::new(),
            by_log_std: Vec::new(),
            by_values: Vec::new(),
        }
    }

    /// Returns a minibatch of given states, actions, logarithms, advantages and returns.
    #[cfg(test)]
    pub(super) fn of(actions: Actions, parts: [Vec<f32>; 5]) -> Self {
        let [states, taken, before, mut advantages, returns] = parts;
        standardise(&mut advantages);
        Self { states, actions: taken, before, advantages, returns, ..Self::new(actions) }
    }

    /// Takes the steps at these places and standardises their advantages.
    pub(super) fn gather(&mut self, rollout: &Rollout, places: &[usize]) {
        self.states.clear();
        self.actions.clear();
        self.before.clear();
        self.advantages.clear();
        self.returns.clear();
        for place in places {
            let sample = rollout.sample(*place);
            self.states.extend_from_slice(sample.state);
            self.actions.extend_from_slice(sample.action);
            self.before.push(sample.log);
            self.advantages.push(sample.advantage);
            self.returns.push(sample.value);
        }
        standardise(&mut self.advantages);
    }

    /// Computes the gradients of the loss, and adds it to the sums.
    pub(super) fn loss(
        &mut self,
        Outputs { policy, log_std, values }: Outputs<'_>,
        settings: &Settings,
        clip_range: f32,
        losses: &mut Losses,
    ) {
        let count = values.len();
        let width = policy.len() / count;
        let share = 1.0 / count as f32;
        self.by_outputs.resize(policy.len(), 0.0);
        self.by_values.resize(count, 0.0);
        self.by_log_std.clear();
        self.by_log_std.resize(log_std.len(), 0.0);
        let (mut surrogate, mut squares, mut entropies) = (0.0, 0.0, 0.0);
        let rows = policy.chunks_exact(width).zip(self.by_outputs.chunks_exact_mut(width));
        for (i, (outputs, gradient)) in rows.enumerate() {
            let (action, advantage) =
                (&self.actions[i * self.action_width..][..self.action_width], self.advantages[i]);
            let ratio =
                libm::expf(self.distribution.log(outputs, log_std, action) - self.before[i]);
            let clipped = ratio.clamp(1.0 - clip_range, 1.0 + clip_range);
            let (free, cut) = (ratio * advantage, clipped * advantage);
            surrogate -= free.min(cut);
            // Beyond the clip range the surrogate is flat.
            let slope = if free <= cut { -free } else { 0.0 };
            entropies += self.distribution.gradient(
                outputs, log_std, action, slope, settings.entropy_coefficient, share, gradient,
                &mut self.by_log_std,
            );
            let error = values[i] - self.returns[i];
            squares += error * error;
            self.by_values[i] = share * 2.0 * settings.value_coefficient * error;
        }
        let Settings { value_coefficient, entropy_coefficient, .. } = *settings;
        let sum = surrogate + value_coefficient * squares - entropy_coefficient * entropies;
        losses.add(f64::from(share * sum), f64::from(share * entropies));
    }
}

/// Shifts and scales numbers to mean 0 and (unbiased) deviation 1; a single number stays as it is.
pub(in crate::rl::sb3) fn standardise(numbers: &mut [f32]) {
    if numbers.len() < 2 {
        return;
    }
    let count = numbers.len() as f32;
    let mean = numbers.iter().sum::<f32>() / count;
    let squares: f32 = numbers.iter().map(|a| (a - mean) * (a - mean)).sum();
    let scale = 1.0 / ((squares / (count - 1.0)).sqrt() + DEVIATION_EPSILON);
    numbers.iter_mut().for_each(|a| *a = (*a - mean) * scale);
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLIP: f32 = 0.2;

    /// Three steps of three actions: within the clip range, beyond it above, beyond it below.
    fn minibatch() -> (Minibatch, [f32; 9], [f32; 3]) {
        let logits = [0.3, -0.8, 0.5, 1.0, 0.1, -0.4, 0.0, 0.2, 0.4];
        let mut minibatch = Minibatch {
            actions: vec![2.0, 0.0, 1.0],
            advantages: vec![1.3, 0.9, -0.7],
            returns: vec![-0.4, 1.1, 0.3],
            ..Minibatch::new(Actions::Numbered(3))
        };
        for ((logits, action), shift) in
            logits.chunks(3).zip([2.0, 0.0, 1.0]).zip([0.05, 0.4, -0.1])
        {
            let log = minibatch.distribution.log(logits, &[], &[action]);
            minibatch.before.push(log - shift);
        }
        (minibatch, logits, [0.5, -0.2, 0.6])
    }

    fn loss(minibatch: &mut Minibatch, logits: &[f32], values: &[f32]) -> f64 {
        let mut losses = Losses::default();
        let settings =
            Settings { entropy_coefficient: 0.3, value_coefficient: 0.7, ..Settings::default() };
        let outputs = Outputs { policy: logits, log_std: &[], values };
        minibatch.loss(outputs, &settings, CLIP, &mut losses);
        losses.means().0.unwrap()
    }

    #[test]
    fn gradients_are_those_of_finite_differences() {
        let (mut minibatch, logits, values) = minibatch();
        loss(&mut minibatch, &logits, &values);
        let (by_outputs, by_values) = (minibatch.by_outputs.clone(), minibatch.by_values.clone());
        let both: Vec<f32> = logits.into_iter().chain(values).collect();
        for (i, gradient) in by_outputs.iter().chain(&by_values).enumerate() {
            let mut moved = |step: f32| {
                let mut both = both.clone();
                both[i] += step;
                loss(&mut minibatch, &both[..9], &both[9..])
            };
            let slope = (moved(1e-2) - moved(-1e-2)) / 2e-2;
            assert!((slope - f64::from(*gradient)).abs() < 1e-3, "{i}: {slope} {gradient}");
        }
    }

    #[test]
    fn the_loss_is_that_computed_by_hand() {
        // One step, two equally likely actions, twice as likely as before: ratio 2 is cut to 1.2.
        let mut one = Minibatch {
            actions: vec![0.0],
            before: vec![0.25f32.ln()],
            advantages: vec![1.0],
            returns: vec![2.0],
            ..Minibatch::new(Actions::Numbered(2))
        };
        let found = loss(&mut one, &[0.0, 0.0], &[1.0]);
        assert!((found - (-1.2 + 0.7 - 0.3 * 2f64.ln())).abs() < 1e-6, "{found}");
        assert_eq!((one.by_outputs[0], one.by_values[0]), (0.0, -1.4));
        one.advantages = vec![-1.0];
        // A bad action is pushed down however likely it has become.
        loss(&mut one, &[0.0, 0.0], &[1.0]);
        assert!((one.by_outputs[0] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn advantages_get_mean_0_and_unbiased_deviation_1() {
        let mut numbers = [1.0, 2.0, 6.0];
        standardise(&mut numbers);
        // Mean 3, squares 4 + 1 + 9, deviation sqrt(7).
        let expected = [-2.0, -1.0, 3.0].map(|x: f32| x / 7f32.sqrt());
        numbers.iter().zip(expected).for_each(|(a, b)| assert!((a - b).abs() < 1e-6));
        let mut one = [5.0];
        standardise(&mut one);
        assert_eq!(one, [5.0]);
    }
}

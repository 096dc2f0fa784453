//! Distributions of actions that a policy's outputs stand for, as Stable-Baselines3's.
//!
//! - **Numbered actions**: the outputs are logits.
//! - **Continuous actions**: the outputs are the means of normal numbers whose deviations do not depend on the state;
//!   their logarithms are parameters beside the network. A drawn action may lie outside of what the environment allows:
//!   what is learned from is the drawn one, what is done is the cut one.

use crate::rl::environment::Actions;
use crate::rl::largest;
use crate::rl::random::Generator;
use crate::rl::{depends_on_both, depends_on_state};

/// Half the logarithm of 2 pi.
const HALF_LOG_TAU: f32 = 0.918_938_5;

/// Whose choices are made where implementations differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::rl) enum Flavour {
    Pfrl,
    StableBaselines3,
}

impl Flavour {
    /// Returns the exponential function; PFRL's records were computed with the platform's.
    pub(super) fn exp(self) -> fn(f32) -> f32 {
        if self == Self::Pfrl { f32::exp } else { libm::expf }
    }

    fn ln(self) -> fn(f32) -> f32 {
        if self == Self::Pfrl { f32::ln } else { libm::logf }
    }
}

#[derive(Debug, Clone)]
pub(super) struct Distribution {
    actions: Actions,
    pub(super) flavour: Flavour,
    probabilities: Vec<f32>,
    logs: Vec<f32>,
}

impl Distribution {
    pub(super) fn new(actions: Actions, flavour: Flavour) -> Self {
        let zeros = vec![0.0; actions.outputs()];
        Self { actions, flavour, probabilities: zeros.clone(), logs: zeros }
    }

    pub(super) fn outputs(&self) -> usize {
        self.actions.outputs()
    }

    /// Returns how many parameters there are beside the network's: logarithms of deviations.
    pub(super) fn parameters(actions: Actions) -> usize {
        match actions {
            Actions::Numbered(_) => 0,
            Actions::Continuous { count, .. } => count,
        }
    }

    fn weigh(&mut self, logits: &[f32]) {
        let exp = self.flavour.exp();
        let largest = logits.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let sum: f32 = logits.iter().map(|logit| exp(logit - largest)).sum();
        let log_of_sum = self.flavour.ln()(sum);
        let all = self.probabilities.iter_mut().zip(&mut self.logs);
        for ((p, log), logit) in all.zip(logits) {
            *log = (logit - largest) - log_of_sum;
            *p = match self.flavour {
                Flavour::Pfrl => exp(logit - largest) / sum,
                Flavour::StableBaselines3 => exp(*log),
            };
        }
    }

    pub(super) fn draw(
        &mut self,
        outputs: &[f32],
        log_std: &[f32],
        generator: &mut Generator,
        action: &mut [f32],
    ) -> f32 {
        match self.actions {
            Actions::Numbered(_) => {
                self.weigh(outputs);
                let number = draw(&self.probabilities, generator);
                action[0] = number as f32;
                self.logs[number]
            }
            Actions::Continuous { .. } => {
                for ((action, mean), log) in action.iter_mut().zip(outputs).zip(log_std) {
                    *action = mean + libm::expf(*log) * generator.normal() as f32;
                }
                self.log(outputs, log_std, action)
            }
        }
    }

    pub(super) fn best(&self, outputs: &[f32], action: &mut [f32]) {
        match self.actions {
            Actions::Numbered(_) => action[0] = largest(outputs) as f32,
            Actions::Continuous { .. } => {
                action.copy_from_slice(outputs);
                self.cut(action);
            }
        }
    }

    pub(super) fn cut(&self, action: &mut [f32]) {
        if let Actions::Continuous { limit, .. } = self.actions {
            action.iter_mut().for_each(|a| *a = a.clamp(-limit, limit));
        }
    }

    pub(super) fn log(&mut self, outputs: &[f32], log_std: &[f32], action: &[f32]) -> f32 {
        match self.actions {
            Actions::Numbered(_) => {
                self.weigh(outputs);
                self.logs[action[0] as usize]
            }
            Actions::Continuous { .. } => {
                let each = action.iter().zip(outputs).zip(log_std).map(|((action, mean), log)| {
                    let z = (action - mean) * libm::expf(-*log);
                    -0.5 * z * z - log - HALF_LOG_TAU
                });
                each.sum()
            }
        }
    }

    /// Writes the gradient of `share * (slope * log - entropy_coefficient * entropy)` by the outputs, adds that by the
    /// logarithms of deviations, and returns the entropy.
    /// Belongs to the last [`Self::log`], with the same outputs and action.
    #[expect(
        clippy::too_many_arguments,
        reason = "a state's part of a loss, and both of its gradients"
    )]
    pub(super) fn gradient(
        &self,
        outputs: &[f32],
        log_std: &[f32],
        action: &[f32],
        slope: f32,
        entropy_coefficient: f32,
        share: f32,
        by_outputs: &mut [f32],
        by_log_std: &mut [f32],
    ) -> f32 {
        let mut entropy = 0.0;
        match self.actions {
            Actions::Numbered(_) => {
                // Finite also where nothing is likely.
                let finite = |(p, log): (&f32, &f32)| match self.flavour {
                    Flavour::Pfrl => (*p, p.max(f32::MIN_POSITIVE).ln()),
                    Flavour::StableBaselines3 => (*p, log.max(f32::MIN)),
                };
                let weights = self.probabilities.iter().zip(&self.logs).map(finite);
                entropy -= weights.clone().map(|(p, log)| p * log).sum::<f32>();
                for (a, (g, (p, log))) in by_outputs.iter_mut().zip(weights).enumerate() {
                    let chosen = if a == action[0] as usize { 1.0 } else { 0.0 };
                    let by_entropy = entropy_coefficient * p * (log + entropy);
                    *g = share * (slope * (chosen - p) + by_entropy);
                }
            }
            Actions::Continuous { .. } => {
                for (i, log) in log_std.iter().enumerate() {
                    let scale = libm::expf(-*log);
                    let z = (action[i] - outputs[i]) * scale;
                    entropy += log + HALF_LOG_TAU + 0.5;
                    by_outputs[i] = share * slope * z * scale;
                    by_log_std[i] += share * (slope * (z * z - 1.0) - entropy_coefficient);
                }
            }
        }
        entropy
    }

    /// Returns the divergence of Kullback and Leibler of what outputs stand for, from what others did; of a continuous action
    /// the mean over its numbers, as sb3-contrib computes it, not the sum.
    pub(super) fn divergence(
        &mut self,
        (outputs, log_std): (&[f32], &[f32]),
        (before, log_std_before): (&[f32], &[f32]),
    ) -> f32 {
        match self.actions {
            Actions::Numbered(_) => {
                self.weigh(outputs);
                // The logits before, up to what all of them have in common.
                let largest = before.iter().copied().fold(f32::NEG_INFINITY, f32::max);
                let sum: f32 = before.iter().map(|l| libm::expf(l - largest)).sum();
                let log = libm::logf(sum);
                let each = self.probabilities.iter().zip(&self.logs).zip(before);
                each.map(|((p, new), old)| p * (new - (old - largest - log))).sum()
            }
            Actions::Continuous { .. } => {
                let each = (0..outputs.len()).map(|i| {
                    let (new, old) = (log_std[i], log_std_before[i]);
                    let (ratio, scale) = (libm::expf(2.0 * (new - old)), libm::expf(-old));
                    let shift = (outputs[i] - before[i]) * scale;
                    0.5 * (ratio + shift * shift - 1.0) - (new - old)
                });
                each.sum::<f32>() / outputs.len() as f32
            }
        }
    }

    /// Turns a move of one state's outputs into Fisher's metric times it, times `share`.
    /// The metric belongs to [`Self::divergence`]; returns it by the logarithm of a deviation, which is the same in every state.
    pub(super) fn metric(
        &mut self,
        outputs: &[f32],
        log_std: &[f32],
        share: f32,
        moved: &mut [f32],
    ) -> f32 {
        match self.actions {
            Actions::Numbered(_) => {
                self.weigh(outputs);
                let mean: f32 = self.probabilities.iter().zip(&*moved).map(|(p, m)| p * m).sum();
                let each = moved.iter_mut().zip(&self.probabilities);
                each.for_each(|(m, p)| *m = share * p * (*m - mean));
                0.0
            }
            Actions::Continuous { .. } => {
                let share = share / outputs.len() as f32;
                let each = moved.iter_mut().zip(log_std);
                each.for_each(|(m, log)| *m *= share * libm::expf(-2.0 * log));
                2.0 / outputs.len() as f32
            }
        }
    }

    /// Whether outputs of several states say something of the state, and of the action where those are numbered.
    pub(super) fn is_alive(&self, outputs: &[f32]) -> bool {
        match self.actions {
            Actions::Numbered(count) => depends_on_both(outputs, count),
            Actions::Continuous { count, .. } => depends_on_state(outputs, count),
        }
    }
}

fn draw(probabilities: &[f32], generator: &mut Generator) -> usize {
    let mut left = generator.unit() as f32;
    for (action, p) in probabilities.iter().enumerate() {
        left -= p;
        if left < 0.0 {
            return action;
        }
    }
    // Rounding may leave a trace: the last action that can happen.
    probabilities.iter().rposition(|p| *p > 0.0).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SB3: Flavour = Flavour::StableBaselines3;

    const BOTH: [Actions; 2] = [Actions::Numbered(3), Actions::Continuous { count: 3, limit: 2.0 }];

    #[test]
    fn actions_are_drawn_as_often_as_they_are_likely() {
        let mut generator = Generator::new(1, &[]);
        let count = (0..10_000).filter(|_| draw(&[0.25, 0.75], &mut generator) == 1).count();
        assert!((7350..7650).contains(&count), "{count}");
    }

    #[test]
    fn continuous_actions_have_their_mean_and_deviation_and_are_cut_only_when_done() {
        let mut distribution = Distribution::new(Actions::Continuous { count: 1, limit: 2.0 }, SB3);
        let mut generator = Generator::new(1, &[]);
        let (mut sum, mut squares, mut beyond) = (0.0, 0.0, 0);
        let mut action = [0.0];
        for _ in 0..20_000 {
            let log = distribution.draw(&[1.5], &[0.5f32.ln()], &mut generator, &mut action);
            let z = f64::from(action[0] - 1.5) / 0.5;
            assert!((f64::from(log) - (-0.5 * z * z - 0.5f64.ln() - 0.918_938_5)).abs() < 1e-5);
            sum += z;
            squares += z * z;
            beyond += u32::from(action[0] > 2.0);
            distribution.cut(&mut action);
            assert!(action[0] <= 2.0);
        }
        assert!((sum / 2e4).abs() < 0.03 && (squares / 2e4 - 1.0).abs() < 0.04);
        // One deviation above the mean: 15.9%.
        assert!((3000..3350).contains(&beyond), "{beyond}");
    }

    fn numbers(seed: u64) -> [f32; 3] {
        let mut generator = Generator::new(seed, &[]);
        std::array::from_fn(|_| generator.normal() as f32)
    }

    #[test]
    fn gradients_are_those_of_finite_differences() {
        for (actions, flavour) in [(BOTH[0], SB3), (BOTH[1], SB3), (BOTH[0], Flavour::Pfrl)] {
            let mut distribution = Distribution::new(actions, flavour);
            let (outputs, log_std) = (numbers(1), numbers(2).map(|x| 0.3 * x));
            let action = match actions {
                Actions::Numbered(_) => vec![2.0],
                Actions::Continuous { .. } => numbers(3).to_vec(),
            };
            let (mut by_outputs, mut by_log_std) = ([0.0; 3], [0.0; 3]);
            let mut loss = |outputs: &[f32],
                            log_std: &[f32],
                            by_outputs: &mut [f32],
                            by_log_std: &mut [f32]| {
                let log = distribution.log(outputs, log_std, &action);
                let entropy = distribution
                    .gradient(outputs, log_std, &action, 0.7, 0.4, 0.5, by_outputs, by_log_std);
                0.5 * (0.7 * log - 0.4 * entropy)
            };
            loss(&outputs, &log_std, &mut by_outputs, &mut by_log_std);
            for i in 0..6 {
                let mut at = |step: f32| {
                    let (mut outputs, mut log_std) = (outputs, log_std);
                    if i < 3 {
                        outputs[i] += step
                    } else {
                        log_std[i - 3] += step
                    }
                    loss(&outputs, &log_std, &mut [0.0; 3], &mut [0.0; 3])
                };
                let slope = (at(1e-2) - at(-1e-2)) / 2e-2;
                let found = if i < 3 { by_outputs[i] } else { by_log_std[i - 3] };
                assert!((slope - found).abs() < 1e-3, "{actions:?} {i}: {slope} {found}");
            }
        }
    }

    #[test]
    fn the_metric_is_the_curvature_of_the_divergence() {
        for actions in BOTH {
            let mut distribution = Distribution::new(actions, SB3);
            let (outputs, log_std, direction) = (numbers(1), numbers(2), numbers(4));
            let mut at = |step: f32, deviations: f32| {
                let moved: Vec<f32> =
                    outputs.iter().zip(direction).map(|(o, d)| o + step * d).collect();
                let wider: Vec<f32> = log_std.iter().map(|l| l + deviations).collect();
                distribution.divergence((&moved, &wider), (&outputs, &log_std))
            };
            assert!(at(0.0, 0.0).abs() < 1e-6);
            let curvature = (at(0.1, 0.0) + at(-0.1, 0.0)) / 0.01;
            // Of three deviations, each with a third of a metric of 2.
            let wider = (at(0.0, 0.03) + at(0.0, -0.03)) / 9e-4;
            let expected = if actions == BOTH[0] { 0.0 } else { 2.0 };
            assert!((wider - expected).abs() < 0.05, "{wider}");
            let mut moved = direction;
            distribution.metric(&outputs, &log_std, 1.0, &mut moved);
            let product: f32 = moved.iter().zip(direction).map(|(m, d)| m * d).sum();
            assert!((curvature - product).abs() < 0.01 * product.max(1.0), "{curvature} {product}");
        }
    }

    #[test]
    fn huge_logits_give_finite_gradients() {
        let mut distribution = Distribution::new(BOTH[0], SB3);
        let outputs = [1e30, -1e30, 0.0];
        let log = distribution.log(&outputs, &[], &[0.0]);
        let mut by_outputs = [0.0; 3];
        let entropy =
            distribution.gradient(&outputs, &[], &[0.0], 1.0, 0.3, 1.0, &mut by_outputs, &mut []);
        assert!(log.is_finite() && entropy.is_finite() && by_outputs.iter().all(|g| g.is_finite()));
    }
}

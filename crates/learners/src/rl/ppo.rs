//! Proximal policy optimisation (Schulman et al., 2017) with numbered actions.
//!
//! One network gives the logits of all actions and, last, the value of the state.
//!
//! Choices where implementations differ, all PFRL's, which RESCO uses:
//! - **Loss**: clipped surrogate, plus the squared error of the value (not halved, not clipped), less
//!   the entropy.
//! - **Advantages** are standardised once per update, over all its steps.
//! - **Minibatches** come from fresh permutations; what one leaves over goes to the next minibatch.
//! - **Values and probabilities** to compare with are the network's just before the update.

mod loss;
mod persist;
mod rollout;
mod settings;

pub use self::rollout::End;
pub use self::settings::Settings;

use rand::seq::SliceRandom;

use self::loss::{Losses, Sample, log_probability, softmax};
use self::rollout::Rollout;
use super::gae::{Step, advantages};
use super::random::Generator;
use super::values::largest;
use crate::nn::Network;
use crate::nn::adam::Adam;

/// Added to the deviation that advantages are divided by.
const DEVIATION_EPSILON: f32 = 1e-8;

/// Rows of one forward pass over everything collected, which bounds the memory of its buffers.
const ROWS: usize = 256;

/// A learner of a policy and its value.
#[derive(Debug, Clone)]
pub struct Ppo<N> {
    network: N,
    settings: Settings,
    parameters: Vec<f32>,
    adam: Adam,
    sampling: Generator,
    shuffling: Generator,
    collected: Rollout,
    loss_sum: f64,
    entropy_sum: f64,
    losses: u32,
    buffers: Buffers,
}

/// Numbers of one update.
#[derive(Debug, Clone, Default)]
struct Buffers {
    probabilities: Vec<f32>,
    log_probabilities: Vec<f32>,
    values: Vec<f32>,
    values_after: Vec<f32>,
    steps: Vec<Step>,
    advantages: Vec<f32>,
    order: Vec<usize>,
    states: Vec<f32>,
    output_gradient: Vec<f32>,
    gradient: Vec<f32>,
}

impl<N: Network> Ppo<N> {
    /// Returns a learner that starts from these parameters; `seed` and `labels` name its randomness.
    pub fn new(
        network: N,
        parameters: Vec<f32>,
        settings: Settings,
        seed: u64,
        labels: &[&str],
    ) -> Self {
        let label = |last: &'static str| [labels, &[last]].concat();
        Self {
            adam: Adam::new(parameters.len(), settings.learning_rate, settings.adam_epsilon),
            sampling: Generator::new(seed, &label("sampling")),
            shuffling: Generator::new(seed, &label("shuffling")),
            collected: Rollout::default(),
            loss_sum: 0.0,
            entropy_sum: 0.0,
            losses: 0,
            buffers: Buffers { gradient: vec![0.0; parameters.len()], ..Buffers::default() },
            network,
            settings,
            parameters,
        }
    }

    /// Draws an action; `generator` replaces the one of training, so that evaluation leaves that as
    /// it is.
    pub fn sample(&mut self, state: &[f32], generator: Option<&mut Generator>) -> usize {
        let outputs = self.network.single(&self.parameters, state);
        let (logits, _) = outputs.split_at(outputs.len() - 1);
        let probabilities = &mut self.buffers.probabilities;
        probabilities.resize(logits.len(), 0.0);
        softmax(logits, probabilities);
        let mut left = generator.unwrap_or(&mut self.sampling).unit() as f32;
        for (action, p) in probabilities.iter().enumerate() {
            left -= p;
            if left < 0.0 {
                return action;
            }
        }
        // Rounding may leave a trace: the last action that can happen.
        probabilities.iter().rposition(|p| *p > 0.0).unwrap_or(0)
    }

    /// Returns the most probable action, the first of several.
    pub fn mode(&mut self, state: &[f32]) -> usize {
        let outputs = self.network.single(&self.parameters, state);
        largest(&outputs[..outputs.len() - 1])
    }

    /// Stores a step, and updates when enough are there.
    pub fn observe(&mut self, state: &[f32], action: usize, reward: f32, next: &[f32], end: End) {
        let c = &mut self.collected;
        let full = c.actions.len() + 1 >= self.settings.num_steps;
        // The last step of an unfinished episode is cut here.
        let end = if full && end == End::None { End::Truncated } else { end };
        c.push(state, action, reward, next, end);
        if full {
            self.update();
            self.collected.clear();
        }
    }

    fn update(&mut self) {
        self.prepare();
        let count = self.collected.actions.len();
        let mut order = std::mem::take(&mut self.buffers.order);
        order.clear();
        let size = self.settings.minibatch_size;
        let mut used = 0;
        while used < count * self.settings.update_epochs {
            while order.len() < size {
                let start = order.len();
                order.extend(0..count);
                order[start..].shuffle(self.shuffling.rng());
                // The new permutation goes below what is left of the last.
                order.rotate_left(start);
            }
            let at = order.len() - size;
            self.descend(&order[at..]);
            order.truncate(at);
            used += size;
        }
        self.buffers.order = order;
    }

    /// Computes values, probabilities and advantages of everything collected.
    fn prepare(&mut self) {
        let width = self.network.inputs();
        let actions = self.network.outputs() - 1;
        let b = &mut self.buffers;
        let c = &self.collected;
        b.log_probabilities.clear();
        b.values.clear();
        b.values_after.clear();
        b.probabilities.resize(actions, 0.0);
        for (rows, taken) in c.states.chunks(ROWS * width).zip(c.actions.chunks(ROWS)) {
            let outputs = self.network.forward(&self.parameters, rows);
            for (output, action) in outputs.chunks_exact(actions + 1).zip(taken) {
                let log = log_probability(&output[..actions], *action as usize);
                b.log_probabilities.push(log);
                b.values.push(output[actions]);
            }
        }
        for rows in c.after.chunks(ROWS * width) {
            let outputs = self.network.forward(&self.parameters, rows);
            b.values_after.extend(outputs.chunks_exact(actions + 1).map(|o| o[actions]));
        }
        b.steps.clear();
        let mut after = b.values_after.iter();
        for (t, (reward, end)) in c.rewards.iter().zip(&c.ends).enumerate() {
            let next_value = match end {
                End::None => b.values[t + 1],
                End::Terminal => 0.0,
                End::Truncated => *after.next().expect("a truncated step keeps its state"),
            };
            let (value, last) = (b.values[t], *end != End::None);
            b.steps.push(Step { reward: *reward, value, next_value, last });
        }
        b.advantages.resize(b.steps.len(), 0.0);
        advantages(&b.steps, self.settings.gamma, self.settings.gae_lambda, &mut b.advantages);
        // From here on `values` are what the value is to become.
        b.values.iter_mut().zip(&b.advantages).for_each(|(v, a)| *v += a);
        let count = b.advantages.len() as f32;
        let mean = b.advantages.iter().sum::<f32>() / count;
        let variance = b.advantages.iter().map(|a| (a - mean).powi(2)).sum::<f32>() / count;
        let scale = 1.0 / (variance.sqrt() + DEVIATION_EPSILON);
        b.advantages.iter_mut().for_each(|a| *a = (*a - mean) * scale);
    }

    /// One gradient step on the steps of these numbers.
    fn descend(&mut self, rows: &[usize]) {
        let width = self.network.inputs();
        let b = &mut self.buffers;
        b.states.clear();
        for row in rows {
            b.states.extend_from_slice(&self.collected.states[row * width..][..width]);
        }
        let actions = self.network.outputs() - 1;
        let outputs = self.network.forward(&self.parameters, &b.states);
        b.output_gradient.resize(outputs.len(), 0.0);
        let mut sums = Losses::default();
        for ((row, output), gradient) in rows
            .iter()
            .zip(outputs.chunks_exact(actions + 1))
            .zip(b.output_gradient.chunks_exact_mut(actions + 1))
        {
            let sample = Sample {
                action: self.collected.actions[*row] as usize,
                log_probability: b.log_probabilities[*row],
                advantage: b.advantages[*row],
                value: b.values[*row],
            };
            sample.loss(output, &self.settings, &mut b.probabilities, gradient, &mut sums);
        }
        let share = 1.0 / rows.len() as f32;
        b.output_gradient.iter_mut().for_each(|g| *g *= share);
        self.network.backward(&self.parameters, &b.states, &b.output_gradient, &mut b.gradient);
        let limit = Some(self.settings.max_grad_norm);
        self.adam.step(&mut self.parameters, &b.gradient, limit);
        self.loss_sum += f64::from(sums.total * share);
        self.entropy_sum += f64::from(sums.entropy * share);
        self.losses += 1;
    }

    /// Returns mean loss and mean entropy of the gradient steps since it was last asked for; `None`
    /// without any.
    pub fn take_loss(&mut self) -> Option<(f64, f64)> {
        let count = f64::from(self.losses);
        let means = (self.losses > 0).then(|| (self.loss_sum / count, self.entropy_sum / count));
        (self.loss_sum, self.entropy_sum, self.losses) = (0.0, 0.0, 0);
        means
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nn::Activation;
    use crate::nn::archive::Archive;
    use crate::nn::init::Init;
    use crate::nn::sequential::Sequential;
    use crate::rl::persist::Persist;

    fn learner(num_steps: usize) -> Ppo<Sequential> {
        let network = Sequential::new(5).linear(32, Activation::Relu).linear(3, Activation::None);
        let mut draw = Generator::new(3, &["initial"]);
        let parameters = network.initial(&|_| Init::Uniform, draw.rng());
        let settings = Settings {
            learning_rate: 3e-3,
            adam_epsilon: 1e-5,
            gamma: 0.9,
            gae_lambda: 0.95,
            num_steps,
            update_epochs: 4,
            minibatch_size: 24,
            clip_range: 0.2,
            value_coefficient: 1.0,
            entropy_coefficient: 0.001,
            max_grad_norm: 0.5,
        };
        Ppo::new(network, parameters, settings, 3, &[])
    }

    fn one_hot(state: usize) -> [f32; 5] {
        std::array::from_fn(|i| f32::from(u8::from(i == state)))
    }

    /// Five states in a row, two actions; the right end pays 1 and ends the episode.
    fn walk(ppo: &mut Ppo<Sequential>, decisions: usize, state: &mut usize) {
        for _ in 0..decisions {
            let action = ppo.sample(&one_hot(*state), None);
            let next = if action == 1 { *state + 1 } else { state.saturating_sub(1) };
            let (reward, end) = if next == 4 { (1.0, End::Terminal) } else { (0.0, End::None) };
            ppo.observe(&one_hot(*state), action, reward, &one_hot(next), end);
            *state = if next == 4 { 0 } else { next };
        }
    }

    #[test]
    fn a_tabular_problem_is_solved() {
        let mut ppo = learner(128);
        walk(&mut ppo, 128 * 60, &mut 0);
        for state in 0..4 {
            assert_eq!(ppo.mode(&one_hot(state)), 1);
            let value = ppo.network.forward(&ppo.parameters, &one_hot(state))[2];
            let best = 0.9f32.powi(3 - state as i32);
            assert!((value - best).abs() < 0.1, "{state}: {value}, {best}");
        }
    }

    #[test]
    fn actions_are_drawn_as_often_as_they_are_likely() {
        let mut ppo = learner(8);
        // Logits 0 and ln 3 in every state.
        ppo.parameters.fill(0.0);
        let bias = ppo.parameters.len() - 2;
        ppo.parameters[bias] = 3f32.ln();
        let mut generator = Generator::new(1, &[]);
        let draws = (0..10_000).filter(|_| ppo.sample(&one_hot(0), Some(&mut generator)) == 1);
        assert!((7350..7650).contains(&draws.count()));
    }

    #[test]
    fn every_step_is_used_once_per_epoch_even_when_minibatches_do_not_fit() {
        // 40 steps, minibatches of 24: 4 epochs are 160 steps, rounded up to 7 minibatches.
        let mut ppo = learner(40);
        walk(&mut ppo, 40, &mut 0);
        assert_eq!(ppo.losses, 7);
        assert!(ppo.collected.actions.is_empty());
        let (loss, entropy) = ppo.take_loss().unwrap();
        assert!(loss.is_finite() && entropy > 0.0 && entropy <= 2f64.ln());
        assert_eq!(ppo.take_loss(), None);
    }

    #[test]
    fn a_restored_learner_goes_on_with_the_same_bytes() {
        let mut one = learner(128);
        let mut state = 0;
        walk(&mut one, 300, &mut state);
        let mut archive = Archive::default();
        one.save("a.", &mut archive);
        let mut other = learner(128);
        other.restore("a.", &archive).unwrap();
        let mut same = state;
        walk(&mut one, 300, &mut state);
        walk(&mut other, 300, &mut same);
        let (mut a, mut b) = (Archive::default(), Archive::default());
        one.save("", &mut a);
        other.save("", &mut b);
        assert!(a.to_bytes() == b.to_bytes());
    }
}

//! Proximal policy optimisation (Schulman et al., 2017), as Stable-Baselines3's `PPO`.
//!
//! Choices where implementations differ:
//! - **Networks**: policy and value apart, hyperbolic tangents, orthogonal weights (gains √2, 0.01 and 1).
//! - **Loss**: clipped surrogate, plus the squared error of the value (not halved, not clipped), less the
//!   entropy; the gradient of both networks together is cut to a norm.
//! - **Advantages** are standardised per minibatch, with the unbiased deviation.
//! - **Minibatches** come from one permutation per pass; the last one may be smaller.
//! - **A cut episode** has the value of the state after it.
//!
//! PFRL's has other choices, see [`crate::rl::ppo`].

use basics::setting::settings;
use rand::seq::SliceRandom;

use super::Schedule;
use super::actor_critic::{ActorCritic, Outputs};
use super::distribution::{Distribution, Flavour};
use super::on_policy::{Algorithm, Experience, OnPolicy, Play};
use super::rollout::Batch;
use crate::rl::Losses;
use crate::rl::environment::Environment;

/// Added to the deviation that advantages are divided by.
const DEVIATION_EPSILON: f32 = 1e-8;

settings! {
    /// Hyper-parameters of `ppo`; the defaults are Stable-Baselines3's.
    pub struct Settings, source "Stable-Baselines3 2.9, PPO" {
        /// Steps of the training, in all environments together; the update that begins before this many
        /// are done is completed.
        total_steps: u64 = 100_000, in 1.0..=1e9, unit "steps",
            source "Jayawardana et al., 2022, give none for this task";
        /// Environments side by side.
        environments: usize = 1, in 1.0..=256.0, unit "environments";
        /// Steps per environment and update.
        num_steps: usize = 2048, in 1.0..=1e6, unit "steps";
        /// Steps per gradient step.
        minibatch_size: usize = 64, in 1.0..=1e6, unit "steps";
        /// Passes over the steps of an update.
        update_epochs: usize = 10, in 1.0..=1000.0, unit "passes";
        /// Step size of Adam.
        learning_rate: f32 = 3e-4, in 1e-8..=1.0;
        /// Schedule of the learning rate: `constant`, or `linear` to 0 at the end of the training.
        learning_rate_schedule: Schedule = Schedule::Constant;
        /// Adam's epsilon, added to the root of the second moment.
        adam_epsilon: f32 = 1e-5, in 1e-12..=1.0;
        /// Discount per step.
        gamma: f32 = 0.99, in 0.0..=1.0;
        /// Discount of later advantages within the generalised advantage estimate.
        gae_lambda: f32 = 0.95, in 0.0..=1.0;
        /// Largest relative change of an action's probability that an update rewards.
        clip_range: f32 = 0.2, in 1e-6..=10.0;
        /// Schedule of the clip range: `constant`, or `linear` to 0 at the end of the training.
        clip_range_schedule: Schedule = Schedule::Constant;
        /// Weight of the entropy bonus.
        entropy_coefficient: f32 = 0.0, in 0.0..=1e3;
        /// Weight of the squared error of the value.
        value_coefficient: f32 = 0.5, in 0.0..=1e3;
        /// Largest Euclidean norm of the gradient of policy and value together.
        max_grad_norm: f32 = 0.5, in 1e-6..=1e9;
        /// Units of both hidden layers, of the policy and of the value.
        hidden: usize = 64, in 1.0..=1024.0, unit "units";
    }
}

/// A training of a policy and its value.
pub type Ppo<E> = OnPolicy<E, ProximalPolicy>;

/// What the updates are computed with.
#[derive(Debug, Clone)]
pub struct ProximalPolicy {
    settings: Settings,
    distribution: Distribution,
    batch: Batch,
}

impl<E: Environment + Clone> Ppo<E> {
    /// Returns a training that has not begun.
    pub fn new(settings: Settings, environment: E, seed: u64) -> Self {
        let play = Play {
            total_steps: settings.total_steps,
            environments: settings.environments,
            num_steps: settings.num_steps,
            gamma: settings.gamma,
            gae_lambda: settings.gae_lambda,
            hidden: settings.hidden,
            adam_epsilon: settings.adam_epsilon,
        };
        Self::start(play, environment, seed, |networks| ProximalPolicy::new(settings, networks))
    }
}

impl ProximalPolicy {
    pub(in crate::rl) fn new(settings: Settings, networks: &ActorCritic) -> Self {
        let distribution = networks.distribution.clone();
        Self { distribution, batch: Batch::default(), settings }
    }

    /// One gradient step on the steps of these places.
    fn step(
        &mut self,
        experience: &mut Experience,
        places: &[usize],
        [learning_rate, clip_range]: [f32; 2],
        losses: &mut Losses,
    ) {
        let Self { settings, distribution, batch } = self;
        let Experience { networks, rollout, .. } = experience;
        batch.gather(rollout, places);
        if distribution.flavour == Flavour::StableBaselines3 && places.len() > 1 {
            standardise(&mut batch.advantages, places.len() as f32 - 1.0);
        }
        let outputs = networks.forward(&batch.states);
        batch.loss(distribution, outputs, settings, clip_range, losses);
        networks.back(&batch.states, &batch.by_outputs, &batch.by_log_std, &batch.by_values);
        networks.descend(learning_rate, settings.max_grad_norm);
    }
}

impl Algorithm for ProximalPolicy {
    #[expect(private_interfaces, reason = "as in the trait")]
    fn update(&mut self, experience: &mut Experience, steps: u64, losses: &mut Losses) {
        let Settings { total_steps, update_epochs, minibatch_size, .. } = self.settings;
        let at = |schedule: Schedule, start| schedule.at(start, steps, total_steps);
        let at = [
            at(self.settings.learning_rate_schedule, self.settings.learning_rate),
            at(self.settings.clip_range_schedule, self.settings.clip_range),
        ];
        let count = experience.rollout.len();
        let mut order = std::mem::take(&mut experience.order);
        order.clear();
        match self.distribution.flavour {
            Flavour::StableBaselines3 => {
                order.extend(0..count);
                for _ in 0..update_epochs {
                    order.shuffle(experience.shuffling.rng());
                    for places in order.chunks(minibatch_size) {
                        self.step(experience, places, at, losses);
                    }
                }
            }
            Flavour::Pfrl => {
                standardise(&mut experience.rollout.advantages, count as f32);
                for _ in 0..(count * update_epochs).div_ceil(minibatch_size) {
                    while order.len() < minibatch_size {
                        let start = order.len();
                        order.extend(0..count);
                        order[start..].shuffle(experience.shuffling.rng());
                        // The new permutation goes below what is left of the last.
                        order.rotate_left(start);
                    }
                    let places = order.split_off(order.len() - minibatch_size);
                    self.step(experience, &places, at, losses);
                }
            }
        }
        experience.order = order;
    }
}

impl Batch {
    fn loss(
        &mut self,
        distribution: &mut Distribution,
        [policy, log_std, values]: Outputs<'_>,
        settings: &Settings,
        clip_range: f32,
        losses: &mut Losses,
    ) {
        let count = values.len();
        let Self { actions, logs, advantages, returns, by_outputs, by_log_std, by_values, .. } =
            self;
        let (width, action_width) = (policy.len() / count, actions.len() / count);
        let share = 1.0 / count as f32;
        by_outputs.resize(policy.len(), 0.0);
        by_values.resize(count, 0.0);
        by_log_std.clear();
        by_log_std.resize(log_std.len(), 0.0);
        let Settings { value_coefficient, entropy_coefficient, .. } = *settings;
        let (mut surrogate, mut squares, mut entropies, mut in_turn) = (0.0, 0.0, 0.0, 0.0);
        let rows = policy.chunks_exact(width).zip(by_outputs.chunks_exact_mut(width));
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
                outputs, log_std, action, slope, entropy_coefficient, share, gradient, by_log_std,
            );
            entropies += entropy;
            let error = values[i] - returns[i];
            squares += error * error;
            by_values[i] = share * 2.0 * value_coefficient * error;
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
pub(super) fn standardise(numbers: &mut [f32], degrees: f32) {
    let mean = numbers.iter().sum::<f32>() / numbers.len() as f32;
    let squares: f32 = numbers.iter().map(|a| (a - mean) * (a - mean)).sum();
    let scale = 1.0 / ((squares / degrees).sqrt() + DEVIATION_EPSILON);
    numbers.iter_mut().for_each(|a| *a = (*a - mean) * scale);
}

#[cfg(test)]
mod tests {
    use super::super::Trainer;
    use super::super::rollout::Rollout;
    use super::super::testing::{Corridor, Slider, check_trainer, play, updates};
    use super::*;
    use crate::rl::environment::Actions;
    use crate::rl::persist::Persist;
    use crate::rl::random::Generator;

    fn settings() -> Settings {
        Settings {
            total_steps: 6000,
            environments: 3,
            num_steps: 43,
            minibatch_size: 32,
            learning_rate: 3e-3,
            learning_rate_schedule: Schedule::Linear,
            gamma: 0.9,
            clip_range_schedule: Schedule::Linear,
            hidden: 32,
            ..Settings::default()
        }
    }

    fn trainer(seed: u64) -> Ppo<Corridor> {
        Ppo::new(settings(), Corridor::default(), seed)
    }

    #[test]
    fn a_corridor_is_learned_to_its_exact_values() {
        let mut ppo = trainer(3);
        ppo.advance(u64::MAX, &mut |k| u64::from(k));
        assert_eq!(play(&mut ppo), 4);
        for state in 0..4 {
            let value = ppo.experience.networks.values(&Corridor::one_hot(state))[0];
            let exact = 0.9f32.powi(3 - state as i32);
            assert!((value - exact).abs() < 0.1, "{state}: {value}, {exact}");
        }
    }

    #[test]
    fn a_training_can_stop_after_every_update() {
        check_trainer(&Corridor::default(), trainer);
        check_trainer(&Slider::default(), |seed| Ppo::new(settings(), Slider::default(), seed));
    }

    #[test]
    fn a_gradient_step_is_that_of_stable_baselines3() {
        let all = updates();
        for (name, actions) in [
            ("ppo-numbered", Actions::Numbered(2)),
            ("ppo-continuous", Actions::Continuous { count: 2, limit: 1.0 }),
        ] {
            let update = &all[name];
            let settings =
                Settings { entropy_coefficient: 0.2, max_grad_norm: 0.3, hidden: 5, ..settings() };
            let mut networks = ActorCritic::new(3, actions, 5, 1e-5, 1);
            networks.parameters = update.numbers("before");
            let parts = ["states", "actions", "logs", "advantages", "returns"];
            let rollout = Rollout::of(parts.map(|part| update.numbers(part)));
            let places: Vec<usize> = (0..rollout.len()).collect();
            let mut experience = Experience::new(networks, rollout, Generator::new(1, &[]));
            let mut algorithm = ProximalPolicy::new(settings, &experience.networks);
            algorithm.step(&mut experience, &places, [0.01, 0.2], &mut Losses::default());
            update.check("then", &experience.networks.parameters, 1e-5);
        }
    }

    #[test]
    fn an_update_takes_every_step_once_per_pass() {
        // 3 * 43 = 129 steps: four minibatches of 32 and one of a single step, ten times.
        let mut ppo = trainer(3);
        let mut losses = Losses::default();
        ppo.collect(&mut |k| u64::from(k));
        ppo.update(&mut losses);
        assert_eq!((ppo.steps, losses.count), (129, 50));
        let mut order = ppo.experience.order.clone();
        order.sort_unstable();
        assert!(order.iter().copied().eq(0..129));
        assert!(ppo.is_finite());
    }

    const CLIP: f32 = 0.2;

    #[test]
    fn the_loss_is_that_computed_by_hand() {
        for flavour in [Flavour::Pfrl, Flavour::StableBaselines3] {
            // One step, two equally likely actions, twice as likely as before: ratio 2 is cut to 1.2.
            let mut one = Batch {
                actions: vec![0.0],
                logs: vec![0.25f32.ln()],
                advantages: vec![1.0],
                returns: vec![2.0],
                ..Batch::default()
            };
            let mut distribution = Distribution::new(Actions::Numbered(2), flavour);
            let settings = Settings {
                entropy_coefficient: 0.3,
                value_coefficient: 0.7,
                ..Settings::default()
            };
            let outputs = [&[0.0, 0.0][..], &[], &[1.0]];
            let mut losses = Losses::default();
            one.loss(&mut distribution, outputs, &settings, CLIP, &mut losses);
            let found = losses.take().0.unwrap();
            assert!((found - (-1.2 + 0.7 - 0.3 * 2f64.ln())).abs() < 1e-6, "{found}");
            assert_eq!((one.by_outputs[0], one.by_values[0]), (0.0, -1.4));
            one.advantages = vec![-1.0];
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

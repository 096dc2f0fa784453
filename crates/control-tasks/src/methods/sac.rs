//! `sac`: soft actor-critic, as Stable-Baselines3 has it.

use super::{Begin, weights};
use evaluation::run::method::{Method, Training};
use evaluation::settings::setting::settings;
use learners::rl::environment::Environment;
use learners::rl::sb3::sac::{Sac, Settings};

/// `sac` as evaluation knows it.
pub const METHOD: Method = Method {
    summary: "soft actor-critic, as in Stable-Baselines3",
    default: true,
    decision_s: 8e-3,
    dash: "1 3",
    settings: Config::SETTINGS,
    ..Method::built_in("sac", Training::Learned, "#e69f00")
};

settings! {
    /// Hyper-parameters of `sac`; the defaults are those of Stable-Baselines3.
    pub struct Config extends Settings, source "Stable-Baselines3 2.9, SAC" {
        /// Steps of the training.
        total_steps: u64 = 20_000, in 1.0..=1e9, unit "steps",
            source "rl-baselines3-zoo 2.9 for Pendulum-v1";
        /// Step size of Adam, for policy, critics and entropy coefficient.
        learning_rate: f32 = 3e-4, in 1e-8..=1.0;
        /// Adam's epsilon, added to the root of the second moment.
        adam_epsilon: f32 = 1e-8, in 1e-12..=1.0;
        /// Discount per step.
        gamma: f32 = 0.99, in 0.0..=1.0;
        /// Share by which the slow copies follow at each update.
        tau: f32 = 0.005, in 1e-6..=1.0;
        /// Steps in the replay buffer.
        buffer_size: usize = 1_000_000, in 1.0..=1e8, unit "steps";
        /// Steps per update, drawn with replacement.
        batch_size: usize = 256, in 1.0..=4096.0, unit "steps";
        /// Steps before the first update, in which actions are random.
        learning_starts: u64 = 100, in 0.0..=1e9, unit "steps";
        /// Steps between two blocks of updates.
        train_frequency: u64 = 1, in 1.0..=1e6, unit "steps";
        /// Updates of a block.
        gradient_steps: u32 = 1, in 1.0..=1e6, unit "updates";
        /// Weight of the entropy, at first.
        entropy_coefficient: f32 = 1.0, in 1e-6..=1e3;
        /// Whether the weight of the entropy is learned, towards an entropy of minus the number of action dimensions.
        learned_entropy_coefficient: bool = true;
        /// Units of both hidden layers of every network.
        hidden: usize = 256, in 1.0..=1024.0, unit "units";
    } and {}
}

impl Config {
    /// Returns products and sums of a step, updates included, for observation and action of so many numbers.
    pub(crate) fn work(&self, numbers: usize) -> f64 {
        let updates = f64::from(self.gradient_steps) / self.train_frequency as f64;
        // Forward: policy and targets afterwards, policy, both critics twice; backward: both critics twice, policy.
        18.0 * updates * self.batch_size as f64 * weights(numbers, self.hidden, self.hidden)
    }
}

/// Returns how trainings begin.
pub(crate) fn begin<E: Environment + Clone + 'static>(
    config: &Config,
    environment: E,
) -> Box<Begin> {
    let config = config.clone();
    Box::new(move |seed| Box::new(Sac::new((&config).into(), environment.clone(), seed)))
}

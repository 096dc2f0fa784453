//! `dqn`: deep Q-learning, as Stable-Baselines3 has it.

use super::{Begin, weights};
use evaluation::run::method::{Method, Training};
use evaluation::settings::setting::settings;
use learners::rl::environment::Environment;
use learners::rl::sb3::dqn::{Dqn, Settings};

/// `dqn` as evaluation knows it.
pub const METHOD: Method = Method {
    summary: "deep Q-learning, as in Stable-Baselines3",
    default: true,
    decision_s: 3.3e-6,
    dash: "6 3",
    settings: Config::SETTINGS,
    ..Method::built_in("dqn", Training::Learned, "#d55e00")
};

settings! {
    /// Hyper-parameters of `dqn`; the defaults are Stable-Baselines3's, which hardly learn this task.
    pub struct Config extends Settings, source "Stable-Baselines3 2.9, DQN" {
        /// Steps of the training.
        total_steps: u64 = 100_000, in 1.0..=1e9, unit "steps",
            source "Jayawardana et al., 2022, give none for this task";
        /// Step size of Adam.
        learning_rate: f32 = 1e-4, in 1e-8..=1.0;
        /// Adam's epsilon, added to the root of the second moment.
        adam_epsilon: f32 = 1e-8, in 1e-12..=1.0;
        /// Discount per step.
        gamma: f32 = 0.99, in 0.0..=1.0;
        /// Steps in the replay buffer.
        buffer_size: usize = 1_000_000, in 1.0..=1e8, unit "steps";
        /// Steps per update, drawn with replacement.
        batch_size: usize = 32, in 1.0..=4096.0, unit "steps";
        /// Steps before the first update, in which actions are random.
        learning_starts: u64 = 100, in 0.0..=1e9, unit "steps";
        /// Steps between two blocks of updates.
        train_frequency: u64 = 4, in 1.0..=1e6, unit "steps";
        /// Updates of a block.
        gradient_steps: u32 = 1, in 1.0..=1e6, unit "updates";
        /// Steps between two copies into the target network.
        target_network_frequency: u64 = 10_000, in 1.0..=1e9, unit "steps";
        /// Share of random actions at the beginning.
        start_epsilon: f64 = 1.0, in 0.0..=1.0;
        /// Share of random actions at the end.
        end_epsilon: f64 = 0.05, in 0.0..=1.0;
        /// Share of the training over which the share of random actions falls linearly.
        exploration_fraction: f64 = 0.1, in 0.0..=1.0;
        /// Largest Euclidean norm of the gradient.
        max_grad_norm: f32 = 10.0, in 1e-6..=1e9;
        /// Units of both hidden layers.
        hidden: usize = 64, in 1.0..=1024.0, unit "units";
    } and {}
}

impl Config {
    /// Returns products and sums of a step, updates included, for observation and action of so many numbers.
    pub(crate) fn work(&self, numbers: usize) -> f64 {
        let updates = f64::from(self.gradient_steps) / self.train_frequency as f64;
        // Both networks forward, and one twice as much backward.
        4.0 * updates * self.batch_size as f64 * weights(numbers, self.hidden, self.hidden)
    }
}

/// Returns how trainings begin.
pub(crate) fn begin<E: Environment + Clone + 'static>(
    config: &Config,
    environment: E,
) -> Box<Begin> {
    let config = config.clone();
    Box::new(move |seed| Box::new(Dqn::new((&config).into(), environment.clone(), seed)))
}

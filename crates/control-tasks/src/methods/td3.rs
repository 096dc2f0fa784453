//! `td3`: twin delayed deep deterministic policy gradient, as Stable-Baselines3 has it.

use super::{Begin, weights};
use evaluation::run::method::{Method, Training};
use evaluation::settings::setting::settings;
use learners::rl::environment::Environment;
use learners::rl::sb3::td3::{Settings, Td3};

/// `td3` as evaluation knows it.
pub const METHOD: Method = Method {
    summary: "twin delayed deep deterministic policy gradient, as in Stable-Baselines3",
    decision_s: 8e-3,
    dash: "4 2 1 2",
    settings: Config::SETTINGS,
    ..Method::built_in("td3", Training::Learned, "#56b4e9")
};

settings! {
    /// Hyper-parameters of `td3`; the defaults are those of Stable-Baselines3.
    pub struct Config extends Settings, source "Stable-Baselines3 2.9, TD3" {
        /// Steps of the training.
        total_steps: u64 = 20_000, in 1.0..=1e9, unit "steps",
            source "rl-baselines3-zoo 2.9 for Pendulum-v1";
        /// Step size of Adam, for policy and critics.
        learning_rate: f32 = 1e-3, in 1e-8..=1.0;
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
        /// Updates of the critics per update of the policy.
        policy_delay: u32 = 2, in 1.0..=1e6, unit "updates";
        /// Deviation of the noise on actions while learning, as a share of the largest action.
        action_noise: f32 = 0.0, in 0.0..=10.0;
        /// Deviation of the noise on the actions of targets, as a share of the largest action.
        target_noise: f32 = 0.2, in 0.0..=10.0;
        /// Largest noise on the actions of targets, as a share of the largest action.
        target_noise_clip: f32 = 0.5, in 0.0..=10.0;
        /// Units of the first hidden layer of every network.
        hidden: usize = 400, in 1.0..=1024.0, unit "units";
        /// Units of the second hidden layer of every network.
        second_hidden: usize = 300, in 1.0..=1024.0, unit "units";
    } and {}
}

impl Config {
    /// Returns products and sums of a step, updates included, for observation and action of so many numbers.
    pub(crate) fn work(&self, numbers: usize) -> f64 {
        let updates = f64::from(self.gradient_steps) / self.train_frequency as f64;
        let policy = 4.0 / f64::from(self.policy_delay);
        // Forward: policy and targets afterwards, both critics; backward: both critics; then what the policy takes.
        let passes = 9.0 + 1.5 * policy;
        passes
            * updates
            * self.batch_size as f64
            * weights(numbers, self.hidden, self.second_hidden)
    }
}

/// Returns how trainings begin.
pub(crate) fn begin<E: Environment + Clone + 'static>(
    config: &Config,
    environment: E,
) -> Box<Begin> {
    let config = config.clone();
    Box::new(move |seed| Box::new(Td3::new((&config).into(), environment.clone(), seed)))
}

//! `ppo`: proximal policy optimisation, as Stable-Baselines3 has it.

use super::{Begin, weights};
use evaluation::run::method::{Method, Training};
use evaluation::settings::setting::settings;
use learners::rl::environment::Environment;
use learners::rl::sb3::Schedule;
use learners::rl::sb3::ppo::{Ppo, Settings};

/// `ppo` as evaluation knows it.
pub const METHOD: Method = Method {
    summary: "proximal policy optimisation, as in Stable-Baselines3",
    default: true,
    decision_s: 5.2e-6,
    settings: Config::SETTINGS,
    ..Method::built_in("ppo", Training::Learned, "#0072b2")
};

settings! {
    /// Hyper-parameters of `ppo`; the defaults are Stable-Baselines3's.
    pub struct Config extends Settings, source "Stable-Baselines3 2.9, PPO" {
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
    } and {}
}

impl Config {
    /// Returns products and sums of a step, updates included, for observation and action of so many numbers.
    pub(crate) fn work(&self, numbers: usize) -> f64 {
        // Policy and value, forward and twice as much backward.
        2.0 * 3.0 * self.update_epochs as f64 * weights(numbers, self.hidden, self.hidden)
    }
}

/// Returns how trainings begin.
pub(crate) fn begin<E: Environment + Clone + 'static>(
    config: &Config,
    environment: E,
) -> Box<Begin> {
    let config = config.clone();
    Box::new(move |seed| Box::new(Ppo::new((&config).into(), || environment.clone(), seed)))
}

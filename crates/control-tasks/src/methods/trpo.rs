//! `trpo`: trust region policy optimisation, as sb3-contrib has it.

use super::{Begin, weights};
use evaluation::run::method::{Method, Training};
use evaluation::settings::setting::settings;
use learners::rl::environment::Environment;
use learners::rl::sb3::trpo::{Settings, Trpo};

/// `trpo` as evaluation knows it.
pub const METHOD: Method = Method {
    summary: "trust region policy optimisation, as in sb3-contrib",
    decision_s: 6e-6,
    dash: "2 2",
    settings: Config::SETTINGS,
    ..Method::built_in("trpo", Training::Learned, "#009e73")
};

settings! {
    /// Hyper-parameters of `trpo`; the defaults are those of sb3-contrib.
    pub struct Config extends Settings, source "sb3-contrib 2.9, TRPO" {
        /// Steps of the training, in all environments together; the update that begins before this many
        /// are done is completed.
        total_steps: u64 = 100_000, in 1.0..=1e9, unit "steps",
            source "Jayawardana et al., 2022, give none for most tasks";
        /// Environments side by side.
        environments: usize = 1, in 1.0..=256.0, unit "environments";
        /// Steps per environment and update.
        num_steps: usize = 2048, in 1.0..=1e6, unit "steps";
        /// Steps per gradient step of the value.
        minibatch_size: usize = 128, in 1.0..=1e6, unit "steps";
        /// Passes of the value over the steps of an update.
        critic_epochs: usize = 10, in 1.0..=1000.0, unit "passes";
        /// Step size of Adam, which moves the value only.
        learning_rate: f32 = 1e-3, in 1e-8..=1.0;
        /// Adam's epsilon, added to the root of the second moment.
        adam_epsilon: f32 = 1e-5, in 1e-12..=1.0;
        /// Discount per step.
        gamma: f32 = 0.99, in 0.0..=1.0;
        /// Discount of later advantages within the generalised advantage estimate.
        gae_lambda: f32 = 0.95, in 0.0..=1.0;
        /// Largest mean divergence of the policy after an update from that before.
        target_kl: f32 = 0.01, in 1e-9..=10.0;
        /// Steps of conjugate gradients per update.
        cg_steps: u32 = 15, in 1.0..=1000.0, unit "steps";
        /// Added to the diagonal of Fisher's metric.
        cg_damping: f32 = 0.1, in 0.0..=1e3;
        /// Factor by which a step that does not improve the policy is made shorter.
        line_search_factor: f32 = 0.8, in 0.01..=0.99;
        /// Steps tried before the policy is left as it is.
        line_search_steps: u32 = 10, in 1.0..=1000.0, unit "steps";
        /// Units of both hidden layers, of the policy and of the value.
        hidden: usize = 64, in 1.0..=1024.0, unit "units";
    } and {}
}

impl Config {
    /// Returns products and sums of a step, updates included, for observation and action of so many numbers.
    pub(crate) fn work(&self, numbers: usize) -> f64 {
        // The value forward and twice as much backward, and four passes of the policy per step of conjugate gradients.
        let passes = 3.0 * self.critic_epochs as f64 + 4.0 * f64::from(self.cg_steps);
        passes * weights(numbers, self.hidden, self.hidden)
    }
}

/// Returns how trainings begin.
pub(crate) fn begin<E: Environment + Clone + 'static>(
    config: &Config,
    environment: E,
) -> Box<Begin> {
    let config = config.clone();
    Box::new(move |seed| Box::new(Trpo::new((&config).into(), || environment.clone(), seed)))
}

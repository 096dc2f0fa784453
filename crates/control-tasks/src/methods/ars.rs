//! `ars`: augmented random search, as sb3-contrib has it.

use super::Begin;
use evaluation::run::method::{Method, Training};
use evaluation::settings::setting::settings;
use learners::rl::environment::Environment;
use learners::rl::sb3::ars::{Ars, Settings};

/// `ars` as evaluation knows it.
pub const METHOD: Method = Method {
    summary: "augmented random search with a linear policy, as in sb3-contrib",
    decision_s: 1.5e-7,
    dash: "8 2 2 2",
    settings: Config::SETTINGS,
    ..Method::built_in("ars", Training::Learned, "#882255")
};

settings! {
    /// Hyper-parameters of `ars`; the defaults are those of sb3-contrib.
    pub struct Config extends Settings, source "sb3-contrib 2.9, ARS with LinearPolicy" {
        /// Steps of the training; the update that begins before this many are done is completed.
        total_steps: u64 = 100_000, in 1.0..=1e9, unit "steps",
            source "Jayawardana et al., 2022, give none for most tasks";
        /// Directions of an update, each tried both ways for an episode.
        directions: usize = 8, in 1.0..=1e4, unit "directions";
        /// How many of the best directions count, by the better return of both ways; all where there are fewer.
        best_directions: usize = 8, in 1.0..=1e4, unit "directions";
        /// Size of a step.
        learning_rate: f32 = 0.02, in 1e-8..=1e3;
        /// Deviation of what is added to each weight when a direction is tried.
        deviation: f32 = 0.05, in 1e-8..=1e3;
        /// Added to the return for every step of an episode.
        alive_bonus: f32 = 0.0, in -1e3..=1e3;
    } and {}
}

impl Config {
    /// Returns products and sums of a step, updates included, for observation and action of so many numbers.
    #[expect(clippy::unused_self, reason = "as of the other methods")]
    pub(crate) fn work(&self, numbers: usize) -> f64 {
        // A matrix times an observation; most of a step is the environment's.
        20.0 + numbers as f64
    }
}

/// Returns how trainings begin.
pub(crate) fn begin<E: Environment + Clone + 'static>(
    config: &Config,
    environment: E,
) -> Box<Begin> {
    let config = config.clone();
    Box::new(move |seed| Box::new(Ars::new((&config).into(), environment.clone(), seed)))
}

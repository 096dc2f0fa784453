use super::{Method, Training, weights};
pub(crate) use learners::rl::sb3::dqn::{Dqn as Algorithm, Settings as Config};

pub(crate) const METHOD: Method = Method {
    summary: "deep Q-learning, as in Stable-Baselines3",
    default: true,
    decision_s: 3.3e-6,
    dash: "6 3",
    settings: Config::SETTINGS,
    ..Method::built_in("dqn", Training::Learned, "#d55e00")
};

pub(crate) const WORK: fn(&Config, usize) -> f64 = |config, numbers| {
    let updates = f64::from(config.gradient_steps) / config.train_frequency as f64;
    // Both networks forward, and one twice as much backward.
    4.0 * updates * config.batch_size as f64 * weights(numbers, config.hidden, config.hidden)
};

use super::{Method, Training, weights};
pub(crate) use learners::rl::sb3::sac::{Sac as Algorithm, Settings as Config};

pub(crate) const METHOD: Method = Method {
    summary: "soft actor-critic, as in Stable-Baselines3",
    default: true,
    decision_s: 8e-3,
    dash: "1 3",
    settings: Config::SETTINGS,
    ..Method::built_in("sac", Training::Learned, "#e69f00")
};

pub(crate) const WORK: fn(&Config, usize) -> f64 = |config, numbers| {
    let updates = f64::from(config.gradient_steps) / config.train_frequency as f64;
    // Forward: policy and targets afterwards, policy, both critics twice; backward: both critics twice, policy.
    18.0 * updates * config.batch_size as f64 * weights(numbers, config.hidden, config.hidden)
};

use super::{Method, Training, weights};
pub(crate) use learners::rl::sb3::ppo::{Ppo as Algorithm, Settings as Config};

pub(crate) const METHOD: Method = Method {
    summary: "proximal policy optimisation, as in Stable-Baselines3",
    default: true,
    decision_s: 5.2e-6,
    settings: Config::SETTINGS,
    ..Method::built_in("ppo", Training::Learned, "#0072b2")
};

pub(crate) const WORK: fn(&Config, usize) -> f64 = |config, numbers| {
    // Policy and value, forward and twice as much backward.
    2.0 * 3.0 * config.update_epochs as f64 * weights(numbers, config.hidden, config.hidden)
};

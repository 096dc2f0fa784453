use super::{Method, Training, weights};
pub(crate) use learners::rl::sb3::td3::{Settings as Config, Td3 as Algorithm};

pub(crate) const METHOD: Method = Method {
    summary: "twin delayed deep deterministic policy gradient, as in Stable-Baselines3",
    decision_s: 8e-3,
    dash: "4 2 1 2",
    settings: Config::SETTINGS,
    ..Method::built_in("td3", Training::Learned, "#56b4e9")
};

pub(crate) const WORK: fn(&Config, usize) -> f64 = |config, numbers| {
    let updates = f64::from(config.gradient_steps) / config.train_frequency as f64;
    let policy = 4.0 / f64::from(config.policy_delay);
    // Forward: policy and targets afterwards, both critics; backward: both critics; then what the policy takes.
    let passes = (9.0 + 1.5 * policy) * updates * config.batch_size as f64;
    passes * weights(numbers, config.hidden, config.second_hidden)
};

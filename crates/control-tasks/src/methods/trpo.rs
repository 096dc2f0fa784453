use super::{Method, Training, weights};
pub(crate) use learners::rl::sb3::trpo::{Settings as Config, Trpo as Algorithm};

pub(crate) const METHOD: Method = Method {
    summary: "trust region policy optimisation, as in sb3-contrib",
    decision_s: 6e-6,
    dash: "2 2",
    settings: Config::SETTINGS,
    ..Method::built_in("trpo", Training::Learned, "#009e73")
};

pub(crate) const WORK: fn(&Config, usize) -> f64 = |config, numbers| {
    // The value forward and twice as much backward, and four passes of the policy per step of conjugate gradients.
    let passes = 3.0 * config.critic_epochs as f64 + 4.0 * f64::from(config.cg_steps);
    passes * weights(numbers, config.hidden, config.hidden)
};

use super::{Method, Training};
pub(crate) use learners::rl::sb3::ars::{Ars as Algorithm, Settings as Config};

pub(crate) const METHOD: Method = Method {
    summary: "augmented random search with a linear policy, as in sb3-contrib",
    decision_s: 1.5e-7,
    dash: "8 2 2 2",
    settings: Config::SETTINGS,
    ..Method::built_in("ars", Training::Learned, "#882255")
};

pub(crate) const WORK: fn(&Config, usize) -> f64 = |_config, numbers| {
    // A matrix times an observation; most of a step is the environment's.
    20.0 + numbers as f64
};

//! MPLight*: MPLight that sees four numbers per movement instead of one.
//!
//! Pressure, waiting time, speeds and approaching vehicles (`state.rs`); everything
//! else, the reward too, is [MPLight](super::mplight)'s.
//!
//! Here every movement sees its own four numbers, as intended; in RESCO's code part of them are those of others.
//!
//! Source: RESCO, agents/mplight.py (`MPLightFULL`) and states.py (`mplight_full`).

use super::deep_q::{self, deep_q_settings};
use super::learner::Learning;
use super::mplight::MpLight;
use super::state::Demand;
use super::{Controller, Setup};
use evaluation::run::method::{Method, Training};

/// The method.
pub const METHOD: Method = Method {
    summary: "MPLight that also sees waiting times, speeds and arrivals",
    decision_s: 6e-4,
    dash: "3 3",
    settings: Config::SETTINGS,
    ..Method::built_in("mplight-star", Training::Learned, "#993333")
};

deep_q_settings! { {
    /// Hyper-parameters of `mplight-star`; the defaults are RESCO's.
    pub struct Config extends deep_q::Config
} "RESCO, config/agent_config.py and agents/mplight.py" and {
    /// Whether the speeds of all lanes of a movement count. In RESCO only those of its last lane do.
    speed_of_all_lanes: bool = false;
} }

/// Returns MPLight*, untrained.
pub fn create(config: &Config, setup: &Setup) -> Box<dyn Controller> {
    let demand = Demand::Full { all_lanes: config.speed_of_all_lanes };
    Box::new(Learning::new(METHOD.name, MpLight::new(config.into(), demand), setup))
}

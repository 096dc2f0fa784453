//! SUMO's gap-based actuated control: what traffic engineers compare with.
//!
//! The greens for vehicles of the network's own program run in their order; each is prolonged while vehicles
//! pass the detectors with time gaps below SUMO's default of 3 s, within the signal's limits.
//!
//! Source: SUMO documentation, "Traffic Lights", actuated traffic lights based on time gaps.

use super::{Controller, Drive, Setup, same};
use evaluation::run::method::{Method, Training};
use evaluation::settings::setting::settings;

/// The method.
pub const METHOD: Method = Method {
    summary: "SUMO's gap-based actuated control",
    default: true,
    settings: Config::SETTINGS,
    ..Method::built_in("actuated", Training::None, "#009e73")
};

settings! {
    /// SUMO's gap-based control.
    pub struct Config, source "SUMO documentation, actuated traffic lights" {
        /// Longest green (SUMO's default), within the limits of `[signal]`.
        max_green_s: f64 = 50.0, in 1.0..=600.0, unit "s";
    }
}

/// Returns actuated control.
pub fn create(config: &Config, _setup: &Setup) -> Box<dyn Controller> {
    same(METHOD.name, Drive::OwnActuated(config.max_green_s))
}

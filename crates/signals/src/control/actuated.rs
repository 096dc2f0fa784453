//! SUMO's gap-based actuated control: what traffic engineers compare with.
//!
//! The greens for vehicles of the network's own program run in their order; each is prolonged while vehicles
//! pass the detectors with time gaps below the passage time, within the signal's limits.
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
    tunes: &[
        ("actuated.passage_s", &[1.0, 2.0, 3.0, 4.0, 5.0]),
        ("actuated.max_green_s", &[15.0, 20.0, 30.0, 40.0, 50.0, 60.0, 90.0]),
    ],
    ..Method::built_in("actuated", Training::None, "#009e73")
};

/// SUMO's default of the gap between vehicles that ends a green, seconds.
pub(crate) const SUMO_GAP_S: f64 = 3.0;

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_sumo_gap(gap_s: &f64) -> bool {
    *gap_s == SUMO_GAP_S
}

settings! {
    /// SUMO's gap-based control.
    pub struct Config, source "SUMO documentation, actuated traffic lights" {
        /// Longest green (SUMO's default), within the limits of `[signal]`.
        max_green_s: f64 = 50.0, in 1.0..=600.0, unit "s";
        /// Gap between vehicles at the detectors after which a green may end.
        #[serde(skip_serializing_if = "is_sumo_gap")]
        passage_s: f64 = SUMO_GAP_S, in 0.1..=30.0, unit "s";
    }
}

/// Returns actuated control.
pub fn create(config: &Config, _setup: &Setup) -> Box<dyn Controller> {
    same(METHOD.name, Drive::OwnActuated(config.max_green_s, config.passage_s))
}

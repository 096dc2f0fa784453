//! Coordinated-actuated control: the dual rings of [`nema`](super::nema) within a common cycle.
//!
//! Cycle, splits and offsets are found as those of [`coordinated`](super::coordinated) are, but every plan that is tried runs as
//! a cabinet runs it: phases are skipped and end when nobody comes, and what they leave goes to the coordinated phases. Those
//! are the through phases of the busiest street at a signal. What a phase may do at which second of the cycle is in
//! `env/dual_ring/coordination.rs`.
//!
//! Choices:
//! - **Fixed force-offs**: a phase that begins early may last until the end of its split in the cycle.
//! - **Coordinated phases hold their green** until their yield point, whether vehicles come or not.
//! - **The first cycle** of an episode begins with the coordinated phases, which last until their first yield point.
//! - **A signal whose stages two rings cannot follow** runs them as a fixed cycle with the same offset.
//!
//! Deviation: `signal.max_green_s` does not end a coordinated phase, as in a cabinet. All other limits hold.
//!
//! Source: "Signal Timing Manual" (2nd ed., NCHRP Report 812), chapter 7; NEMA TS 2.

use super::coordinated::Coordinated;
use super::dual_ring::{self, Recall};
use super::webster::Constants;
use super::{Controller, Setup};
use evaluation::run::method::{Method, Training};
use evaluation::settings::setting::settings;

/// The method.
pub const METHOD: Method = Method {
    summary: "dual-ring, actuated control within a common cycle with offsets, tuned in simulation",
    settings: Config::SETTINGS,
    ..Method::built_in("nema-coordinated", Training::Tuned { episodes: "simulations" }, "#8787b4")
};

settings! {
    /// Coordinated-actuated control.
    pub struct Config, source "Signal Timing Manual (2nd ed., NCHRP Report 812), chapter 7" {
        /// Simulated episodes that tuning may use for one signal; for n signals, √n times as many.
        simulations: u32 = 24, in 8.0..=10_000.0, unit "episodes", source "our choice";
        /// Time lost per phase change in Webster's formula.
        lost_time_s: f64 = 4.0, in 0.0..=30.0, unit "s";
        /// Saturation flow in Webster's formula (HCM base 1900).
        saturation_flow_vph: f64 = 1900.0, in 100.0..=5000.0, unit "veh/h per lane";
        /// Time without a vehicle on a phase's detectors after which its green may end.
        passage_s: u32 = 2, in 1.0..=30.0, unit "s", source "as for nema";
        /// Length of the detectors, which end at the stop line. If a lane is shorter than the detector, the detector
        /// continues on the street upstream.
        detector_m: f64 = 20.0, in 1.0..=200.0, unit "m", source "as for nema";
        /// The same on lanes for left turns alone.
        left_detector_m: f64 = 10.0, in 1.0..=200.0, unit "m", source "as for nema";
    }
}

/// Longest green that a phase has of its own, seconds: its split ends it, within the limits.
const UNTIL_FORCE_OFF_S: u32 = 600;

/// Returns coordinated-actuated control, not yet tuned.
pub fn create(config: &Config, _setup: &Setup) -> Box<dyn Controller> {
    let Config { simulations, lost_time_s, saturation_flow_vph, .. } = *config;
    let constants = Constants { lost_time_s, saturation_flow_vph };
    Box::new(Coordinated::new(METHOD.name, constants, simulations, Some(rings(config))))
}

/// Returns what the rings are told.
pub fn rings(config: &Config) -> dual_ring::Config {
    dual_ring::Config {
        passage_s: config.passage_s,
        detector_m: config.detector_m,
        left_detector_m: config.left_detector_m,
        max_green_s: UNTIL_FORCE_OFF_S,
        left_max_green_s: UNTIL_FORCE_OFF_S,
        recall: Recall::None,
    }
}

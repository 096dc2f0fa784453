//! What dual-ring control is told; [`super::nema`] and [`super::coordinated`] explain it.

use serde::{Deserialize, Serialize};

use evaluation::settings::setting::settings;

/// Which phases are served in every cycle without a vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Recall {
    /// None: the signal rests where it served last.
    None,
    /// The through phases of the main street.
    Main,
    /// The through phases of every street.
    All,
}

settings! {
    /// Dual-ring control.
    pub struct Config, source "Signal Timing Manual (2nd ed., NCHRP Report 812), chapters 5 and 6" {
        /// Time without a vehicle on a phase's detectors after which its green may end.
        passage_s: u32 = 2, in 1.0..=30.0, unit "s", source "Signal Timing Manual, chapter 6; 2 s is our choice";
        /// Longest green of a phase while another one is called, within the limits of `[signal]`.
        max_green_s: u32 = 60, in 1.0..=600.0, unit "s", source "Signal Timing Manual, chapter 6";
        /// The same for a left turn's own phase. It is shorter where the through phase after it would otherwise get
        /// less than its shortest green. In left-hand traffic these are right turns.
        left_max_green_s: u32 = 30, in 1.0..=600.0, unit "s", source "Signal Timing Manual, chapter 6";
        /// Length of the detectors, which end at the stop line. If a lane is shorter than the detector, the detector
        /// continues on the street upstream.
        detector_m: f64 = 20.0, in 1.0..=200.0, unit "m", source "SUMO's NEMA controller; presence detection, Signal Timing Manual, chapter 4";
        /// The same on lanes for left turns alone.
        left_detector_m: f64 = 10.0, in 1.0..=200.0, unit "m", source "our choice: two vehicles";
        /// Which phases are served in every cycle without a vehicle: `main`, the through phases of the street with more
        /// lanes, `all`, those of every street, or `none`.
        recall: Recall = Recall::Main, source "NEMA TS 2";
    }
}

//! Dual-ring, fully actuated control in free operation: what stands in North American cabinets.
//!
//! Phases run in two rings side by side. Barriers cut the rings into sides, usually the main street and the
//! side street; both rings cross a barrier together. A phase is skipped when nobody calls it, lasts at least
//! its least green, is prolonged while vehicles pass its detectors, and ends at its longest green. What the
//! phases of a signal are, and how the rings go on, is in [`crate::traffic::env::dual_ring`], behind the limits of
//! `[signal]` that hold for every method.
//!
//! Choices:
//! - **Own logic instead of SUMO's `type="NEMA"`.** SUMO's cuts least greens short while a phase rests, shows a
//!   yellow beside an opposing green, sees only links with `G`, and stops for ever (1.15) where changes at a
//!   barrier are unequal. Own logic has no such case and is the same in every version of SUMO.
//! - **It decides every second**, as a cabinet does; `signal.delta_time_s` is for the others.
//! - **Detection is presence at the stop line**, without memory: a call ends when the vehicle has left. A lane calls
//!   the phase of its through movement; a lane for left turns alone calls the phase of its own if there is one.
//! - **The least green of a through phase** is that beside its crosswalks, in every cycle: there are no push
//!   buttons.
//!
//! Source: NEMA TS 2; FHWA, "Signal Timing Manual" (2nd ed., NCHRP 812), chapters 5 and 6.

use serde::{Deserialize, Serialize};

use super::{ControlError, Controller, Drive, Setup, SignalSpec};
use crate::run::method::{Method, Training};
use crate::settings::setting::settings;

/// The method.
pub const METHOD: Method = Method {
    name: "nema",
    summary: "dual-ring, fully actuated control as in North American cabinets",
    training: Training::None,
    default: false,
    decision_s: 0.0,
    color: "#7b3294",
    dash: "",
    settings: Config::SETTINGS,
};

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
    pub struct Config, source "FHWA, Signal Timing Manual (2nd ed.), chapters 5 and 6" {
        /// Time without a vehicle on a phase's detectors after which its green may end.
        passage_s: u32 = 2, in 1.0..=30.0, unit "s", source "Signal Timing Manual, chapter 6; of 2, 3 and 4 s the best here";
        /// Longest green of a phase while another one is called, within the limits of `[signal]`.
        max_green_s: u32 = 60, in 1.0..=600.0, unit "s", source "Signal Timing Manual, chapter 6";
        /// The same for a left turn's own phase; less where the through phase after it could not last its shortest green
        /// any more. In left-hand traffic these are right turns.
        left_max_green_s: u32 = 30, in 1.0..=600.0, unit "s", source "Signal Timing Manual, chapter 6";
        /// Length of the detectors, which end at the stop line; of a shorter lane, the street upstream is seen too.
        detector_m: f64 = 20.0, in 1.0..=200.0, unit "m", source "SUMO's NEMA controller; presence detection, Signal Timing Manual, chapter 4";
        /// The same on lanes for left turns alone.
        left_detector_m: f64 = 10.0, in 1.0..=200.0, unit "m", source "our choice: two vehicles";
        /// Which phases are served in every cycle without a vehicle: `main`, the through phases of the street with more
        /// lanes, `all`, those of every street, or `none`.
        recall: Recall = Recall::Main, source "NEMA TS 2";
    }
}

/// Returns dual-ring control.
pub fn create(config: &Config, _setup: &Setup) -> Box<dyn Controller> {
    Box::new(Nema { config: config.clone() })
}

/// Dual-ring control.
#[derive(Debug, Clone, PartialEq)]
struct Nema {
    config: Config,
}

impl Controller for Nema {
    fn name(&self) -> &'static str {
        METHOD.name
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        Ok(vec![Drive::DualRing(self.config.clone()); signals.len()])
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::two_phase_signal;
    use super::*;

    #[test]
    fn every_signal_runs_dual_ring_with_the_settings() {
        let config = Config { passage_s: 3, recall: Recall::All, ..Config::default() };
        let mut nema = create(&config, &Setup::default());
        let drives = nema.begin(&[two_phase_signal(), two_phase_signal()]).unwrap();
        assert_eq!(drives, vec![Drive::DualRing(config); 2]);
    }
}

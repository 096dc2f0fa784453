//! Dual-ring, fully actuated control in free operation: what stands in North American cabinets.
//!
//! Phases run in two rings side by side. Barriers cut the rings into sides, usually the main street and the
//! side street; both rings cross a barrier together. A phase is skipped when nobody calls it, lasts at least
//! its least green, is prolonged while vehicles pass its detectors, and ends at its longest green. What the
//! phases of a signal are, and how the rings go on, is in [`crate::env::dual_ring`], behind the limits of
//! `[signal]` that hold for every method.
//!
//! Choices:
//! - **Own logic instead of SUMO's `type="NEMA"`.** SUMO's cuts least greens short while a phase rests, shows a
//!   yellow beside an opposing green, sees only links with `G`, and stops for ever (1.15) where changes at a
//!   barrier are unequal. Own logic has no such case and is the same in every version of SUMO.
//! - **It decides every second**, as a cabinet does; `signal.delta_time_s` is for the others.
//! - **Detection is presence at the stop line**, without memory: a call ends when the vehicle has left. A lane calls
//!   the phase of its through movement; a lane for left turns alone calls the phase of its own if there is one.
//! - **The least green of a through phase** is that of the crosswalk to its right: in every cycle, or when
//!   somebody has pushed the button, which calls the phase, too.
//!
//! Source: NEMA TS 2; "Signal Timing Manual" (2nd ed., NCHRP Report 812), chapters 5 and 6.

pub use super::dual_ring::{Config, Recall};
use super::{Controller, Drive, Setup, same};
use evaluation::run::method::{Method, Training};

/// The method.
pub const METHOD: Method = Method {
    summary: "dual-ring, fully actuated control as in North American cabinets",
    default: true,
    settings: Config::SETTINGS,
    tunes: &[
        ("nema.passage_s", &[1.0, 2.0, 3.0, 4.0]),
        ("nema.max_green_s", &[20.0, 30.0, 40.0, 60.0, 90.0]),
        ("nema.left_max_green_s", &[10.0, 15.0, 20.0, 30.0, 45.0]),
    ],
    ..Method::built_in("nema", Training::None, "#000000")
};

/// Returns dual-ring control.
pub fn create(config: &Config, _setup: &Setup) -> Box<dyn Controller> {
    same(METHOD.name, Drive::DualRing(config.clone()))
}

//! The plan that a signal has today, as the cabinet has it.
//!
//! What the plan is comes with the point MDP: `--existing` or `family.existing`, a table of phases, UTDF or a program of SUMO.
//! Plans of `--plan-file` run in the same way. A pretimed plan
//! is a fixed cycle of its splits. An actuated one runs the logic of [`nema`](super::nema) with its own phases and times, a
//! coordinated one within its cycle.
//!
//! Deviation: the plan's own greens, yellow and red hold, not the limits of `[signal]`. It is what the street has, and
//! other methods are what it might have within the limits.
//!
//! Deviation: gap reduction, detectors of the plan, delayed calls and conditional service are not simulated.
//!
//! Source: "Signal Timing Manual" (2nd ed., NCHRP Report 812), chapters 5 to 7; NEMA TS 2.

use super::{Controller, Drive, Setup, same};
use evaluation::run::method::{Method, Training};
use evaluation::settings::setting::NoSettings;

/// The method.
pub const METHOD: Method = Method {
    summary: "the plan that the signal has today, given with --existing or UTDF",
    ..Method::built_in("existing", Training::None, "#875a78")
};

/// Returns the existing plan.
pub fn create(_config: &NoSettings, _setup: &Setup) -> Box<dyn Controller> {
    same(METHOD.name, Drive::Existing)
}

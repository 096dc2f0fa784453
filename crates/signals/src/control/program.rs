//! The network's own signal program, untouched: what a city runs today, and RESCO's FIXED.
//!
//! On generated networks the own program is netconvert's default, so the method equals the
//! baseline there.

use super::{ControlError, Controller, Drive, Setup, SignalSpec};
use evaluation::run::method::{Method, Training};
use evaluation::settings::setting::NoSettings;

/// The method.
pub const METHOD: Method = Method {
    summary: "the network's own signal program, untouched",
    ..Method::built_in("program", Training::None, "#66002b")
};

/// Returns the own program.
pub fn create(_config: &NoSettings, _setup: &Setup) -> Box<dyn Controller> {
    Box::new(Program)
}

/// The network's own program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Program;

impl Controller for Program {
    fn name(&self) -> &'static str {
        METHOD.name
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        Ok(vec![Drive::OwnProgram; signals.len()])
    }
}

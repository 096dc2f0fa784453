//! The network's own signal program, untouched: what a city runs today, and RESCO's FIXED.
//!
//! On generated networks the own program is netconvert's default, so the method equals the
//! baseline there.

use super::{ControlError, Controller, Drive, SignalSpec};

/// The network's own program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Program;

impl Program {
    /// Name of the method.
    pub const NAME: &'static str = "program";
}

impl Controller for Program {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        Ok(vec![Drive::OwnProgram; signals.len()])
    }
}

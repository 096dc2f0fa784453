//! SUMO's gap-based actuated control: what traffic engineers compare with.
//!
//! The greens of the network's own program run in their order; each is prolonged while vehicles
//! pass the detectors with time gaps below SUMO's default of 3 s, within the signal's limits.
//!
//! Source: SUMO documentation, "Traffic Lights", actuated traffic lights based on time gaps.

use super::{ControlError, Controller, Drive, SignalSpec};

/// Gap-based actuated control.
#[derive(Debug, Clone, PartialEq)]
pub struct Actuated {
    /// Longest green, seconds.
    pub max_green_s: f64,
}

impl Actuated {
    /// Name of the method.
    pub const NAME: &'static str = "actuated";
}

impl Controller for Actuated {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        Ok(vec![Drive::OwnActuated(self.max_green_s); signals.len()])
    }
}

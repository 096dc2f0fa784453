//! SUMO's gap-based actuated control: what traffic engineers compare with.
//!
//! The greens of the network's own program run in their order; each is prolonged while vehicles
//! pass the detectors with time gaps below SUMO's default of 3 s.
//!
//! Source: SUMO documentation, "Traffic Lights", actuated traffic lights based on time gaps.

use super::{ControlError, Controller, Drive, SignalSpec};

/// Gap-based actuated control.
#[derive(Debug, Clone, PartialEq)]
pub struct Actuated {
    /// Shortest green, seconds.
    pub min_green_s: f64,
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
        let (min_green_s, max_green_s) = (self.min_green_s, self.max_green_s);
        Ok(vec![Drive::OwnActuated { min_green_s, max_green_s }; signals.len()])
    }
}

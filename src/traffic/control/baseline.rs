//! The baseline: an untuned fixed-time program, the denominator of every score.
//!
//! - Generated networks run netconvert's own default program (cycle 90 s, 6 s for left phases,
//!   yellow by speed): what anyone gets who builds the network and changes nothing.
//! - Imported scenarios run the greens of their own program with the same time each; 35 s
//!   reproduces the paper's normaliser on Ingolstadt (43.5 s, implied by its published figures).
//!
//! Source: Jayawardana et al. (NeurIPS 2022), section 4: "an untuned yet sufficiently performant
//! fixed time controller"; the paper does not give the program.

use super::{ControlError, Controller, Drive, SignalSpec};

/// The untuned fixed-time program.
#[derive(Debug, Clone, PartialEq)]
pub struct Baseline {
    /// Green per phase of an equal split, seconds; `None` runs the network's own program.
    pub equal_split_green_s: Option<f64>,
}

impl Baseline {
    /// Name of the method.
    pub const NAME: &'static str = "baseline";
}

impl Controller for Baseline {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        let drive = self.equal_split_green_s.map_or(Drive::OwnProgram, Drive::OwnEqualSplit);
        Ok(vec![drive; signals.len()])
    }
}

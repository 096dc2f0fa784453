//! The baseline: an untuned fixed-time program, the denominator of every score.
//!
//! - Generated networks run netconvert's own default program (cycle 90 s, 6 s for left phases,
//!   yellow by speed): what anyone gets who builds the network and changes nothing.
//! - Imported scenarios run the greens for vehicles of their own program with the same time each; 35 s
//!   reproduces the paper's normaliser on Ingolstadt (43.5 s, implied by its published figures).
//!
//! Source: Jayawardana et al. (NeurIPS 2022), section 4: "an untuned yet sufficiently performant
//! fixed time controller"; the paper does not give the program.

use serde::{Deserialize, Serialize};

use super::{Controller, Drive, Setup, same};
use evaluation::run::method::{Method, Training};
use evaluation::settings::setting::settings;

/// The method.
pub const METHOD: Method = Method {
    summary: "untuned fixed time, the denominator of every score",
    default: true,
    settings: Config::SETTINGS,
    ..Method::built_in("baseline", Training::None, "#8c8c8c")
};

settings! {
    /// The denominator of every score: an untuned fixed-time program.
    pub struct Config, source "Jayawardana et al. (NeurIPS 2022), section 4" {
        /// Program of the baseline: `netconvert` is its default program, `equal-split` gives all phases the same green,
        /// and `auto` is the first for generated networks and the second for imported scenarios.
        program: BaselineProgram = BaselineProgram::Auto;
        /// Green per phase of the equal split; 35 s comes near the paper's baseline on Ingolstadt.
        green_s: f64 = 35.0, in 1.0..=300.0, unit "s";
    }
}

/// Programs that the baseline can run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BaselineProgram {
    /// `netconvert` for generated networks, `equal-split` for imported scenarios.
    Auto,
    /// The program that netconvert gives a signal by default.
    Netconvert,
    /// The same green for every phase.
    EqualSplit,
}

impl BaselineProgram {
    /// Whether it is an equal split, in an imported scenario or a generated network.
    fn is_equal_split(self, imported: bool) -> bool {
        match self {
            Self::Auto => imported,
            Self::Netconvert => false,
            Self::EqualSplit => true,
        }
    }
}

/// Returns the baseline.
pub fn create(config: &Config, setup: &Setup) -> Box<dyn Controller> {
    let split = config.program.is_equal_split(setup.imported);
    let drive = if split { Drive::OwnEqualSplit(config.green_s) } else { Drive::OwnProgram };
    same(METHOD.name, drive)
}

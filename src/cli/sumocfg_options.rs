//! What the command line says of SUMO scenarios, in place of what their files say.

use crate::cli::refused::Refused;
use crate::traffic::sim::obstacle::{Accept, Given};
use crate::traffic::sim::sumocfg::seconds;

/// Options on SUMO scenarios of somebody's own.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct SumocfgArgs {
    /// Start of SUMO scenarios, seconds or HH:MM:SS [default: their own]
    #[arg(long, value_name = "SECONDS", value_parser = parse_time)]
    pub begin: Option<f64>,
    /// End of SUMO scenarios, seconds or HH:MM:SS [default: their own]
    #[arg(long, value_name = "SECONDS", value_parser = parse_time)]
    pub end: Option<f64>,
    /// Length of a step of SUMO scenarios, seconds [default: their own]
    #[arg(long, value_name = "SECONDS", value_parser = parse_time)]
    pub step_length: Option<f64>,
    /// Things in SUMO scenarios that are refused without this option
    #[arg(long, value_name = "WHAT,...", value_enum, value_delimiter = ',')]
    pub accept: Vec<Accept>,
}

fn parse_time(text: &str) -> Result<f64, String> {
    seconds(text)
}

impl SumocfgArgs {
    /// Returns what is said.
    pub fn given(&self) -> Given {
        Given {
            begin_s: self.begin,
            end_s: self.end,
            step_length_s: self.step_length,
            accept: self.accept.iter().copied().collect(),
        }
    }

    /// Refuses what has no effect where no SUMO scenario is given.
    pub fn check(&self, imported: bool) -> Result<(), Refused> {
        let flags = [
            ("--begin", self.begin.is_some()),
            ("--end", self.end.is_some()),
            ("--step-length", self.step_length.is_some()),
            ("--accept", !self.accept.is_empty()),
        ];
        match flags.iter().find(|(_, is_given)| *is_given && !imported) {
            None => Ok(()),
            Some((flag, _)) => Err(Refused(format!(
                "{flag} has no effect: no SUMO configuration is given; leave it out"
            ))),
        }
    }
}

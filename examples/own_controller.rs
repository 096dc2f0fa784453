//! A controller of one's own in Rust: with it, this program is the command `tsc-family` and its workers.
//!
//! ```sh
//! cargo run --release --example own_controller -- run smoke --methods longest-queue,max-pressure,actuated \
//!     --out results/own-controller
//! ```
//!
//! A controller sees the signals once per episode and what their detectors count at every decision,
//! nothing else. The manifest has the hash of the program, so that one that was built anew from other sources is
//! another run.

use std::process::ExitCode;

use tsc_family::traffic::control::{
    ControlError, Controller, Drive, GreenPhase, Observation, SignalSpec,
};
use tsc_family::{Method, Traffic, Training, cli};

/// Name of the controller, in records, tables and figures.
const NAME: &str = "longest-queue";

/// Serves the phase whose lanes hold the most vehicles that have halted in them.
#[derive(Default)]
struct LongestQueue {
    /// Per signal and phase the lanes that it serves.
    serves: Vec<Vec<Vec<usize>>>,
}

impl Controller for LongestQueue {
    fn name(&self) -> &'static str {
        NAME
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        let of_phases = |s: &SignalSpec| (0..s.phases.len()).map(|p| s.served_lanes(p)).collect();
        self.serves = signals.iter().map(of_phases).collect();
        Ok(vec![Drive::Decisions; signals.len()])
    }

    fn act(
        &mut self,
        observations: &[Observation],
        phases: &mut [GreenPhase],
    ) -> Result<(), ControlError> {
        for ((seen, serves), phase) in observations.iter().zip(&self.serves).zip(phases) {
            let queue = |lanes: &[usize]| lanes.iter().map(|l| seen.lanes[*l].queue).sum::<f64>();
            let longest = (0..serves.len()).max_by(|a, b| {
                // The first of equals: `max_by` would take the last.
                queue(&serves[*a]).total_cmp(&queue(&serves[*b])).then(b.cmp(a))
            });
            *phase = GreenPhase(longest.unwrap_or(0));
        }
        Ok(())
    }
}

fn main() -> ExitCode {
    let summary = "the phase with the most vehicles that have halted";
    let about = Method::new(NAME, summary, Training::None);
    cli::main_with(Traffic::default().with(about, Box::new(|_| Box::new(LongestQueue::default()))))
}

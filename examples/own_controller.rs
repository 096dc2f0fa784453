//! A controller of one's own, beside two of this library, on the smoke scenario.
//!
//! ```sh
//! cargo run --release --example own_controller
//! ```
//!
//! A controller sees the signals once per episode and what their detectors count at every decision,
//! nothing else. What it is compared with and the records are those of `tsc-family run`; the page is made by
//! `tsc-family report results/own-controller/run`. Finished tasks are kept: give another folder when the
//! controller has changed.

use std::error::Error;
use std::io::Write;
use std::path::Path;

use tsc_family::analysis::{Analysis, NoMeasures};
use tsc_family::traffic::control::{
    ControlError, Controller, Drive, GreenPhase, Light, Observation, SignalSpec,
};
use tsc_family::traffic::family::load::load;
use tsc_family::{Method, Request, SignalProblem, Traffic, Training, evaluate};

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
        self.serves = signals
            .iter()
            .map(|signal| signal.phases.iter().map(|p| lanes(signal, &p.service)).collect())
            .collect();
        Ok(vec![Drive::Decisions; signals.len()])
    }

    fn act(&mut self, observations: &[Observation], phases: &mut [GreenPhase]) {
        for ((seen, serves), phase) in observations.iter().zip(&self.serves).zip(phases) {
            let queue = |lanes: &[usize]| lanes.iter().map(|l| seen.lanes[*l].queue).sum::<f64>();
            let longest = (0..serves.len()).max_by(|a, b| {
                // The first of equals: `max_by` would take the last.
                queue(&serves[*a]).total_cmp(&queue(&serves[*b])).then(b.cmp(a))
            });
            *phase = GreenPhase(longest.unwrap_or(0));
        }
    }
}

/// Returns the lanes of a signal that a phase serves, each once.
fn lanes(signal: &SignalSpec, service: &[Light]) -> Vec<usize> {
    let served = signal.movements.iter().zip(service).filter(|(_, s)| **s != Light::Red);
    let mut lanes: Vec<usize> = served.flat_map(|(m, _)| m.lanes.iter().copied()).collect();
    lanes.sort_unstable();
    lanes.dedup();
    lanes
}

fn main() -> Result<(), Box<dyn Error>> {
    let about =
        Method::new(NAME, "the phase with the most vehicles that have halted", Training::None);
    let traffic =
        Traffic::default().with(about, Box::new(|_seed| Box::new(LongestQueue::default())));
    let folder = Path::new("results/own-controller");
    // No folder of a city beside the scenario, networks of our own, no SUMO scenarios in place of the family.
    let problem = SignalProblem::new(load("smoke")?, None, folder.join("networks"), &[])?;
    let methods = [NAME, "max-pressure", "actuated"].map(str::to_owned);
    let request = Request::new(&traffic, &problem, &methods);
    let results = evaluate(&request, &folder.join("run"))?;

    let mut out = std::io::stdout().lock();
    for method in &Analysis::new(&results, &NoMeasures).methods {
        let score = method.overall.map_or("no score".to_owned(), |score| format!("{score:.2}"));
        writeln!(out, "{:14} {score}", method.method)?;
    }
    for (task, kept) in results.failed() {
        let reason = kept.reason().unwrap_or("no reason");
        writeln!(out, "{} on {}: {reason}", task.method, task.point)?;
    }
    Ok(())
}

//! The programs of one task, from its record.

use crate::shown::finished;
use evaluation::stats::Direction;
use evaluation::store::manifest::Task;
use evaluation::store::record::Summary;
use evaluation::store::results::Results;
use signals::program::{PHASES, ProgramKind, SignalProgram};

/// The programs of one task.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskPlan {
    /// Position of the method in the manifest.
    pub method: usize,
    /// Position of the point MDP among the chosen ones.
    pub point: usize,
    /// Which of several independent trainings.
    pub replicate: u32,
    /// Mean objective of the evaluation episodes.
    pub objective: Option<f64>,
    /// One program per signal; empty for a method that decides while it runs.
    pub programs: Vec<SignalProgram>,
    /// Phases of the signals that a method drives by phases, in words, by signal.
    pub phases: Vec<(String, String)>,
    /// Signals of a task in which some ran in two rings: with their phases, or with the fixed cycle of the others.
    pub rings: Vec<SignalProgram>,
}

impl TaskPlan {
    /// Whether its objective is better than that of another training; a training without one is the worst.
    pub(crate) fn is_better_than(&self, other: &Self, direction: Direction) -> bool {
        match (self.objective, other.objective) {
            (Some(own), Some(other)) => direction.is_worse(other, own),
            (own, other) => own.is_some() && other.is_none(),
        }
    }
}

/// Returns what every finished task ran, in the order of the plan.
pub(crate) fn plans(results: &Results) -> Vec<TaskPlan> {
    let identity = &results.manifest.identity;
    let plan = |(method, point, task, record): (usize, usize, &Task, &Summary)| {
        // The checksum of the record vouches for their form.
        let recorded: Vec<SignalProgram> = record.programs.read().ok().unwrap_or_default();
        // Within a common cycle some signals may run rings, and others a fixed cycle.
        let (rings, programs) = match recorded.iter().any(|p| p.kind == ProgramKind::DualRing) {
            true => (recorded, Vec::new()),
            false => (Vec::new(), recorded),
        };
        let phases = |(name, text): (&String, &String)| {
            Some((name.strip_prefix(PHASES)?.to_owned(), text.clone()))
        };
        TaskPlan {
            method,
            point,
            replicate: task.replicate,
            objective: record.metrics.get(&identity.objective).copied(),
            programs,
            phases: record.details.iter().filter_map(phases).collect(),
            rings,
        }
    };
    finished(results).map(plan).collect()
}

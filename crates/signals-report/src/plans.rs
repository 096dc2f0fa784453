//! The signal programs of methods whose behaviour is one: tables, files for SUMO, and what shows the
//! best method of a point MDP.
//!
//! - **Several trainings** have several plans. All are in the table; the files have that of the
//!   best recorded objective.

pub(super) mod cabinet;
pub mod episode;
mod files;
mod program_xml;
pub(super) mod told;

use minijinja::{Value, context};

use crate::shown::{Seen, finished};
use evaluation::report::format;
use evaluation::stats::Direction;
use evaluation::store::manifest::Task;
use evaluation::store::record::Summary;
use evaluation::store::results::Results;
use signals::program::{PHASES, ProgramKind, SignalProgram};

pub(super) use files::{FOLDER, TABLE, remove_earlier, write};

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
pub(super) fn plans(results: &Results) -> Vec<TaskPlan> {
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

/// Returns the section on signal plans; undefined without a finished task.
pub(super) fn values(seen: Seen<'_>) -> Option<Value> {
    let Seen { data, shown } = seen;
    let identity = &data.manifest.identity;
    let rows: Vec<Value> = identity
        .methods
        .iter()
        .enumerate()
        .filter_map(|(index, method)| {
            let plans: Vec<&TaskPlan> = shown.plans.iter().filter(|p| p.method == index).collect();
            let wins = || {
                let best = |p: &usize| data.winners[*p].as_ref().is_some_and(|w| w.best == index);
                (0..data.points.len()).filter(best)
            };
            let weight: f64 = wins().map(|p| data.points[p].weight).sum();
            (!plans.is_empty()).then(|| {
                context! {
                    name => method.clone(),
                    wins => wins().count(),
                    share => format::percent(weight),
                    behaviour => behaviour(&plans),
                }
            })
        })
        .collect();
    (!rows.is_empty())
        .then(|| context! { rows, chosen => data.points.len(), whole => shown.plans.iter().any(|p| !p.programs.is_empty()) })
}

/// Says what a method does, and where that can be had.
fn behaviour(plans: &[&TaskPlan]) -> &'static str {
    let own = |p: &&TaskPlan| p.programs.iter().all(|program| program.own);
    if plans.iter().all(|p| p.programs.is_empty()) {
        "no program to load in its records"
    } else if plans.iter().all(own) {
        "the network\u{2019}s own program: nothing to load"
    } else {
        "a program"
    }
}

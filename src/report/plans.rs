//! The signal programs of methods whose behaviour is one: tables, files for SUMO, and what shows the
//! best method of a point MDP.
//!
//! - **Records keep what signals ran.** Those from before that have the greens of tuned plans in words;
//!   where yellow and all-red are the same everywhere the whole plan follows, elsewhere it is listed
//!   without them.
//! - **Several trainings** have several plans. All are in the table; the files have that of the
//!   least recorded delay.

mod config;
mod described;
mod files;
mod program_xml;
mod table;

pub(super) use files::write;

use crate::analysis::TaskScore;
use crate::store::results::Results;
use crate::traffic::program::SignalProgram;
use crate::traffic::settings::signal::SignalSettings;

/// Methods whose behaviour is a program, for records from before programs were kept.
const ALWAYS_PROGRAMS: [&str; 4] = ["baseline", "fixed-time", "actuated", "program"];

/// The method whose plans are tuned.
const TUNED: &str = "fixed-time";

/// How much is known of what a method does on a point MDP.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The record has the programs.
    Recorded,
    /// The record has greens and cycle in words; yellow and all-red follow from the settings.
    Described,
    /// The record has greens and cycle in words, nothing else.
    Greens,
    /// Not even that: the record is from before programs were kept.
    NotKept,
    /// The method decides while it runs.
    Decides,
}

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
    /// How much is known.
    pub source: Source,
    /// One program per signal; without phases where they are not known.
    pub programs: Vec<SignalProgram>,
    /// Cycle per signal where the record says it and its phases do not, seconds.
    pub cycles_s: Vec<Option<f64>>,
}

/// Returns what every finished task ran, in the order of the plan.
pub(super) fn plans(results: &Results, rows: &[TaskScore]) -> Vec<TaskPlan> {
    let identity = &results.manifest.identity;
    let settings = identity.settings.get("signal").cloned().unwrap_or_default();
    let settings: SignalSettings = serde_json::from_value(settings).unwrap_or_default();
    let position = |point: &str| identity.points.iter().position(|p| p.point == point);
    let mut plans = Vec::new();
    for (task, row) in results.plan.iter().zip(rows) {
        let method = identity.methods.iter().position(|m| *m == task.method);
        let (Some(record), Some(method), Some(point)) =
            (results.records.get(&task.task), method, position(&task.point))
        else {
            continue;
        };
        let s = &record.summary;
        let always =
            ALWAYS_PROGRAMS.contains(&task.method.as_str()) || task.method == identity.baseline;
        // The checksum of the record vouches for their form.
        let recorded: Vec<SignalProgram> = s.programs.read().unwrap_or_default();
        let (source, programs, cycles_s) = if !recorded.is_empty() {
            let cycles_s = vec![None; recorded.len()];
            (Source::Recorded, recorded, cycles_s)
        } else if let Some(found) = described::programs(&s.details, &settings) {
            found
        } else if always {
            (Source::NotKept, Vec::new(), Vec::new())
        } else {
            (Source::Decides, Vec::new(), Vec::new())
        };
        if s.outcome != crate::store::record::Outcome::Ok {
            continue;
        }
        let objective = row.metrics.get(&identity.objective).copied();
        let replicate = task.replicate;
        plans.push(TaskPlan { method, point, replicate, objective, source, programs, cycles_s });
    }
    plans
}

impl TaskPlan {
    /// Whether SUMO can be given the programs.
    pub fn is_whole(&self) -> bool {
        matches!(self.source, Source::Recorded | Source::Described)
    }
}

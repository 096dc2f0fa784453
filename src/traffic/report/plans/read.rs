//! What every task ran, from its record.

use std::collections::HashMap;

use super::described;
use super::task_plan::{Source, TaskPlan};
use crate::store::record::Outcome;
use crate::store::results::Results;
use crate::traffic::program::SignalProgram;
use crate::traffic::settings::signal::SignalSettings;

/// Methods whose behaviour is a program, for records from before programs were kept.
const ALWAYS_PROGRAMS: [&str; 4] = ["baseline", "fixed-time", "actuated", "program"];

/// Returns what every finished task ran, in the order of the plan.
pub(in crate::traffic::report) fn plans(results: &Results) -> Vec<TaskPlan> {
    let identity = &results.manifest.identity;
    let settings = identity.settings.get("signal").cloned().unwrap_or_default();
    let settings: SignalSettings = serde_json::from_value(settings).unwrap_or_default();
    let points = identity.points.iter().enumerate();
    let points: HashMap<&str, usize> = points.map(|(i, p)| (p.point.as_str(), i)).collect();
    let mut plans = Vec::new();
    for task in &results.plan {
        let method = identity.methods.iter().position(|m| *m == task.method);
        let (Some(record), Some(method), Some(point)) =
            (results.records.get(&task.task), method, points.get(task.point.as_str()).copied())
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
        if s.outcome != Outcome::Ok {
            continue;
        }
        let objective = s.metrics.get(&identity.objective).copied();
        let replicate = task.replicate;
        plans.push(TaskPlan { method, point, replicate, objective, source, programs, cycles_s });
    }
    plans
}

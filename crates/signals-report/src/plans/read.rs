//! What every task ran, from its record.

use super::described;
use super::task_plan::{Programs, Source, TaskPlan};
use crate::shown::finished;
use evaluation::store::results::Results;
use signals::program::{PHASES, ProgramKind, SignalProgram};
use signals::settings::signal::SignalSettings;

/// Methods whose behaviour is a program, for records from before programs were kept.
const ALWAYS_PROGRAMS: [&str; 4] = ["baseline", "fixed-time", "actuated", "program"];

/// Returns what every finished task ran, in the order of the plan.
pub(crate) fn plans(results: &Results) -> Vec<TaskPlan> {
    let identity = &results.manifest.identity;
    let settings = identity.settings.get("signal").cloned().unwrap_or_default();
    let settings: SignalSettings = serde_json::from_value(settings).unwrap_or_default();
    let mut plans = Vec::new();
    for (method, point, task, record) in finished(results) {
        let always = ALWAYS_PROGRAMS.contains(&&*task.method) || *task.method == *identity.baseline;
        // The checksum of the record vouches for their form.
        let recorded: Vec<SignalProgram> = record.programs.read().ok().unwrap_or_default();
        // Within a common cycle some signals may run rings, and others a fixed cycle.
        let (rings, recorded) = match recorded.iter().any(|p| p.kind == ProgramKind::DualRing) {
            true => (recorded, Vec::new()),
            false => (Vec::new(), recorded),
        };
        let (source, programs, cycles_s) = if !rings.is_empty() {
            (Source::Decides, Vec::new(), Vec::new())
        } else if !recorded.is_empty() {
            let cycles_s = vec![None; recorded.len()];
            (Source::Recorded, recorded, cycles_s)
        } else if let Some(found) = described::programs(&record.details, &settings) {
            found
        } else if always {
            (Source::NotKept, Vec::new(), Vec::new())
        } else {
            (Source::Decides, Vec::new(), Vec::new())
        };
        let objective = record.metrics.get(&identity.objective).copied();
        let replicate = task.replicate;
        let known = Programs { all: programs, cycles_s };
        let programs = (!known.all.is_empty()).then(|| Box::new(known));
        let details = record.details.iter();
        let phases = details
            .filter_map(|(name, text)| Some((name.strip_prefix(PHASES)?.to_owned(), text.clone())))
            .collect();
        plans.push(TaskPlan {
            method,
            point,
            replicate,
            objective,
            source,
            programs,
            phases,
            rings,
        });
    }
    plans
}

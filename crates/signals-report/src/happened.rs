//! What happened to vehicles of somebody's own scenario that a reader of the ranking should know: a collision or a teleport
//! takes a vehicle off the street, and the delay of those behind it is then of other traffic. One that stands to the end
//! may alone decide the delay.

use evaluation::analysis::Analysis;
use evaluation::store::record::Outcome;
use signals::env::standing::STANDING_S;
use signals::network_files::GENERATED;

use super::shown::OfTask;

/// Metrics of what happened, and what is said of them.
const METRICS: [(&str, &str); 2] =
    [("collisions", "vehicles collided"), ("teleports", "vehicles were teleported")];

/// Most places that are named.
const NAMED: usize = 5;

/// Returns a line per kind of event on all imported scenarios; nothing of networks that are generated.
pub(super) fn happened(data: &Analysis, standing: &[OfTask<String>]) -> Vec<String> {
    let identity = &data.manifest.identity;
    let mut lines = Vec::new();
    for (metric, what) in METRICS {
        let mut found: Vec<(f64, String)> = Vec::new();
        for task in data.tasks.iter().filter(|task| task.outcome == Some(Outcome::Ok)) {
            let row = &data.points[task.point].row;
            let count = task.metrics.get(metric).copied().unwrap_or_default();
            if row.environment != GENERATED && count > 0.0 {
                let method = &identity.methods[task.method];
                found.push((count, format!("{method} on {}: {count:.1}", row.name())));
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let found: Vec<String> = found.into_iter().map(|(_, text)| text).collect();
        lines.extend(listed(&found).map(|all| format!("{what}, per episode: {all}")));
    }
    let stood = standing.iter().map(|task| {
        let point = data.points[task.point].row.name();
        format!("{} on {point} {}", identity.methods[task.method], task.results)
    });
    lines.extend(listed(&stood.collect::<Vec<_>>()).map(|all| {
        format!(
            "vehicles stood for {STANDING_S} s or longer, and the delay is then of those behind them, first: {all}; \
             simulation.time_to_teleport_s = {STANDING_S} has SUMO move them on, as it does by default"
        )
    }));
    lines
}

/// Returns the first of some texts and how many more there are; `None` without any.
fn listed(found: &[String]) -> Option<String> {
    let more = match found.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(", and {more} more"),
    };
    (!found.is_empty()).then(|| format!("{}{more}", found[..found.len().min(NAMED)].join(", ")))
}

//! What happened to vehicles of somebody's own scenario that a reader of the ranking should know: a collision or a teleport
//! takes a vehicle off the street, and the delay of those behind it is then of other traffic.

use evaluation::analysis::Analysis;
use evaluation::store::record::Outcome;
use signals::network_files::GENERATED;

/// Metrics of what happened, and what is said of them.
const METRICS: [(&str, &str); 2] =
    [("collisions", "vehicles collided"), ("teleports", "vehicles were teleported")];

/// Most places that are named.
const NAMED: usize = 5;

/// Returns a line per kind of event on all imported scenarios; nothing of networks that are generated.
pub(super) fn happened(data: &Analysis) -> Vec<String> {
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
        let most: Vec<&str> = found.iter().take(NAMED).map(|(_, text)| text.as_str()).collect();
        let more = match found.len() - most.len() {
            0 => String::new(),
            more => format!(", and {more} more"),
        };
        if !most.is_empty() {
            lines.push(format!("{what}, per episode: {}{more}", most.join(", ")));
        }
    }
    lines
}

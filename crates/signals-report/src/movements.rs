//! Results by movement: `movements.csv`, and a table on the page where there are few intersections.
//!
//! Deviation: the level of service of a movement is that of the simulator's delay, which contains slowing down and waiting
//! to enter; the Highway Capacity Manual has control delay, and F wherever demand exceeds capacity.

use std::collections::BTreeMap;

use minijinja::{Value, context};

use super::level_of_service::letter;
use super::shown::Seen;
use basics::units::SECONDS_PER_HOUR;
use evaluation::analysis::Analysis;
use evaluation::report::csv::{self, number};
use evaluation::report::figures::shown as named;
use evaluation::report::format;
use evaluation::store::record::Outcome;
use evaluation::store::results::Results;
use signals::movement_results::MovementResult;

/// Name of the table in the report's folder.
pub(crate) const TABLE: &str = "movements.csv";

/// Most intersections whose movements the page shows.
const FEW: usize = 12;

/// Share of unfinished vehicles from which on a movement is marked: more arrive than leave.
const UNSERVED: f64 = 0.1;

const HEADER: [&str; 13] = [
    "point",
    "method",
    "replicate",
    "movement",
    "from_edge",
    "to_edge",
    "volume_vph",
    "delay_s",
    "level_of_service",
    "stops_per_veh",
    "unfinished_share",
    "queue_50_veh",
    "queue_95_veh",
];

/// Results by movement of a task.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TaskMovements {
    method: usize,
    /// Position of the point MDP in the manifest.
    pub(crate) point: usize,
    replicate: u32,
    /// The results.
    pub(crate) results: Vec<MovementResult>,
}

/// Returns the results by movement of every finished task that has them, in the order of the plan.
pub(crate) fn movements(results: &Results) -> Vec<TaskMovements> {
    let identity = &results.manifest.identity;
    let points: BTreeMap<&str, usize> =
        identity.points.iter().enumerate().map(|(i, p)| (p.point.as_str(), i)).collect();
    let mut all = Vec::new();
    for (task, record) in results.rows() {
        let method = identity.methods.iter().position(|m| *m == *task.method);
        let (Some(record), Some(method), Some(point)) =
            (record, method, points.get(&*task.point).copied())
        else {
            continue;
        };
        let record = &record.summary;
        if record.outcome != Outcome::Ok || record.parts.is_empty() {
            continue;
        }
        // The checksum of the record vouches for their form.
        let results: Vec<MovementResult> = record.parts.read().unwrap_or_default();
        if !results.is_empty() {
            all.push(TaskMovements { method, point, replicate: task.replicate, results });
        }
    }
    all
}

/// Returns the table of all movements.
pub(crate) fn table(seen: Seen<'_>) -> String {
    let Seen { data, shown } = seen;
    let titles = shown.titles(data);
    let titled = csv::Titled(titles.as_deref());
    let hours = hours(data);
    let rows = shown.movements.iter().flat_map(|task| {
        let identity = &data.manifest.identity;
        task.results.iter().map(move |m| {
            let cells = vec![
                identity.points[task.point].point.clone(),
                identity.methods[task.method].clone(),
                task.replicate.to_string(),
                m.movement.clone(),
                m.from.clone(),
                m.to.clone(),
                number(Some(m.vehicles_veh / hours)),
                number(m.delay_s),
                m.delay_s.map_or_else(String::new, |delay_s| letter(delay_s).to_string()),
                number(m.stops),
                number(unfinished(m)),
                number(Some(m.queue_50_veh)),
                number(Some(m.queue_95_veh)),
            ];
            titled.row(task.point, cells)
        })
    });
    csv::table(&titled.header(HEADER.map(str::to_owned).to_vec()), rows)
}

/// Returns the section on movements; undefined where no record has them.
pub(crate) fn values(seen: Seen<'_>) -> Option<Value> {
    let Seen { data, shown } = seen;
    if shown.movements.is_empty() {
        return None;
    }
    let identity = &data.manifest.identity;
    let many = data.points.len() > FEW;
    let points: Vec<Value> =
        (0..data.points.len()).filter(|_| !many).filter_map(|p| point(seen, p)).collect();
    Some(
        context! { points, many, few => FEW, chosen => data.points.len(), baseline => identity.baseline.as_str() },
    )
}

/// Returns the movements of an intersection under the best method and under the baseline.
fn point(seen: Seen<'_>, point: usize) -> Option<Value> {
    let Seen { data, shown } = seen;
    let identity = &data.manifest.identity;
    let of =
        |method: usize| shown.movements.iter().find(|t| t.point == point && t.method == method);
    let best = data.winners[point].as_ref().map(|winner| winner.best)?;
    let baseline = identity.methods.iter().position(|m| *m == identity.baseline);
    let compared: Vec<usize> = [Some(best), baseline.filter(|b| *b != best)]
        .into_iter()
        .flatten()
        .filter(|m| of(*m).is_some())
        .collect();
    let all = of(*compared.first()?)?;
    let hours = hours(data);
    let rows: Vec<Value> = all
        .results
        .iter()
        .map(|m| {
            let cells = compared.iter().map(|method| {
                let own = of(*method).and_then(|task| {
                    task.results.iter().find(|r| (&r.from, &r.to) == (&m.from, &m.to))
                });
                own.map(|own| {
                    let unserved = unfinished(own).is_some_and(|share| share > UNSERVED);
                    context! {
                        delay => own.delay_s.map(|s| format!("{s:.1}")),
                        level => own.delay_s.map(|s| letter(s).to_string()),
                        stops => own.stops.map(|stops| format!("{stops:.2}")),
                        queue => format!("{:.0}", own.queue_95_veh),
                        unserved,
                    }
                })
            });
            context! {
                movement => m.movement.as_str(),
                volume => format!("{:.0}", m.vehicles_veh / hours),
                cells => cells.collect::<Vec<_>>(),
            }
        })
        .collect();
    let names: Vec<String> = compared.iter().map(|m| named(data, &identity.methods[*m])).collect();
    let title = shown.title(&data.points[point].row);
    Some(context! { title, names, rows, weight => format::percent(data.points[point].weight) })
}

fn unfinished(movement: &MovementResult) -> Option<f64> {
    (movement.vehicles_veh > 0.0).then(|| movement.unfinished_veh / movement.vehicles_veh)
}

/// Returns the hours of an episode.
fn hours(data: &Analysis) -> f64 {
    let horizon_s = data.manifest.identity.settings.get("demand").and_then(|d| d.get("horizon_s"));
    horizon_s.and_then(serde_json::Value::as_f64).unwrap_or(SECONDS_PER_HOUR) / SECONDS_PER_HOUR
}

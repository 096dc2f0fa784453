//! Models away from home: what was learned on one point MDP, evaluated on the others of the run, beside what was trained there.
//!
//! The run has the learners with their own training on every point MDP, and every model as a method of its own.

use super::table::{Cell, Columns, Table};
use crate::analysis::{Analysis, PointSummary};

/// A model as a method of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Origin {
    /// Name of the model among the run's methods.
    pub name: String,
    /// The method that learned it.
    pub method: String,
    /// Id of the point MDP of its training.
    pub point: String,
}

/// Returns a row per model and point MDP, those with most weight first; without a score there is the reason.
///
/// # Arguments
///
/// * `origins` — the models among the run's methods.
pub fn table(data: &Analysis, origins: &[Origin]) -> Table {
    type Row<'a> = (&'a Origin, &'a PointSummary);
    let position = |name: &str| data.manifest.identity.methods.iter().position(|m| m == name);
    let score = move |name: &str, p: &PointSummary| p.results[position(name)?].as_ref()?.score;
    let reason = |(origin, p): &Row<'_>| {
        let method = position(&origin.name).filter(|_| score(&origin.name, p).is_none());
        let mut tasks =
            data.tasks.iter().filter(|t| t.point == p.index && Some(t.method) == method);
        tasks.find_map(|task| task.reason.clone()).unwrap_or_default()
    };
    let ratio = move |(origin, p): &Row<'_>| {
        let own = score(&origin.method, p).filter(|own| *own != 0.0)?;
        Some(score(&origin.name, p)? / own)
    };
    let mut points: Vec<&PointSummary> = data.points.iter().collect();
    points.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    Columns::new()
        .text("method", "", |(origin, _): &Row<'_>| origin.method.clone())
        .text("trained_on", "", |(origin, _)| origin.point.clone())
        .text("evaluated_on", "", |(_, p)| p.row.point.clone())
        .file("weight", |(_, p)| Cell::exact(p.weight))
        .file("score", move |(origin, p)| Cell::exact(score(&origin.name, p)))
        .file("own_training", move |(origin, p)| Cell::exact(score(&origin.method, p)))
        .file("ratio", move |row| Cell::exact(ratio(row)))
        .text("reason", "", reason)
        .table(origins.iter().flat_map(|origin| points.iter().map(move |p| (origin, *p))))
}

//! The tables of a report: `scores.csv` with one row per task, `summary.csv` with one per method,
//! `training.csv` with one per task of a learner.

use super::data::{MethodSummary, ReportData, ScoreRow};
use super::level_of_service::{DELAY, letter};
use super::training::Training;
use crate::store::record::Outcome;

/// Metrics that have a column of their own besides the objective.
const METRICS: [&str; 5] =
    ["waiting_s", "queue_veh", "throughput_veh", "unfinished_veh", "teleports"];

/// Returns `scores.csv`: one row per method, point MDP and replicate; without a successful record
/// the metrics are empty.
pub(super) fn scores(data: &ReportData) -> String {
    let identity = &data.manifest.identity;
    let objective = identity.objective.clone();
    let mut header: Vec<String> =
        ["method", "point", "importance", "replicate"].map(str::to_owned).to_vec();
    header.extend([objective.clone(), format!("baseline_{objective}"), "score".to_owned()]);
    header.extend(METRICS.map(str::to_owned));
    header.push("level_of_service".to_owned());
    header.extend(identity.features.iter().map(|f| f.name.clone()));
    header.push("weight".to_owned());
    table(&header, data.rows.iter().map(|row| score_row(data, row)))
}

fn score_row(data: &ReportData, row: &ScoreRow) -> Vec<String> {
    let point = &data.points[row.point].row;
    let objective = data.manifest.identity.objective.as_str();
    let value = match row.outcome {
        Some(Outcome::Ok) => row.metrics.get(objective).copied(),
        _ => None,
    };
    let mut cells = vec![
        row.method.clone(),
        point.point.clone(),
        point.importance.to_string(),
        row.replicate.to_string(),
        number(value),
        number(row.baseline),
        number(row.score),
    ];
    cells.extend(METRICS.map(|name| number(row.metrics.get(name).copied())));
    let level = value.filter(|_| objective == DELAY).map(letter);
    cells.push(level.map_or_else(String::new, |l| l.to_string()));
    cells.extend(point.features.iter().map(f64::to_string));
    cells.push(data.points[row.point].weight.to_string());
    cells
}

/// Returns `summary.csv`: one row per method, best first.
pub(super) fn summary(data: &ReportData) -> String {
    let identity = &data.manifest.identity;
    let objective = identity.objective.clone();
    let header = ["method", "rank", "overall", "overall_low", "overall_high", &objective]
        .into_iter()
        .chain(["waiting_s", "queue_veh", "worst_point", "worst_score", "points", "failed"])
        .chain(["missing", "sampling", "budget", "family_size", "evaluation_seeds"])
        .map(str::to_owned)
        .collect::<Vec<_>>();
    table(&header, data.methods.iter().map(|m| summary_row(data, m)))
}

fn summary_row(data: &ReportData, m: &MethodSummary) -> Vec<String> {
    let identity = &data.manifest.identity;
    vec![
        m.method.clone(),
        m.rank.map_or_else(String::new, |r| r.to_string()),
        number(m.overall),
        number(m.interval.map(|i| i.0)),
        number(m.interval.map(|i| i.1)),
        number(m.objective),
        number(m.metrics.get("waiting_s").copied()),
        number(m.metrics.get("queue_veh").copied()),
        m.worst.as_ref().map_or_else(String::new, |w| w.0.clone()),
        number(m.worst.as_ref().map(|w| w.1)),
        m.points.to_string(),
        m.failed.to_string(),
        m.missing.to_string(),
        data.sampling().to_owned(),
        identity.sample.budget.to_string(),
        identity.sample.family_size.to_string(),
        identity.evaluation_seeds.len().to_string(),
    ]
}

/// Returns `training.csv`: one row per training; `score` is of the evaluation, `resco_best` and
/// `resco_last_ten` are of training episodes, all of them relative to the baseline.
pub(super) fn training(data: &ReportData) -> String {
    let header = ["method", "point", "replicate", "outcome", "episodes", "score"]
        .into_iter()
        .chain(["resco_best", "resco_last_ten", "gridlocked", "weight"])
        .map(str::to_owned)
        .collect::<Vec<_>>();
    table(&header, data.trainings.iter().map(|t| training_row(data, t)))
}

fn training_row(data: &ReportData, t: &Training) -> Vec<String> {
    let outcome = match t.outcome {
        Some(Outcome::Ok) => "ok",
        Some(Outcome::Failed) if t.diverged => "diverged",
        Some(Outcome::Failed) => "failed",
        None => "missing",
    };
    let point = &data.points[t.point];
    vec![
        t.method.clone(),
        point.row.point.clone(),
        t.replicate.to_string(),
        outcome.to_owned(),
        t.episodes.to_string(),
        number(t.score),
        number(t.resco_best),
        number(t.resco_last_ten),
        t.score.map_or_else(String::new, |_| t.gridlocked.to_string()),
        point.weight.to_string(),
    ]
}

/// Returns the shortest text that reads back as the same number.
fn number(value: Option<f64>) -> String {
    value.map_or_else(String::new, |v| v.to_string())
}

fn table(header: &[String], rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let in_memory = "writing rows of equal length to memory cannot fail";
    writer.write_record(header).expect(in_memory);
    for row in rows {
        writer.write_record(&row).expect(in_memory);
    }
    String::from_utf8(writer.into_inner().expect(in_memory)).expect("strings are UTF-8")
}

//! The tables of a report: `scores.csv` with one row per task, `summary.csv` with one per method,
//! `episodes.csv` with one per episode, `training.csv` with one per task of a learner.
//!
//! A cell is empty where nothing was measured; it is never 0 for that reason. The last column of tables with
//! a column `point` is its `title`, where point MDPs are called otherwise than by their ids.

use super::data::ReportData;
use crate::analysis::Estimated;
use crate::analysis::{Episode, EpisodeSummary};
use crate::analysis::{LOSS, RETURN, TrainingSummary};
use crate::analysis::{MethodSummary, TaskScore};
use crate::store::record::{Outcome, RowKind};
use crate::traffic::report::level_of_service::{DELAY, letter};

/// Metrics that have a column of their own besides the objective.
const METRICS: [&str; 5] =
    ["waiting_s", "queue_veh", "throughput_veh", "unfinished_veh", "teleports"];

/// Metrics of an episode that have a column of their own besides the objective.
const OF_EPISODE: [&str; 6] =
    ["waiting_s", "unfinished_veh", "undeparted_veh", "vehicles_veh", RETURN, LOSS];

/// Returns `scores.csv`: one row per method, point MDP and replicate; without a successful record
/// the metrics are empty.
pub(super) fn scores(data: &ReportData) -> String {
    let identity = &data.manifest.identity;
    let objective = identity.objective.clone();
    let mut header: Vec<String> =
        ["method", "point", "importance", "replicate"].map(str::to_owned).to_vec();
    let divisor = if data.reference.is_baseline { "baseline" } else { "against" };
    header.extend([objective.clone(), format!("{divisor}_{objective}"), "score".to_owned()]);
    header.extend(METRICS.map(str::to_owned));
    header.push("level_of_service".to_owned());
    header.extend(identity.features.iter().map(|f| f.name.clone()));
    header.extend(["weight", "against"].map(str::to_owned));
    titled(data, header, data.tasks.iter().map(|row| (row.point, score_row(data, row))))
}

fn score_row(data: &ReportData, row: &TaskScore) -> Vec<String> {
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
        number(row.reference),
        number(row.score),
    ];
    cells.extend(METRICS.map(|name| number(row.metrics.get(name).copied())));
    let level = value.filter(|_| objective == DELAY).map(letter);
    cells.push(level.map_or_else(String::new, |l| l.to_string()));
    cells.extend(point.features.iter().map(f64::to_string));
    cells.push(data.points[row.point].weight.to_string());
    cells.push(data.reference.name.clone());
    cells
}

/// Summaries beside the overall performance, each with an interval; those of regimes follow.
const SUMMARIES: [&str; 3] = ["ratio_of_means", "median", "geometric_mean"];

/// Returns the names of the columns that summarise evaluation episodes.
fn of_episodes(data: &ReportData) -> Vec<String> {
    let objective = &data.manifest.identity.objective;
    let shares = data.shares.iter().map(|share| share.name.to_owned());
    let spread = [
        format!("episode_median_{objective}"),
        format!("episode_worst_{objective}"),
        "episode_median".to_owned(),
        "episode_worst".to_owned(),
    ];
    shares.chain(spread).collect()
}

fn episode_cells(e: &EpisodeSummary) -> impl Iterator<Item = String> {
    let spread = [e.median, e.worst, e.median_relative, e.worst_relative];
    e.shares.iter().copied().chain(spread).map(number)
}

/// Returns `summary.csv`: one row per method, best first.
pub(super) fn summary(data: &ReportData) -> String {
    let identity = &data.manifest.identity;
    let objective = identity.objective.clone();
    let header = ["method", "rank", "overall", "overall_low", "overall_high", &objective]
        .into_iter()
        .chain(["waiting_s", "queue_veh", "worst_point", "worst_score", "points", "failed"])
        .chain(["missing", "sampling", "budget", "family_size", "evaluation_seeds", "against"])
        .map(str::to_owned)
        .chain(
            SUMMARIES
                .into_iter()
                .chain(data.regimes.iter().map(|regime| regime.name))
                .flat_map(|s| [s.to_owned(), format!("{s}_low"), format!("{s}_high")]),
        )
        .chain(["points_at_f", "importance_at_f", "delay_share_at_f"].map(str::to_owned))
        .chain(of_episodes(data))
        .collect::<Vec<_>>();
    table(&header, data.methods.iter().map(|m| summary_row(data, m)))
}

fn summary_row(data: &ReportData, m: &MethodSummary) -> Vec<String> {
    let identity = &data.manifest.identity;
    let mut cells = vec![
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
        data.reference.name.clone(),
    ];
    let s = &m.summaries;
    for summary in [s.ratio_of_means, s.median, s.geometric_mean].iter().chain(&s.by_regime) {
        cells.extend(with_interval(*summary));
    }
    let at_f = data.overloaded;
    cells.push(at_f.map_or_else(String::new, |o| o.points.to_string()));
    cells.extend([at_f.map(|o| o.importance), at_f.map(|o| o.delay)].map(number));
    cells.extend(episode_cells(&m.episodes));
    cells
}

fn with_interval(summary: Option<Estimated>) -> [String; 3] {
    let interval = summary.and_then(|s| s.interval);
    [summary.map(|s| s.value), interval.map(|i| i.0), interval.map(|i| i.1)].map(number)
}

/// Returns `episodes.csv`: one row per episode of training and evaluation, in the order of the plan.
pub(super) fn episodes(data: &ReportData) -> String {
    let header = ["method", "point", "replicate", "kind", "episode", "seed"]
        .into_iter()
        .chain([data.manifest.identity.objective.as_str()])
        .chain(OF_EPISODE)
        .map(str::to_owned)
        .collect();
    titled(data, header, data.episodes.iter().map(|e| (e.point, episode_row(data, e))))
}

fn episode_row(data: &ReportData, e: &Episode) -> Vec<String> {
    let identity = &data.manifest.identity;
    let kind = match e.kind {
        RowKind::Evaluation => "evaluation",
        RowKind::Training => "training",
    };
    let mut cells = vec![
        identity.methods[e.method].clone(),
        data.points[e.point].row.point.clone(),
        e.replicate.to_string(),
        kind.to_owned(),
        e.episode.to_string(),
        e.seed.to_string(),
    ];
    let names = std::iter::once(identity.objective.as_str()).chain(OF_EPISODE);
    cells.extend(names.map(|name| number(e.metrics.get(name).copied())));
    cells
}

/// Returns `training.csv`: one row per training; `score` is of the evaluation, `resco_best` and
/// `resco_last_ten` are of training episodes, all of them relative to the reference.
pub(super) fn training(data: &ReportData) -> String {
    let header = ["method", "point", "replicate", "outcome", "episodes", "score"]
        .into_iter()
        .chain(["resco_best", "resco_last_ten"])
        .chain(events(data).map(|(_, event)| event))
        .chain(["weight", "against"])
        .map(str::to_owned)
        .chain(of_episodes(data))
        .collect::<Vec<_>>();
    titled(data, header, data.trainings.iter().map(|t| (t.point, training_row(data, t))))
}

fn training_row(data: &ReportData, t: &TrainingSummary) -> Vec<String> {
    let outcome = match t.outcome {
        Some(Outcome::Ok) => "ok",
        Some(Outcome::Failed) if t.diverged => "diverged",
        Some(Outcome::Failed) => "failed",
        None => "missing",
    };
    let point = &data.points[t.point];
    let mut cells = vec![
        t.method.clone(),
        point.row.point.clone(),
        t.replicate.to_string(),
        outcome.to_owned(),
        t.episodes.to_string(),
        number(t.score),
        number(t.resco_best),
        number(t.resco_last_ten),
    ];
    let has = |i: usize| t.has_share(i).map_or_else(String::new, |has| has.to_string());
    cells.extend(events(data).map(|(i, _)| has(i)));
    cells.extend([point.weight.to_string(), data.reference.name.clone()]);
    cells.extend(episode_cells(&t.evaluations));
    cells
}

/// Returns what happens in an evaluation episode or does not, with its position among the shares.
pub(super) fn events(data: &ReportData) -> impl Iterator<Item = (usize, &'static str)> {
    data.shares.iter().enumerate().filter_map(|(i, share)| Some((i, share.event?)))
}

/// Returns the shortest text that reads back as the same number.
fn number(value: Option<f64>) -> String {
    value.map_or_else(String::new, |v| v.to_string())
}

/// Returns a table whose rows are each of a point MDP, with what that is called where it is not its id.
pub(super) fn titled(
    data: &ReportData,
    mut header: Vec<String>,
    rows: impl Iterator<Item = (usize, Vec<String>)>,
) -> String {
    let titles = data.titles();
    header.extend(titles.as_ref().map(|_| "title".to_owned()));
    let row = |(point, mut cells): (usize, Vec<String>)| {
        cells.extend(titles.as_ref().map(|titles| titles[point].clone()));
        cells
    };
    table(&header, rows.map(row))
}

pub(super) fn table(header: &[String], rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let in_memory = "writing rows of equal length to memory cannot fail";
    writer.write_record(header).expect(in_memory);
    for row in rows {
        writer.write_record(&row).expect(in_memory);
    }
    String::from_utf8(writer.into_inner().expect(in_memory)).expect("strings are UTF-8")
}

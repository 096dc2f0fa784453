//! The tables of a report: `scores.csv` with one row per task, `episodes.csv` with one per episode, `training.csv` with one per task of a learner.
//!
//! A cell is empty where nothing was measured; it is never 0 for that reason. The last column of tables with
//! a column `point` is its `title`, where point MDPs are called otherwise than by their ids.

use super::sections::Table;
use super::whole::Report;
use crate::analysis::{EpisodeSummary, TaskScore, TrainingSummary};
use crate::store::record::{Metrics, Outcome, Row};
use basics::plain::cell;

/// Name of the column of the score.
const SCORE: &str = "score";

/// The same where the objective is called so.
const RELATIVE_SCORE: &str = "relative_score";

/// Returns the names of the metrics that have a column in a table besides the objective.
fn names(data: &Report, table: Table) -> Vec<String> {
    data.sections.metrics(table, data).into_iter().map(|metric| metric.name).collect()
}

/// Returns the cells of metrics.
fn cells_of<'a>(names: &'a [String], metrics: &'a Metrics) -> impl Iterator<Item = String> + 'a {
    names.iter().map(|name| number(metrics.get(name).copied()))
}

/// Returns the names of the columns of the score: the objective, what that is divided by, and the score, if it is any
/// else; under a name of its own where the objective has its.
fn score_columns(data: &Report) -> Vec<String> {
    let objective = &data.manifest.identity.objective;
    let mut columns = vec![objective.clone()];
    if !data.reference.is_none() {
        let divisor = if data.reference.is_baseline { "baseline" } else { "against" };
        columns.push(format!("{divisor}_{objective}"));
    }
    columns.extend(score_column(data).map(str::to_owned));
    columns
}

/// Returns the name of the column of the score, if it is anything else than the objective.
fn score_column(data: &Report) -> Option<&'static str> {
    match (data.manifest.identity.objective == SCORE, data.reference.is_none()) {
        (true, true) => None,
        (true, false) => Some(RELATIVE_SCORE),
        (false, _) => Some(SCORE),
    }
}

/// Returns `scores.csv`: one row per method, point MDP and replicate; without a successful record
/// the metrics are empty.
pub(super) fn scores(data: &Report) -> String {
    let identity = &data.manifest.identity;
    let mut header: Vec<String> =
        ["method", "point", "importance", "replicate"].map(str::to_owned).to_vec();
    header.extend(score_columns(data));
    let names = names(data, Table::Scores);
    header.extend(names.clone());
    header.extend(data.sections.score_columns().iter().map(|name| (*name).to_owned()));
    header.extend(identity.features.iter().map(|f| f.name.clone()));
    header.extend(["weight", "against"].map(str::to_owned));
    let titled = Titled(data.titles());
    let rows = data.tasks.iter().map(|row| titled.row(row.point, score_row(data, row, &names)));
    table(&titled.header(header), rows)
}

fn score_row(data: &Report, row: &TaskScore, names: &[String]) -> Vec<String> {
    let point = &data.points[row.point].row;
    let objective = data.manifest.identity.objective.as_str();
    let value = match row.outcome {
        Some(Outcome::Ok) => row.metrics.get(objective).copied(),
        _ => None,
    };
    let mut cells = vec![
        data.manifest.identity.methods[row.method].clone(),
        point.point.clone(),
        point.importance.to_string(),
        row.replicate.to_string(),
        number(value),
    ];
    if !data.reference.is_none() {
        cells.push(number(row.reference));
    }
    if score_column(data).is_some() {
        cells.push(number(row.score));
    }
    cells.extend(cells_of(names, &row.metrics));
    cells.extend(data.sections.score_cells(data, row, value));
    cells.extend(point.features.iter().map(f64::to_string));
    cells.extend([data.points[row.point].weight.to_string(), data.reference.name.clone()]);
    cells
}

/// Returns the names of the columns that summarise evaluation episodes.
fn of_episodes(data: &Report) -> Vec<String> {
    let objective = &data.manifest.identity.objective;
    let shares = data.shares.iter().map(|share| share.name.to_owned());
    let spread = [
        format!("episode_median_{objective}"),
        format!("episode_worst_{objective}"),
        "episode_median".to_owned(),
        "episode_worst".to_owned(),
    ];
    let relative = if data.reference.is_none() { 2 } else { 4 };
    shares.chain(spread.into_iter().take(relative)).collect()
}

fn episode_cells(data: &Report, e: &EpisodeSummary) -> Vec<String> {
    let spread = [e.median, e.worst, e.median_relative, e.worst_relative];
    let relative = if data.reference.is_none() { 2 } else { 4 };
    e.shares.iter().copied().chain(spread.into_iter().take(relative)).map(number).collect()
}

/// Returns `episodes.csv`: one row per episode of training and evaluation, in the order of the plan.
pub(super) fn episodes(data: &Report) -> String {
    let names = names(data, Table::Episodes);
    let header = ["method", "point", "replicate", "kind", "episode", "seed"]
        .into_iter()
        .chain([data.manifest.identity.objective.as_str()])
        .map(str::to_owned)
        .chain(names.clone())
        .collect::<Vec<_>>();
    let titled = Titled(data.titles());
    let records = data.tasks.iter().zip(data.results.rows());
    let rows = records.flat_map(|(task, (_, record))| {
        record.into_iter().flat_map(move |record| record.rows.iter().map(move |row| (task, row)))
    });
    let row = |(task, row): (&TaskScore, &Row)| {
        titled.row(task.point, episode_row(data, (task, row), &names))
    };
    table(&titled.header(header), rows.map(row))
}

fn episode_row(data: &Report, (task, e): (&TaskScore, &Row), names: &[String]) -> Vec<String> {
    let identity = &data.manifest.identity;
    let mut cells = vec![
        identity.methods[task.method].clone(),
        data.points[task.point].row.point.clone(),
        task.replicate.to_string(),
        e.kind.name().to_owned(),
        e.episode.to_string(),
        e.seed.to_string(),
        number(e.metrics.get(&identity.objective).copied()),
    ];
    cells.extend(cells_of(names, &e.metrics));
    cells
}

/// Returns `training.csv`: one row per training; `score` is of the evaluation, the columns of the best and the
/// last episodes are of training, all of them relative to the reference.
pub(super) fn training(data: &Report) -> String {
    let header = ["method", "point", "replicate", "outcome", "episodes", "score"]
        .into_iter()
        .chain(["policy_row", "last_policy", "restarts", "dead"])
        .chain(data.sections.training_columns()[0])
        .chain(events(data).map(|(_, event)| event))
        .chain(["weight", "against"])
        .map(str::to_owned)
        .chain(of_episodes(data))
        .collect::<Vec<_>>();
    let titled = Titled(data.titles());
    let rows = data.trainings.iter().map(|t| titled.row(t.point, training_row(data, t)));
    table(&titled.header(header), rows)
}

fn training_row(data: &Report, t: &TrainingSummary) -> Vec<String> {
    let outcome = match t.outcome {
        Some(Outcome::Ok) => "ok",
        Some(Outcome::Failed) if t.diverged => "diverged",
        Some(Outcome::Failed) => "failed",
        None => "missing",
    };
    let point = &data.points[t.point];
    let whole = |n: Option<u32>| n.map_or_else(String::new, |n| n.to_string());
    let mut cells = vec![
        t.method.clone(),
        point.row.point.clone(),
        t.replicate.to_string(),
        outcome.to_owned(),
        t.episodes.to_string(),
        number(t.score),
        whole(t.policy_row),
        number(t.last_policy),
        whole(t.restarts),
        t.is_dead.map_or_else(String::new, |dead| dead.to_string()),
        number(t.best_episode),
        number(t.last_episodes),
    ];
    let has = |i: usize| t.has_share(i).map_or_else(String::new, |has| has.to_string());
    cells.extend(events(data).map(|(i, _)| has(i)));
    cells.extend([point.weight.to_string(), data.reference.name.clone()]);
    cells.extend(episode_cells(data, &t.evaluations));
    cells
}

/// Returns what happens in an evaluation episode or does not, with its position among the shares.
pub(super) fn events(data: &Report) -> impl Iterator<Item = (usize, &'static str)> {
    data.shares.iter().enumerate().filter_map(|(i, share)| Some((i, share.event?)))
}

/// Returns the shortest text that reads back as the same number.
pub fn number(value: Option<f64>) -> String {
    value.map_or_else(String::new, |v| v.to_string())
}

/// A table whose rows are each of a point MDP, with what that is called where it is not its id.
///
/// It is made of what point MDPs are called, by their positions; of nothing when all are called by their ids.
#[derive(Clone, Copy)]
pub struct Titled<'a>(pub Option<&'a [String]>);

impl Titled<'_> {
    /// Returns the header, with the column of titles if there is one.
    pub fn header(self, mut header: Vec<String>) -> Vec<String> {
        header.extend(self.0.map(|_| "title".to_owned()));
        header
    }

    /// Returns a row of the point MDP at a position.
    pub fn row(self, point: usize, mut cells: Vec<String>) -> Vec<String> {
        cells.extend(self.0.map(|titles| titles[point].clone()));
        cells
    }
}

/// Returns a table; every row has as many cells as the header.
pub fn table<H: AsRef<str>>(header: &[H], rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let in_memory = "writing rows of equal length to memory cannot fail";
    let header = header.iter().map(|name| cell(name.as_ref()).into_owned());
    writer.write_record(header).expect(in_memory);
    for row in rows {
        writer.write_record(row.iter().map(|text| cell(text).into_owned())).expect(in_memory);
    }
    String::from_utf8(writer.into_inner().expect(in_memory)).expect("strings are UTF-8")
}

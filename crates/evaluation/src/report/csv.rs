//! The tables of a report: `scores.csv` with one row per task, `episodes.csv` with one per episode, `training.csv` with one per task of a learner.
//!
//! A cell is empty where nothing was measured; it is never 0 for that reason. The last column of tables with
//! a column `point` is its `title`, where point MDPs are called otherwise than by their ids.

use super::sections;
use super::table::{Cell, Columns};
use super::whole::Report;
use crate::analysis::{EpisodeSummary, TaskScore, TrainingSummary};
use crate::store::record::{Metrics, Outcome, Row};
use basics::plain::cell;

/// Name of the column of the score.
const SCORE: &str = "score";

/// The same where the objective is called so.
const RELATIVE_SCORE: &str = "relative_score";

fn names(data: &Report, table: sections::Table) -> Vec<String> {
    data.sections.metrics(table, data).into_iter().map(|metric| metric.name).collect()
}

fn cells_of<'a>(names: &'a [String], metrics: &'a Metrics) -> impl Iterator<Item = String> + 'a {
    names.iter().map(|name| number(metrics.get(name).copied()))
}

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
    let objective = identity.objective.as_str();
    let point = |t: &&TaskScore| &data.points[t.point].row;
    let value = |t: &&TaskScore| {
        t.metrics.get(objective).copied().filter(|_| t.outcome == Some(Outcome::Ok))
    };
    let mut columns = Columns::new()
        .text("method", "", |t: &&TaskScore| identity.methods[t.method].clone())
        .text("point", "", move |t| point(t).point.clone())
        .file("importance", move |t| Cell::exact(point(t).importance))
        .file("replicate", |t| Cell::count(t.replicate as usize))
        .file(objective, move |t| Cell::exact(value(t)));
    if !data.reference.is_none() {
        let divisor = if data.reference.is_baseline { "baseline" } else { "against" };
        columns = columns.file(format!("{divisor}_{objective}"), |t| Cell::exact(t.reference));
    }
    if let Some(name) = score_column(data) {
        columns = columns.file(name, |t| Cell::exact(t.score));
    }
    for name in names(data, sections::Table::Scores) {
        columns = columns.file(name.clone(), move |t| Cell::exact(t.metrics.get(&name).copied()));
    }
    for (i, name) in data.sections.score_columns().iter().enumerate() {
        let cell =
            move |t: &&TaskScore| data.sections.score_cells(data, t, value(t)).swap_remove(i);
        columns = columns.text(name, "", cell);
    }
    for (i, feature) in identity.features.iter().enumerate() {
        columns = columns.file(&*feature.name, move |t| Cell::exact(point(t).features[i]));
    }
    let columns = columns.file("weight", |t| Cell::exact(data.points[t.point].weight)).text(
        "against",
        "",
        |_| data.reference.name.clone(),
    );
    titled(columns, data, |t| t.point).table(&data.tasks).csv()
}

/// Adds what point MDPs are called, where that is not their ids.
fn titled<'a, R>(
    columns: Columns<'a, R>,
    data: &'a Report,
    point: impl Fn(&R) -> usize + 'a,
) -> Columns<'a, R> {
    match data.titles() {
        Some(titles) => columns.text("title", "", move |row| titles[point(row)].clone()),
        None => columns,
    }
}

/// Returns `episodes.csv`: one row per episode of training and evaluation, in the order of the plan.
pub(super) fn episodes(data: &Report) -> String {
    let names = names(data, sections::Table::Episodes);
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
    let outcome = |t: &&TrainingSummary| match t.outcome {
        Some(Outcome::Ok) => "ok",
        Some(Outcome::Failed) if t.diverged => "diverged",
        Some(Outcome::Failed) => "failed",
        None => "missing",
    };
    let whole = |n: Option<u32>| n.map_or_else(Cell::unknown, |n| Cell::count(n as usize));
    let [best, last] = data.sections.training_columns()[0];
    let mut columns = Columns::new()
        .text("method", "", |t: &&TrainingSummary| t.method.clone())
        .text("point", "", |t| data.points[t.point].row.point.clone())
        .file("replicate", |t| Cell::count(t.replicate as usize))
        .text("outcome", "", move |t| outcome(t).to_owned())
        .file("episodes", |t| Cell::count(t.episodes))
        .file("score", |t| Cell::exact(t.score))
        .file("policy_row", move |t| whole(t.policy_row))
        .file("last_policy", |t| Cell::exact(t.last_policy))
        .file("restarts", move |t| whole(t.restarts))
        .file("dead", |t| Cell::flag(t.is_dead))
        .file(best, |t| Cell::exact(t.best_episode))
        .file(last, |t| Cell::exact(t.last_episodes));
    for (i, event) in events(data) {
        columns = columns.file(event, move |t| Cell::flag(t.has_share(i)));
    }
    columns = columns
        .file("weight", |t: &&TrainingSummary| Cell::exact(data.points[t.point].weight))
        .text("against", "", |_| data.reference.name.clone());
    let columns = of_episodes(columns, data, |t| &t.evaluations);
    titled(columns, data, |t| t.point).table(&data.trainings).csv()
}

/// Adds the columns that summarise evaluation episodes.
pub(super) fn of_episodes<'a, R: 'a>(
    mut columns: Columns<'a, R>,
    data: &'a Report,
    of: impl for<'r> Fn(&'r R) -> &'r EpisodeSummary + Copy + 'a,
) -> Columns<'a, R> {
    for (i, share) in data.shares.iter().enumerate() {
        columns = columns.file(share.name, move |row| Cell::exact(of(row).shares[i]));
    }
    let objective = &data.manifest.identity.objective;
    columns = columns
        .file(format!("episode_median_{objective}"), move |row| Cell::exact(of(row).median))
        .file(format!("episode_worst_{objective}"), move |row| Cell::exact(of(row).worst));
    match data.reference.is_none() {
        true => columns,
        false => columns
            .file("episode_median", move |row| Cell::exact(of(row).median_relative))
            .file("episode_worst", move |row| Cell::exact(of(row).worst_relative)),
    }
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

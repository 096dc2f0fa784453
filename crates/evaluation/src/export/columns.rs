//! The columns of a table of episodes, and what stands in them.

use std::collections::{BTreeSet, HashMap, HashSet};

use crate::sample::SamplePlan;
use crate::store::manifest::{Identity, PointRow};
use crate::store::record::{Outcome, Record, Row};

/// What is before the features and metrics of a task.
const TASK: [(&str, Kind, Part<'static>); 13] = [
    ("task", Kind::Whole, Part::Task),
    ("method", Kind::Text, Part::Method),
    ("point", Kind::Text, Part::Point),
    ("title", Kind::Text, Part::Title),
    ("replicate", Kind::Whole, Part::Replicate),
    ("kind", Kind::Text, Part::Kind),
    ("episode", Kind::Whole, Part::Episode),
    ("seed", Kind::Whole, Part::Seed),
    ("outcome", Kind::Text, Part::Outcome),
    ("reason", Kind::Text, Part::Reason),
    ("importance", Kind::Number, Part::Importance),
    ("weight", Kind::Number, Part::Weight),
    ("instances", Kind::Whole, Part::Instances),
];

/// What a column has in its cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Whole numbers of 0 or more.
    Whole,
    /// Numbers.
    Number,
    /// Text.
    Text,
}

/// What of an episode or its task a column is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part<'a> {
    Task,
    Method,
    Point,
    Title,
    Replicate,
    Kind,
    Episode,
    Seed,
    Outcome,
    Reason,
    Importance,
    Weight,
    Instances,
    Feature(usize),
    Metric(&'a str),
}

/// A column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Column<'a> {
    /// Its name; a metric that is called as something before it has `metric_` before that.
    pub(super) name: String,
    /// What is in it.
    pub(super) kind: Kind,
    part: Part<'a>,
}

/// The columns of a table.
#[derive(Debug)]
pub(super) struct Columns<'a> {
    /// All of them, in order.
    pub(super) all: Vec<Column<'a>>,
    /// Point MDPs with their weights, by their ids; without one outside the sample.
    points: HashMap<&'a str, (&'a PointRow, Option<f64>)>,
}

/// What a row of the table is of: an episode of a record, or a record that has none.
pub(super) type Line<'a> = (&'a Record, Option<&'a Row>);

/// What stands in a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cell<'a> {
    /// Nothing.
    None,
    /// A whole number.
    Whole(u64),
    /// A number.
    Number(f64),
    /// A text.
    Text(&'a str),
}

impl<'a> Columns<'a> {
    /// Returns the columns of a run.
    ///
    /// # Arguments
    ///
    /// * `sample` — that of the report; a point MDP outside has no weight.
    /// * `metrics` — the names of those that some episode has.
    pub(super) fn of(
        identity: &'a Identity,
        sample: &SamplePlan,
        metrics: &BTreeSet<&'a String>,
    ) -> Self {
        let mut all: Vec<Column<'_>> = TASK
            .iter()
            .map(|(name, kind, part)| Column { name: (*name).to_owned(), kind: *kind, part: *part })
            .collect();
        let mut taken: HashSet<String> = all.iter().map(|column| column.name.clone()).collect();
        let features = identity.features.iter().map(|feature| feature.name.as_str());
        let features = features.enumerate().map(|(i, name)| ("feature", name, Part::Feature(i)));
        let own = metrics.iter().map(|name| ("metric", name.as_str(), Part::Metric(name)));
        for (prefix, name, part) in features.chain(own) {
            let mut name = name.to_owned();
            while !taken.insert(name.clone()) {
                name = format!("{prefix}_{name}");
            }
            all.push(Column { name, kind: Kind::Number, part });
        }
        let draws = sample.draws.iter();
        let weights: HashMap<&str, f64> = draws.map(|d| (d.point.as_str(), d.weight)).collect();
        let point = |row: &'a PointRow| {
            let id = row.point.as_str();
            (id, (row, weights.get(id).copied()))
        };
        Self { all, points: identity.points.iter().map(point).collect() }
    }

    /// Returns what stands in a column of a row, whose task is one of the run.
    pub(super) fn cell(&self, (record, row): Line<'a>, column: &Column<'_>) -> Cell<'a> {
        let task = &record.summary;
        let point = || self.points[task.point.as_str()];
        let number = |value: f64| if value.is_nan() { Cell::None } else { Cell::Number(value) };
        let episode = |of: fn(&Row) -> Cell<'static>| row.map_or(Cell::None, of);
        match column.part {
            Part::Task => Cell::Whole(task.task as u64),
            Part::Method => Cell::Text(&task.method),
            Part::Point => Cell::Text(&task.point),
            Part::Title => Cell::Text(point().0.name()),
            Part::Replicate => Cell::Whole(task.replicate.into()),
            Part::Kind => episode(|row| Cell::Text(row.kind.name())),
            Part::Episode => episode(|row| Cell::Whole(row.episode.into())),
            Part::Seed => episode(|row| Cell::Whole(row.seed)),
            Part::Outcome => Cell::Text(match task.outcome {
                Outcome::Ok => "ok",
                Outcome::Failed => "failed",
            }),
            Part::Reason => task.reason.as_deref().map_or(Cell::None, Cell::Text),
            Part::Importance => number(point().0.importance),
            Part::Weight => point().1.map_or(Cell::None, number),
            Part::Instances => Cell::Whole(point().0.instances.into()),
            Part::Feature(at) => point().0.features.get(at).map_or(Cell::None, |v| number(*v)),
            Part::Metric(name) => {
                row.and_then(|row| row.metrics.get(name)).map_or(Cell::None, |v| number(*v))
            }
        }
    }
}

impl Column<'_> {
    /// Whether it is what was measured of an episode.
    pub(super) fn is_metric(&self) -> bool {
        matches!(self.part, Part::Metric(_))
    }
}

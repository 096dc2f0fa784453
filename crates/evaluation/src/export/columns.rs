//! The columns of a table of episodes, and what stands in them.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::sync::Arc;

use crate::store::manifest::Identity;
use crate::store::record::{Outcome, Record, Row, RowKind};

/// What is before the features and metrics of a task.
const TASK: [(&str, Kind, Part); 13] = [
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
pub enum Kind {
    /// Whole numbers of 0 or more.
    Whole,
    /// Numbers.
    Number,
    /// Text.
    Text,
}

/// What of an episode or its task a column is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
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
    Metric(usize),
}

/// A column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Its name; a metric that is called as something before it has `metric_` before that.
    pub name: String,
    /// What is in it.
    pub kind: Kind,
    part: Part,
}

/// What is known of a point MDP.
#[derive(Debug)]
struct Point {
    id: Arc<str>,
    title: Arc<str>,
    importance: f64,
    weight: f64,
    instances: u32,
    features: Vec<f64>,
}

/// The columns of a table.
#[derive(Debug)]
pub struct Columns {
    /// All of them, in order.
    pub all: Vec<Column>,
    metrics: Vec<String>,
    points: Vec<Arc<Point>>,
    positions: HashMap<String, usize>,
    methods: Vec<Arc<str>>,
}

/// The cells of a row.
#[derive(Debug)]
pub struct Cells {
    task: u64,
    method: Arc<str>,
    point: Arc<Point>,
    replicate: u32,
    outcome: Outcome,
    reason: Option<Box<str>>,
    episode: Option<(RowKind, u32, u64)>,
    /// In the order of the names of metrics; not a number where the episode has none.
    metrics: Box<[f64]>,
}

/// What stands in a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cell<'a> {
    /// Nothing.
    None,
    /// A whole number.
    Whole(u64),
    /// A number.
    Number(f64),
    /// A text.
    Text(&'a str),
}

impl Columns {
    /// Returns the columns of a run.
    ///
    /// # Arguments
    ///
    /// * `metrics` — the names of those that some episode has.
    pub fn of(identity: &Identity, metrics: &BTreeSet<&String>) -> Self {
        let mut all: Vec<Column> = TASK
            .iter()
            .map(|(name, kind, part)| Column { name: (*name).to_owned(), kind: *kind, part: *part })
            .collect();
        let mut taken: HashSet<String> = all.iter().map(|column| column.name.clone()).collect();
        let features = identity.features.iter().map(|feature| feature.name.as_str());
        let features = features.enumerate().map(|(i, name)| ("feature", name, Part::Feature(i)));
        let own =
            metrics.iter().enumerate().map(|(i, name)| ("metric", name.as_str(), Part::Metric(i)));
        for (prefix, name, part) in features.chain(own) {
            let mut name = name.to_owned();
            while !taken.insert(name.clone()) {
                name = format!("{prefix}_{name}");
            }
            all.push(Column { name, kind: Kind::Number, part });
        }
        let draws = identity.sample.draws.iter();
        let weights: HashMap<&str, f64> = draws.map(|d| (d.point.as_str(), d.weight)).collect();
        let point = |row: &crate::store::manifest::PointRow| {
            Arc::new(Point {
                id: row.point.as_str().into(),
                title: row.name().into(),
                importance: row.importance,
                weight: weights.get(row.point.as_str()).copied().unwrap_or(0.0),
                instances: row.instances,
                features: row.features.clone(),
            })
        };
        let ids = identity.points.iter().enumerate();
        Self {
            all,
            metrics: metrics.iter().map(|name| (*name).clone()).collect(),
            points: identity.points.iter().map(point).collect(),
            positions: ids.map(|(i, row)| (row.point.clone(), i)).collect(),
            methods: identity.methods.iter().map(|m| m.as_str().into()).collect(),
        }
    }

    /// Returns the rows of a record, whose task is one of the run.
    pub fn cells(&self, record: &Record) -> Vec<Cells> {
        let summary = &record.summary;
        let point = self.positions.get(&summary.point).map(|at| &self.points[*at]);
        let method = self.methods.iter().find(|name| ***name == *summary.method);
        let (Some(point), Some(method)) = (point, method) else { return Vec::new() };
        let cells = |row: Option<&Row>| Cells {
            task: summary.task as u64,
            method: method.clone(),
            point: point.clone(),
            replicate: summary.replicate,
            outcome: summary.outcome,
            reason: summary.reason.as_deref().map(Box::from),
            episode: row.map(|row| (row.kind, row.episode, row.seed)),
            metrics: (self.metrics.iter())
                .map(|name| row.and_then(|row| row.metrics.get(name).copied()).unwrap_or(f64::NAN))
                .collect(),
        };
        match record.rows.is_empty() {
            true => vec![cells(None)],
            false => record.rows.iter().map(|row| cells(Some(row))).collect(),
        }
    }
}

impl Cells {
    /// Returns what stands in the cell of a column.
    pub fn cell(&self, column: &Column) -> Cell<'_> {
        let number = |value: f64| if value.is_nan() { Cell::None } else { Cell::Number(value) };
        let episode =
            |of: fn((RowKind, u32, u64)) -> Cell<'static>| self.episode.map_or(Cell::None, of);
        match column.part {
            Part::Task => Cell::Whole(self.task),
            Part::Method => Cell::Text(&self.method),
            Part::Point => Cell::Text(&self.point.id),
            Part::Title => Cell::Text(&self.point.title),
            Part::Replicate => Cell::Whole(self.replicate.into()),
            Part::Kind => episode(|(kind, ..)| Cell::Text(kind.name())),
            Part::Episode => episode(|(_, number, _)| Cell::Whole(number.into())),
            Part::Seed => episode(|(.., seed)| Cell::Whole(seed)),
            Part::Outcome => Cell::Text(match self.outcome {
                Outcome::Ok => "ok",
                Outcome::Failed => "failed",
            }),
            Part::Reason => self.reason.as_deref().map_or(Cell::None, Cell::Text),
            Part::Importance => number(self.point.importance),
            Part::Weight => number(self.point.weight),
            Part::Instances => Cell::Whole(self.point.instances.into()),
            Part::Feature(at) => self.point.features.get(at).map_or(Cell::None, |v| number(*v)),
            Part::Metric(at) => number(self.metrics[at]),
        }
    }
}

impl Column {
    /// Whether it is what was measured of an episode.
    pub(super) fn is_metric(&self) -> bool {
        matches!(self.part, Part::Metric(_))
    }
}

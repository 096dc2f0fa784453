//! What reports show of traffic beside the analysis of its records: where intersections are and what they are called,
//! and what their signals ran.

use std::collections::{BTreeMap, HashMap};

use evaluation::analysis::Analysis;
use evaluation::report::titles::differ;
use evaluation::stats::Direction;
use evaluation::store::Layout;
use evaluation::store::error::StoreError;
use evaluation::store::manifest::{PointRow, Task};
use evaluation::store::record::{Outcome, Summary};
use evaluation::store::results::Results;
use signals::control::fixed_time::SETTING;
use signals::movement_results::MovementResult;
use signals::places::{DrawnIntersection, MappedIntersection, Places};
use signals::program::{ProgramKind, SignalProgram};
use signals::street_results::ByStreet;
use signals::trial::STANDING;

/// Intersections of a point MDP that are named; more are counted.
const NAMED: usize = 3;

/// What reports show of traffic beside the analysis of its records.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Shown {
    /// Where the intersections are.
    pub(super) places: Places,
    /// Positions of the intersections of every point MDP.
    of_point: HashMap<String, Vec<usize>>,
    /// For how many intersections each point MDP stands.
    stood_for: HashMap<String, usize>,
    /// What every finished task ran, in the order of the plan.
    pub(super) plans: Vec<TaskPlan>,
    /// Results by movement of every finished task that has them, in the order of the plan.
    pub(super) movements: Vec<OfTask<Vec<MovementResult>>>,
    /// Results by street of every finished task that has them, in the order of the plan.
    pub(super) streets: Vec<OfTask<ByStreet>>,
    /// Which vehicle stood for long, where one did.
    pub(super) standing: Vec<OfTask<String>>,
}

/// What a finished task has: the positions of its method and point MDP in the manifest, its training, and results.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OfTask<T> {
    pub(super) method: usize,
    pub(super) point: usize,
    pub(super) replicate: u32,
    pub(super) results: T,
}

/// Returns the parts of the results of every finished task that has such, in the order of the plan. The checksum of a record
/// vouches for their form.
fn parts<T>(results: &Results, read: fn(&Summary) -> Option<T>) -> Vec<OfTask<T>> {
    let of_task = |(method, point, task, summary): (usize, usize, &Task, &Summary)| {
        let replicate = task.replicate;
        read(summary).map(|results| OfTask { method, point, replicate, results })
    };
    finished(results).filter_map(of_task).collect()
}

/// Returns every task that ended well, in the order of the plan: the positions of its method and point MDP in the manifest,
/// the task, and the summary of its record.
fn finished(results: &Results) -> impl Iterator<Item = (usize, usize, &Task, &Summary)> {
    let identity = &results.manifest.identity;
    let points = identity.points.iter().enumerate();
    let points: HashMap<&str, usize> = points.map(|(i, p)| (p.point.as_str(), i)).collect();
    results.rows().filter_map(move |(task, record)| {
        let method = identity.methods.iter().position(|m| *m == *task.method)?;
        let point = *points.get(&*task.point)?;
        let summary = &record?.summary;
        (summary.outcome == Outcome::Ok).then_some((method, point, task, summary))
    })
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TaskPlan {
    /// Position of the method in the manifest.
    pub method: usize,
    /// Position of the point MDP among the chosen ones.
    pub point: usize,
    /// Which of several independent trainings.
    pub replicate: u32,
    /// Mean objective of the evaluation episodes.
    pub objective: Option<f64>,
    /// One program per signal; empty for a method that decides while it runs.
    pub programs: Vec<SignalProgram>,
    /// Settings that tuning has chosen, in words, each after a semicolon.
    pub chosen: String,
    /// Signals of a task in which some ran in two rings: with their phases, or with the fixed cycle of the others.
    pub rings: Vec<SignalProgram>,
}

impl TaskPlan {
    /// Whether its objective is better than that of another training; a training without one is the worst.
    pub(crate) fn is_better_than(&self, other: &Self, direction: Direction) -> bool {
        match (self.objective, other.objective) {
            (Some(own), Some(other)) => direction.is_worse(other, own),
            (own, other) => own.is_some() && other.is_none(),
        }
    }
}

/// Returns what every finished task ran, in the order of the plan.
fn plans(results: &Results) -> Vec<TaskPlan> {
    let identity = &results.manifest.identity;
    let plan = |(method, point, task, record): (usize, usize, &Task, &Summary)| {
        // The checksum of the record vouches for their form.
        let recorded: Vec<SignalProgram> = record.programs.read().ok().unwrap_or_default();
        // Within a common cycle some signals may run rings, and others a fixed cycle.
        let (rings, programs) = match recorded.iter().any(|p| p.kind == ProgramKind::DualRing) {
            true => (recorded, Vec::new()),
            false => (Vec::new(), recorded),
        };
        let chosen = |(name, value): (&String, &String)| {
            Some(format!("; tuned: {} = {value}", name.strip_prefix(SETTING)?))
        };
        TaskPlan {
            method,
            point,
            replicate: task.replicate,
            objective: record.metrics.get(&identity.objective).copied(),
            programs,
            chosen: record.details.iter().filter_map(chosen).collect(),
            rings,
        }
    };
    finished(results).map(plan).collect()
}

/// An analysis with what is shown beside it.
#[derive(Clone, Copy)]
pub(super) struct Seen<'a> {
    /// What records say.
    pub(super) data: &'a Analysis,
    /// What is shown beside it.
    pub(super) shown: &'a Shown,
}

impl Shown {
    pub(super) fn read(layout: &Layout, results: &Results) -> Result<Self, StoreError> {
        let places = Places::read(layout)?;
        let of_points = || Places::of_points(&results.manifest.identity.points);
        let places = places.unwrap_or_else(of_points);
        let mut of_point: HashMap<String, Vec<usize>> = HashMap::new();
        let mut stood_for = HashMap::new();
        for (i, place) in places.intersections.iter().enumerate() {
            of_point.entry(place.point.clone()).or_default().push(i);
            if let Some(stands) = &place.stands {
                *stood_for.entry(stands.clone()).or_default() += 1;
            }
        }
        Ok(Self {
            places,
            of_point,
            stood_for,
            plans: plans(results),
            movements: parts(results, |summary| {
                summary.parts.read().ok().filter(|all: &Vec<MovementResult>| !all.is_empty())
            }),
            standing: parts(results, |summary| summary.details.get(STANDING).cloned()),
            streets: parts(results, |summary| {
                summary.parts.read().ok().filter(|all: &ByStreet| !all.streets.is_empty())
            }),
        })
    }

    /// Returns the names of movements on a point MDP, by signal and link index; empty where they are not known.
    pub(super) fn link_names(&self, point: usize) -> BTreeMap<String, BTreeMap<usize, String>> {
        let mut names: BTreeMap<String, BTreeMap<usize, String>> = BTreeMap::new();
        let of_point = self.movements.iter().find(|task| task.point == point);
        for m in of_point.iter().flat_map(|task| &task.results) {
            let of_signal = names.entry(m.signal.clone()).or_default();
            of_signal.extend(m.links.iter().map(|link| (*link, m.movement.clone())));
        }
        names
    }

    /// Whether any intersection has a place.
    pub(super) fn is_placed(&self) -> bool {
        !self.places.intersections.is_empty()
    }

    fn places_of<'a>(&'a self, point: &'a str) -> impl Iterator<Item = &'a MappedIntersection> {
        let own = self.of_point.get(point).into_iter().flatten();
        own.map(|i| &self.places.intersections[*i])
    }

    /// Returns the training of a method on a point MDP that is shown where only one can be: the best of several, and how
    /// many there are.
    pub(super) fn training(
        &self,
        data: &Analysis,
        point: usize,
        method: usize,
    ) -> Option<(&TaskPlan, usize)> {
        let direction = data.direction();
        let own = || self.plans.iter().filter(|task| (task.point, task.method) == (point, method));
        let best = own()
            .reduce(|best, task| if task.is_better_than(best, direction) { task } else { best })?;
        Some((best, own().count()))
    }

    /// Returns how a point MDP that is one intersection is drawn, with its period; `None` where it stands for others by
    /// its features alone.
    pub(super) fn drawing(&self, point: &str) -> Option<&DrawnIntersection> {
        self.places.drawings.iter().find(|drawn| drawn.point == point)
    }

    /// Returns for how many intersections a point MDP stands.
    pub(super) fn stood_for(&self, point: &str) -> usize {
        self.stood_for.get(point).copied().unwrap_or_default()
    }

    /// Returns the streets of the intersections of a point MDP, those of the first few by name; `None`
    /// when none has a name.
    pub(super) fn streets_of(&self, point: &str) -> Option<String> {
        let places: Vec<&MappedIntersection> = self.places_of(point).collect();
        let mut named: Vec<String> = places.iter().filter_map(|p| streets(p)).take(NAMED).collect();
        if named.is_empty() {
            return None;
        }
        if places.len() > named.len() {
            named.push(format!("and {} more", places.len() - named.len()));
        }
        Some(named.join("; "))
    }

    /// Returns what a point MDP is called: by its streets where it is one intersection, else as its table
    /// does.
    pub(super) fn title(&self, row: &PointRow) -> String {
        self.streets_alone(&row.point).unwrap_or_else(|| row.name().to_owned())
    }

    /// Returns what a point MDP of an analysis is called, with its id behind it.
    pub(super) fn called(&self, data: &Analysis, point: &str) -> String {
        let title = match data.position(point) {
            Some(position) => Some(self.title(&data.points[position].row)),
            None => self.streets_alone(point),
        };
        let other = title.filter(|title| title != point);
        other.map_or_else(|| point.to_owned(), |title| format!("{title} ({point})"))
    }

    /// Returns what every point MDP is called, as [`evaluation::report::csv::Titled`] takes it.
    pub(super) fn titles(&self, data: &Analysis) -> Option<Vec<String>> {
        let titles: Vec<String> = data.points.iter().map(|p| self.title(&p.row)).collect();
        differ(&data.points, &titles).then_some(titles)
    }

    /// Returns the streets of a point MDP that is one intersection, among the chosen or not.
    fn streets_alone(&self, point: &str) -> Option<String> {
        let mut places = self.places_of(point);
        match (places.next().and_then(streets), places.next()) {
            (Some(streets), None) => Some(streets),
            _ => None,
        }
    }
}

/// Returns the streets of an intersection; `None` when the map names none.
pub(super) fn streets(place: &MappedIntersection) -> Option<String> {
    (!place.streets.is_empty()).then(|| place.streets.join(" / "))
}

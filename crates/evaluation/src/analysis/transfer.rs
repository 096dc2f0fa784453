//! Models away from home: what was learned on one point MDP, evaluated on the others of the run, beside what was trained there.
//!
//! The run has the learners with their own training on every point MDP, and every model as a method of its own.

use super::whole::Analysis;

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

/// What became of models on the point MDPs of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Transfer {
    /// Ids of the point MDPs, by descending weight.
    pub points: Vec<String>,
    /// Weights of these.
    pub weights: Vec<f64>,
    /// A group per method, in the order of the models.
    pub groups: Vec<Group>,
}

/// The models of a method.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// The method.
    pub method: String,
    /// Score of its own training on every point MDP, in the order of [`Transfer::points`].
    pub own: Vec<Option<f64>>,
    /// Its models.
    pub models: Vec<Moved>,
}

/// A model on the point MDPs of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Moved {
    /// What it is.
    pub origin: Origin,
    /// What came of it on every point MDP, in the order of [`Transfer::points`].
    pub cells: Vec<Cell>,
}

/// What came of a model on a point MDP.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Its score.
    Score(f64),
    /// Why it has none.
    Failed(String),
    /// Nobody has tried yet, or the baseline has no record.
    Missing,
}

impl Cell {
    /// Returns the score.
    pub fn score(&self) -> Option<f64> {
        if let Self::Score(score) = self { Some(*score) } else { None }
    }
}

impl Transfer {
    /// Returns what became of models.
    ///
    /// # Arguments
    ///
    /// * `origins` — the models among the run's methods; those of a method follow one another.
    ///
    /// # Panics
    ///
    /// When a model or its method is no method of the run.
    pub fn of(analysis: &Analysis, origins: &[Origin]) -> Self {
        let methods = &analysis.manifest.identity.methods;
        let index = |name: &str| {
            let found = methods.iter().position(|method| method == name);
            found.expect("models and their methods are methods of the run")
        };
        let mut order: Vec<usize> = (0..analysis.points.len()).collect();
        order.sort_by(|a, b| analysis.points[*b].weight.total_cmp(&analysis.points[*a].weight));
        let weights: Vec<f64> = order.iter().map(|p| analysis.points[*p].weight).collect();
        let points: Vec<String> =
            order.iter().map(|p| analysis.points[*p].row.point.clone()).collect();
        let cells = |method: usize| -> Vec<Cell> {
            order.iter().map(|point| cell(analysis, *point, method)).collect()
        };
        let mut groups: Vec<Group> = Vec::new();
        for origin in origins {
            if groups.last().is_none_or(|group| group.method != origin.method) {
                let own = cells(index(&origin.method)).iter().map(Cell::score).collect();
                groups.push(Group { method: origin.method.clone(), own, models: Vec::new() });
            }
            let group = groups.last_mut().expect("there is one");
            let cells = cells(index(&origin.name));
            group.models.push(Moved { origin: origin.clone(), cells });
        }
        Self { points, weights, groups }
    }

    /// Returns the models, group by group.
    pub fn models(&self) -> impl Iterator<Item = (&Group, &Moved)> {
        self.groups.iter().flat_map(|group| group.models.iter().map(move |model| (group, model)))
    }

    /// Returns the models that have no score on a point MDP, with the reason.
    pub fn failures(&self) -> impl Iterator<Item = (&Moved, &str, &str)> {
        self.models().flat_map(move |(_, model)| {
            self.points.iter().zip(&model.cells).filter_map(move |(point, cell)| match cell {
                Cell::Failed(reason) => Some((model, point.as_str(), reason.as_str())),
                _ => None,
            })
        })
    }
}

/// Returns what came of a method on a point MDP.
fn cell(analysis: &Analysis, point: usize, method: usize) -> Cell {
    let result = analysis.points[point].results[method].as_ref();
    if let Some(score) = result.and_then(|result| result.score) {
        return Cell::Score(score);
    }
    let mut tasks = analysis.tasks.iter().filter(|t| (t.point, t.method) == (point, method));
    tasks.find_map(|task| task.reason.clone()).map_or(Cell::Missing, Cell::Failed)
}

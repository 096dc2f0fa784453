//! Models away from home: what was learned on one point MDP, evaluated on the others of the run, beside what was trained there.
//!
//! The run has the learners with their own training on every point MDP, and every model as a method of its own. Summaries
//! are over the point MDPs on which the model was not trained and on which both have a score; weights are renormalised over
//! these.

use super::whole::Analysis;
use crate::stats::Direction;
use crate::stats::score::weighted_mean;
use crate::stats::weighted_quantile::weighted_quantile;

/// By how much a model may be worse than own training, relative to that, and still count as near it.
pub const NEAR: f64 = 0.05;

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
    /// Its summary elsewhere; `None` where it has no score on any other point MDP.
    pub elsewhere: Option<Elsewhere>,
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

/// A model over the point MDPs on which it was not trained.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Elsewhere {
    /// Number of these on which it and own training have a score.
    pub points: usize,
    /// Their share of the weight of all on which it was not trained.
    pub covered: f64,
    /// Share of the weight of these on which it is near own training ([`NEAR`]) or better.
    pub near: f64,
    /// Weighted median of its scores, and of those of own training.
    pub median: (f64, f64),
    /// Weighted mean of its scores, and of those of own training.
    pub score: (f64, f64),
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
            let away = |point: usize| points[point] != origin.point;
            let elsewhere = elsewhere(&cells, &group.own, &weights, away, analysis.direction());
            group.models.push(Moved { origin: origin.clone(), cells, elsewhere });
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

fn elsewhere(
    cells: &[Cell],
    own: &[Option<f64>],
    weights: &[f64],
    away: impl Fn(usize) -> bool,
    direction: Direction,
) -> Option<Elsewhere> {
    let others: f64 = (0..cells.len()).filter(|p| away(*p)).map(|p| weights[p]).sum();
    let both: Vec<(f64, f64, f64)> = (0..cells.len())
        .filter(|point| away(*point))
        .filter_map(|point| Some((weights[point], cells[point].score()?, own[point]?)))
        .collect();
    let model = || both.iter().map(|(weight, model, _)| (*weight, *model));
    let trained = || both.iter().map(|(weight, _, own)| (*weight, *own));
    let total: f64 = both.iter().map(|(weight, ..)| weight).sum();
    let is_near = |(_, model, own): &&(f64, f64, f64)| match direction {
        Direction::Lower => *model <= own + NEAR * own.abs(),
        Direction::Higher => *model >= own - NEAR * own.abs(),
    };
    let near: f64 = both.iter().filter(is_near).map(|(weight, ..)| weight).sum();
    Some(Elsewhere {
        points: both.len(),
        covered: total / others,
        near: near / total,
        median: (weighted_quantile(model(), 0.5)?, weighted_quantile(trained(), 0.5)?),
        score: (weighted_mean(model())?, weighted_mean(trained())?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_is_summarised_where_it_was_not_trained_and_both_have_a_score() {
        let cells = [
            Cell::Score(9.0),
            Cell::Score(0.525),
            Cell::Score(0.53),
            Cell::Failed("other lanes".to_owned()),
            Cell::Score(0.4),
        ];
        let own = [Some(1.0), Some(0.5), Some(0.5), Some(0.5), None];
        let weights = [0.4, 0.3, 0.1, 0.1, 0.1];
        let found =
            elsewhere(&cells, &own, &weights, |point| point != 0, Direction::Lower).unwrap();
        assert_eq!(found.points, 2, "not at home, nor where one of the two has no score");
        assert!((found.covered - 0.4 / 0.6).abs() < 1e-12);
        assert!((found.near - 0.75).abs() < 1e-12, "5% worse is near, 6% is not");
        assert_eq!(found.median, (0.525, 0.5));
        assert!((found.score.0 - (0.3 * 0.525 + 0.1 * 0.53) / 0.4).abs() < 1e-12);
        let higher = elsewhere(&cells, &own, &weights, |point| point != 0, Direction::Higher);
        assert_eq!(higher.unwrap().near, 1.0);
        assert_eq!(elsewhere(&cells, &own, &weights, |_| false, Direction::Lower), None);
    }
}

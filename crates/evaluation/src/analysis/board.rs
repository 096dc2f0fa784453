//! The scores of some methods on the point MDPs that all of them have, as a table: what rankings under other
//! importance, and across families, are computed from.

use super::reference::{AnalysisError, position};
use super::whole::Analysis;
use crate::stats::Direction;

/// The scores of some methods on the point MDPs that all of them have.
#[derive(Debug, Clone, PartialEq)]
pub struct Board {
    /// Names of the methods.
    pub methods: Vec<String>,
    /// Whether less or more of a score is better.
    pub direction: Direction,
    /// The point MDPs, in the order of the family.
    pub points: Vec<BoardPoint>,
    /// What readers must know: which methods lack scores, and what was not evaluated.
    pub notes: Vec<String>,
}

/// A point MDP on which all methods have a score.
#[derive(Debug, Clone, PartialEq)]
pub struct BoardPoint {
    /// Position in [`Analysis::points`].
    pub index: usize,
    /// Weight in the run's estimates, above 0; the importance where the whole family was evaluated.
    pub weight: f64,
    /// Score of every method.
    pub scores: Vec<f64>,
}

impl Board {
    /// Returns the methods that are compared unless others are asked for: all with results but what scores are divided by.
    pub(super) fn methods_of(analysis: &Analysis) -> Vec<String> {
        let identity = &analysis.manifest.identity;
        let has = |m: usize| analysis.results_of(m).next().is_some();
        let compared = |m: &usize| Some(*m) != analysis.reference.index && has(*m);
        (0..identity.methods.len()).filter(compared).map(|m| identity.methods[m].clone()).collect()
    }

    /// Returns the scores of these methods, two or more.
    pub(super) fn new(analysis: &Analysis, methods: &[String]) -> Result<Self, AnalysisError> {
        let all = &analysis.manifest.identity.methods;
        let positions = methods
            .iter()
            .map(|name| position("method", name, all.iter().map(String::as_str)))
            .collect::<Result<Vec<usize>, _>>()?;
        if let Some(twice) = (1..methods.len()).find(|m| methods[..*m].contains(&methods[*m])) {
            return Err(AnalysisError(format!(
                "`{}` is named twice; name it once",
                methods[twice]
            )));
        }
        if methods.len() < 2 {
            return Err(AnalysisError(format!(
                "there is only `{}` to compare; name two methods or more with --methods, or finish the run",
                methods.join(", ")
            )));
        }
        let score = |point: usize, method: usize| {
            let result = analysis.points[point].results[method].as_ref()?;
            result.score.filter(|score| score.is_finite())
        };
        let chosen = analysis.points.len();
        let points: Vec<BoardPoint> = (0..chosen)
            .filter(|p| analysis.points[*p].weight > 0.0)
            .filter_map(|index| {
                let scores: Option<Vec<f64>> = positions.iter().map(|m| score(index, *m)).collect();
                Some(BoardPoint { index, weight: analysis.points[index].weight, scores: scores? })
            })
            .collect();
        let lacking: Vec<String> = positions
            .iter()
            .map(|m| (&all[*m], (0..chosen).filter(|p| score(*p, *m).is_none()).count()))
            .filter(|(_, count)| *count > 0)
            .map(|(name, count)| format!("{name} {count}"))
            .collect();
        let mut notes = Vec::new();
        if !lacking.is_empty() {
            notes.push(format!(
                "of {chosen} point MDPs {} are compared, on which all methods have a score; lacking: {}",
                points.len(),
                lacking.join(", ")
            ));
        }
        if points.is_empty() {
            let lacking = notes.pop().unwrap_or_default();
            return Err(AnalysisError(format!(
                "{lacking}; finish the run, or choose methods with --methods"
            )));
        }
        let size = analysis.manifest.identity.sample.family_size;
        if chosen < size {
            notes.push(format!(
                "{chosen} of {size} point MDPs were evaluated; the effect of the others is not known"
            ));
        }
        let direction = analysis.direction();
        Ok(Self { methods: methods.to_vec(), direction, points, notes })
    }

    /// Puts the methods into another order.
    pub(super) fn reorder(&mut self, order: &[usize]) {
        self.methods = order.iter().map(|m| self.methods[*m].clone()).collect();
        for point in &mut self.points {
            point.scores = order.iter().map(|m| point.scores[*m]).collect();
        }
    }
}

/// Returns ranks from 1; values that are equal have the mean of theirs.
pub(super) fn ranks(values: &[f64], direction: Direction) -> Vec<f64> {
    let rank = |value: &f64| {
        let better = values.iter().filter(|other| direction.is_worse(*value, **other)).count();
        let like = values.iter().filter(|other| *other == value).count();
        better as f64 + (like as f64 + 1.0) / 2.0
    };
    values.iter().map(rank).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_that_are_equal_have_the_mean_of_their_ranks() {
        assert_eq!(ranks(&[3.0, 1.0, 3.0, 2.0], Direction::Lower), [3.5, 1.0, 3.5, 2.0]);
        assert_eq!(ranks(&[3.0, 1.0, 3.0, 2.0], Direction::Higher), [1.5, 4.0, 1.5, 3.0]);
    }
}

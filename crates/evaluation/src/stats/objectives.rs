//! What was measured on one point MDP, and its means.

use super::StatsError;
use super::score::mean;

/// Returns the least of some values, and the mean of the last ones; `None` where there are none.
pub fn best_and_last(values: &[f64], last: usize) -> Option<[f64; 2]> {
    let best = values.iter().copied().reduce(f64::min)?;
    Some([best, mean(&values[values.len().saturating_sub(last)..])?])
}

/// What was measured on one point MDP.
#[derive(Debug, Clone, PartialEq)]
pub struct PointObjectives {
    /// Weight of the score in the estimate.
    pub weight: f64,
    /// How often the point MDP was drawn; 1 unless drawn with replacement.
    pub draws: u32,
    /// Objective of the method, shape `[replicates, seeds]`.
    pub method: Vec<Vec<f64>>,
    /// Objective of the baseline on the same seeds, shape `[seeds]`.
    pub baseline: Vec<f64>,
}

/// The means of one point MDP, from which statistics over point MDPs are computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointMeans {
    /// Position among the point MDPs.
    pub point: usize,
    /// Weight in the statistic.
    pub weight: f64,
    /// Mean objective of the method over replicates and seeds.
    pub method: f64,
    /// Mean objective of the baseline over seeds.
    pub baseline: f64,
    /// The score: the first divided by the second.
    pub score: f64,
}

impl PointObjectives {
    /// Returns the score on this point MDP.
    ///
    /// # Errors
    ///
    /// [`StatsError`] as [`super::score()`] has it, and [`StatsError::Empty`] without a replicate.
    pub fn score(&self) -> Result<f64, StatsError> {
        let scores = self
            .method
            .iter()
            .map(|replicate| super::score(replicate, &self.baseline))
            .collect::<Result<Vec<_>, _>>()?;
        mean(&scores).ok_or(StatsError::Empty("the list of replicates"))
    }

    /// Returns the means over all replicates and seeds; `point` is kept as it is.
    ///
    /// # Errors
    ///
    /// Those of [`PointObjectives::score`].
    pub fn means(&self, point: usize) -> Result<PointMeans, StatsError> {
        let score = self.score()?;
        let baseline = mean(&self.baseline).ok_or(StatsError::Empty("baseline"))?;
        let replicates: Vec<f64> = self.method.iter().filter_map(|values| mean(values)).collect();
        let method = mean(&replicates).ok_or(StatsError::Empty("the list of replicates"))?;
        Ok(PointMeans { point, weight: self.weight, method, baseline, score })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(method: &[&[f64]], baseline: &[f64]) -> PointObjectives {
        let method = method.iter().map(|values| values.to_vec()).collect();
        PointObjectives { weight: 2.0, draws: 1, method, baseline: baseline.to_vec() }
    }

    #[test]
    fn means_are_over_replicates_and_seeds() {
        let means = point(&[&[5.0, 7.0], &[9.0, 11.0]], &[10.0, 30.0]).means(3).unwrap();
        let expected =
            PointMeans { point: 3, weight: 2.0, method: 8.0, baseline: 20.0, score: 0.4 };
        assert_eq!(means, expected);
    }
}

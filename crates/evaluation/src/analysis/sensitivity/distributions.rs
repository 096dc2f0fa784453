//! Overall performance when point MDPs are weighed otherwise: as people may mean it, and at random.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Gamma};

use crate::analysis::board::{Board, position};
use crate::analysis::error::AnalysisError;
use crate::analysis::ranks::ranks;
use crate::analysis::whole::Analysis;
use crate::stats::quantile::{ALPHA, central};
use basics::seed::derive;

/// Random distributions that are shown one by one, as the paper's `D_1` to `D_5`.
pub const NAMED: usize = 5;

/// Random distributions over which ranks are counted; the first are those that are shown.
pub const RANDOM: usize = 1000;

/// A distribution over the point MDPs of a board, and the methods under it.
#[derive(Debug, Clone, PartialEq)]
pub struct Distribution {
    /// Short name: `importance`, `equal`, the name of a feature, `D1`.
    pub name: String,
    /// Weight of every point MDP; they sum to 1.
    pub weights: Vec<f64>,
    /// Overall performance of every method.
    pub overall: Vec<f64>,
    /// Rank of every method, from 1; methods that tie have the mean of theirs.
    pub ranks: Vec<f64>,
}

/// How ranks vary over random distributions.
#[derive(Debug, Clone, PartialEq)]
pub struct RandomRanks {
    /// Concentration of the Dirichlet distribution that they are from.
    pub concentration: f64,
    /// Their seed.
    pub seed: u64,
    /// Share of the distributions, shape `[methods, ranks]`; methods that tie share their ranks.
    pub shares: Vec<Vec<f64>>,
    /// Range of the central 95% of each method's overall performance.
    pub range: Vec<Option<(f64, f64)>>,
    /// Share of the distributions under which the ranking is that by importance.
    pub as_overall: f64,
}

impl Distribution {
    fn new(board: &Board, name: &str, weights: Vec<f64>) -> Self {
        let total: f64 = weights.iter().sum();
        let weights: Vec<f64> = weights.into_iter().map(|w| w / total).collect();
        let of = |m: usize| board.points.iter().zip(&weights).map(|(p, w)| w * p.scores[m]).sum();
        let overall: Vec<f64> = (0..board.methods.len()).map(of).collect();
        let ranks = ranks(&overall, board.direction);
        Self { name: name.to_owned(), weights, overall, ranks }
    }

    /// The run's own weights.
    pub(super) fn importance(board: &Board) -> Self {
        Self::new(board, "importance", board.weights())
    }

    /// The same weight for every point MDP.
    pub(super) fn equal(board: &Board) -> Self {
        Self::new(board, "equal", vec![1.0; board.points.len()])
    }

    /// Importance times a feature, as vehicles rather than intersections count.
    pub(super) fn by_feature(
        analysis: &Analysis,
        board: &Board,
        feature: &str,
    ) -> Result<Self, AnalysisError> {
        let features = &analysis.manifest.identity.features;
        let column = position("feature", feature, features.iter().map(|f| f.name.as_str()))?;
        let value = |index: usize| analysis.points[index].row.features[column];
        if let Some(p) =
            board.points.iter().find(|p| value(p.index).is_nan() || value(p.index) < 0.0)
        {
            return Err(AnalysisError::NotTogether(format!(
                "point MDPs cannot be weighed by {feature}, which is {} on {}; choose a feature without negative \
                 values",
                value(p.index),
                p.id
            )));
        }
        let weights: Vec<f64> = board.points.iter().map(|p| p.weight * value(p.index)).collect();
        let total: f64 = weights.iter().sum();
        if !(total.is_finite() && total > 0.0) {
            return Err(AnalysisError::NotTogether(format!(
                "point MDPs cannot be weighed by {feature}, which is 0 on all of them; choose another feature"
            )));
        }
        Ok(Self::new(board, feature, weights))
    }

    /// Returns how many point MDPs of equal weight would be as unequal: the inverse of the sum of squared weights.
    pub fn effective(&self) -> f64 {
        1.0 / self.weights.iter().map(|w| w * w).sum::<f64>()
    }
}

/// Returns weights from a symmetric Dirichlet distribution; they sum to 1.
///
/// Deviation: the paper says "randomly generate". With a concentration of 1 every distribution over the point MDPs
/// is equally likely.
///
/// # Arguments
///
/// * `concentration` — above 0.
/// * `number` — which of the distributions of the seed.
pub fn random_importance(points: usize, concentration: f64, seed: u64, number: usize) -> Vec<f64> {
    let labels = ["sensitivity", "importance", &number.to_string()];
    let mut rng = ChaCha8Rng::seed_from_u64(derive(seed, &labels));
    let gamma = Gamma::new(concentration + 1.0, 1.0).expect("a concentration is above 0");
    // A gamma variate of a small shape underflows; its logarithm, by way of a larger shape, does not.
    // Source: G. Marsaglia and W. W. Tsang, "A simple method for generating gamma variables", 2000, section 6.
    let logarithms: Vec<f64> = (0..points)
        .map(|_| {
            let (large, uniform): (f64, f64) = (gamma.sample(&mut rng), 1.0 - rng.random::<f64>());
            large.ln() + uniform.ln() / concentration
        })
        .collect();
    let most = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = logarithms.iter().map(|l| (l - most).exp()).collect();
    let total: f64 = weights.iter().sum();
    weights.into_iter().map(|w| w / total).collect()
}

/// Returns the random distributions that are shown, and how ranks vary over all of them.
pub(super) fn random(
    board: &Board,
    concentration: f64,
    seed: u64,
) -> (Vec<Distribution>, RandomRanks) {
    let methods = board.methods.len();
    let expected = Distribution::importance(board).ranks;
    let mut shares = vec![vec![0.0; methods]; methods];
    let mut overall = vec![Vec::with_capacity(RANDOM); methods];
    let (mut named, mut as_overall) = (Vec::new(), 0.0);
    for number in 0..RANDOM {
        let weights = random_importance(board.points.len(), concentration, seed, number);
        let drawn = Distribution::new(board, &format!("D{}", number + 1), weights);
        for m in 0..methods {
            let like = drawn.ranks.iter().filter(|rank| **rank == drawn.ranks[m]).count();
            // The mean of tied ranks lies in the middle of them.
            let first = (drawn.ranks[m] - (like as f64 + 1.0) / 2.0).round() as usize;
            for share in &mut shares[m][first..first + like] {
                *share += 1.0 / like as f64;
            }
            overall[m].push(drawn.overall[m]);
        }
        if drawn.ranks == expected {
            as_overall += 1.0;
        }
        if number < NAMED {
            named.push(drawn);
        }
    }
    shares.iter_mut().flatten().for_each(|share| *share /= RANDOM as f64);
    as_overall /= RANDOM as f64;
    let range = overall.iter().map(|values| central(values, ALPHA)).collect();
    (named, RandomRanks { concentration, seed, shares, range, as_overall })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn random_importance_is_a_distribution(points in 1usize..300, exponent in -3.0f64..3.0, seed: u64) {
            let weights = random_importance(points, 10f64.powf(exponent), seed, 3);
            prop_assert_eq!(weights.len(), points);
            prop_assert!(weights.iter().all(|w| (0.0..=1.0).contains(w)));
            prop_assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn weights_have_the_spread_of_their_concentration() {
        // The variance of a weight of a symmetric Dirichlet distribution is (n - 1) / (n^2 (n a + 1)).
        for a in [0.05, 1.0, 20.0] {
            let n = 10.0;
            let squares: f64 =
                (0..4000).map(|k| (random_importance(10, a, 5, k)[2] - 1.0 / n).powi(2)).sum();
            let expected = (n - 1.0) / (n * n * (n * a + 1.0));
            assert!((squares / 4000.0 / expected - 1.0).abs() < 0.1, "{a}: {squares} {expected}");
        }
    }

    #[test]
    fn the_same_seed_and_number_give_the_same_weights() {
        assert_eq!(random_importance(5, 1.0, 7, 0), random_importance(5, 1.0, 7, 0));
        assert_ne!(random_importance(5, 1.0, 7, 0), random_importance(5, 1.0, 7, 1));
        assert_ne!(random_importance(5, 1.0, 7, 0), random_importance(5, 1.0, 8, 0));
    }
}

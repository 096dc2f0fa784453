//! How far the ranking of methods depends on which point MDPs count how much: other importance, random importance, and
//! a single point MDP that is usually reported.
//!
//! Source: Jayawardana et al. (NeurIPS 2022), appendix, "Impact of Point MDP Distribution on Evaluations"; figure of
//! reported and overall performance.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Gamma};

use super::board::{Board, ranks};
use super::reference::{AnalysisError, position};
use super::whole::Analysis;
use crate::stats::quantile::{ALPHA, central};
use basics::seed::derive;

/// Random distributions that are shown one by one, as the paper's `D_1` to `D_5`.
const NAMED: usize = 5;

/// Random distributions over which ranks are counted; the first are those that are shown.
pub const RANDOM: usize = 1000;

/// What is asked of the records of a family.
#[derive(Debug, Clone, PartialEq)]
pub struct Question {
    /// Whom to compare; `None` takes all methods with results but the baseline.
    pub methods: Option<Vec<String>>,
    /// Features by which importance is multiplied, each for a distribution of its own.
    pub weigh_by: Vec<String>,
    /// Concentration of random distributions, above 0: 1 makes all equally likely, less makes few point MDPs count.
    pub concentration: f64,
    /// Seed of random distributions.
    pub seed: u64,
    /// Point MDPs that are reported for the family: distributions of one point MDP.
    pub reported: Vec<String>,
}

/// How far the ranking of methods depends on which point MDPs count how much.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivity {
    /// The methods, best first by importance, and their scores.
    pub board: Board,
    /// Overall performance by importance, with equal weights, by features, at reported point MDPs, and under some random
    /// distributions.
    pub distributions: Vec<Distribution>,
    /// Per method the range of the central 95% of its overall performance over [`RANDOM`] distributions.
    pub range: Vec<Option<(f64, f64)>>,
    /// Share of these under which the ranking is that by importance.
    pub as_overall: f64,
}

/// A distribution over the point MDPs of a board, and the methods under it.
#[derive(Debug, Clone, PartialEq)]
pub struct Distribution {
    /// Short name: `importance`, `equal`, the name of a feature or a point MDP, `D1`.
    pub name: String,
    /// Weight of every point MDP; they sum to 1.
    pub weights: Vec<f64>,
    /// Overall performance of every method.
    pub overall: Vec<f64>,
    /// Rank of every method, from 1; methods that tie have the mean of theirs.
    pub ranks: Vec<f64>,
}

impl Sensitivity {
    /// Looks at the records of a family.
    ///
    /// # Errors
    ///
    /// [`AnalysisError`] for names that are not in the results, and where methods have nothing in common.
    pub fn new(analysis: &Analysis, question: &Question) -> Result<Self, AnalysisError> {
        let methods = question.methods.clone().unwrap_or_else(|| Board::methods_of(analysis));
        let mut board = Board::new(analysis, &methods)?;
        let total: f64 = board.points.iter().map(|p| p.weight).sum();
        let importance: Vec<f64> = board.points.iter().map(|p| p.weight / total).collect();
        let overall = Distribution::new(&board, "importance", importance.clone()).overall;
        let mut order: Vec<usize> = (0..board.methods.len()).collect();
        order.sort_by(|a, b| board.direction.compare(overall[*a], overall[*b]));
        board.reorder(&order);
        let equal = vec![1.0; board.points.len()];
        let mut distributions = vec![
            Distribution::new(&board, "importance", importance),
            Distribution::new(&board, "equal", equal),
        ];
        for feature in &question.weigh_by {
            let weights = by_feature(analysis, &board, feature)?;
            distributions.push(Distribution::new(&board, feature, weights));
        }
        for point in &question.reported {
            let rows = || analysis.points.iter().map(|p| &p.row);
            let named = rows().position(|row| row.title == *point);
            let ids = rows().map(|row| row.point.as_str());
            let index = named.map_or_else(|| position("point MDP", point, ids), Ok)?;
            let is_it = |i: usize| f64::from(u8::from(i == index));
            let weights: Vec<f64> = board.points.iter().map(|p| is_it(p.index)).collect();
            if !weights.contains(&1.0) {
                return Err(AnalysisError(format!(
                    "not every method has a score on point MDP `{point}`; finish the run, or choose methods with --methods"
                )));
            }
            distributions.push(Distribution::new(&board, point, weights));
        }
        let mut overall = vec![Vec::with_capacity(RANDOM); board.methods.len()];
        let mut as_overall = 0.0;
        for number in 0..RANDOM {
            let points = board.points.len();
            let weights = random_importance(points, question.concentration, question.seed, number);
            let drawn = Distribution::new(&board, &format!("D{}", number + 1), weights);
            overall.iter_mut().zip(&drawn.overall).for_each(|(of, value)| of.push(*value));
            if drawn.ranks == distributions[0].ranks {
                as_overall += 1.0 / RANDOM as f64;
            }
            if number < NAMED {
                distributions.push(drawn);
            }
        }
        let range = overall.iter().map(|values| central(values, ALPHA)).collect();
        Ok(Self { board, distributions, range, as_overall })
    }
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
}

fn by_feature(
    analysis: &Analysis,
    board: &Board,
    feature: &str,
) -> Result<Vec<f64>, AnalysisError> {
    let features = &analysis.manifest.identity.features;
    let column = position("feature", feature, features.iter().map(|f| f.name.as_str()))?;
    let value = |index: usize| analysis.points[index].row.features[column];
    let weights: Vec<f64> = board.points.iter().map(|p| p.weight * value(p.index)).collect();
    let total: f64 = weights.iter().sum();
    if weights.iter().all(|w| *w >= 0.0) && total.is_finite() && total > 0.0 {
        return Ok(weights);
    }
    Err(AnalysisError(format!(
        "point MDPs cannot be weighed by {feature}, which is negative or missing on some of them, or 0 on all; choose another \
         feature"
    )))
}

/// Returns weights from a symmetric Dirichlet distribution; they sum to 1.
fn random_importance(points: usize, concentration: f64, seed: u64, number: usize) -> Vec<f64> {
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

//! How well estimators do when failures are rare, when they are frequent, and when importance is random.
//!
//! Source: Jayawardana et al. (NeurIPS 2022), appendix, "Further experiments on approximation algorithms", cases 1
//! to 3. Failures are given by the caller: they are known only because the whole family was evaluated.
//! Deviation: the paper does not say how low and how high the probabilities of failures are. Here their importance
//! is divided and multiplied by a factor. Its third case is "uniformly random" in the text and "discrete normal" below the
//! figure; here it is uniform.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{Cell, Recorded, StudyError, StudyPlan, study};
use basics::seed::derive;

/// Another importance of the point MDPs, as the paper asks about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Case {
    /// Case 1: failures get low probabilities.
    Rare,
    /// Case 2: failures get high probabilities.
    Frequent,
    /// Case 3: the importance of every point MDP is drawn from the same interval.
    Random,
}

/// What came of a case.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseStudy {
    /// The case.
    pub case: Case,
    /// Importance of every point MDP, in the order of the family; sums to 1.
    pub importance: Vec<f64>,
    /// Share that failures have of it.
    pub failures: f64,
    /// A cell per estimator, budget and method.
    pub cells: Vec<Cell>,
}

impl Case {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Rare, Self::Frequent, Self::Random];

    /// Returns its number in the paper.
    pub fn number(self) -> usize {
        match self {
            Self::Rare => 1,
            Self::Frequent => 2,
            Self::Random => 3,
        }
    }

    /// Returns what it is, in words.
    pub fn title(self) -> &'static str {
        match self {
            Self::Rare => "failures get low probabilities",
            Self::Frequent => "failures get high probabilities",
            Self::Random => "importance is uniformly random",
        }
    }

    /// Returns the importance of the point MDPs; sums to 1.
    ///
    /// # Arguments
    ///
    /// * `importance` — the family's own.
    /// * `fails` — which point MDPs are failures, in the same order.
    /// * `odds` — by how much the importance of failures is divided or multiplied, above 1.
    pub fn importance(self, importance: &[f64], fails: &[bool], odds: f64, seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(derive(seed, &["cases", "importance"]));
        let weights: Vec<f64> = importance
            .iter()
            .zip(fails)
            .map(|(p, fails)| match (self, fails) {
                (Self::Rare, true) => p / odds,
                (Self::Frequent, true) => p * odds,
                (Self::Rare | Self::Frequent, false) => *p,
                // Never 0: such a point MDP would not belong to the family.
                (Self::Random, _) => 1.0 - rng.random::<f64>(),
            })
            .collect();
        let total: f64 = weights.iter().sum();
        weights.into_iter().map(|w| w / total).collect()
    }
}

/// Studies estimators in every case; in the first two only where some point MDPs fail and some do not.
///
/// # Arguments
///
/// * `fails` — which point MDPs are failures, in the order of the family.
/// * `odds` — by how much the importance of failures is divided or multiplied, above 1.
/// * `done` — called with the number of samples that were finished since the last call, from any thread.
///
/// # Errors
///
/// Those of [`study`], and [`StudyError::Family`] for an importance that is none.
pub fn study_cases(
    recorded: &Recorded,
    fails: &[bool],
    odds: f64,
    plan: &StudyPlan,
    done: &(dyn Fn(usize) + Sync),
) -> Result<Vec<CaseStudy>, StudyError> {
    let family: Vec<f64> = recorded.family.points.iter().map(|p| p.importance).collect();
    let differ = fails.contains(&true) && fails.contains(&false);
    let mut studies = Vec::new();
    for case in Case::ALL.into_iter().filter(|case| *case == Case::Random || differ) {
        let importance = case.importance(&family, fails, odds, plan.seed);
        let cells = study(&recorded.with_importance(&importance)?, plan, done)?;
        let of_failures = importance.iter().zip(fails).filter(|(_, fails)| **fails);
        let failures = of_failures.map(|(p, _)| p).sum();
        studies.push(CaseStudy { case, importance, failures, cells });
    }
    Ok(studies)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_are_ten_times_rarer_or_more_frequent() {
        let (family, fails) = ([0.5, 0.3, 0.2], [false, true, false]);
        let of = |case: Case| case.importance(&family, &fails, 10.0, 0);
        let near = |found: Vec<f64>, expected: [f64; 3]| {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        };
        near(of(Case::Rare), [0.5 / 0.73, 0.03 / 0.73, 0.2 / 0.73]);
        near(of(Case::Frequent), [0.5 / 3.7, 3.0 / 3.7, 0.2 / 3.7]);
    }

    #[test]
    fn random_importance_depends_on_the_seed_alone() {
        let of = |fails: [bool; 2], seed| Case::Random.importance(&[0.9, 0.1], &fails, 10.0, seed);
        assert_eq!(of([true, false], 3), of([false, true], 3));
        assert_ne!(of([true, false], 3), of([true, false], 4));
        let many = Case::Random.importance(&[1e-4; 10_000], &[false; 10_000], 10.0, 0);
        let (least, most) = many.iter().fold((1.0f64, 0.0f64), |(a, b), p| (a.min(*p), b.max(*p)));
        // Uniform from 0 to twice the mean.
        assert!(least > 0.0 && most < 2.05e-4 && most > 1.95e-4, "{least} {most}");
    }
}

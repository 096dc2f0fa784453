//! Which point MDPs to evaluate under a budget, and with which weight.
//!
//! Source: Jayawardana et al. (NeurIPS 2022), appendix, "Evaluate DRL methods on a family of MDPs".

pub mod kmeans;
mod random;

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::family::MdpFamily;

/// How point MDPs are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sampling {
    /// M3: k-means clusters, each represented by the point MDP nearest to its centroid
    KMeans,
    /// M1: random draws by importance, with replacement
    WithReplacement,
    /// M2: random draws by importance, without replacement
    WithoutReplacement,
    /// Every point MDP of the family: what `--budget all` does, no choice of its own
    All,
}

/// A chosen point MDP.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Draw {
    /// Id of the point MDP.
    pub point: String,
    /// Weight of its score in the estimate; weights sum to 1.
    pub weight: f64,
    /// How often it was drawn (more than once only with replacement), or for k-means how many
    /// point MDPs its cluster has.
    pub count: u32,
}

/// The chosen point MDPs; written before anything runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SamplePlan {
    /// How they were chosen.
    pub sampling: Sampling,
    /// Number of draws.
    pub budget: usize,
    /// Size of the family.
    pub family_size: usize,
    /// Seed of the choice.
    pub seed: u64,
    /// The choice, in the order of the family.
    pub draws: Vec<Draw>,
}

/// Why a sample cannot be drawn.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SampleError {
    /// A budget of 0 or, without replacement, above the family's size.
    #[error(
        "budget {budget}: the family has {size} point MDPs; give a budget from 1 to {size}, or `all`"
    )]
    Budget {
        /// What was asked for.
        budget: usize,
        /// Size of the family.
        size: usize,
    },
}

/// Chooses `budget` point MDPs of a family.
///
/// - `with-replacement` (M1) draws by importance; each draw weighs `1 / budget`.
///   Deviation: the paper prints M1's estimate as a plain sum of scores; a mean is meant.
/// - `without-replacement` (M2) draws one after the other by the importance of those that are
///   left; weights are the importance, renormalised over the draws.
/// - `k-means` (M3) clusters the standardised features, or what else describes the point MDPs
///   ([`MdpFamily::describing`]), with every point MDP weighing the same, represents each cluster by the point MDP nearest to its centroid and gives it the
///   importance of the whole cluster.
/// - `all` takes every point MDP with its importance.
///
/// # Errors
///
/// [`SampleError::Budget`] for a budget of 0 or above the size of the family.
pub fn choose(
    family: &MdpFamily,
    sampling: Sampling,
    budget: usize,
    seed: u64,
) -> Result<SamplePlan, SampleError> {
    let size = family.points.len();
    if budget == 0 || budget > size {
        return Err(SampleError::Budget { budget, size });
    }
    let importance = family.importance();
    let chosen: Vec<(usize, f64, u32)> = match sampling {
        Sampling::All => importance.iter().enumerate().map(|(i, p)| (i, *p, 1)).collect(),
        Sampling::WithReplacement => random::with_replacement(&importance, budget, seed),
        Sampling::WithoutReplacement => random::without_replacement(&importance, budget, seed),
        Sampling::KMeans => kmeans::representatives(&features(family), &importance, budget, seed),
    };
    let draws = chosen
        .into_iter()
        .map(|(i, weight, count)| Draw { point: family.points[i].id.clone(), weight, count })
        .collect();
    Ok(SamplePlan { sampling, budget, family_size: size, seed, draws })
}

/// Returns per point MDP of the family the position of the chosen one that stands for it: its own, or
/// with k-means that of its cluster; `None` where none does, as with random draws.
pub fn stands(family: &MdpFamily, plan: &SamplePlan) -> Vec<Option<usize>> {
    let chosen: Vec<usize> =
        plan.draws.iter().filter_map(|draw| family.position(&draw.point)).collect();
    let own = |point: usize| chosen.contains(&point).then_some(point);
    let size = family.points.len();
    if plan.sampling != Sampling::KMeans {
        return (0..size).map(own).collect();
    }
    let labels = kmeans::labels(&features(family), plan.budget, plan.seed);
    let of_cluster = |label: usize| chosen.iter().copied().find(|c| labels[*c] == label);
    (0..size).map(|point| of_cluster(labels[point])).collect()
}

/// Returns the features that point MDPs are clustered by.
fn features(family: &MdpFamily) -> Cow<'_, [Vec<f64>]> {
    match family.describing.is_empty() {
        true => family.points.iter().map(|p| p.features.clone()).collect(),
        false => Cow::Borrowed(&family.describing),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traffic::family::load::load;
    use proptest::prelude::*;

    const CHOICES: [Sampling; 3] =
        [Sampling::KMeans, Sampling::WithReplacement, Sampling::WithoutReplacement];

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn weights_sum_to_one(budget in 1usize..=164, seed in 0u64..1000, which in 0usize..3) {
            let family = load("salt-lake-city").unwrap().family;
            let plan = choose(&family, CHOICES[which], budget, seed).unwrap();
            let sum: f64 = plan.draws.iter().map(|d| d.weight).sum();
            prop_assert!((sum - 1.0).abs() < 1e-9);
            prop_assert!(plan.draws.len() <= budget);
        }
    }

    #[test]
    fn the_whole_family_without_replacement_has_the_family_s_importance() {
        let family = load("salt-lake-city").unwrap().family;
        for sampling in [Sampling::WithoutReplacement, Sampling::KMeans] {
            let plan = choose(&family, sampling, 164, 5).unwrap();
            for (draw, point) in plan.draws.iter().zip(&family.points) {
                assert_eq!(draw.point, point.id);
                assert!((draw.weight - point.importance).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_budget_above_the_family_says_its_size() {
        let family = load("smoke").unwrap().family;
        let e = choose(&family, Sampling::KMeans, 3, 0).unwrap_err();
        assert_eq!(
            e.to_string(),
            "budget 3: the family has 2 point MDPs; give a budget from 1 to 2, or `all`"
        );
    }

    #[test]
    fn the_same_seed_chooses_the_same_points() {
        let family = load("salt-lake-city").unwrap().family;
        for sampling in CHOICES {
            let plan = choose(&family, sampling, 40, 3).unwrap();
            assert_eq!(plan, choose(&family, sampling, 40, 3).unwrap());
            assert_ne!(plan.draws, choose(&family, sampling, 40, 4).unwrap().draws);
        }
    }

    #[test]
    fn every_cluster_stands_for_as_many_point_mdps_as_its_draw_counts() {
        let family = load("salt-lake-city").unwrap().family;
        let plan = choose(&family, Sampling::KMeans, 20, 3).unwrap();
        let stands = stands(&family, &plan);
        for draw in &plan.draws {
            let chosen = family.position(&draw.point);
            let members: Vec<usize> =
                (0..family.points.len()).filter(|p| stands[*p] == chosen).collect();
            assert_eq!(members.len() as u32, draw.count);
            assert!(members.contains(&chosen.unwrap()));
            let weight: f64 = members.iter().map(|m| family.points[*m].importance).sum();
            assert!((weight - draw.weight).abs() < 1e-9);
        }
    }

    #[test]
    fn a_random_draw_stands_for_itself_alone() {
        let family = load("salt-lake-city").unwrap().family;
        let plan = choose(&family, Sampling::WithoutReplacement, 20, 3).unwrap();
        let stands = stands(&family, &plan);
        assert_eq!(stands.iter().flatten().count(), 20);
        assert!((0..stands.len()).all(|p| stands[p].is_none_or(|s| s == p)));
    }
}

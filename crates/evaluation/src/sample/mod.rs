//! Which point MDPs to evaluate under a budget, and with which weight.
//!
//! Source of M1 to M3: Jayawardana et al. (NeurIPS 2022), appendix, "Evaluate DRL methods on a family of MDPs".

pub mod balanced;
mod choice;
pub mod design;
pub mod kmeans;
pub mod looks;
mod plan;
pub mod quadrature;

use std::collections::HashMap;

use design::features;
use quadrature::Quadrature;
use rand::SeedableRng;
use rand::distr::Distribution;
use rand::distr::weighted::WeightedIndex;
use rand_chacha::ChaCha8Rng;

use crate::family::MdpFamily;
use basics::seed::derive;

pub use choice::Choice;
pub use design::{Design, Input, Measure, Process};
pub use plan::{Draw, Growth, Look, SampleError, SamplePlan, Sampling, Until};

/// Chooses `budget` point MDPs of a family.
///
/// - `with-replacement` (M1) draws by importance; each draw weighs `1 / budget`.
///   Deviation: the paper prints M1's estimate as a plain sum of scores; a mean is meant.
/// - `without-replacement` (M2) draws one after the other by the importance of those that are
///   left; weights are the importance, renormalised over the draws.
/// - `k-means` (M3) clusters the standardised features, or what else describes the point MDPs
///   ([`MdpFamily::describing`]), with every point MDP weighing the same, represents each cluster by the point MDP nearest to its centroid and gives it the
///   importance of the whole cluster.
/// - `balanced` draws with probabilities in proportion to importance, spread over the design by the local pivotal
///   method; weights are importance divided by probability, renormalised over the draws.
/// - `bayesian-quadrature` takes the first point MDPs of one order, in which each leaves least unknown of the overall
///   performance ([`quadrature`]).
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
    let design = Design::of(family).for_sampling(sampling);
    choose_over(family, &design, sampling, budget, seed)
}

/// Chooses point MDPs of a family as [`choose`] does, a balanced sample and one by Bayesian quadrature over this design.
///
/// # Errors
///
/// Those of [`choose`].
///
/// # Panics
///
/// If the design has other point MDPs than the family, or no process of its own for Bayesian quadrature
/// ([`Design::modelled`]).
pub fn choose_over(
    family: &MdpFamily,
    design: &Design,
    sampling: Sampling,
    budget: usize,
    seed: u64,
) -> Result<SamplePlan, SampleError> {
    let size = family.points.len();
    if budget == 0 || budget > size {
        return Err(SampleError::Budget { budget, size });
    }
    assert_eq!(design.points.len(), size, "a design has all point MDPs of its family");
    let importance = family.importance();
    let mut probabilities: Option<Vec<f64>> = None;
    let chosen: Vec<Chosen> = match sampling {
        Sampling::All => importance.iter().enumerate().map(|(i, p)| (i, *p, 1)).collect(),
        Sampling::WithReplacement => with_replacement(&importance, budget, seed),
        Sampling::WithoutReplacement => {
            probabilities = Some(inclusion(&importance, budget));
            without_replacement(&importance, budget, seed)
        }
        Sampling::KMeans => kmeans::representatives(&features(family), &importance, budget, seed),
        Sampling::Balanced => {
            let pi = balanced::inclusion(&importance, budget);
            let drawn = balanced::pivotal(&pi, &design.coordinates(), seed);
            let weights = balanced::weights(&importance, &pi, &drawn);
            probabilities = Some(pi);
            drawn.into_iter().zip(weights).map(|(i, weight)| (i, weight, 1)).collect()
        }
        Sampling::BayesianQuadrature => {
            let quadrature = Quadrature::of(design).expect("the design has a process of its own");
            let mut rows = quadrature.order(design, budget, seed);
            rows.sort_unstable();
            let weights = quadrature.rule(&rows, false).weights;
            rows.into_iter().zip(weights).map(|(i, weight)| (i, weight, 1)).collect()
        }
    };
    let draw = |(i, weight, count): Chosen| Draw {
        point: family.points[i].id.clone(),
        weight,
        count,
        inclusion: probabilities.as_ref().map(|p| p[i]),
    };
    let draws = chosen.into_iter().map(draw).collect();
    let sha256 = if sampling.has_design() { design.sha256() } else { String::new() };
    let family_size = size;
    Ok(SamplePlan { sampling, budget, family_size, seed, draws, design: sha256, growth: None })
}

/// Returns per point MDP of the family the position of the chosen one that stands for it: its own, with k-means that
/// of its cluster, in a balanced sample and one by Bayesian quadrature the nearest; `None` where none does, as with other random draws.
pub fn stands(family: &MdpFamily, plan: &SamplePlan) -> Vec<Option<usize>> {
    let chosen: Vec<usize> =
        plan.draws.iter().filter_map(|draw| family.position(&draw.point)).collect();
    let size = family.points.len();
    let mut is_chosen = vec![false; size];
    chosen.iter().for_each(|point| is_chosen[*point] = true);
    let own = |point: usize| is_chosen[point].then_some(point);
    match plan.sampling {
        Sampling::KMeans => {}
        Sampling::Balanced | Sampling::BayesianQuadrature => {
            let rows = kmeans::standardise(&features(family));
            let nearest = |point: usize| {
                let distance = |at: &usize| kmeans::squared_distance(&rows[point], &rows[*at]);
                let nearer =
                    |a: &usize, b: &usize| distance(a).total_cmp(&distance(b)).then(a.cmp(b));
                chosen.iter().copied().min_by(nearer)
            };
            return (0..size).map(|point| own(point).or_else(|| nearest(point))).collect();
        }
        _ => return (0..size).map(own).collect(),
    }
    let labels = kmeans::labels(&features(family), plan.budget, plan.seed);
    let of_cluster: HashMap<usize, usize> =
        chosen.iter().rev().map(|point| (labels[*point], *point)).collect();
    (0..size).map(|point| of_cluster.get(&labels[point]).copied()).collect()
}

/// Halvings of the time, which leave nothing of it.
const BISECTIONS: usize = 100;

/// A drawn point MDP: its index, its weight in the estimate, how often it was drawn.
type Chosen = (usize, f64, u32);

/// M1: `budget` independent draws by importance; a draw weighs `1 / budget`.
fn with_replacement(importance: &[f64], budget: usize, seed: u64) -> Vec<Chosen> {
    let mut rng = ChaCha8Rng::seed_from_u64(derive(seed, &["sample", "with-replacement"]));
    let distribution = WeightedIndex::new(importance).expect("a family's importance sums to 1");
    let mut counts = vec![0u32; importance.len()];
    for _ in 0..budget {
        counts[distribution.sample(&mut rng)] += 1;
    }
    counts
        .into_iter()
        .enumerate()
        .filter(|(_, count)| *count > 0)
        .map(|(i, count)| (i, f64::from(count) / budget as f64, count))
        .collect()
}

/// M2: successive draws by the importance of the point MDPs that are left; weights are the importance, renormalised.
fn without_replacement(importance: &[f64], budget: usize, seed: u64) -> Vec<Chosen> {
    let mut rng = ChaCha8Rng::seed_from_u64(derive(seed, &["sample", "without-replacement"]));
    let mut left = importance.to_vec();
    let mut drawn = Vec::with_capacity(budget);
    for _ in 0..budget {
        let Ok(distribution) = WeightedIndex::new(&left) else {
            // Only points without importance are left; they would weigh nothing.
            break;
        };
        let i = distribution.sample(&mut rng);
        left[i] = 0.0;
        drawn.push(i);
    }
    drawn.sort_unstable();
    let total: f64 = drawn.iter().map(|i| importance[*i]).sum();
    drawn.into_iter().map(|i| (i, importance[i] / total, 1)).collect()
}

/// Returns the probability of every point MDP to be among `budget` successive draws by importance without
/// replacement.
///
/// Draws one after the other have the order of independent exponential times with importance as rates, so that a point
/// MDP is in if its time is among the first `budget` ones. Here that is before the time by which `budget` are expected,
/// which is exact for large families and about 0.01 off for 20 of 164.
///
/// Source: B. Rosén, "Asymptotic theory for order sampling", Journal of Statistical Planning and Inference 62 (1997).
fn inclusion(importance: &[f64], budget: usize) -> Vec<f64> {
    let by = |time: f64| importance.iter().map(move |p| -(-p * time).exp_m1());
    let possible = importance.iter().filter(|p| **p > 0.0).count();
    if budget >= possible {
        return importance.iter().map(|p| f64::from(u8::from(*p > 0.0))).collect();
    }
    let (mut early, mut late) = (0.0, 1.0);
    while by(late).sum::<f64>() < budget as f64 {
        late *= 2.0;
    }
    for _ in 0..BISECTIONS {
        let middle = (early + late) / 2.0;
        if by(middle).sum::<f64>() < budget as f64 { early = middle } else { late = middle }
    }
    by(late).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::family::testing::city;
    use proptest::prelude::*;

    const CHOICES: [Sampling; 5] = [
        Sampling::Balanced,
        Sampling::BayesianQuadrature,
        Sampling::KMeans,
        Sampling::WithReplacement,
        Sampling::WithoutReplacement,
    ];

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn weights_sum_to_one(budget in 1usize..=164, seed in 0u64..1000, which in 0usize..5) {
            let family = city();
            let plan = choose(&family, CHOICES[which], budget, seed).unwrap();
            let sum: f64 = plan.draws.iter().map(|d| d.weight).sum();
            prop_assert!((sum - 1.0).abs() < 1e-9);
            prop_assert!(plan.draws.len() <= budget);
        }
    }

    #[test]
    fn the_whole_family_without_replacement_has_the_family_s_importance() {
        let family = city();
        let all = CHOICES.into_iter().filter(|c| *c != Sampling::WithReplacement);
        for sampling in all {
            let plan = choose(&family, sampling, 164, 5).unwrap();
            for (draw, point) in plan.draws.iter().zip(&family.points) {
                assert_eq!(draw.point, point.id);
                assert!((draw.weight - point.importance).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_same_seed_chooses_the_same_points() {
        let family = city();
        for sampling in CHOICES {
            let plan = choose(&family, sampling, 40, 3).unwrap();
            assert_eq!(plan, choose(&family, sampling, 40, 3).unwrap());
            assert_ne!(plan.draws, choose(&family, sampling, 40, 4).unwrap().draws);
        }
    }

    #[test]
    fn every_cluster_stands_for_as_many_point_mdps_as_its_draw_counts() {
        let family = city();
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
    fn the_nearest_draw_of_a_balanced_sample_stands_for_a_point_mdp() {
        let family = city();
        let plan = choose(&family, Sampling::Balanced, 20, 3).unwrap();
        let stands = stands(&family, &plan);
        let drawn: Vec<usize> =
            plan.draws.iter().filter_map(|d| family.position(&d.point)).collect();
        assert!(stands.iter().all(|s| s.is_some_and(|s| drawn.contains(&s))));
        assert!(drawn.iter().all(|d| stands[*d] == Some(*d)));
    }
}

#[cfg(test)]
mod random {
    use super::*;

    #[test]
    fn with_replacement_draws_in_proportion_to_importance() {
        let chosen = with_replacement(&[0.7, 0.3], 10_000, 1);
        assert!((chosen[0].1 - 0.7).abs() < 0.02, "{chosen:?}");
    }

    #[test]
    fn without_replacement_never_draws_a_point_twice() {
        let chosen = without_replacement(&[0.9, 0.05, 0.05], 3, 1);
        assert_eq!(chosen.iter().map(|c| c.0).collect::<Vec<_>>(), [0, 1, 2]);
    }

    #[test]
    fn probabilities_are_those_of_successive_draws() {
        let importance = [0.3, 0.2, 0.1, 0.1, 0.1, 0.05, 0.05, 0.04, 0.03, 0.03];
        let expected = inclusion(&importance, 4);
        assert!((expected.iter().sum::<f64>() - 4.0).abs() < 1e-9);
        let mut drawn = [0u32; 10];
        for seed in 0..4000 {
            without_replacement(&importance, 4, seed).iter().for_each(|c| drawn[c.0] += 1);
        }
        for (n, p) in drawn.iter().zip(&expected) {
            assert!((f64::from(*n) / 4000.0 - p).abs() < 0.05, "{drawn:?} {expected:?}");
        }
        assert_eq!(inclusion(&[0.5, 0.5, 0.0], 2), [1.0, 1.0, 0.0]);
    }
}

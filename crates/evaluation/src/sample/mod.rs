//! Which point MDPs to evaluate under a budget, and with which weight.
//!
//! Source of M1 to M3: Jayawardana et al. (NeurIPS 2022), appendix, "Evaluate DRL methods on a family of MDPs".

pub mod balanced;
mod choice;
pub mod design;
mod fit;
pub mod kmeans;
pub mod looks;
mod plan;
mod process;
pub mod quadrature;
mod random;

use std::collections::HashMap;

pub use choice::Choice;
use design::features;
pub use design::{Design, Input, Measure};
pub use plan::{Draw, Growth, Look, SampleError, SamplePlan, Sampling, Until};
pub use process::Process;
use quadrature::Quadrature;

use crate::family::MdpFamily;

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
    let chosen: Vec<random::Chosen> = match sampling {
        Sampling::All => importance.iter().enumerate().map(|(i, p)| (i, *p, 1)).collect(),
        Sampling::WithReplacement => random::with_replacement(&importance, budget, seed),
        Sampling::WithoutReplacement => {
            probabilities = Some(random::inclusion(&importance, budget));
            random::without_replacement(&importance, budget, seed)
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
    let draw = |(i, weight, count): random::Chosen| Draw {
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

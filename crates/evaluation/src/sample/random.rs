//! M1 and M2: random draws by importance.

use rand::SeedableRng;
use rand::distr::Distribution;
use rand::distr::weighted::WeightedIndex;
use rand_chacha::ChaCha8Rng;

use basics::seed::derive;

/// Halvings of the time, which leave nothing of it.
const BISECTIONS: usize = 100;

/// A drawn point MDP: its index, its weight in the estimate, how often it was drawn.
pub(super) type Chosen = (usize, f64, u32);

/// M1: `budget` independent draws by importance; a draw weighs `1 / budget`.
pub(super) fn with_replacement(importance: &[f64], budget: usize, seed: u64) -> Vec<Chosen> {
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
pub(super) fn without_replacement(importance: &[f64], budget: usize, seed: u64) -> Vec<Chosen> {
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
pub(super) fn inclusion(importance: &[f64], budget: usize) -> Vec<f64> {
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

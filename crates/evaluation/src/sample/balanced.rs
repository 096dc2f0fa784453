//! Balanced sampling: every point MDP with a probability in proportion to its importance, spread over what is known
//! of the family by the local pivotal method.
//!
//! Two neighbours decide which of them takes the probability of both, until all are 0 or 1; so close point MDPs are
//! rarely drawn together, and the sample has of every region what the family has there.
//!
//! Choices where implementations differ:
//! - A probability that would exceed 1 is 1, and what is left goes to the others in proportion.
//! - One of the undecided point MDPs is drawn, and decides with its nearest undecided neighbour (LPM2), of equally near
//!   ones a random one.
//!
//! Source: A. Grafström, N. Lundström and L. Schelin, "Spatially balanced sampling through the pivotal method",
//! Biometrics 68 (2012).

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::kmeans::squared_distance;
use basics::seed::derive;

/// How far a probability may be from 0 or 1 and count as decided.
const DECIDED: f64 = 1e-9;

/// Returns the probability of every point MDP to be in a balanced sample of this size; they sum to the size, or to the
/// number of point MDPs with importance where these are fewer.
pub fn inclusion(importance: &[f64], budget: usize) -> Vec<f64> {
    let mut probabilities = vec![0.0; importance.len()];
    let mut open: Vec<usize> = (0..importance.len()).filter(|i| importance[*i] > 0.0).collect();
    let mut left = budget.min(open.len());
    loop {
        let total: f64 = open.iter().map(|i| importance[*i]).sum();
        let of = |i: usize| left as f64 * importance[i] / total;
        let (certain, rest): (Vec<usize>, Vec<usize>) =
            open.iter().partition(|i| of(**i) >= 1.0 - DECIDED);
        if certain.is_empty() {
            rest.iter().for_each(|i| probabilities[*i] = of(*i));
            return probabilities;
        }
        certain.iter().for_each(|i| probabilities[*i] = 1.0);
        left -= certain.len();
        open = rest;
        if open.is_empty() {
            return probabilities;
        }
    }
}

/// Returns the weights of drawn point MDPs: importance by probability, summing to 1.
pub(super) fn weights(importance: &[f64], probabilities: &[f64], drawn: &[usize]) -> Vec<f64> {
    let expanded = |i: &usize| importance[*i] / probabilities[*i];
    let total: f64 = drawn.iter().map(expanded).sum();
    drawn.iter().map(|i| expanded(i) / total).collect()
}

/// Draws a sample with these probabilities, spread over the coordinates; positions in order.
///
/// # Arguments
///
/// * `probabilities` — shape `[n]`, from 0 to 1; the sample has as many point MDPs as they sum to.
/// * `coordinates` — shape `[n, d]`; distances are Euclidean.
pub fn pivotal(probabilities: &[f64], coordinates: &[Vec<f64>], seed: u64) -> Vec<usize> {
    let mut rng = ChaCha8Rng::seed_from_u64(derive(seed, &["sample", "balanced"]));
    let mut probabilities = probabilities.to_vec();
    let is_open = |p: f64| p > DECIDED && p < 1.0 - DECIDED;
    let mut open: Vec<usize> =
        (0..probabilities.len()).filter(|i| is_open(probabilities[*i])).collect();
    while open.len() > 1 {
        let a = open[rng.random_range(0..open.len())];
        let near = nearest_others(coordinates, &open, a);
        let b = near[rng.random_range(0..near.len())];
        let (pa, pb) = (probabilities[a], probabilities[b]);
        let both = pa + pb;
        let takes = if both < 1.0 {
            rng.random::<f64>() * both < pa
        } else {
            rng.random::<f64>() * (2.0 - both) < 1.0 - pb
        };
        let (high, low) = if both < 1.0 { (both, 0.0) } else { (1.0, both - 1.0) };
        (probabilities[a], probabilities[b]) = if takes { (high, low) } else { (low, high) };
        for decided in [a, b].into_iter().filter(|i| !is_open(probabilities[*i])) {
            open.retain(|other| *other != decided);
        }
    }
    if let [last] = open[..] {
        let drawn = rng.random::<f64>() < probabilities[last];
        probabilities[last] = f64::from(u8::from(drawn));
    }
    (0..probabilities.len()).filter(|i| probabilities[*i] > 0.5).collect()
}

/// Returns the open rows that are nearest to one of them, in ascending order.
fn nearest_others(rows: &[Vec<f64>], open: &[usize], to: usize) -> Vec<usize> {
    let (mut least, mut near) = (f64::INFINITY, Vec::new());
    for other in open.iter().copied().filter(|other| *other != to) {
        let distance = squared_distance(&rows[to], &rows[other]);
        if distance < least {
            least = distance;
            near.clear();
        }
        if distance == least {
            near.push(other);
        }
    }
    near
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_exceeds_one_goes_to_the_others() {
        let p = inclusion(&[0.7, 0.2, 0.1], 2);
        assert_eq!(p[0], 1.0);
        assert!((p[1] - 2.0 / 3.0).abs() < 1e-12 && (p[2] - 1.0 / 3.0).abs() < 1e-12);
        assert_eq!(inclusion(&[0.5, 0.5, 0.0], 3), [1.0, 1.0, 0.0]);
    }

    #[test]
    fn every_point_mdp_is_drawn_with_its_probability() {
        let probabilities = [0.9, 0.5, 0.2, 0.4, 0.7, 0.3];
        let rows: Vec<Vec<f64>> = (0..6).map(|i| vec![f64::from(i * i % 5)]).collect();
        let mut drawn = [0u32; 6];
        for seed in 0..4000 {
            let sample = pivotal(&probabilities, &rows, seed);
            assert_eq!(sample.len(), 3);
            sample.into_iter().for_each(|i| drawn[i] += 1);
        }
        for (n, p) in drawn.iter().zip(probabilities) {
            assert!((f64::from(*n) / 4000.0 - p).abs() < 0.03, "{drawn:?}");
        }
    }

    #[test]
    fn neighbours_are_not_drawn_together() {
        // Pairs at one place, a probability of one half each: exactly one of every pair.
        let rows: Vec<Vec<f64>> = (0..20).map(|i| vec![f64::from(i / 2)]).collect();
        for seed in 0..50 {
            let sample = pivotal(&[0.5; 20], &rows, seed);
            let places: Vec<usize> = sample.iter().map(|i| i / 2).collect();
            assert_eq!(places, (0..10).collect::<Vec<_>>());
        }
    }

    proptest! {
        #[test]
        fn probabilities_sum_to_the_budget_and_follow_importance(
            importance in prop::collection::vec(0.01f64..1.0, 1..40), budget in 1usize..40,
        ) {
            let budget = budget.min(importance.len());
            let p = inclusion(&importance, budget);
            prop_assert!((p.iter().sum::<f64>() - budget as f64).abs() < 1e-6);
            for (i, j) in (0..p.len()).flat_map(|i| (0..i).map(move |j| (i, j))) {
                let (less, more) = if importance[i] <= importance[j] { (i, j) } else { (j, i) };
                prop_assert!(p[less] <= p[more] + 1e-9);
            }
            let rows: Vec<Vec<f64>> = importance.iter().map(|x| vec![*x]).collect();
            prop_assert_eq!(pivotal(&p, &rows, 3).len(), budget);
        }
    }
}

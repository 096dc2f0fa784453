//! How likely each method takes each place.
//!
//! In every resample the methods are ordered by what they would have scored there; a probability is the share of resamples
//! in which a method takes a place. Methods that are equal share the places that they take together.
//!
//! Source: R. Agarwal et al., "Deep reinforcement learning at the edge of the statistical precipice", NeurIPS 2021, appendix
//! ("rank comparisons").
//!
//! Deviation: the resamples are paired, so that all methods meet the same draw of point MDPs and seeds in each; there they
//! are drawn method by method. What the methods met together then changes no place.

use super::Direction;

/// Returns the probability of every place for every method, shape `[methods, methods]`: rows are methods, columns places,
/// the best first; `None` without resamples, or where methods have differently many.
///
/// # Arguments
///
/// * `resamples` — shape `[methods, resamples]`; equal positions are of the same draw.
///
/// # Examples
///
/// ```
/// # use tsc_family_evaluation::stats::{Direction, ranks::rank_probabilities};
/// let probabilities = rank_probabilities(&[&[1.0, 2.0], &[3.0, 2.0]], Direction::Lower);
/// assert_eq!(probabilities, Some(vec![vec![0.75, 0.25], vec![0.25, 0.75]]));
/// ```
pub fn rank_probabilities(resamples: &[&[f64]], direction: Direction) -> Option<Vec<Vec<f64>>> {
    let (methods, count) = (resamples.len(), resamples.first()?.len());
    if count == 0 || resamples.iter().any(|r| r.len() != count) {
        return None;
    }
    let mut sums = vec![vec![0.0; methods]; methods];
    let mut order: Vec<usize> = (0..methods).collect();
    let draws = (0..count).map(|draw| resamples.iter().map(|r| r[draw]).collect::<Vec<f64>>());
    for values in draws {
        let value = |m: usize| values[m];
        order.sort_by(|a, b| direction.compare(value(*a), value(*b)).then(a.cmp(b)));
        let mut place = 0;
        for tied in order.chunk_by(|a, b| value(*a) == value(*b)) {
            for m in tied {
                let share = 1.0 / tied.len() as f64;
                sums[*m][place..place + tied.len()].iter_mut().for_each(|sum| *sum += share);
            }
            place += tied.len();
        }
    }
    sums.iter_mut().flatten().for_each(|sum| *sum /= count as f64);
    Some(sums)
}

/// Returns the probability that the first method is the best, as [`rank_probabilities`] has it, without ordering the others.
///
/// # Arguments
///
/// * `resamples` — shape `[methods, resamples]`; equal positions are of the same draw.
pub fn probability_of_first(resamples: &[&[f64]], direction: Direction) -> Option<f64> {
    let (first, others) = resamples.split_first()?;
    if first.is_empty() || others.iter().any(|r| r.len() != first.len()) {
        return None;
    }
    let share = |(draw, own): (usize, &f64)| {
        let values = || others.iter().map(|r| r[draw]);
        let is_best = values().all(|other| direction.compare(*own, other).is_le() || *own == other);
        if is_best { 1.0 / (1 + values().filter(|other| other == own).count()) as f64 } else { 0.0 }
    };
    let sum = first.iter().enumerate().map(share).fold(0.0, |sum, share| sum + share);
    Some(sum / first.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn equal_methods_share_their_places() {
        let p = rank_probabilities(&[&[1.0], &[1.0], &[0.5]], Direction::Lower).unwrap();
        assert_eq!(p, [[0.0, 0.5, 0.5], [0.0, 0.5, 0.5], [1.0, 0.0, 0.0]]);
    }

    proptest! {
        #[test]
        fn places_and_methods_sum_to_one(
            table in prop::collection::vec(prop::collection::vec((0u8..5).prop_map(f64::from), 7), 1..6),
        ) {
            let rows: Vec<&[f64]> = table.iter().map(Vec::as_slice).collect();
            let p = rank_probabilities(&rows, Direction::Lower).unwrap();
            prop_assert_eq!(probability_of_first(&rows, Direction::Lower), Some(p[0][0]));
            for i in 0..rows.len() {
                prop_assert!((p[i].iter().sum::<f64>() - 1.0).abs() < 1e-9);
                prop_assert!((p.iter().map(|row| row[i]).sum::<f64>() - 1.0).abs() < 1e-9);
            }
        }
    }
}

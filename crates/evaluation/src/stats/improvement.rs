//! Probability of improvement: how likely a run of one method is better than a run of another, where it happens.
//!
//! On one point MDP it is the share of pairs of runs, one of each method, of which the first is better, a tie
//! counting half: the statistic of Mann and Whitney divided by the number of pairs. Over the family it is the mean
//! of these. It says how often, not by how much: a method with a probability of 0.9 can have the worse score.
//!
//! Source: R. Agarwal et al., "Deep reinforcement learning at the edge of the statistical precipice", NeurIPS 2021;
//! their library rliable 1.2.0, `metrics.probability_of_improvement`.
//!
//! Deviations:
//! - The mean over point MDPs weighs them by importance; rliable's tasks weigh the same.
//! - A run is an evaluation episode, of each training where there are several; rliable's is a training.
//! - Less may be better: [`Direction`]. rliable's scores are better when they are higher.

use super::Direction;
use super::score::mean;

/// Returns the share of pairs of runs in which the first method's is better, ties counting half; `None` where a
/// method has none.
///
/// # Arguments
///
/// * `x`, `y` — shape `[runs]` each, not necessarily equally many; objectives, or scores against the same divisor.
///
/// # Examples
///
/// ```
/// # use tsc_family_evaluation::stats::{Direction, improvement::share_better};
/// assert_eq!(share_better(&[1.0, 3.0], &[2.0, 3.0], Direction::Lower), Some(0.625));
/// ```
pub fn share_better(x: &[f64], y: &[f64], direction: Direction) -> Option<f64> {
    let shares: Vec<f64> = x.iter().map(|run| placement(*run, y, direction)).collect();
    if y.is_empty() { None } else { mean(&shares) }
}

/// Returns a value per training and seed whose mean is [`share_better`] and whose spread is that of the latter, so
/// that resampling seeds resamples the runs of both methods.
///
/// A run's value is its own share of wins, plus the share of wins against the other method's run on the same seed, less
/// the mean: the first-order terms of the statistic (Hoeffding's projection). Where the methods have
/// differently many trainings, those of the one that has fewer are averaged.
///
/// # Arguments
///
/// * `x`, `y` — shape `[trainings, seeds]` each, on the same seeds.
///
/// Source: E. DeLong, D. DeLong and D. Clarke-Pearson, "Comparing the areas under two or more correlated receiver
/// operating characteristic curves", Biometrics 44 (1988).
pub fn placements(x: &[Vec<f64>], y: &[Vec<f64>], direction: Direction) -> Vec<Vec<f64>> {
    let (all_x, all_y) = (x.concat(), y.concat());
    let Some(whole) = share_better(&all_x, &all_y, direction) else { return Vec::new() };
    let of = |runs: &[Vec<f64>], wins: &dyn Fn(f64) -> f64| -> Vec<Vec<f64>> {
        runs.iter().map(|seeds| seeds.iter().map(|run| wins(*run)).collect()).collect()
    };
    let own = of(x, &|run| placement(run, &all_y, direction));
    let other = of(y, &|run| 1.0 - placement(run, &all_x, direction));
    combined(&own, &other, |own, other| own + other - whole)
}

/// Returns by how much `x` is better than `y` per training and seed, paired as [`placements`] are; negative where it is
/// worse.
pub fn ahead(x: &[Vec<f64>], y: &[Vec<f64>], direction: Direction) -> Vec<Vec<f64>> {
    match direction {
        Direction::Lower => differences(y, x),
        Direction::Higher => differences(x, y),
    }
}

/// Returns the differences `x - y` per training and seed, paired as [`placements`] are.
pub fn differences(x: &[Vec<f64>], y: &[Vec<f64>]) -> Vec<Vec<f64>> {
    combined(x, y, |x, y| x - y)
}

fn placement(run: f64, others: &[f64], direction: Direction) -> f64 {
    let won = |other: &f64| match run == *other {
        true => 0.5,
        false => f64::from(u8::from(direction.is_worse(*other, run))),
    };
    others.iter().map(won).sum::<f64>() / others.len() as f64
}

/// Combines two tables training by training; that with fewer trainings is averaged over them where the numbers differ.
fn combined(x: &[Vec<f64>], y: &[Vec<f64>], of: impl Fn(f64, f64) -> f64) -> Vec<Vec<f64>> {
    let trainings = x.len().max(y.len());
    let (x, y) = (averaged(x, trainings), averaged(y, trainings));
    x.iter().zip(&y).map(|(x, y)| x.iter().zip(y).map(|(x, y)| of(*x, *y)).collect()).collect()
}

fn averaged(table: &[Vec<f64>], trainings: usize) -> Vec<Vec<f64>> {
    if table.len() == trainings {
        return table.to_vec();
    }
    let seeds = table.iter().map(Vec::len).min().unwrap_or(0);
    let of_seed = |k: usize| table.iter().map(|runs| runs[k]).sum::<f64>() / table.len() as f64;
    vec![(0..seeds).map(of_seed).collect(); trainings]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ties_count_half_and_the_direction_turns_it_round() {
        let (x, y) = ([1.0, 3.0], [2.0, 3.0]);
        assert_eq!(share_better(&x, &y, Direction::Lower), Some(0.625));
        assert_eq!(share_better(&x, &y, Direction::Higher), Some(0.375));
        assert_eq!(share_better(&x, &[], Direction::Lower), None);
        assert_eq!(share_better(&[], &y, Direction::Lower), None);
    }

    #[test]
    fn the_method_with_fewer_trainings_is_averaged() {
        let (two, one) = (vec![vec![5.0, 7.0], vec![9.0, 11.0]], vec![vec![1.0, 2.0]]);
        assert_eq!(differences(&two, &one), [[4.0, 5.0], [8.0, 9.0]]);
        let three = vec![vec![1.0, 1.0]; 3];
        assert_eq!(differences(&two, &three), [[6.0, 8.0]; 3]);
    }

    fn table() -> impl Strategy<Value = Vec<Vec<f64>>> {
        let run = (0u8..9).prop_map(f64::from);
        prop::collection::vec(prop::collection::vec(run, 4), 1..4)
    }

    proptest! {
        #[test]
        fn the_mean_of_the_placements_is_the_probability(x in table(), y in table()) {
            let values = placements(&x, &y, Direction::Lower).concat();
            let whole = share_better(&x.concat(), &y.concat(), Direction::Lower).unwrap();
            prop_assert!((mean(&values).unwrap() - whole).abs() < 1e-9);
        }

        #[test]
        fn the_two_probabilities_of_a_pair_sum_to_one(x in table(), y in table()) {
            let p = |a: &[Vec<f64>], b: &[Vec<f64>]| share_better(&a.concat(), &b.concat(), Direction::Higher);
            prop_assert!((p(&x, &y).unwrap() + p(&y, &x).unwrap() - 1.0).abs() < 1e-12);
        }
    }
}

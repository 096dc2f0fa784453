//! The whole family: every point MDP with its importance.
//!
//! Only the noise of seeds and trainings remains. Where results are missing, those that are there are taken for a random
//! part of the family. What trainings that were not repeated could have given otherwise, neighbours tell
//! ([`Sample::learned_once`]).

use super::balanced::NEIGHBOURS;
use super::contract::Sample;
use super::neighbours::local_means;
use crate::stats::{PointObjectives, Resampling};

/// Returns how what is left unknown of a whole family is drawn anew.
pub(super) fn resampling(sample: Sample<'_>, scores: &[PointObjectives]) -> Resampling {
    let weights: Vec<f64> = scores.iter().map(|p| p.weight).collect();
    let share = scores.len() as f64 / sample.family_size.max(1) as f64;
    let inclusion = vec![sample.fixed(share); scores.len()];
    if sample.learned_once {
        let contrasts = local_means(sample.points, &weights, &inclusion, NEIGHBOURS);
        Resampling::of(contrasts, scores.len() as f64 - 1.0)
    } else {
        Resampling::distinct(&weights, &inclusion)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::contract::{Chosen, Estimate, Estimator};
    use super::*;
    use crate::stats::{Direction, degrees, improvement};

    const FAMILY: usize = 60;

    /// Scores that follow a feature, each with the luck of one training: one in ten goes wrong.
    fn trained(rng: &mut ChaCha8Rng) -> Vec<PointObjectives> {
        let of = |i: usize| {
            let luck = if rng.random::<f64>() < 0.1 { 1.0 } else { 0.0 };
            let score = 0.5 + i as f64 / FAMILY as f64 + luck;
            let method = vec![vec![10.0 * score, 10.1 * score]];
            PointObjectives { weight: 1.0, draws: 1, method, baseline: vec![10.0, 10.1] }
        };
        (0..FAMILY).map(of).collect()
    }

    /// Returns the estimate of a whole family, whose intervals may miss with this probability.
    fn whole(objectives: &[PointObjectives], alpha: f64) -> Estimate {
        let sample = Sample {
            family_size: FAMILY,
            chosen: FAMILY,
            method: 0,
            name: "m",
            learned_once: false,
            points: &[],
            design: None,
            resamples: 400,
            alpha,
        };
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        Estimator::Whole.estimate(sample, objectives, &mut rng).unwrap()
    }

    /// Of 100 intervals, how many hold the mean over all trainings that there could be.
    fn held(learned_once: bool) -> usize {
        let truth = 0.5 + (FAMILY as f64 - 1.0) / 2.0 / FAMILY as f64 + 0.1;
        let at = |i: usize| Chosen { count: 1, at: vec![i as f64], ..Chosen::default() };
        let points: Vec<Chosen> = (0..FAMILY).map(at).collect();
        let sample = Sample {
            family_size: FAMILY,
            chosen: FAMILY,
            method: 0,
            name: "m",
            learned_once,
            points: &points,
            design: None,
            resamples: 400,
            alpha: 0.05,
        };
        let mut luck = ChaCha8Rng::seed_from_u64(5);
        let holds = |_: &u64| {
            let scores = trained(&mut luck);
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            let e = Estimator::Whole.estimate(sample, &scores, &mut rng).unwrap();
            e.interval.is_some_and(|(low, high)| low <= truth && truth <= high)
        };
        (0..100u64).filter(holds).count()
    }

    #[test]
    fn the_interval_of_a_whole_family_holds_what_other_trainings_would_give() {
        let (without, with) = (held(false), held(true));
        assert!(without < 30 && (90..=100).contains(&with), "{without} and {with} of 100");
    }

    #[test]
    fn without_replicates_the_difference_of_means_is_the_mean_of_differences() {
        let mut luck = ChaCha8Rng::seed_from_u64(9);
        let mut measured = |level: f64| -> Vec<PointObjectives> {
            let noisy = |luck: &mut ChaCha8Rng, of: f64| of * (0.8 + 0.4 * luck.random::<f64>());
            let on = |i: usize| PointObjectives {
                weight: 1.0 + (i % 7) as f64,
                draws: 1,
                method: vec![(0..5).map(|_| noisy(&mut luck, level + i as f64)).collect()],
                baseline: (0..5).map(|seed| 60.0 + (i * seed) as f64).collect(),
            };
            (0..FAMILY).map(on).collect()
        };
        let (x, y) = (measured(20.0), measured(24.0));
        let differences: Vec<PointObjectives> = (x.iter().zip(&y))
            .map(|(x, y)| PointObjectives {
                method: improvement::differences(&y.method, &x.method),
                ..x.clone()
            })
            .collect();
        let direct = whole(&differences, 0.05);
        let apart = whole(&x, 0.05).ahead(&whole(&y, 0.05), Direction::Lower);
        let apart = apart.with_degrees(degrees(&differences));
        let ends = |e: &Estimate| {
            let (low, high) = e.interval.unwrap();
            [low, e.value, high]
        };
        assert!(ends(&direct)[0] < ends(&direct)[2]);
        for (a, b) in ends(&direct).into_iter().zip(ends(&apart)) {
            assert!((a - b).abs() < 1e-12, "{direct:?} {apart:?}");
        }
    }
}

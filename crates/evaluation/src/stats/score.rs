//! The score of a method on one point MDP and its overall performance on a family.
//!
//! Source: Jayawardana et al. (NeurIPS 2022), section 3 and Definition 1.

use super::StatsError;

/// How far importance may be from 1 in total.
const IMPORTANCE_TOLERANCE: f64 = 1e-9;

/// Returns the score of a method on one point MDP: its mean objective divided by the baseline's on
/// the same evaluation seeds.
///
/// # Arguments
///
/// * `method`, `baseline` — shape `[seeds]`; objective per evaluation seed, same order, lower is
///   better.
///
/// # Errors
///
/// [`StatsError::Length`] if the shapes differ, [`StatsError::Empty`] without a seed,
/// [`StatsError::Value`] if a mean is not finite or the baseline's is not above 0.
///
/// # Examples
///
/// ```
/// # use tsc_family_evaluation::stats::score;
/// assert_eq!(score(&[10.0, 20.0], &[30.0, 30.0])?, 0.5);
/// # Ok::<(), tsc_family_evaluation::stats::StatsError>(())
/// ```
pub fn score(method: &[f64], baseline: &[f64]) -> Result<f64, StatsError> {
    if method.len() != baseline.len() {
        let (left, right) = (method.len(), baseline.len());
        return Err(StatsError::Length { what: "method and baseline", left, right });
    }
    let top = mean(method).ok_or(StatsError::Empty("method"))?;
    let bottom = mean(baseline).ok_or(StatsError::Empty("baseline"))?;
    if !top.is_finite() {
        let expected = "a finite number";
        return Err(StatsError::Value { what: "the method's mean", value: top, expected });
    }
    if !(bottom.is_finite() && bottom > 0.0) {
        let expected = "a number above 0, for it is what scores are divided by";
        return Err(StatsError::Value { what: "the baseline's mean", value: bottom, expected });
    }
    Ok(top / bottom)
}

/// Returns the overall performance `E = sum_i s_i p_i` of one method on the whole family.
///
/// # Arguments
///
/// * `scores` — shape `[M]`; normalised objective per point MDP, dimensionless, where 1.0 is the
///   baseline and **lower is better**.
/// * `importance` — shape `[M]`; probability of each point MDP, same order, sums to 1.
///
/// # Errors
///
/// [`StatsError::Length`] if the shapes differ, [`StatsError::NotADistribution`] if `importance`
/// does not sum to 1 within 1e-9.
///
/// # Examples
///
/// ```
/// # use tsc_family_evaluation::stats::overall_performance;
/// let e = overall_performance(&[0.5, 2.0], &[0.75, 0.25])?;
/// assert!((e - 0.875).abs() < 1e-12);
/// # Ok::<(), tsc_family_evaluation::stats::StatsError>(())
/// ```
///
/// Source: Jayawardana et al. (NeurIPS 2022), Definition 1.
pub fn overall_performance(scores: &[f64], importance: &[f64]) -> Result<f64, StatsError> {
    if scores.len() != importance.len() {
        let (left, right) = (scores.len(), importance.len());
        return Err(StatsError::Length { what: "scores and importance", left, right });
    }
    let sum: f64 = importance.iter().sum();
    if (sum - 1.0).abs() > IMPORTANCE_TOLERANCE || sum.is_nan() {
        return Err(StatsError::NotADistribution(sum));
    }
    Ok(scores.iter().zip(importance).map(|(s, p)| s * p).sum())
}

/// Returns the mean, `None` of nothing.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Returns `sum w x / sum w` over pairs `(weight, value)`, `None` when the weights sum to 0.
pub fn weighted_mean(pairs: impl IntoIterator<Item = (f64, f64)>) -> Option<f64> {
    let (top, bottom) =
        pairs.into_iter().fold((0.0, 0.0), |(top, bottom), (w, x)| (top + w * x, bottom + w));
    (bottom > 0.0).then(|| top / bottom)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_score_divides_means_not_seeds() {
        assert_eq!(score(&[10.0, 50.0], &[10.0, 20.0]), Ok(2.0));
    }

    #[test]
    fn a_baseline_without_delay_has_no_score() {
        let e = score(&[1.0], &[0.0]).unwrap_err();
        assert_eq!(
            e.to_string(),
            "the baseline's mean is 0; expected a number above 0, for it is what scores are \
             divided by"
        );
    }

    #[test]
    fn importance_must_sum_to_one() {
        let e = overall_performance(&[1.0], &[0.5]).unwrap_err();
        assert_eq!(e, StatsError::NotADistribution(0.5));
    }

    #[test]
    fn a_weighted_mean_of_nothing_is_none() {
        assert_eq!(weighted_mean([]), None);
        assert_eq!(weighted_mean([(1.0, 2.0), (3.0, 6.0)]), Some(5.0));
    }

    fn family() -> impl Strategy<Value = Vec<(f64, f64)>> {
        prop::collection::vec((0.01f64..50.0, 0.01f64..1.0), 1..60)
    }

    fn overall(pairs: &[(f64, f64)]) -> f64 {
        let total: f64 = pairs.iter().map(|p| p.1).sum();
        let scores: Vec<f64> = pairs.iter().map(|p| p.0).collect();
        let importance: Vec<f64> = pairs.iter().map(|p| p.1 / total).collect();
        overall_performance(&scores, &importance).unwrap()
    }

    proptest! {
        #[test]
        fn overall_performance_lies_between_the_best_and_the_worst_score(pairs in family()) {
            let e = overall(&pairs);
            let best = pairs.iter().map(|p| p.0).fold(f64::INFINITY, f64::min);
            let worst = pairs.iter().map(|p| p.0).fold(0.0, f64::max);
            prop_assert!(best - 1e-9 <= e && e <= worst + 1e-9);
        }

        #[test]
        fn a_permutation_changes_nothing(pairs in family(), by in 0usize..60) {
            let mut other = pairs.clone();
            other.rotate_left(by % pairs.len());
            prop_assert!((overall(&pairs) - overall(&other)).abs() < 1e-9);
        }
    }
}

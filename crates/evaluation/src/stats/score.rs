//! The score of a method on one point MDP, and the means that overall performances are.
//!
//! Source: Jayawardana et al. (NeurIPS 2022), section 3 and Definition 1.

use super::StatsError;

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
}

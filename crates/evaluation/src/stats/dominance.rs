//! First-order stochastic dominance of one method over another: better at every threshold, not only on average.
//!
//! A method dominates another when its performance profile is nowhere below the other's and somewhere above it; whoever
//! prefers better scores then prefers it, whatever a score is worth to them. It is a statement on two distributions: on
//! a single point MDP the other may still be better.
//!
//! The test is for either direction: "this one is nowhere behind" is rejected when it is behind somewhere by more than chance
//! makes of none. At every threshold a p-value is the share of resamples whose deviation is at least the distance seen; the
//! smallest of them is compared with the smallest that each resample has, so that there may be many thresholds
//! (Westfall and Young). As in Barrett and Donald, one is said to dominate when it is not rejected that it is nowhere behind,
//! and rejected that the other is nowhere behind; none, when both are rejected; it is open when neither is.
//!
//! Source: G. Barrett and S. Donald, "Consistent tests for stochastic dominance", Econometrica 71 (2003), 71-104;
//! P. Westfall and S. Young, "Resampling-based multiple testing", 1993.
//!
//! Deviations:
//! - Barrett and Donald compare the largest distance, whatever its noise is at its threshold. Where profiles are steep they are noisy,
//!   and a crossing that is certain elsewhere would be lost in that; so p-values are compared instead.
//! - Deviations are from the mean of the resamples, not from the estimate. Noise within point MDPs widens every
//!   profile; resamples have it once more than the estimate, and that shift is not spread.

use super::score::mean;

/// By how much rounding may part equal shares.
const ROUNDING: f64 = 1e-12;

/// What profiles say of two methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The first dominates.
    First,
    /// The second dominates.
    Second,
    /// Each is ahead somewhere.
    Neither,
    /// Either could dominate, or none, or they are equal.
    Open,
}

/// Two profiles compared at all thresholds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dominance {
    /// What they say.
    pub verdict: Verdict,
    /// The most by which the first is ahead of the second at some threshold, and the second of the first; shares of
    /// the family.
    pub ahead: (f64, f64),
    /// Of the hypotheses that the first is nowhere behind, and that the second is; `None` without resamples.
    pub p: Option<(f64, f64)>,
}

/// Compares two profiles.
///
/// # Arguments
///
/// * `first`, `second` — shape `[thresholds]`; shares with a better score, as
///   [`super::profile::share_beyond`] gives them.
/// * `alpha` — "nowhere behind" is rejected where its p-value is below it, such as 0.05.
/// * `tested` — the distances `first - second` at those thresholds that are tested, which need not be all, each with
///   its resamples. Empty where there are none.
pub fn dominance(
    first: &[f64],
    second: &[f64],
    tested: &[(f64, Vec<f64>)],
    alpha: f64,
) -> Dominance {
    let most =
        |sign: f64| first.iter().zip(second).map(|(a, b)| sign * (a - b)).fold(0.0, f64::max);
    let ahead = (most(1.0), most(-1.0));
    let p = p_value(tested, -1.0).zip(p_value(tested, 1.0));
    // Without resamples what was seen is taken for what is.
    let rejected = match p {
        Some((first, second)) => (first < alpha, second < alpha),
        None => (ahead.1 > ROUNDING, ahead.0 > ROUNDING),
    };
    let verdict = match rejected {
        (false, true) => Verdict::First,
        (true, false) => Verdict::Second,
        (true, true) => Verdict::Neither,
        (false, false) => Verdict::Open,
    };
    Dominance { verdict, ahead, p }
}

/// Returns the p-value of the largest evidence that a distance is above 0 somewhere, distances and resamples times the sign; 1
/// where none is. `None` without resamples, or with differently many at different thresholds.
fn p_value(tested: &[(f64, Vec<f64>)], sign: f64) -> Option<f64> {
    let count = tested.first()?.1.len();
    if count == 0 || tested.iter().any(|(_, r)| r.len() != count) {
        return None;
    }
    let mut seen = 1.0;
    let mut by_chance = vec![1.0; count];
    for (distance, resamples) in tested {
        let middle = mean(resamples)?;
        let deviations: Vec<f64> = resamples.iter().map(|r| sign * (r - middle)).collect();
        let mut sorted = deviations.clone();
        sorted.sort_by(f64::total_cmp);
        let reached = |least: f64| {
            let below = sorted.partition_point(|d| *d < least - ROUNDING);
            (count - below) as f64 / count as f64
        };
        if sign * distance > ROUNDING {
            seen = f64::min(seen, reached(sign * distance));
        }
        for (least, deviation) in by_chance.iter_mut().zip(&deviations) {
            *least = f64::min(*least, reached(*deviation));
        }
    }
    if seen >= 1.0 {
        return Some(1.0);
    }
    let as_small = by_chance.iter().filter(|p| **p <= seen).count();
    Some(as_small as f64 / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::quantile::ALPHA;

    /// Resampled distances: the distance and a noise that is the same at all thresholds, its mean shifted.
    fn noisy(distances: &[f64], spread: f64, shift: f64) -> Vec<(f64, Vec<f64>)> {
        let noise = |i: i32| shift + spread * f64::from(i) / 100.0;
        distances.iter().map(|d| (*d, (-100..=100).map(|i| d + noise(i)).collect())).collect()
    }

    #[test]
    fn without_resamples_the_profiles_decide() {
        let verdict = |a: &[f64], b: &[f64]| dominance(a, b, &[], ALPHA).verdict;
        assert_eq!(verdict(&[0.0, 0.5, 1.0], &[0.0, 0.3, 1.0]), Verdict::First);
        assert_eq!(verdict(&[0.0, 0.3, 1.0], &[0.0, 0.5, 1.0]), Verdict::Second);
        assert_eq!(verdict(&[0.2, 0.3], &[0.1, 0.5]), Verdict::Neither);
        assert_eq!(verdict(&[0.2, 0.3], &[0.2, 0.3]), Verdict::Open);
    }

    #[test]
    fn a_lead_within_the_noise_is_open_and_one_beyond_it_is_not() {
        let (a, b) = ([0.2, 0.6], [0.2, 0.3]);
        let sure = dominance(&a, &b, &noisy(&[0.0, 0.3], 0.1, 0.0), ALPHA);
        assert_eq!((sure.verdict, sure.p), (Verdict::First, Some((1.0, 0.0))));
        let open = dominance(&a, &b, &noisy(&[0.0, 0.3], 0.9, 0.0), ALPHA);
        assert_eq!(open.verdict, Verdict::Open);
    }

    #[test]
    fn being_behind_within_the_noise_does_not_prevent_dominance() {
        let (a, b) = ([0.2, 0.6], [0.22, 0.3]);
        let d = dominance(&a, &b, &noisy(&[-0.02, 0.3], 0.1, 0.0), ALPHA);
        assert_eq!(d.verdict, Verdict::First);
        assert!((d.ahead.1 - 0.02).abs() < 1e-12 && d.p.unwrap().0 > 0.05);
        let none = dominance(&a, &b, &noisy(&[-0.02, 0.3], 0.01, 0.0), ALPHA);
        assert_eq!(none.verdict, Verdict::Neither);
    }

    #[test]
    fn a_shift_of_all_resamples_is_no_spread() {
        let (a, b) = ([0.2, 0.6], [0.2, 0.3]);
        let d = dominance(&a, &b, &noisy(&[0.0, 0.3], 0.1, 0.4), ALPHA);
        assert_eq!(d.verdict, Verdict::First);
    }

    #[test]
    fn a_crossing_that_is_certain_is_not_lost_in_the_noise_of_another_threshold() {
        // Behind by a quarter of the family in every resample, ahead by three quarters in most of them.
        let (a, b) = ([0.0, 1.0], [0.25, 0.25]);
        let mut tested = noisy(&[-0.25], 0.0, 0.0);
        tested.extend(noisy(&[0.75], 0.7, 0.0));
        let d = dominance(&a, &b, &tested, ALPHA);
        assert_eq!((d.verdict, d.p), (Verdict::Neither, Some((0.0, 0.0))));
    }

    #[test]
    fn resamples_of_unequal_length_are_none() {
        assert_eq!(dominance(&[0.2], &[0.1], &[(0.1, vec![0.1]), (0.1, vec![])], ALPHA).p, None);
    }
}

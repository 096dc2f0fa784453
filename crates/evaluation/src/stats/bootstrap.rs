//! Percentile bootstrap intervals for the overall performance of a method and for other summaries.
//!
//! A summary is a function of the point MDPs' weights and means, first of all
//! `E = sum_i w_i s_i / sum_i w_i` over the evaluated point MDPs, with
//! `s_i = mean over seeds of the method / mean over the same seeds of the baseline` and the method
//! averaged over its replicates first. One resample does this:
//!
//! 1. **Seeds.** Within every point MDP the evaluation seeds are drawn anew, the same draw for
//!    method, replicates and baseline, because they met the same vehicles.
//! 2. **Replicates.** Where a method was trained more than once on a point MDP, its replicates are
//!    drawn anew, independently of the seeds and of other methods' replicates.
//! 3. **Point MDPs.** When they are a sample of the family, their weights are moved as the sampling design would
//!    have drawn others, see [`Resampling`]. With `W` the estimate after steps 1 and 2 and `B` the one after step 3,
//!    the resample is `W + f (B - W)`, where `f` makes up for small steps and few degrees of freedom.
//!
//! Choices where implementations differ:
//! - **Resample size** of seeds and replicates is `n - 1` of `n`, not `n`: the variance of a mean
//!   is then unbiased, which matters with five seeds (McCarthy and Snowden, 1985). A group of one
//!   is kept as it is.
//! - **Interval** of a mean: the 2.5% and 97.5% quantile of the resamples, linearly interpolated, moved so that the mean of
//!   the resamples is the estimate, and of a whole family stretched for few seeds ([`super::stretch`]). Resampled
//!   denominators are noisier than those of the estimate and make quotients larger, which percentiles would count twice.
//!
//! Limits:
//! - Representatives of k-means clusters are no random sample, see [`crate::analysis::estimator`].
//! - Step 3 contains the simulation noise once more, so that intervals of small samples are
//!   slightly wide.
//! - With one seed the noise between simulations, with one replicate the noise between trainings
//!   cannot be seen and is not covered.
//! - Step 3 holds for statistics that are nearly linear in the weights; for a median over few point MDPs it is rough.
//!
//! Source: B. Efron and R. Tibshirani, "An Introduction to the Bootstrap", 1993, chapter 13;
//! P. McCarthy and C. Snowden, "The bootstrap and finite population sampling", Vital and Health
//! Statistics 2 (95), 1985.

use rand_chacha::ChaCha8Rng;

use super::quantile::{ALPHA, central, shift};
use super::resamples::resample;
use super::summary::{Statistics, only_mean};
use super::{PointMeans, PointObjectives, Resampling, StatsError};

/// Resamples of an interval; 2000 leave the ends of a 95% interval accurate to a few per cent of its
/// width (Efron and Tibshirani advise at least 1000), and to less where one seed makes most of the variance.
pub const RESAMPLES: usize = 2000;

/// An estimate and what it could have been.
#[derive(Debug, Clone, PartialEq)]
pub struct Bootstrap {
    /// The estimate from all data.
    pub estimate: f64,
    /// Estimates from resampled data; empty when the spread cannot be estimated.
    pub resamples: Vec<f64>,
}

impl Bootstrap {
    /// Returns the 95% interval; `None` when there is only one seed per point MDP of a complete
    /// family, or only one draw.
    pub fn interval(&self) -> Option<(f64, f64)> {
        central(&self.resamples, ALPHA)
    }

    /// Returns the same with resamples whose mean is the estimate.
    pub fn centred(mut self) -> Self {
        let shift = shift(self.estimate, &self.resamples).unwrap_or_default();
        self.resamples.iter_mut().for_each(|r| *r -= shift);
        self
    }

    /// Returns the same with every resample further from the estimate by a factor of its own.
    pub fn stretched(mut self, by: &[f64]) -> Self {
        let estimate = self.estimate;
        self.resamples.iter_mut().zip(by).for_each(|(r, by)| *r = estimate + by * (*r - estimate));
        self
    }

    /// Returns `other - self` with its 95% interval, resample by resample, which is much narrower
    /// than the two intervals suggest: both methods met the same vehicles.
    ///
    /// Only meaningful for the same point MDPs and seeds and equally seeded generators.
    pub fn difference(&self, other: &Self) -> Self {
        let resamples = self.resamples.iter().zip(&other.resamples).map(|(a, b)| b - a).collect();
        Self { estimate: other.estimate - self.estimate, resamples }
    }
}

/// Estimates the overall performance of a method and resamples it [`RESAMPLES`] times.
///
/// # Arguments
///
/// Those of [`bootstrap_all`].
///
/// # Errors
///
/// [`StatsError`] without points, for weights that sum to 0, and where a score is undefined.
pub fn bootstrap(
    points: &[PointObjectives],
    resampling: &Resampling,
    rng: &ChaCha8Rng,
    trainings: u64,
) -> Result<Bootstrap, StatsError> {
    let count = (trainings, RESAMPLES);
    let mut all = bootstrap_all(points, resampling, &mut rng.clone(), count, &only_mean())?;
    all.pop().flatten().ok_or(StatsError::Empty("the list of point MDPs with a weight"))
}

/// Estimates statistics over point MDPs and resamples all of them `count` times, each from the same draws.
///
/// Returns one entry per statistic, `None` where it is undefined on all data, such as the mean of a
/// regime that no point MDP is in. Resamples on which a statistic is undefined are left out.
///
/// # Arguments
///
/// * `points` — the evaluated point MDPs; their weights need not sum to 1, so that an estimate
///   without the missing ones is over those that are there.
/// * `rng` — the source of randomness. Two calls with equally seeded generators, the same point
///   MDPs and the same seeds draw the same points and seeds, which [`Bootstrap::difference`] relies
///   on.
/// * `trainings` — tells methods apart: the same generator draws other replicates for another
///   number, because the trainings of two methods have nothing in common.
/// * `count` — number of resamples.
/// * `statistics` — functions of the means per point MDP; [`PointMeans::point`] is the position in
///   `points`.
///
/// # Errors
///
/// [`StatsError`] where a score is undefined.
pub fn bootstrap_all(
    points: &[PointObjectives],
    resampling: &Resampling,
    rng: &mut ChaCha8Rng,
    (trainings, count): (u64, usize),
    statistics: &dyn Statistics,
) -> Result<Vec<Option<Bootstrap>>, StatsError> {
    let whole = means(points)?;
    let mut values = Vec::new();
    statistics.values(&whole, &mut values);
    let estimate = |value: &Option<f64>| {
        Some(Bootstrap { estimate: (*value)?, resamples: Vec::with_capacity(count) })
    };
    let mut all: Vec<Option<Bootstrap>> = values.iter().map(estimate).collect();
    let mut of_moved = Vec::new();
    resample((points, &whole), resampling, rng, trainings, count, &mut |within, moved, factor| {
        values.clear();
        statistics.values(within, &mut values);
        of_moved.clear();
        if let Some(moved) = moved {
            statistics.values(moved, &mut of_moved);
        }
        for (i, bootstrap) in all.iter_mut().enumerate() {
            let Some(within) = values[i] else { continue };
            let value = match of_moved.get(i) {
                None => Some(within),
                Some(moved) => moved.map(|moved| within + factor * (moved - within)),
            };
            if let (Some(bootstrap), Some(value)) = (bootstrap, value) {
                bootstrap.resamples.push(value);
            }
        }
    });
    Ok(all)
}

/// Returns the means of every point MDP.
///
/// # Errors
///
/// [`StatsError`] where a score is undefined.
pub fn means(points: &[PointObjectives]) -> Result<Vec<PointMeans>, StatsError> {
    points.iter().enumerate().map(|(i, p)| p.means(i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};

    /// Point MDPs with what was measured there.
    fn any_points() -> impl Strategy<Value = Vec<PointObjectives>> {
        let values = || prop::collection::vec(0.1f64..100.0, 3);
        let one = (0.01f64..1.0, 1u32..4, prop::collection::vec(values(), 1..3), values());
        let one = one.prop_map(|(weight, draws, method, baseline)| PointObjectives {
            weight,
            draws,
            method,
            baseline,
        });
        prop::collection::vec(one, 1..6)
    }

    fn bootstrap(
        points: &[PointObjectives],
        resampling: Resampling,
        rng: &mut ChaCha8Rng,
    ) -> Result<Bootstrap, StatsError> {
        crate::stats::bootstrap(points, &resampling, rng, 0)
    }

    fn rng(seed: u64) -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(seed)
    }

    fn point(weight: f64, method: &[f64], baseline: &[f64]) -> PointObjectives {
        let (method, baseline) = (vec![method.to_vec()], baseline.to_vec());
        PointObjectives { weight, draws: 1, method, baseline }
    }

    fn whole(_: &[PointObjectives]) -> Resampling {
        Resampling::whole()
    }

    fn of(points: &[PointObjectives], family_size: usize) -> Resampling {
        let weights: Vec<f64> = points.iter().map(|p| p.weight).collect();
        Resampling::distinct(
            &weights,
            &vec![points.len() as f64 / family_size as f64; points.len()],
        )
    }

    #[test]
    fn the_estimate_is_the_weighted_mean_of_scores() {
        let points = [point(3.0, &[5.0], &[10.0]), point(1.0, &[20.0], &[10.0])];
        let e = bootstrap(&points, whole(&points), &mut rng(0)).unwrap();
        assert_eq!(e.estimate, 0.875);
    }

    #[test]
    fn one_seed_on_the_whole_family_has_no_interval() {
        let points = [point(0.5, &[5.0], &[10.0]), point(0.5, &[20.0], &[10.0])];
        assert_eq!(bootstrap(&points, whole(&points), &mut rng(0)).unwrap().interval(), None);
    }

    #[test]
    fn the_whole_family_leaves_only_simulation_noise() {
        let quiet = [point(0.5, &[5.0, 5.0], &[10.0, 10.0]), point(0.5, &[9.0, 9.0], &[3.0, 3.0])];
        let e = bootstrap(&quiet, whole(&quiet), &mut rng(0)).unwrap();
        assert_eq!(e.interval(), Some((1.75, 1.75)));
        let (low, high) =
            bootstrap(&quiet, Resampling::draws(&quiet), &mut rng(0)).unwrap().interval().unwrap();
        assert!(low < 0.5 && high > 3.0, "two draws that differ say little: {low} to {high}");
    }

    #[test]
    fn a_difference_is_narrower_than_its_two_intervals() {
        let mut r = rng(1);
        let (mut a, mut b) = (Vec::new(), Vec::new());
        for _ in 0..30 {
            let level = 10.0 + 5.0 * r.random::<f64>();
            a.push(point(1.0, &[level, level + 1.0], &[20.0, 20.0]));
            b.push(point(1.0, &[level + 1.0, level + 2.0], &[20.0, 20.0]));
        }
        let design = of(&a, 300);
        let a = bootstrap(&a, design.clone(), &mut rng(0)).unwrap();
        let b = bootstrap(&b, design, &mut rng(0)).unwrap();
        let difference = a.difference(&b);
        assert!((difference.estimate - 0.05).abs() < 1e-9);
        let (low, high) = difference.interval().unwrap();
        let (alow, ahigh) = a.interval().unwrap();
        assert!(low > 0.0 && high - low < 0.01 * (ahigh - alow), "{low} {high}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn resamples_lie_between_the_most_extreme_ratios_of_seeds(points in any_points()) {
            let (mut least, mut most) = (f64::INFINITY, 0.0f64);
            for p in &points {
                let all = || p.method.iter().flatten().copied();
                let top = |f: fn(f64, f64) -> f64, start| all().fold(start, f);
                let bottom = |f: fn(f64, f64) -> f64, start| p.baseline.iter().copied().fold(start, f);
                least = least.min(top(f64::min, f64::INFINITY) / bottom(f64::max, 0.0));
                most = most.max(top(f64::max, 0.0) / bottom(f64::min, f64::INFINITY));
            }
            let e = bootstrap(&points, Resampling::whole(), &mut rng(0)).unwrap();
            for x in e.resamples {
                prop_assert!(least - 1e-9 <= x && x <= most + 1e-9);
            }
        }

        #[test]
        fn equal_seeds_give_equal_intervals_in_order(points in any_points(), seed in 0u64..99) {
            let again = || bootstrap(&points, Resampling::draws(&points), &mut rng(seed)).unwrap();
            let e = again();
            prop_assert_eq!(&e, &again());
            if let Some((low, high)) = e.interval() {
                prop_assert!(low <= high);
            }
        }
    }
}

//! How much wider intervals must be than resamples of few seeds and replicates make them.
//!
//! Five seeds tell a variance only roughly, so that percentiles of resampled means, which are as wide as the normal
//! distribution asks, hold less than they say: of normal values 86 of 100 where they should hold 95. Over many point MDPs
//! that evens out, unless few of them make most of the variance.
//!
//! Linearised, a score has the variance of `(m - s b) / mean(b)`, with `m` the method's objective on a seed, `b` the
//! baseline's and `s` the score. Of point MDP `i` the mean over seeds has the variance `v_i` and `n - 1` degrees of freedom,
//! that over replicates likewise. The degrees of freedom of the weighted mean are Welch's and Satterthwaite's,
//! `nu = (sum_i w_i^2 v_i)^2 / sum_i w_i^4 v_i^2 / (n_i - 1)`, and intervals are stretched by the quotient of the
//! quantiles of Student's t with `nu` and of the normal distribution.
//!
//! Source: F. Satterthwaite, "An approximate distribution of estimates of variance components", Biometrics Bulletin 2
//! (1946).

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use super::PointObjectives;
use super::quantile::ALPHA;
use super::score::mean;

/// Half of the interval of a standard normal value that holds it in 95 of 100 cases.
const NORMAL_HALF: f64 = 1.959_963_984_540_054;

/// Returns by which factor intervals of the mean score are wider than its resamples, at least 1.
///
/// # Arguments
///
/// * `degrees` — degrees of freedom of the mean score, as [`degrees`] returns them; `None` where there is no noise.
/// * `alpha` — share of such intervals that may miss what they are of; the less, the wider are Student's beside normal ones.
pub fn stretch(degrees: Option<f64>, alpha: f64) -> f64 {
    degrees.map_or(1.0, |degrees| of_degrees(degrees, alpha))
}

/// Returns the mean of values with its 95% interval by Student's t; an interval without width for one value, `None` without
/// values.
pub fn mean_interval(values: &[f64]) -> Option<(f64, f64, f64)> {
    let middle = mean(values)?;
    let half = of_mean(values).map_or(0.0, |(variance, degrees)| {
        NORMAL_HALF * variance.sqrt() * of_degrees(degrees, ALPHA)
    });
    Some((middle, middle - half, middle + half))
}

/// Returns the degrees of freedom of the mean score; `None` where there is no noise.
pub fn degrees(points: &[PointObjectives]) -> Option<f64> {
    let (mut variance, mut squares) = (0.0, 0.0);
    for point in points {
        for (own, degrees) in parts(point).into_iter().flatten() {
            let own = own * point.weight.powi(2);
            variance += own;
            squares += own.powi(2) / degrees;
        }
    }
    (squares > 0.0).then(|| variance.powi(2) / squares)
}

fn of_degrees(degrees: f64, alpha: f64) -> f64 {
    let quantiles = StudentsT::new(0.0, 1.0, degrees).ok().zip(Normal::new(0.0, 1.0).ok());
    let at = 1.0 - alpha / 2.0;
    let quotient = quantiles.map(|(t, normal)| t.inverse_cdf(at) / normal.inverse_cdf(at));
    quotient.filter(|q| q.is_finite()).map_or(1.0, |q| q.max(1.0))
}

/// Returns the variances of a score that seeds and replicates make, each with its degrees of freedom; `None` where there
/// is one of them only.
fn parts(point: &PointObjectives) -> [Option<(f64, f64)>; 2] {
    let (Ok(score), Some(unit)) = (point.score(), mean(&point.baseline)) else { return [None; 2] };
    let residual = |value: &f64, baseline: &f64| (value - score * baseline) / unit;
    let rows: Vec<Vec<f64>> = (point.method.iter())
        .map(|row| row.iter().zip(&point.baseline).map(|(m, b)| residual(m, b)).collect())
        .collect();
    let replicates: Vec<f64> = rows.iter().filter_map(|row| mean(row)).collect();
    let of_seed = |s: usize| rows.iter().map(|row| row[s]).sum::<f64>() / rows.len() as f64;
    let seeds: Vec<f64> = (0..point.baseline.len()).map(of_seed).collect();
    [of_mean(&seeds), of_mean(&replicates)]
}

fn of_mean(values: &[f64]) -> Option<(f64, f64)> {
    let middle = mean(values)?;
    let degrees = values.len() as f64 - 1.0;
    let squares = values.iter().map(|v| (v - middle).powi(2)).sum::<f64>();
    (degrees > 0.0).then(|| (squares / degrees / values.len() as f64, degrees))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(weight: f64, method: &[&[f64]], baseline: &[f64]) -> PointObjectives {
        let method = method.iter().map(|row| row.to_vec()).collect();
        PointObjectives { weight, draws: 1, method, baseline: baseline.to_vec() }
    }

    #[test]
    fn the_interval_of_a_mean_is_student_s() {
        // The mean of three values with a standard deviation of 1: 4.303 / sqrt(3).
        let (mean, low, high) = mean_interval(&[1.0, 2.0, 3.0]).unwrap();
        assert!((mean - 2.0).abs() < 1e-12 && (high - 2.0 - 2.484).abs() < 1e-3, "{high}");
        assert!((mean - low - (high - mean)).abs() < 1e-12);
        assert_eq!(mean_interval(&[4.0]), Some((4.0, 4.0, 4.0)));
        assert_eq!(mean_interval(&[]), None);
    }

    #[test]
    fn of_one_point_mdp_it_is_student_s_quantile() {
        let five = point(0.3, &[&[4.0, 5.0, 6.0, 5.5, 4.2]], &[10.0; 5]);
        assert!((stretch(degrees(&[five]), ALPHA) - 2.776_445 / 1.959_964).abs() < 1e-5);
        let two = point(1.0, &[&[4.0, 5.0]], &[10.0; 2]);
        assert!((stretch(degrees(&[two]), ALPHA) - 12.706_205 / 1.959_964).abs() < 1e-4);
        // Of four degrees of freedom, the quantiles at 1 - 0.025 / 2.
        let five = [point(0.3, &[&[4.0, 5.0, 6.0, 5.5, 4.2]], &[10.0; 5])];
        assert!((stretch(degrees(&five), 0.025) - 3.495_406 / 2.241_403).abs() < 1e-5);
    }

    #[test]
    fn many_equal_point_mdps_need_none_and_one_that_decides_all() {
        let one = point(1.0, &[&[4.0, 5.0, 6.0, 5.5, 4.2]], &[10.0; 5]);
        let many = vec![one.clone(); 500];
        let of_many = stretch(degrees(&many), ALPHA);
        assert!((1.0..1.002).contains(&of_many), "{of_many}");
        let wild = point(1.0, &[&[4.0, 5.0, 600.0, 5.5, 4.2]], &[10.0; 5]);
        let alone = stretch(degrees(std::slice::from_ref(&wild)), ALPHA);
        let beside: Vec<_> = many.into_iter().chain([wild]).collect();
        assert!((stretch(degrees(&beside), ALPHA) / alone - 1.0).abs() < 0.01);
    }

    #[test]
    fn trainings_that_differ_more_than_seeds_count_by_their_number() {
        let trained = point(1.0, &[&[4.0, 4.1, 4.0], &[9.0, 9.1, 9.0]], &[10.0; 3]);
        assert!((stretch(degrees(&[trained]), ALPHA) - 12.706_205 / 1.959_964).abs() < 0.01);
    }
}

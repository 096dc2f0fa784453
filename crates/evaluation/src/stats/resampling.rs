//! How the choice of point MDPs is drawn anew: contrasts between weights that mirror a sampling design.
//!
//! A variance estimator of a design that is a sum of squares, `V = sum_k (sum_i a_ki y_i)^2`, is also a way to
//! resample: weights `w_i + sum_k z_k a_ki` with independent `z_k` of mean 0 and variance 1 give any weighted total
//! exactly that variance, and other statistics the variance of their linear part. Equal draws of `z` for two methods
//! on the same point MDPs give the variance of their difference.
//!
//! Choices:
//! - `z` is an exponential variable less 1, so that skewed scores give skewed intervals;
//! - weights are moved by a part of the contrasts and the change of the statistic is scaled up, so that weights stay above 0;
//! - every resample's change is multiplied by `sqrt(nu / chi^2_nu)`, the same for all statistics, so that intervals
//!   are as wide as Student's t with `nu` degrees of freedom asks, not as the normal distribution.
//!
//! Source: J.-F. Beaumont and Z. Patak, "On the generalized bootstrap for sample surveys with special attention to
//! Poisson sampling", International Statistical Review 80 (2012), who use normal variables; the choices above are ours.

use rand::Rng;
use rand_distr::{ChiSquared, Distribution, Exp1};

use super::PointObjectives;

/// Part of the contrasts by which weights are moved.
const STEP: f64 = 0.7;

/// A contrast: positions of point MDPs and what is added to their weights; empty where a point MDP adds no spread.
pub type Contrast = Vec<(usize, f64)>;

/// How the choice of point MDPs is drawn anew.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Resampling {
    contrasts: Vec<Contrast>,
    degrees: f64,
    known: bool,
}

impl Resampling {
    /// Returns that of a family which was evaluated as a whole: nothing is drawn anew.
    pub fn whole() -> Self {
        Self { contrasts: Vec::new(), degrees: 0.0, known: true }
    }

    /// Returns that of some contrasts; the spread is unknown with less than one degree of freedom.
    ///
    /// # Arguments
    ///
    /// * `contrasts` — in units of weights that sum to 1.
    pub fn of(contrasts: Vec<Contrast>, degrees: f64) -> Self {
        Self { contrasts, degrees, known: degrees >= 1.0 }
    }

    /// Returns that of independent draws, as with replacement: each draw against the mean of all.
    pub fn draws(points: &[PointObjectives]) -> Self {
        let total: f64 = points.iter().map(|p| p.weight).sum();
        let all: u32 = points.iter().map(|p| p.draws.max(1)).sum();
        let n = f64::from(all);
        let scale = (n / (n - 1.0)).sqrt();
        let of_point = |(i, p): (usize, &PointObjectives)| {
            let draws = p.draws.max(1);
            let one = p.weight / total / f64::from(draws) * scale;
            vec![vec![(i, one)]; draws as usize]
        };
        Self::of(points.iter().enumerate().flat_map(of_point).collect(), n - 1.0)
    }

    /// Returns that of distinct point MDPs which were drawn with these probabilities: each against the mean of all,
    /// those that any sample has not at all.
    pub fn distinct(weights: &[f64], inclusion: &[f64]) -> Self {
        let total: f64 = weights.iter().sum();
        let n = weights.len() as f64;
        let contrast = |(i, (w, pi)): (usize, (&f64, &f64))| {
            vec![(i, w / total * ((1.0 - pi).max(0.0) * n / (n - 1.0)).sqrt())]
        };
        let pairs = weights.iter().zip(inclusion).enumerate();
        if inclusion.iter().all(|pi| *pi >= 1.0) {
            return Self::whole();
        }
        Self::of(pairs.map(contrast).collect(), n - 1.0)
    }

    /// Whether point MDPs are drawn anew.
    pub fn draws_points(&self) -> bool {
        self.contrasts.iter().any(|contrast| !contrast.is_empty())
    }

    /// Whether the spread between samples can be estimated, or there is none.
    pub fn is_known(&self) -> bool {
        self.known
    }

    /// Writes the weights of a resample.
    pub(super) fn moved(&self, weights: &[f64], rng: &mut impl Rng, moved: &mut Vec<f64>) {
        let total: f64 = weights.iter().sum();
        moved.clear();
        moved.extend_from_slice(weights);
        for contrast in &self.contrasts {
            // Also for an empty one: methods that differ in these stay paired.
            let z: f64 = Exp1.sample(rng);
            for (i, a) in contrast {
                moved[*i] += STEP * total * (z - 1.0) * a;
            }
        }
        moved.iter_mut().for_each(|w| *w = w.max(0.0));
    }

    /// Returns the factor by which a resample's change of a statistic is multiplied.
    pub(super) fn factor(&self, rng: &mut impl Rng) -> f64 {
        if self.draws_points() { student(self.degrees, rng) / STEP } else { 1.0 / STEP }
    }

    /// Returns the standard error of the weighted mean of values.
    pub fn standard_error(&self, weights: &[f64], values: &[f64]) -> f64 {
        let total: f64 = weights.iter().sum();
        let mean = weights.iter().zip(values).map(|(w, y)| w * y).sum::<f64>() / total;
        let squared =
            |c: &Contrast| c.iter().map(|(i, a)| a * (values[*i] - mean)).sum::<f64>().powi(2);
        self.contrasts.iter().map(squared).sum::<f64>().sqrt()
    }
}

fn student(degrees: f64, rng: &mut impl Rng) -> f64 {
    ChiSquared::new(degrees).map_or(1.0, |chi| {
        let x: f64 = chi.sample(rng);
        (degrees / x.max(f64::MIN_POSITIVE)).sqrt()
    })
}

/// Returns as many such factors; 1 where there are no degrees of freedom.
pub fn factors(degrees: Option<f64>, count: usize, rng: &mut impl Rng) -> Vec<f64> {
    (0..count).map(|_| degrees.map_or(1.0, |degrees| student(degrees, rng))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    fn draws(values: usize) -> Vec<PointObjectives> {
        let one =
            PointObjectives { weight: 2.0, draws: 1, method: vec![vec![1.0]], baseline: vec![1.0] };
        vec![one; values]
    }

    #[test]
    fn independent_draws_have_the_standard_error_of_a_mean() {
        let values = [1.0, 4.0, 4.0, 7.0, 9.0];
        let resampling = Resampling::draws(&draws(5));
        let se = resampling.standard_error(&[1.0; 5], &values);
        let mean = values.iter().sum::<f64>() / 5.0;
        let variance = values.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / 4.0;
        assert!((se - (variance / 5.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn point_mdps_that_every_sample_has_add_no_spread() {
        let weights = [1.0, 1.0, 2.0];
        assert!(!Resampling::distinct(&weights, &[1.0; 3]).draws_points());
        let some = Resampling::distinct(&weights, &[0.5, 0.5, 1.0]);
        assert!(some.standard_error(&weights, &[1.0, 1.0, 9.0]) > 0.0);
        assert_eq!(some.contrasts[2], [(2, 0.0)]);
    }

    #[test]
    fn resamples_of_a_mean_have_the_variance_of_the_contrasts() {
        let values: Vec<f64> = (0..60).map(|i| f64::from(i * 17 % 23)).collect();
        let weights: Vec<f64> = (0..60).map(|i| 1.0 + f64::from(i % 3)).collect();
        let resampling = Resampling::distinct(&weights, &[0.4; 60]);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mean = |w: &[f64]| {
            w.iter().zip(&values).map(|(w, y)| w * y).sum::<f64>() / w.iter().sum::<f64>()
        };
        let whole = mean(&weights);
        let n = 20_000;
        let mut moved = Vec::new();
        let squares = (0..n).map(|_| {
            resampling.moved(&weights, &mut rng, &mut moved);
            ((mean(&moved) - whole) / STEP).powi(2)
        });
        let se = (squares.sum::<f64>() / f64::from(n)).sqrt();
        let expected = resampling.standard_error(&weights, &values);
        assert!((se / expected - 1.0).abs() < 0.05, "{se} {expected}");
    }

    #[test]
    fn one_draw_has_no_spread_that_could_be_known() {
        assert!(!Resampling::draws(&draws(1)).is_known());
        assert!(Resampling::draws(&draws(2)).is_known() && Resampling::whole().is_known());
    }
}

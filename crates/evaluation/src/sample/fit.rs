//! The process that suits a design.
//!
//! Choices:
//! - **Length scales and nugget** suit the complete scores of the cheap methods ([`length_scales`]), each explained without
//!   its own column, on at most [`MOST_FITTED`] point MDPs. Columns of cheap scores share a length scale. Without cheap
//!   methods they are those of the prior.
//! - **Spread** `s_i` is one half and one half of what the cheap methods differ by around point MDP `i`, in proportion to the
//!   mean over the family: where control matters, methods differ. Without two cheap methods it is 1.
//! - Numbers that are kept are rounded, so that the choice of point MDPs does not hang on their last digits.
//!
//! Source: as in [`super::process`].

use super::balanced::pivotal;
use super::design::{Design, DesignPoint, Measure};
use super::kmeans::standardise;
use super::plan::Sampling;
use super::process::{Places, Process};
use crate::model::{Curve, length_scales};

/// Most point MDPs that length scales are fitted on; more change them little.
const MOST_FITTED: usize = 90;

/// Share of the spread that cheap methods decide.
const FROM_CHEAP: f64 = 0.5;

/// Least nugget: below it, point MDPs that are nearly the same make weights inexact.
const LEAST_NUGGET: f64 = 1e-3;

/// Significant digits of what is kept.
const DIGITS: i32 = 4;

impl Design {
    /// Returns the same with the [`Process`] that follows from it.
    pub fn modelled(self) -> Self {
        Self { process: Some(process(&self)), ..self }
    }

    /// Returns a design with all that a sampling needs of it.
    pub fn for_sampling(self, sampling: Sampling) -> Self {
        if sampling == Sampling::BayesianQuadrature { self.modelled() } else { self }
    }
}

/// Returns the process of a design.
fn process(design: &Design) -> Process {
    let rows = standardised(design);
    let describing = design.points.first().map_or(0, |p| p.describing.len());
    let is_score =
        |c: usize| c >= describing && design.inputs[c - describing].measure == Measure::Score;
    let width = describing + design.inputs.len();
    let own = (0..width).filter(|c| !is_score(*c)).count();
    let mut next = 0..own;
    let groups: Vec<usize> =
        (0..width).map(|c| if is_score(c) { own } else { next.next().unwrap_or(own) }).collect();
    let fitted = fitted(&rows);
    let column = |c: usize| fitted.iter().map(|row| rows[*row][c]).collect::<Vec<f64>>();
    let columns: Vec<Vec<f64>> = (0..width).map(column).collect();
    let curve = |c: usize| Curve {
        values: fitted.iter().map(|row| design.points[*row].inputs[c - describing]).collect(),
        column: Some(c),
    };
    let curves: Vec<Curve> = (0..width).filter(|c| is_score(*c)).map(curve).collect();
    let found = length_scales(&columns, &groups, &curves);
    let lengths: Vec<f64> = groups.iter().map(|g| rounded(found.lengths[*g])).collect();
    let places = Places::new(&rows, &lengths);
    let spread = spread(design, &places);
    let mut process = Process {
        length_scales: lengths,
        nugget: rounded(found.noise.max(LEAST_NUGGET)),
        covariance: Vec::new(),
        variance: 0.0,
        spread,
    };
    let importance: Vec<f64> = design.points.iter().map(|p| p.importance).collect();
    let total: f64 = importance.iter().sum();
    let share = |p: &f64| p / total;
    let size = importance.len();
    let of = |i: usize| {
        let smooth = |j: usize| process.smooth(&places, i, j) * share(&importance[j]);
        (0..size).map(smooth).sum::<f64>()
    };
    process.covariance = (0..size).map(of).collect();
    process.variance = process.covariance.iter().zip(&importance).map(|(c, p)| c * share(p)).sum();
    process
}

/// Returns what is known of every point MDP, a row each: in logarithms where all values of a column are above 0, columns
/// standardised.
pub(super) fn standardised(design: &Design) -> Vec<Vec<f64>> {
    let columns = design.points.first().map_or(0, |p| p.describing.len());
    let positive: Vec<bool> =
        (0..columns).map(|c| design.points.iter().all(|p| p.describing[c] > 0.0)).collect();
    let value = |(x, positive): (&f64, &bool)| if *positive { libm::log(*x) } else { *x };
    let row = |(p, inputs): (&DesignPoint, Vec<f64>)| {
        let describing: Vec<f64> = p.describing.iter().zip(&positive).map(value).collect();
        [describing, inputs].concat()
    };
    let rows: Vec<Vec<f64>> =
        design.points.iter().zip(design.transformed_inputs()).map(row).collect();
    standardise(&rows)
}

/// Returns the rows that length scales are fitted on, spread over all.
fn fitted(rows: &[Vec<f64>]) -> Vec<usize> {
    if rows.len() <= MOST_FITTED {
        return (0..rows.len()).collect();
    }
    let share = MOST_FITTED as f64 / rows.len() as f64;
    pivotal(&vec![share; rows.len()], rows, 0)
}

/// Returns by how much methods are expected to differ around every point MDP.
fn spread(design: &Design, places: &Places) -> Vec<f64> {
    let size = design.points.len();
    let scores: Vec<usize> =
        (0..design.inputs.len()).filter(|c| design.inputs[*c].measure == Measure::Score).collect();
    if scores.len() < 2 {
        return vec![1.0; size];
    }
    let variance = |p: &DesignPoint| {
        let mean = scores.iter().map(|c| p.inputs[*c]).sum::<f64>() / scores.len() as f64;
        let squares = scores.iter().map(|c| (p.inputs[*c] - mean).powi(2));
        squares.sum::<f64>() / (scores.len() - 1) as f64
    };
    let variances: Vec<f64> = design.points.iter().map(variance).collect();
    let around = |i: usize| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (j, variance) in variances.iter().enumerate() {
            // Over half a length scale.
            let weight = libm::exp(-2.0 * places.squared_distance(i, j));
            sum += weight * variance;
            weights += weight;
        }
        (sum / weights).sqrt()
    };
    let deviations: Vec<f64> = (0..size).map(around).collect();
    let mean = deviations.iter().sum::<f64>() / size as f64;
    let of = |deviation: &f64| match mean > 0.0 {
        true => rounded(1.0 - FROM_CHEAP + FROM_CHEAP * deviation / mean),
        false => 1.0,
    };
    deviations.iter().map(of).collect()
}

/// Returns a number above 0 with [`DIGITS`] significant digits.
fn rounded(x: f64) -> f64 {
    let shift = DIGITS - 1 - libm::floor(libm::log10(x)) as i32;
    match shift {
        0.. => (x * 10f64.powi(shift)).round() / 10f64.powi(shift),
        _ => (x / 10f64.powi(-shift)).round() * 10f64.powi(-shift),
    }
}

#[cfg(test)]
mod tests {
    use super::super::design::Input;
    use super::*;

    #[test]
    fn numbers_keep_four_digits() {
        let found = [1234567.0, 0.000123456, 1.0, 99.999].map(rounded);
        assert_eq!(found, [1235000.0, 0.0001235, 1.0, 100.0]);
    }

    fn design(scores: &[[f64; 2]]) -> Design {
        let input = |method: &str| Input { method: method.to_owned(), measure: Measure::Score };
        let point = |(i, inputs): (usize, &[f64; 2])| DesignPoint {
            point: format!("p{i}"),
            importance: 1.0 / scores.len() as f64,
            describing: vec![i as f64 - 1.0],
            inputs: inputs.to_vec(),
        };
        let points = scores.iter().enumerate().map(point).collect();
        Design { inputs: vec![input("a"), input("b")], points, process: None }
    }

    #[test]
    fn methods_are_expected_to_differ_where_cheap_ones_do() {
        let scores: Vec<[f64; 2]> =
            (0..30).map(|i| [0.5, if i < 20 { 0.52 } else { 2.5 }]).collect();
        let process = super::process(&design(&scores));
        assert!(process.spread[5] < 0.8 && process.spread[25] > 1.5, "{:?}", process.spread);
        let mean = process.spread.iter().sum::<f64>() / 30.0;
        assert!((mean - 1.0).abs() < 1e-3);
    }

    #[test]
    fn without_cheap_scores_the_prior_is_left() {
        let plain = design(&[[1.0; 2]; 5]).without(&["a", "b"]);
        let process = super::process(&plain);
        assert_eq!((process.length_scales, process.spread), (vec![1.0], vec![1.0; 5]));
        assert_eq!(process.nugget, 0.1111);
    }

    #[test]
    fn what_was_kept_of_another_design_does_not_fit() {
        let (own, other) = (design(&[[1.0, 2.0]; 5]), design(&[[1.0, 2.0]; 6]));
        let process = super::process(&own);
        let fits = |process: &Process, design: &Design| {
            let design = Design { process: Some(process.clone()), ..design.clone() };
            crate::sample::quadrature::Quadrature::of(&design).is_some()
        };
        assert!(fits(&process, &own) && !fits(&process, &other));
        assert!(!fits(&process, &own.without(&["a"])));
        assert!(!fits(&Process { nugget: f64::NAN, ..process }, &own));
    }
}

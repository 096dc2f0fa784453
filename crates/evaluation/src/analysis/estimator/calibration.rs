//! By how much intervals must be widened so that those of methods that are known everywhere would hold what is known.

use super::assisted::modelled;
use crate::sample::{Design, Measure};
use crate::stats::{PointMeans, Resampling};

/// Half-width of a 95% interval of a normal variable, in standard errors.
const HALF_WIDTH: f64 = 1.96;

/// Most that an interval is widened; beyond it, one method decides alone, and differs in kind.
const MOST: f64 = 4.0;

/// Returns the factor for the interval of a method, from 1 to [`MOST`].
///
/// Every method with known scores but this one is estimated from the sample with a model that knows the others; the
/// factor is the largest error in half-widths.
///
/// # Arguments
///
/// * `rows` — positions of the sample in the design; `observed` — the sample, of which weights count here.
pub(super) fn widening(
    design: &Design,
    method: &str,
    rows: &[usize],
    observed: &[PointMeans],
    resampling: &Resampling,
) -> f64 {
    let weights: Vec<f64> = observed.iter().map(|m| m.weight).collect();
    let known = design.inputs.iter().filter(|i| i.measure == Measure::Score && i.method != method);
    let errors = known.filter_map(|input| {
        let scores = design.input(&input.method, Measure::Score)?;
        let others = design.without(&[input.method.as_str(), method]);
        Some(error(&others, &scores, (rows, &weights), resampling))
    });
    errors.fold(1.0, f64::max).min(MOST)
}

/// Returns the error of the estimate of a method with known scores, in half-widths of its interval.
fn error(
    others: &Design,
    scores: &[f64],
    (rows, weights): (&[usize], &[f64]),
    resampling: &Resampling,
) -> f64 {
    let own: Vec<f64> = rows.iter().map(|row| scores[*row]).collect();
    let predicted = modelled(others, rows, &own, weights);
    let total: f64 = weights.iter().sum();
    let wrong: Vec<f64> = own.iter().zip(&predicted.sample).map(|(y, m)| y - m).collect();
    let correction = wrong.iter().zip(weights).map(|(e, w)| e * w).sum::<f64>() / total;
    let importance: f64 = others.points.iter().map(|p| p.importance).sum();
    let of_family = |values: &[f64]| {
        let pairs = others.points.iter().zip(values);
        pairs.map(|(p, value)| p.importance * value).sum::<f64>() / importance
    };
    let off = of_family(&predicted.family) + correction - of_family(scores);
    let half = HALF_WIDTH * resampling.standard_error(weights, &wrong);
    if half > 0.0 { off.abs() / half } else { 0.0 }
}

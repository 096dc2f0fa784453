//! Scores as a model predicts them from what is known of a family.

use crate::model::{Known, Prediction, cross_fit};
use crate::sample::Design;

/// Seed of the folds of the cross-validation.
const FOLD_SEED: u64 = 0;

/// Returns predicted scores of a method that is not among the inputs of the design.
///
/// # Arguments
///
/// * `rows` — positions of the sample in the design; `scores`, `weights` — of the sample.
pub(super) fn modelled(
    design: &Design,
    rows: &[usize],
    scores: &[f64],
    weights: &[f64],
) -> Prediction {
    let known = Known { inputs: design.transformed_inputs(), all: design.coordinates() };
    cross_fit(&known, rows, scores, weights, FOLD_SEED)
}

//! From the scores on a sample of point MDPs to the whole family: one file per estimator.
//!
//! | sampling | estimator | weights |
//! | --- | --- | --- |
//! | with replacement (M1) | [`WithReplacement`] | equal per draw |
//! | without replacement (M2) | [`Distinct::Drawn`] | importance, renormalised |
//! | k-means (M3) | [`Distinct::Representatives`] | importance of the cluster |
//! | all | [`Distinct::Whole`] | importance |
//!
//! To add one: a file with a type that implements [`Estimator`], and its line in [`estimator_of`]; with a sampling of
//! its own, that is a variant of [`Sampling`], its file in `sample`, and their lines.
//!
//! Source: Jayawardana et al. (NeurIPS 2022), appendix, "Evaluate DRL methods on a family of MDPs".

mod contract;
mod distinct;
mod with_replacement;

pub use contract::{Estimate, Estimator, Sample};
pub use distinct::Distinct;
pub use with_replacement::WithReplacement;

use crate::sample::Sampling;

/// Returns the estimator of a sampling.
pub fn estimator_of(sampling: Sampling) -> &'static dyn Estimator {
    match sampling {
        Sampling::WithReplacement => &WithReplacement,
        Sampling::WithoutReplacement => &Distinct::Drawn,
        Sampling::KMeans => &Distinct::Representatives,
        Sampling::All => &Distinct::Whole,
    }
}

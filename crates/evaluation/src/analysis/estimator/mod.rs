//! From the scores on a sample of point MDPs to the whole family: one file per estimator that takes more than a line.
//!
//! | sampling | estimator | weights | interval |
//! | --- | --- | --- | --- |
//! | with replacement (M1) | [`Estimator::WithReplacement`] | equal per draw | independent draws |
//! | without replacement (M2) | [`Estimator::WithoutReplacement`] | importance, renormalised | probabilities to be drawn |
//! | k-means (M3) | [`Estimator::Representatives`] | importance of the cluster | between neighbouring clusters |
//! | balanced | [`Estimator::Balanced`] | importance by probability | between neighbours in the sample |
//! | Bayesian quadrature | [`Estimator::BayesianQuadrature`] | least expected error under a Gaussian process | what the process leaves unknown |
//! | all | [`Estimator::Whole`] | importance | seeds and trainings only |
//!
//! A method that learned once on each point MDP has scores that another training would have changed. How much is not
//! known, so its interval takes all that neighbours differ by for the luck of training ([`Sample::learned_once`]): it is
//! that of a family without end, of which even the whole is a sample. That tends to be too wide.
//!
//! To add one: a variant of [`Estimator`], its file, and its line in [`estimator_of`]; with a sampling of its own, that is a
//! variant of [`Sampling`], its file in `sample`, and their lines.
//!
//! Source of M1 to M3: Jayawardana et al. (NeurIPS 2022), appendix, "Evaluate DRL methods on a family of MDPs".

mod balanced;
mod bayesian_quadrature;
mod contract;
mod neighbours;
mod representatives;
mod whole_family;
mod without_replacement;

pub use contract::{Chosen, Estimate, Estimator, Sample};

use crate::sample::{SamplePlan, Sampling};

/// Returns the estimator of a sample.
pub fn estimator_of(plan: &SamplePlan) -> Estimator {
    match plan.sampling {
        Sampling::WithReplacement => Estimator::WithReplacement,
        Sampling::WithoutReplacement => Estimator::WithoutReplacement,
        Sampling::KMeans => Estimator::Representatives,
        Sampling::BayesianQuadrature => Estimator::BayesianQuadrature,
        Sampling::Balanced => Estimator::Balanced,
        Sampling::All => Estimator::Whole,
    }
}

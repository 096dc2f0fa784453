//! From the scores on a sample of point MDPs to the whole family: one file per estimator.
//!
//! | sampling | estimator | weights | interval |
//! | --- | --- | --- | --- |
//! | with replacement (M1) | [`WithReplacement`] | equal per draw | independent draws |
//! | without replacement (M2) | [`WithoutReplacement`] | importance, renormalised | probabilities to be drawn |
//! | k-means (M3) | [`Representatives`] | importance of the cluster | between neighbouring clusters |
//! | balanced | [`Balanced`] | importance by probability | between neighbours in the sample |
//! | Bayesian quadrature | [`BayesianQuadrature`] | least expected error under a Gaussian process | what the process leaves unknown |
//! | balanced, cheap scores known (M4) | [`Assisted`] | the same, over a model | the same, over its errors |
//! | all | [`Whole`] | importance | seeds and trainings only |
//!
//! A method that learned once on each point MDP has scores that another training would have changed. How much is not
//! known, so its interval takes all that neighbours differ by for the luck of training ([`Sample::learned_once`]): it is
//! that of a family without end, of which even the whole is a sample. That is rather too wide.
//!
//! To add one: a file with a type that implements [`Estimator`], and its line in [`estimator_of`]; with a sampling of
//! its own, that is a variant of [`Sampling`], its file in `sample`, and their lines.
//!
//! Source of M1 to M3: Jayawardana et al. (NeurIPS 2022), appendix, "Evaluate DRL methods on a family of MDPs".

mod assisted;
mod balanced;
mod bayesian_quadrature;
mod calibration;
mod contract;
mod neighbours;
mod prediction;
mod representatives;
mod weighted;
mod whole_family;
mod with_replacement;
mod without_replacement;

pub use assisted::Assisted;
pub use balanced::Balanced;
pub use bayesian_quadrature::BayesianQuadrature;
pub use contract::{Chosen, Estimate, Estimator, Sample};
pub use representatives::Representatives;
pub use whole_family::Whole;
pub use with_replacement::WithReplacement;
pub use without_replacement::WithoutReplacement;

use crate::sample::{SamplePlan, Sampling};

/// Returns the estimator of a sample.
pub fn estimator_of(plan: &SamplePlan) -> &'static dyn Estimator {
    match plan.sampling {
        Sampling::WithReplacement => &WithReplacement,
        Sampling::WithoutReplacement => &WithoutReplacement,
        Sampling::KMeans => &Representatives,
        Sampling::BayesianQuadrature => &BayesianQuadrature,
        Sampling::Balanced if plan.assisted => &Assisted,
        Sampling::Balanced => &Balanced,
        Sampling::All => &Whole,
    }
}

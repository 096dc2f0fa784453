//! What a run is asked to evaluate: the one way from there to a sample.

use serde_json::Value;

use super::plan_file::{PlanError, PlanFile};
use super::{Design, SampleError, SamplePlan, Sampling, choose_over};
use crate::family::MdpFamily;

/// Which point MDPs a run evaluates.
#[derive(Debug, Clone)]
pub enum Choice {
    /// Every one.
    All,
    /// So many.
    Budget {
        /// Number of point MDPs.
        budget: usize,
        /// How they are chosen.
        sampling: Sampling,
        /// What they are spread over, as [`Design::for_sampling`] returns it: features and scores that are known of
        /// other methods. `None` takes the features alone.
        design: Option<Design>,
        /// What is kept of the settings of the run whose scores those are; `None` where there is none.
        assisting: Option<Value>,
    },
    /// A sample that was chosen before.
    Plan(PlanFile),
}

/// Why nothing can be chosen.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ChoiceError {
    /// An impossible budget.
    #[error(transparent)]
    Sample(#[from] SampleError),
    /// A plan of another family, or one that was altered.
    #[error("the plan: {0}")]
    Plan(#[from] PlanError),
}

impl Choice {
    /// Returns the sample, and what it was spread over where estimates need that.
    ///
    /// # Errors
    ///
    /// [`ChoiceError`].
    pub fn sample(
        &self,
        family: &MdpFamily,
        seed: u64,
    ) -> Result<(SamplePlan, Option<Design>), ChoiceError> {
        let (budget, sampling, design) = match self {
            Self::All => (family.points.len(), Sampling::All, &None),
            Self::Budget { budget, sampling, design, .. } => (*budget, *sampling, design),
            Self::Plan(plan) => {
                plan.check(family)?;
                return Ok((plan.sample.clone(), plan.design.clone()));
            }
        };
        let design = design.clone().unwrap_or_else(|| Design::of(family).for_sampling(sampling));
        let sample = choose_over(family, &design, sampling, budget, seed)?;
        Ok((sample, sampling.has_design().then_some(design)))
    }

    /// Returns what is kept of the settings of the run whose scores assist the sample; `None` where no run does, or
    /// nothing is known of them.
    pub fn assisting(&self) -> Option<&Value> {
        match self {
            Self::All => None,
            Self::Budget { assisting, .. } => assisting.as_ref(),
            Self::Plan(plan) => plan.assisting.as_ref(),
        }
    }
}

//! What a run is asked to evaluate: the one way from there to a sample.

use serde_json::Value;

use super::{Design, SampleError, SamplePlan, Sampling, choose_over};
use crate::family::MdpFamily;

/// How far the importance of a point MDP may be from the family's.
const TOLERANCE: f64 = 1e-6;

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
    Sample {
        /// The choice.
        sample: SamplePlan,
        /// What it was spread over, of those that need it later.
        design: Option<Design>,
        /// As in [`Self::Budget`].
        assisting: Option<Value>,
    },
}

impl Choice {
    /// Returns so many point MDPs, spread over the features alone.
    pub fn drawn(budget: usize, sampling: Sampling) -> Self {
        Self::Budget { budget, sampling, design: None, assisting: None }
    }

    /// Returns the sample, and what it was spread over where estimates need that.
    ///
    /// # Errors
    ///
    /// [`SampleError`].
    pub fn sample(
        &self,
        family: &MdpFamily,
        seed: u64,
    ) -> Result<(SamplePlan, Option<Design>), SampleError> {
        let (budget, sampling, design) = match self {
            Self::All => (family.points.len(), Sampling::All, &None),
            Self::Budget { budget, sampling, design, .. } => (*budget, *sampling, design),
            Self::Sample { sample, design, .. } => {
                check(sample, design.as_ref(), family)?;
                return Ok((sample.clone(), design.clone()));
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
            Self::Budget { assisting, .. } | Self::Sample { assisting, .. } => assisting.as_ref(),
        }
    }
}

/// Checks that a sample, and what it was spread over, are of a family.
fn check(
    sample: &SamplePlan,
    design: Option<&Design>,
    family: &MdpFamily,
) -> Result<(), SampleError> {
    let other = |what: String| {
        Err(SampleError::Unfit(format!(
            "the sample is of another family than {}: {what}; give the scenario and settings it was chosen for",
            family.name
        )))
    };
    let (own, size) = (sample.family_size, family.points.len());
    if own != size || design.is_some_and(|design| design.points.len() != size) {
        return other(format!("its family has {own} point MDPs, this one {size}"));
    }
    if let Some(draw) = sample.draws.iter().find(|draw| family.position(&draw.point).is_none()) {
        return other(format!("this one has no point MDP {}", draw.point));
    }
    let rows = design.iter().flat_map(|design| &design.points).zip(&family.points);
    for (own, point) in rows {
        if own.point != point.id || (own.importance - point.importance).abs() > TOLERANCE {
            return other(format!(
                "{} with importance {:.6} there, {} with {:.6} here",
                own.point, own.importance, point.id, point.importance
            ));
        }
    }
    Ok(())
}

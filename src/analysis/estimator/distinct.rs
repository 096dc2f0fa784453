//! M2, M3 and the whole family: distinct point MDPs, each with its weight.
//!
//! The estimate is the weighted mean of scores. The interval is the percentile bootstrap of
//! [`crate::stats::bootstrap`] with point MDPs drawn anew and scaled by the finite population correction, so
//! that of a whole family only the noise of seeds and trainings remains.

use rand_chacha::ChaCha8Rng;

use super::contract::{Estimate, Estimator, Sample};
use crate::stats::summary::Statistic;
use crate::stats::{Design, PointObjectives, StatsError, bootstrap_all};

/// How distinct point MDPs came to be chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Distinct {
    /// M2: drawn by importance without replacement.
    Drawn,
    /// M3: representatives of clusters.
    Representatives,
    /// All of the family.
    Whole,
}

impl Estimator for Distinct {
    fn name(&self) -> &'static str {
        match self {
            Self::Drawn => "M2",
            Self::Representatives => "M3",
            Self::Whole => "all",
        }
    }

    fn assumptions(&self) -> &'static str {
        match self {
            Self::Drawn => {
                "Scores do not depend on importance: draws by importance that weigh their importance again \
                 favour important point MDPs."
            }
            Self::Representatives => {
                "Representatives of clusters are no random sample; the interval treats them as one, which \
                 is usually wide."
            }
            Self::Whole => "What is missing is missing at random.",
        }
    }

    fn estimate_all(
        &self,
        sample: Sample,
        scores: &[PointObjectives],
        statistics: &[Statistic<'_>],
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<Option<Estimate>>, StatsError> {
        let design = Design::Distinct { family_size: sample.family_size };
        let all = bootstrap_all(scores, design, rng, sample.method, statistics)?;
        Ok(all.into_iter().map(|b| b.map(Estimate::from)).collect())
    }
}

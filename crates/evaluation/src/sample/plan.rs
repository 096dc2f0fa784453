//! A sample: which point MDPs, with which weights, and how it grows.

use std::collections::BTreeSet;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::stats::quantile::ALPHA;

/// Most times as many resamples as usual.
const MOST: f64 = 10.0;

/// How point MDPs are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Sampling {
    /// random draws by importance, spread over the features (local pivotal method)
    Balanced,
    /// the point MDPs that leave least unknown of the family's score, by a Gaussian process
    BayesianQuadrature,
    /// M3: k-means clusters, each represented by the point MDP nearest to its centroid
    KMeans,
    /// M1: random draws by importance, with replacement
    WithReplacement,
    /// M2: random draws by importance, without replacement
    WithoutReplacement,
    /// Every point MDP of the family: what `--budget all` does, no choice of its own
    #[value(skip)]
    All,
}

impl Sampling {
    /// What is used where nothing else is asked for.
    pub const DEFAULT: Self = Self::Balanced;

    /// Returns its name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Balanced => "balanced",
            Self::BayesianQuadrature => "bayesian-quadrature",
            Self::KMeans => "k-means",
            Self::WithReplacement => "with-replacement",
            Self::WithoutReplacement => "without-replacement",
            Self::All => "all",
        }
    }

    /// Whether it is over a [`super::Design`], which its estimates need; such samples can grow.
    pub fn has_design(self) -> bool {
        matches!(self, Self::Balanced | Self::BayesianQuadrature)
    }
}

/// A chosen point MDP.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Draw {
    /// Id of the point MDP.
    pub point: String,
    /// Weight of its score in the estimate; weights sum to 1.
    pub weight: f64,
    /// How often it was drawn (more than once only with replacement), or for k-means how many
    /// point MDPs its cluster has.
    pub count: u32,
    /// Probability to be in the sample, from 0 to 1; `None` with replacement, for representatives of clusters, and in
    /// plans from before it was kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inclusion: Option<f64>,
}

/// The chosen point MDPs; written before anything runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SamplePlan {
    /// How they were chosen.
    pub sampling: Sampling,
    /// Number of draws.
    pub budget: usize,
    /// Size of the family.
    pub family_size: usize,
    /// Seed of the choice.
    pub seed: u64,
    /// The choice, in the order of the family.
    pub draws: Vec<Draw>,
    /// sha256 of the `Design` that the sample was spread over; empty where none was.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub design: String,
    /// How it grows, if it does; [`Self::budget`] and [`Self::draws`] are then those of the largest sample, or of the
    /// look that is evaluated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub growth: Option<Growth>,
}

/// Why a sample cannot be drawn.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SampleError {
    /// A budget of 0 or, without replacement, above the family's size.
    #[error(
        "budget {budget}: the family has {size} point MDPs; give a budget from 1 to {size}, or `all`"
    )]
    Budget {
        /// What was asked for.
        budget: usize,
        /// Size of the family.
        size: usize,
    },
    /// Looks that a sample cannot have, or a sample of another family.
    #[error("{0}")]
    Unfit(String),
}

/// When a sample is large enough.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Until {
    /// One of these methods is ahead of every other: the intervals of the differences do not contain 0
    FirstPlace(Vec<String>),
    /// The loss of one of these methods against every other is at most this much, by the intervals of the differences
    Within(f64, Vec<String>),
}

impl Until {
    /// Returns the methods that it is about, and how far the answer may be from the best.
    pub fn question(&self) -> (&[String], f64) {
        match self {
            Self::FirstPlace(methods) => (methods, 0.0),
            Self::Within(within, methods) => (methods, *within),
        }
    }
}

/// The sample at one look.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Look {
    /// Number of point MDPs; where some have probability 1, a sample may have one more or less.
    pub budget: usize,
    /// The choice, in the order of the family.
    pub draws: Vec<Draw>,
}

/// How a sample grows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Growth {
    /// When it stops.
    pub until: Until,
    /// Its looks, each within the next; the last has the whole budget.
    pub looks: Vec<Look>,
}

impl fmt::Display for Until {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (methods, within) = self.question();
        match methods {
            _ if within > 0.0 => {
                let methods = methods.len();
                write!(f, "it is known which of {methods} methods is within {within} of the best")
            }
            [first, second] => write!(f, "it is decided which of {first} and {second} is better"),
            _ => write!(f, "it is decided which of {} methods is the best", methods.len()),
        }
    }
}

impl SamplePlan {
    /// Returns the sample as it is at a look, counted from 0; `None` for a look that it has not.
    pub fn at_look(&self, look: usize) -> Option<Self> {
        let Look { budget, draws } = self.growth.as_ref()?.looks.get(look)?.clone();
        Some(Self { budget, draws, ..self.clone() })
    }

    /// Returns which look this is, from 1, and how many there may be; `None` where it does not grow.
    pub fn look_of(&self) -> Option<(usize, usize)> {
        Some((self.look()? + 1, self.growth.as_ref()?.looks.len()))
    }

    /// Returns the first look, counted from 0, that has all of some point MDPs; `None` where the sample does not grow.
    pub fn first_look_with(&self, points: &BTreeSet<&str>) -> Option<(usize, &Look)> {
        let looks = &self.growth.as_ref()?.looks;
        let lacks = |look: &&Look| {
            let drawn: BTreeSet<&str> = look.draws.iter().map(|d| d.point.as_str()).collect();
            !points.is_subset(&drawn)
        };
        // Each is within the next.
        let first = looks.iter().take_while(lacks).count().min(looks.len().checked_sub(1)?);
        Some((first, &looks[first]))
    }

    /// Returns at which look the sample is, counted from 0; `None` where it does not grow.
    pub fn look(&self) -> Option<usize> {
        self.growth.as_ref()?.looks.iter().position(|look| look.budget == self.budget)
    }

    /// Returns the share of intervals that may miss what they are of; what has been looked at before leaves less of it.
    pub fn alpha(&self) -> f64 {
        let (Some(growth), Some(look)) = (&self.growth, self.look()) else { return ALPHA };
        let budget = |look: usize| growth.looks[look].budget as f64;
        let before = if look == 0 { 0.0 } else { budget(look - 1) };
        ALPHA * (budget(look) - before) / budget(growth.looks.len() - 1)
    }

    /// Returns how many resamples leave as many beyond an interval as `usual` do beyond one of 95%.
    pub fn resamples(&self, usual: usize) -> usize {
        (usual as f64 * (ALPHA / self.alpha()).min(MOST)).round() as usize
    }
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;

    use super::*;

    #[test]
    fn a_sampling_has_one_name_on_the_command_line_and_in_files() {
        for sampling in Sampling::value_variants().iter().chain(&[Sampling::All]) {
            assert_eq!(serde_json::to_value(sampling).unwrap(), sampling.name());
        }
    }
}

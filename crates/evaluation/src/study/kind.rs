//! What is studied: a sampling with its estimator.

use crate::sample::Sampling;

/// A sampling with its estimator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// M1: with replacement.
    M1,
    /// M2: without replacement.
    M2,
    /// M3: representatives of k-means clusters.
    M3,
    /// Balanced over the features.
    Balanced,
    /// Bayesian quadrature over the features.
    BqFeatures,
    /// Bayesian quadrature over features and the scores of cheap methods.
    Bq,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::M1, Self::M2, Self::M3, Self::Balanced, Self::BqFeatures, Self::Bq];

    /// Returns its name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::M1 => "m1",
            Self::M2 => "m2",
            Self::M3 => "m3",
            Self::Balanced => "balanced",
            Self::BqFeatures => "bq-features",
            Self::Bq => "bq",
        }
    }

    /// Returns its name in tables and figures.
    pub fn title(self) -> &'static str {
        match self {
            Self::M1 => "M1, with replacement",
            Self::M2 => "M2, without replacement",
            Self::M3 => "M3, k-means",
            Self::Balanced => "balanced",
            Self::BqFeatures => "Bayesian quadrature, features",
            Self::Bq => "Bayesian quadrature",
        }
    }

    /// Returns how point MDPs are chosen.
    pub fn sampling(self) -> Sampling {
        match self {
            Self::M1 => Sampling::WithReplacement,
            Self::M2 => Sampling::WithoutReplacement,
            Self::M3 => Sampling::KMeans,
            Self::Balanced => Sampling::Balanced,
            Self::BqFeatures | Self::Bq => Sampling::BayesianQuadrature,
        }
    }

    /// Whether it uses the scores of cheap methods on all point MDPs.
    pub fn is_assisted(self) -> bool {
        self == Self::Bq
    }
}

impl clap::ValueEnum for Kind {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<clap::builder::PossibleValue> {
        Some(clap::builder::PossibleValue::new(self.name()).help(self.title()))
    }
}

//! Estimates from scores and how sure they are: pure functions that know of no files.

pub mod bootstrap;
pub mod direction;
mod few_seeds;
pub mod histogram;
pub mod improvement;
pub mod iqm;
pub mod limit;
pub mod objectives;
pub mod profile;
pub mod quantile;
pub mod ranks;
mod resamples;
pub mod resampling;
pub mod score;
pub mod summary;
pub mod weighted_quantile;

pub use bootstrap::{Bootstrap, bootstrap, bootstrap_all, means};
pub use direction::Direction;
pub use few_seeds::{degrees, mean_interval, stretch};
pub use histogram::Histogram;
pub use limit::{Limit, Side};
pub use objectives::{PointMeans, PointObjectives};
pub use resampling::Resampling;
pub use score::score;

/// Why a statistic cannot be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StatsError {
    /// Two lists that belong together have different lengths.
    #[error("{what}: {left} values against {right}; give both for the same points and seeds")]
    Length {
        /// Which lists.
        what: &'static str,
        /// Length of the first.
        left: usize,
        /// Length of the second.
        right: usize,
    },
    /// Nothing to average.
    #[error("{0} is empty; give at least one value")]
    Empty(&'static str),
    /// A value for which the statistic is undefined.
    #[error("{what} is {value}; expected {expected}")]
    Value {
        /// Which value.
        what: &'static str,
        /// What it is.
        value: f64,
        /// What it should be.
        expected: &'static str,
    },
}

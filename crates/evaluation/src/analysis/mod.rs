//! From records to what they say: scores, estimates with their uncertainty, ranking, trainings, winners.
//!
//! Everything here is a function of records that were read already: no files, no drawing, no simulator, and
//! nothing of what the point MDPs are. What a domain knows beside the objective it says through [`Measures`].
//!
//! ```text
//! records -> points, episodes -> method (estimator, summaries) -> ranking, comparison, training, winners -> Analysis
//! ```

pub mod across;
mod board;
mod choice;
mod comparison;
pub mod estimator;
pub mod joined;
mod measures;
mod method;
mod mix;
mod points;
mod reference;
pub mod sensitivity;
mod summaries;
mod training;
mod whole;
mod winners;

pub use crate::store::figures::{LAST_EPISODES, RETURN};
pub use board::Board;
pub use comparison::{Comparison, Decided, FEWEST_SEEDS_FOR_PLACES, Pair};
pub use measures::{Measures, Regime, Share};
pub use method::MethodSummary;
pub use mix::{Mix, MixPoint, of_best};
pub use points::{EpisodeSummary, PointResult, PointSummary, TaskScore};
pub use reference::{AnalysisError, Reference, check_name, noun, unit};
pub use summaries::{Estimated, Summaries};
pub use training::{LOSS, LearnerSummary, SMOOTHED_OVER, TrainingSummary};
pub use whole::{Analysis, Standing};
pub use winners::Winner;

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
mod episodes;
mod error;
pub mod estimator;
mod evidence;
mod failing;
mod family_share;
pub mod joined;
mod measures;
mod method;
mod mix;
mod naming;
mod pairs;
mod points;
mod ranking;
mod reference;
pub mod sensitivity;
mod standing;
mod statistics;
mod summaries;
mod training;
mod whole;
mod winners;

pub use crate::store::figures::{LAST_EPISODES, RETURN};
pub use board::{Board, BoardPoint};
pub use comparison::{Comparison, FEWEST_SEEDS_FOR_PLACES, Profile};
pub use episodes::EpisodeSummary;
pub use error::AnalysisError;
pub use measures::{Measures, NoMeasures, Regime, Share};
pub use method::{MethodSummary, TuningSummary};
pub use mix::{Mix, MixPoint};
pub use naming::{noun, unit};
pub use pairs::{Decided, Pair};
pub use points::{PointResult, PointSummary, TaskScore};
pub use ranking::OnCommonPoints;
pub use reference::{Reference, check_name};
pub use standing::Standing;
pub use summaries::{Estimated, Summaries};
pub use training::{LOSS, LearnerSummary, SMOOTHED_OVER, TrainingSummary};
pub use whole::Analysis;
pub use winners::Winner;

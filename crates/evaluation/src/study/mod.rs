//! How well estimators do on a family whose every point MDP was evaluated: samples are drawn again and again, and what
//! they say is held against the whole family.
//!
//! ```text
//! Analysis of a whole family -> Recorded -> study: samples x estimators x methods -> Cell
//! ```
//!
//! Source: Jayawardana et al. (NeurIPS 2022), section "Evaluate DRL methods on a family of MDPs" and appendix.

mod cell;
mod engine;
mod kind;
mod recorded;

pub use cell::Cell;
pub use engine::{StudyPlan, study};
pub use kind::Kind;
pub use recorded::{Recorded, RecordedMethod, StudyError};

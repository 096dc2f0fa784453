//! The signal programs of methods whose behaviour is one: tables, files for SUMO, and what shows the
//! best method of a point MDP.
//!
//! - **Several trainings** have several plans. All are in the table; the files have that of the
//!   best recorded objective.

mod beside;
pub(super) mod cabinet;
mod config;
pub mod episode;
mod files;
mod program_xml;
pub(super) mod sheets;
mod table;
mod task_plan;
pub(super) mod told;

pub(super) use files::{FOLDER, TABLE, remove_earlier, write};
pub use task_plan::TaskPlan;
pub(super) use task_plan::plans;

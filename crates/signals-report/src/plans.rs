//! The signal programs of methods whose behaviour is one: tables, files for SUMO, and what shows the
//! best method of a point MDP.
//!
//! - **Records keep what signals ran.** Those from before that have the greens of tuned plans in words;
//!   where yellow and all-red are the same everywhere the whole plan follows, elsewhere it is listed
//!   without them.
//! - **Several trainings** have several plans. All are in the table; the files have that of the
//!   best recorded objective.

mod beside;
pub(super) mod cabinet;
mod config;
mod described;
pub mod episode;
mod files;
pub(super) mod left_turns;
mod numbers;
mod program_xml;
mod read;
pub(super) mod sheets;
mod table;
mod task_plan;
pub(super) mod told;

pub(super) use files::{FOLDER, TABLE, remove_earlier, write};
pub(super) use read::plans;
pub use task_plan::{Programs, Source, TaskPlan};

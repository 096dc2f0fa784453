//! The signal programs of methods whose behaviour is one: tables, files for SUMO, and what shows the
//! best method of a point MDP.
//!
//! - **Several trainings** have several plans. All are in the table; the files have that of the
//!   best recorded objective.

pub(super) mod cabinet;
pub mod episode;
mod files;
mod program_xml;
pub(super) mod told;

use crate::shown::TaskPlan;

pub(super) use files::{FOLDER, TABLE, remove_earlier, write};

//! Evaluates methods over a family of point MDPs with a budget, whatever the task is.
//!
//! [`family`] and [`sample`] choose point MDPs, [`run`] plans and does tasks, [`store`] keeps their records,
//! [`analysis`] makes scores and intervals of them with [`stats`] and [`model`], and [`report`]
//! writes them. [`study`] says how wrong estimators are.

pub mod analysis;
pub mod family;
pub mod model;
pub mod published;
pub mod report;
pub mod run;
pub mod sample;
pub mod settings;
pub mod stats;
pub mod store;
pub mod study;

//! What a results directory says, for people: one self-contained page, tables and figures.
//!
//! A report reads `DIR` and writes `DIR/report/`; it runs nothing, and it works with whatever
//! records are there. What it says of the task beyond its records, the domain adds through
//! [`Sections`].

pub mod across;
mod all;
pub mod csv;
mod curves;
mod divisor;
mod error;
mod figure;
pub mod figures;
mod first;
pub mod format;
mod html;
pub mod leaderboard;
mod methods;
mod mix;
mod models;
pub mod page;
pub mod palette;
mod plain;
mod provenance;
mod ranks;
mod sections;
pub mod sensitivity;
pub mod study;
mod summaries;
mod sure;
pub mod svg;
pub mod table;
pub mod text;
pub mod titles;
pub mod transfer;
mod whole;
mod words;
mod write;

pub use error::ReportError;
pub use figure::Figure;
pub use figure::WIDTH;
pub use models::write_models;
pub use plain::Plain;
pub use provenance::CITATIONS;
pub use sections::{About, Look, Metric, Part, Sections, Slot, Spot, Table, Written};
pub use whole::{Report, Runs};
pub use words::Words;
pub use write::{ReportPaths, write, write_to};

//! What a results directory says, for people: one self-contained page, tables and figures.
//!
//! A report reads `DIR` and writes `DIR/report/`; it runs nothing, and it works with whatever
//! records are there. What it says of the task beyond its records, the domain adds through
//! [`Sections`].

pub mod across;
pub mod csv;
pub mod figures;
pub mod findings;
pub mod format;
mod html;
pub mod page;
pub mod palette;
mod published;
mod sections;
pub mod sensitivity;
pub mod study;
pub mod svg;
pub mod table;
mod tables;
pub mod text;
pub mod titles;
pub mod transfer;
mod whole;
mod words;
mod write;

pub use html::CITATIONS;
pub use sections::{
    About, Look, Metric, Part, Plain, ReportError, Sections, Slot, Spot, Table, Written,
};
pub use svg::{Figure, WIDTH};
pub use whole::{Report, Runs};
pub use words::Words;
pub use write::{ReportPaths, write, write_models, write_to};

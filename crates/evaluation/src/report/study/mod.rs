//! What came of a study of estimators: a table, a figure, a page.

mod csv;
mod figure;
mod page;
mod stopping;
mod table;
mod whole;
mod write;

pub use whole::StudyReport;
pub use write::write;

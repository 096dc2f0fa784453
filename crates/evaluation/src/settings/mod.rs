//! Settings of scenarios: how sections declare them, what replaces them, and what to say of one that is
//! wrong.

pub mod default_name;
pub mod named;
pub mod overrides;
pub mod page;
pub use basics::setting;
pub mod source;
mod within;
pub mod wording;

pub use within::{all_within, shortest, within};

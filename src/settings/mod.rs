//! Settings of scenarios: what replaces them, and what to say of one that is wrong.

pub mod default_name;
pub mod overrides;
mod within;
pub mod wording;

pub use within::within;

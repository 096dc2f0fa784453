//! The survey of an extract, from outside.

mod cases;
mod properties;
mod spread;
mod survey;

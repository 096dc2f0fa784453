//! What every crate of tsc-family uses, and what knows of no crate: files that are written safely, hashes,
//! streams of random numbers, settings that are declared once, units, what a machine has, text that is only text, and the
//! name that was probably meant.

pub mod files;
pub mod hash;
pub mod heartbeat;
pub mod machine;
pub mod plain;
pub mod seed;
pub mod setting;
pub mod suggest;
pub mod units;

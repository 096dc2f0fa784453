//! Most bytes of files that are read into memory as a whole: far above what anybody has, and far below what a machine has.

/// Of a scenario.
pub const SCENARIO: u64 = 1 << 24;

/// Of a table that a scenario names.
pub const TABLE: u64 = sheet::file::TABLE_BYTES;

/// Of a file of ours that says something of many point MDPs or tasks: manifest, plan, sample, places, index.
pub const DOCUMENT: u64 = 1 << 30;

/// Of a record.
pub const RECORD: u64 = 1 << 30;

/// Of the files of a network that we made, and of a configuration of SUMO.
pub const NETWORK: u64 = 1 << 28;

/// Of a model or checkpoint, which may hold what a learner has seen.
pub const ARCHIVE: u64 = 1 << 33;

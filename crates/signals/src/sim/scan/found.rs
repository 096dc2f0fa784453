//! What is found in a file of a scenario.

use std::ops::Range;

use super::super::departures::Departures;
use super::super::obstacle::{Obstacle, Way};

/// A name of a file, and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Named {
    /// The name as it is written.
    pub name: String,
    /// Its bytes.
    pub at: Range<u64>,
}

/// What a private copy has in place of some bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct Edit {
    /// The bytes.
    pub at: Range<u64>,
    /// What stands there instead.
    pub with: String,
}

/// What is found in a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scanned {
    /// The files that it names.
    pub named: Vec<Named>,
    /// What a private copy has otherwise.
    pub edits: Vec<Edit>,
    /// What a private copy has without classes of vehicles that SUMO 1.15 does not know.
    pub newer_classes: Vec<Edit>,
    /// Elements that switch programs by the clock.
    pub day_plan: Vec<Range<u64>>,
    /// What stands in the way.
    pub obstacles: Vec<Obstacle>,
    /// What goes nowhere, where something does: how many outputs, and the first one with its place.
    pub outputs: Option<(u32, String)>,
    /// What counts in place of what it says, in words.
    pub notes: Vec<String>,
    /// Its vehicles.
    pub departures: Departures,
}

/// Something of a file before its line is known.
pub(super) struct Found {
    pub(super) position: u64,
    pub(super) reason: String,
    pub(super) way: Option<Way>,
    /// How many of the kind there are.
    pub(super) count: u32,
}

//! What is worth a look at an intersection of a family.

use serde::{Serialize, Serializer};

/// What is worth a look at an intersection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Flag {
    /// Nothing has green at another time than anything else.
    OneGreen,
    /// How it was read from the map.
    Map(osm_signals::flags::Flag),
}

impl Flag {
    /// Returns the flag in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::OneGreen => "a single green",
            Self::Map(flag) => flag.words(),
        }
    }
}

impl Serialize for Flag {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::OneGreen => serializer.serialize_str("one_green"),
            Self::Map(flag) => flag.serialize(serializer),
        }
    }
}

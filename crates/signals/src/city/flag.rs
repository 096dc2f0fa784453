//! What is worth a look at an intersection of a family.

use serde::Serialize;

/// What is worth a look at an intersection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Flag {
    /// Nothing has green at another time than anything else.
    OneGreen,
    /// How it was read from the map.
    #[serde(untagged)]
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

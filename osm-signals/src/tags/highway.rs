//! Classes of drivable streets.

use serde::{Deserialize, Serialize};

/// Class of a drivable street: its `highway` tag.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Highway {
    /// `motorway`.
    Motorway,
    /// `trunk`.
    Trunk,
    /// `primary`.
    Primary,
    /// `secondary`.
    Secondary,
    /// `tertiary`.
    Tertiary,
    /// `unclassified`.
    Unclassified,
    /// `residential`.
    Residential,
    /// `living_street`.
    LivingStreet,
    /// `trunk_link`.
    TrunkLink,
    /// `primary_link`.
    PrimaryLink,
    /// `secondary_link`.
    SecondaryLink,
    /// `tertiary_link`.
    TertiaryLink,
    /// `motorway_link`: a ramp.
    MotorwayLink,
    /// Any other value that the filter lets through, such as `road`.
    Other,
}

impl Highway {
    /// All classes with the names that files and settings use.
    pub const NAMES: [(Self, &'static str); 14] = [
        (Self::Motorway, "motorway"),
        (Self::Trunk, "trunk"),
        (Self::Primary, "primary"),
        (Self::Secondary, "secondary"),
        (Self::Tertiary, "tertiary"),
        (Self::Unclassified, "unclassified"),
        (Self::Residential, "residential"),
        (Self::LivingStreet, "living_street"),
        (Self::TrunkLink, "trunk_link"),
        (Self::PrimaryLink, "primary_link"),
        (Self::SecondaryLink, "secondary_link"),
        (Self::TertiaryLink, "tertiary_link"),
        (Self::MotorwayLink, "motorway_link"),
        (Self::Other, "other"),
    ];

    /// Returns the name.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize].1
    }

    /// Returns whether it is a motorway or a ramp of one.
    pub fn is_motorway(self) -> bool {
        matches!(self, Self::Motorway | Self::MotorwayLink)
    }

    /// Returns whether it is a link, such as a slip lane.
    pub fn is_link(self) -> bool {
        use Highway::{MotorwayLink, PrimaryLink, SecondaryLink, TertiaryLink, TrunkLink};
        matches!(self, TrunkLink | PrimaryLink | SecondaryLink | TertiaryLink | MotorwayLink)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stand_in_the_order_of_the_classes() {
        assert!(Highway::NAMES.iter().enumerate().all(|(i, (class, _))| *class as usize == i));
    }
}

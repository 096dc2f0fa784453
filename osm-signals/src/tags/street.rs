//! What the tags of a drivable way say.

use super::closed::open_lanes;
use super::highway::Highway;
use super::lanes::{LaneTags, TurnTags};
use super::speed::SpeedTags;
use super::{Direction, Tags, direction, drivable, tag};
use crate::driving_side::DrivingSide;
use crate::oddities::Oddities;

/// A drivable way's tags.
#[derive(Debug, Clone, PartialEq)]
pub struct Street {
    /// Its class.
    pub highway: Highway,
    /// Which way traffic goes.
    pub direction: Direction,
    /// Whether it is part of a roundabout or traffic circle.
    pub roundabout: bool,
    /// Numbers of lanes.
    pub lanes: LaneTags,
    /// Numbers of lanes if traffic keeps to the other side, where they differ for a bus lane on one side.
    pub lanes_mirrored: Option<Box<LaneTags>>,
    /// Turns that lanes are marked for; most ways have none.
    pub turns: Option<Box<TurnTags>>,
    /// Speed limits.
    pub speed: SpeedTags,
    /// Side of the street that traffic keeps to on it.
    pub driving_side: Option<DrivingSide>,
    /// Its name, or else its number.
    pub name: Option<Box<str>>,
}

impl Street {
    /// Returns what the tags of a way say; `None` if it is not drivable.
    ///
    /// Unusable values are ignored and counted in `oddities`.
    pub fn parse(way: i64, tags: &Tags<'_>, oddities: &mut Oddities) -> Option<Self> {
        if !drivable(tags) {
            return None;
        }
        let value = tag(tags, "highway")?;
        let known = Highway::NAMES.iter().find(|(_, name)| *name == value);
        let highway = known.map_or(Highway::Other, |(class, _)| *class);
        let roundabout = matches!(tag(tags, "junction"), Some("roundabout" | "circular"));
        let name = tag(tags, "name").or_else(|| tag(tags, "ref")).filter(|n| !n.is_empty());
        let direction = direction(tags);
        let lanes = open_lanes(way, tags, direction, DrivingSide::Right, oddities);
        let left_hand = || {
            // What is odd was counted.
            let none = &mut Oddities::default();
            Box::new(open_lanes(way, tags, direction, DrivingSide::Left, none))
        };
        let told_by_side = tags.iter().any(|(key, _)| key.starts_with("busway:"));
        Some(Self {
            highway,
            direction,
            roundabout,
            lanes_mirrored: told_by_side.then(left_hand).filter(|left| **left != lanes),
            lanes,
            turns: TurnTags::parse(way, tags, oddities).map(Box::new),
            speed: SpeedTags::parse(way, tags, oddities),
            driving_side: match tag(tags, "driving_side") {
                Some("left") => Some(DrivingSide::Left),
                Some("right") => Some(DrivingSide::Right),
                _ => None,
            },
            name: name.map(Into::into),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn street(tags: &Tags<'_>) -> Option<Street> {
        Street::parse(1, tags, &mut Oddities::default())
    }

    #[test]
    fn oneway_has_three_ways_to_say_backward() {
        for value in ["-1", "reverse", "T"] {
            let street = street(&[("highway", "primary"), ("oneway", value)]).unwrap();
            assert_eq!(street.direction, Direction::Backward, "{value}");
        }
        for value in ["yes", "true", "1", "F"] {
            let street = street(&[("highway", "primary"), ("oneway", value)]).unwrap();
            assert_eq!(street.direction, Direction::Forward, "{value}");
        }
        for value in ["no", "reversible", "false"] {
            let street = street(&[("highway", "primary"), ("oneway", value)]).unwrap();
            assert_eq!(street.direction, Direction::Both, "{value}");
        }
    }

    #[test]
    fn a_roundabout_is_one_way() {
        let street = street(&[("highway", "primary"), ("junction", "roundabout")]).unwrap();
        assert!(street.roundabout);
        assert_eq!(street.direction, Direction::Forward);
    }
}

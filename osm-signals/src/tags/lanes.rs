//! Numbers of lanes and the turns that lanes are marked for.

use super::{Direction, Tags, closes, lane_by_lane, tag};
use crate::error::brief;
use crate::oddities::Oddities;

/// Most lanes of a way that are believed, both directions together.
pub const MAX_LANES: u8 = 20;

/// The turns that a lane is marked for, as a set; an empty set says nothing.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TurnLane(u8);

impl TurnLane {
    /// Nothing is marked, or `none`.
    pub const UNMARKED: Self = Self(0);
    /// Left turns of any sharpness.
    pub const LEFT: Self = Self(1);
    /// Straight on, also after merging into a neighbouring lane.
    pub const THROUGH: Self = Self(2);
    /// Right turns of any sharpness.
    pub const RIGHT: Self = Self(4);
    /// U-turns.
    pub const REVERSE: Self = Self(8);

    #[must_use]
    const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Returns whether only left turns are marked, of which a U-turn is one in right-hand traffic.
    pub fn is_left_only(self) -> bool {
        self != Self::UNMARKED && Self::LEFT.with(Self::REVERSE).has(self)
    }

    #[must_use]
    fn mirrored(self) -> Self {
        let same = Self(self.0 & (Self::THROUGH.0 | Self::REVERSE.0));
        let left = if self.has(Self::RIGHT) { Self::LEFT } else { Self::UNMARKED };
        let right = if self.has(Self::LEFT) { Self::RIGHT } else { Self::UNMARKED };
        same.with(left).with(right)
    }

    fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Parses the marks of one lane, such as `through;right`; `None` for an unknown one.
    fn parse(text: &str) -> Option<Self> {
        text.split(';').map(str::trim).try_fold(Self::UNMARKED, |set, turn| {
            Some(set.with(match turn {
                "" | "none" => Self::UNMARKED,
                "left" | "slight_left" | "sharp_left" => Self::LEFT,
                "reverse" => Self::REVERSE,
                "through" | "merge_to_left" | "merge_to_right" => Self::THROUGH,
                "right" | "slight_right" | "sharp_right" => Self::RIGHT,
                _ => return None,
            }))
        })
    }
}

/// `lanes` and its suffixes, as tagged; 0 stands for none tagged, except for the centre lane.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LaneTags {
    /// `lanes`: both directions together.
    pub total: Option<u8>,
    /// `lanes:forward`.
    pub forward: Option<u8>,
    /// `lanes:backward`.
    pub backward: Option<u8>,
    /// `lanes:both_ways`: a centre lane for turns from both directions.
    pub both_ways: Option<u8>,
}

impl LaneTags {
    pub(super) fn parse(
        way: i64,
        tags: &Tags<'_>,
        direction: Direction,
        oddities: &mut Oddities,
    ) -> Self {
        let mut number = |key: &str, least: u8| {
            let text = tag(tags, key)?;
            let lanes = lanes(text).filter(|lanes| (least..=MAX_LANES).contains(lanes));
            if lanes.is_none() {
                oddities.add("unusable number of lanes", || {
                    format!("way {way}, {key}={}", brief(text))
                });
            }
            lanes
        };
        let mut lanes = Self {
            total: number("lanes", 1),
            forward: number("lanes:forward", 1),
            backward: number("lanes:backward", 1),
            both_ways: number("lanes:both_ways", 0),
        };
        if lanes.leave_nothing(direction) {
            oddities.add("lanes contradict", || {
                let tags = [
                    ("lanes", lanes.total),
                    ("lanes:forward", lanes.forward),
                    ("lanes:backward", lanes.backward),
                ];
                let tags = tags.iter().filter_map(|(key, n)| n.map(|n| format!(", {key}={n}")));
                format!("way {way}{}", tags.collect::<String>())
            });
            (lanes.forward, lanes.backward) = (None, None);
        }
        lanes
    }

    /// Returns the lanes of a one-way street in its direction: `lanes` counts one against it for buses, too.
    pub fn one_way(self, forward: bool) -> Option<u8> {
        let (own, other) = match forward {
            true => (self.forward, self.backward),
            false => (self.backward, self.forward),
        };
        let rest = || self.total?.checked_sub(other?).filter(|rest| *rest > 0);
        own.or_else(rest).or(self.total)
    }

    /// Returns whether one direction of a two-way street would have all lanes, so that nothing is
    /// left for the other one, of which no tag speaks.
    fn leave_nothing(self, direction: Direction) -> bool {
        let one = match (self.forward, self.backward) {
            (Some(one), None) | (None, Some(one)) => one,
            _ => return false,
        };
        direction == Direction::Both && self.total.is_some_and(|total| total <= one && total > 1)
    }
}

/// Returns a number of lanes; the smallest of a list, as netconvert takes it.
fn lanes(text: &str) -> Option<u8> {
    let numbers = text.split([';', '|']).map(|part| part.trim().parse::<u8>().ok());
    numbers.collect::<Option<Vec<_>>>()?.into_iter().min()
}

/// `turn:lanes` and its suffixes: lanes from left to right in the direction of travel.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TurnTags {
    /// `turn:lanes`: of a one-way street in its direction.
    pub plain: Box<[TurnLane]>,
    /// `turn:lanes:forward`.
    pub forward: Box<[TurnLane]>,
    /// `turn:lanes:backward`.
    pub backward: Box<[TurnLane]>,
}

impl TurnTags {
    pub(super) fn parse(way: i64, tags: &Tags<'_>, oddities: &mut Oddities) -> Option<Self> {
        let mut lanes = |suffix: &str| {
            let key = format!("turn:lanes{suffix}");
            let Some(text) = tag(tags, &key) else { return Box::default() };
            match turn_lanes(text, lane_by_lane(tags, suffix)) {
                Some(lanes) => lanes,
                None => {
                    oddities
                        .add("unusable turn lanes", || format!("way {way}, {key}={}", brief(text)));
                    Box::default()
                }
            }
        };
        let turns =
            Self { plain: lanes(""), forward: lanes(":forward"), backward: lanes(":backward") };
        (turns != Self::default()).then_some(turns)
    }

    /// Exchanges left and right: the order of the lanes and their turns.
    pub fn mirror(&mut self) {
        for lanes in [&mut self.plain, &mut self.forward, &mut self.backward] {
            lanes.reverse();
            for lane in lanes.iter_mut() {
                *lane = lane.mirrored();
            }
        }
    }
}

/// Parses turn lanes, leaving out those that are closed to motor vehicles, such as cycle lanes.
fn turn_lanes(text: &str, access: Option<Vec<&str>>) -> Option<Box<[TurnLane]>> {
    let lanes: Option<Vec<_>> = text.split('|').map(TurnLane::parse).collect();
    let lanes = lanes.filter(|lanes| lanes.len() <= usize::from(MAX_LANES))?;
    let access = access.filter(|access| access.len() == lanes.len()).unwrap_or_default();
    let open = |i: usize| !access.get(i).is_some_and(|value| closes(value));
    let open: Vec<_> = (0..lanes.len()).filter(|i| open(*i)).map(|i| lanes[i]).collect();
    Some(open.into())
}

#[cfg(test)]
mod tests {
    use super::super::closed::open_lanes;
    use super::*;
    use crate::driving_side::DrivingSide;

    fn lane_tags(tags: &Tags<'_>) -> (LaneTags, u64) {
        let mut oddities = Oddities::default();
        let lanes = LaneTags::parse(1, tags, Direction::Both, &mut oddities);
        (lanes, oddities.count("unusable number of lanes"))
    }

    #[test]
    fn the_smallest_number_of_a_list_counts() {
        assert_eq!(lane_tags(&[("lanes", "3;2")]).0.total, Some(2));
        assert_eq!(lane_tags(&[("lanes", " 4 ")]).0.total, Some(4));
    }

    #[test]
    fn unusable_numbers_are_ignored_and_counted() {
        for text in ["0", "-1", "many", "9999", "", "2.5", "2;many"] {
            assert_eq!(lane_tags(&[("lanes", text)]), (LaneTags::default(), 1), "{text:?}");
        }
        assert_eq!(lane_tags(&[("lanes:both_ways", "0")]).1, 0);
    }

    #[test]
    fn a_direction_that_has_all_lanes_of_a_two_way_street_is_ignored_and_counted() {
        let contradictions = |tags: &Tags<'_>, direction| {
            let mut oddities = Oddities::default();
            let lanes = LaneTags::parse(1, tags, direction, &mut oddities);
            (lanes.forward.or(lanes.backward), oddities.count("lanes contradict"))
        };
        for key in ["lanes:forward", "lanes:backward"] {
            for (total, own) in [("3", "3"), ("2", "4")] {
                let tags = [("lanes", total), (key, own)];
                assert_eq!(contradictions(&tags, Direction::Both), (None, 1), "{tags:?}");
            }
        }
        let all = [("lanes", "3"), ("lanes:forward", "3")];
        assert_eq!(contradictions(&all, Direction::Forward), (Some(3), 0));
        let some = [("lanes", "3"), ("lanes:forward", "2")];
        assert_eq!(contradictions(&some, Direction::Both), (Some(2), 0));
        let both = [("lanes", "3"), ("lanes:forward", "3"), ("lanes:backward", "1")];
        assert_eq!(contradictions(&both, Direction::Both), (Some(3), 0));
    }

    #[test]
    fn of_a_one_way_street_its_own_direction_counts() {
        let lanes = |tags: &Tags<'_>, direction: Direction| {
            let lanes =
                open_lanes(1, tags, direction, DrivingSide::Right, &mut Oddities::default());
            lanes.one_way(direction == Direction::Forward)
        };
        let against = [("lanes", "3"), ("lanes:forward", "2"), ("lanes:backward", "1")];
        assert_eq!(lanes(&against, Direction::Forward), Some(2));
        assert_eq!(lanes(&against, Direction::Backward), Some(1));
        assert_eq!(lanes(&against[..2], Direction::Forward), Some(2));
        assert_eq!(lanes(&[against[0], against[2]], Direction::Forward), Some(2));
        assert_eq!(lanes(&[("lanes", "2"), against[1]], Direction::Backward), Some(2));
        let closed = [("lanes", "4"), ("access:lanes", "yes|yes|yes|no")];
        assert_eq!(lanes(&closed, Direction::Forward), Some(3));
        assert_eq!(lanes(&closed, Direction::Backward), Some(3));
    }

    fn turns(text: &str) -> Option<Vec<TurnLane>> {
        turn_lanes(text, None).map(Into::into)
    }

    #[test]
    fn turns_are_read_lane_by_lane() {
        let (left, through, right) = (TurnLane::LEFT, TurnLane::THROUGH, TurnLane::RIGHT);
        assert_eq!(
            turns("left;reverse|through|through;slight_right|sharp_right"),
            Some(vec![left.with(TurnLane::REVERSE), through, through.with(right), right])
        );
        assert_eq!(turns("||none"), Some(vec![TurnLane::UNMARKED; 3]));
        assert_eq!(turns("merge_to_left|through"), Some(vec![through; 2]));
        assert_eq!(turns("left|sideways"), None);
    }

    #[test]
    fn a_u_turn_crosses_opposing_traffic_on_either_side() {
        let lanes = turns("left;reverse|reverse|through;reverse|right").unwrap();
        assert_eq!(
            lanes.iter().map(|l| l.is_left_only()).collect::<Vec<_>>(),
            [true, true, false, false]
        );
        let left_hand = turns("left|through;reverse|reverse|reverse;right").unwrap();
        let mut tags = TurnTags { forward: left_hand.into(), ..TurnTags::default() };
        tags.mirror();
        assert_eq!(*tags.forward, *lanes);
    }

    #[test]
    fn cycle_lanes_among_turn_lanes_are_left_out() {
        let tags = [("turn:lanes", "left|through|through|right"), ("vehicle:lanes", "yes||no|")];
        let turns = TurnTags::parse(1, &tags, &mut Oddities::default()).unwrap();
        assert_eq!(*turns.plain, [TurnLane::LEFT, TurnLane::THROUGH, TurnLane::RIGHT]);
    }
}

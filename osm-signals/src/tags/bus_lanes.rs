//! Bus lanes that are told by their number or their side, and not lane by lane: `lanes:bus`, `lanes:psv`, `busway`.
//! `lanes` counts them.

use super::direction::Direction;
use super::lanes::LaneTags;
use super::value::{Tags, tag};
use crate::driving_side::DrivingSide;

/// Tags with numbers of lanes for buses.
const NUMBERS: [&str; 2] = ["lanes:bus", "lanes:psv"];

/// Values of `busway` that are a lane of the road in the direction of traffic.
const LANE: &str = "lane";

/// Returns whether tags may tell bus lanes by their side.
pub(super) fn tell_sides(tags: &Tags<'_>) -> bool {
    tags.iter().any(|(key, _)| key.starts_with("busway:"))
}

/// Leaves bus lanes out of the numbers of lanes, where something is left.
///
/// # Arguments
///
/// * `side`: which traffic keeps to; of a two-way street it tells which direction has the lanes on the left.
pub(super) fn leave_out_bus_lanes(
    lanes: &mut LaneTags,
    tags: &Tags<'_>,
    direction: Direction,
    side: DrivingSide,
) {
    let (forward, backward) = match direction {
        Direction::Both => on_both(tags, side),
        one_way => {
            let own = if one_way == Direction::Forward { ":forward" } else { ":backward" };
            let count = number(tags, own).or_else(|| number(tags, "")).unwrap_or_else(|| {
                u8::from(["", ":left", ":right", ":both"].iter().any(|side| is_lane(tags, side)))
            });
            if one_way == Direction::Forward { (count, 0) } else { (0, count) }
        }
    };
    let less = |n: Option<u8>, fewer: u8| match n {
        Some(n) => n.checked_sub(fewer).filter(|left| *left > 0).map(Some),
        None => Some(None),
    };
    let Some(fewer) = forward.checked_add(backward).filter(|fewer| *fewer > 0) else { return };
    let left = LaneTags {
        total: match less(lanes.total, fewer) {
            Some(total) => total,
            None => return,
        },
        ..*lanes
    };
    let (Some(own), Some(other)) = (less(lanes.forward, forward), less(lanes.backward, backward))
    else {
        return;
    };
    let half = || {
        // Where only the total is known and its halves differ now, each direction has its own.
        let half = lanes.total.filter(|total| total % 2 == 0 && forward != backward)? / 2;
        let both = (half.checked_sub(forward)?, half.checked_sub(backward)?);
        (both.0 > 0 && both.1 > 0).then_some(both)
    };
    let halves = (direction == Direction::Both && lanes.both_ways.unwrap_or(0) == 0)
        .then(half)
        .flatten()
        .filter(|_| own.is_none() && other.is_none());
    *lanes = LaneTags {
        forward: halves.map(|h| h.0).or(own),
        backward: halves.map(|h| h.1).or(other),
        ..left
    };
}

/// Returns the bus lanes of both directions of a two-way street.
fn on_both(tags: &Tags<'_>, side: DrivingSide) -> (u8, u8) {
    let (forward, backward) = (number(tags, ":forward"), number(tags, ":backward"));
    if forward.is_some() || backward.is_some() {
        return (forward.unwrap_or(0), backward.unwrap_or(0));
    }
    if let Some(all) = number(tags, "") {
        // An odd one is in a direction that no tag tells.
        return (all / 2, all / 2);
    }
    let both = is_lane(tags, "") || is_lane(tags, ":both");
    let (against, along) = side.swapped((":left", ":right"));
    (u8::from(both || is_lane(tags, along)), u8::from(both || is_lane(tags, against)))
}

fn number(tags: &Tags<'_>, suffix: &str) -> Option<u8> {
    NUMBERS.iter().find_map(|key| tag(tags, &format!("{key}{suffix}"))?.trim().parse().ok())
}

fn is_lane(tags: &Tags<'_>, side: &str) -> bool {
    tag(tags, &format!("busway{side}")) == Some(LANE)
}

#[cfg(test)]
mod tests {
    use super::super::closed::open_lanes;
    use super::*;
    use crate::oddities::Oddities;

    fn left(tags: &Tags<'_>, direction: Direction) -> (Option<u8>, Option<u8>, Option<u8>) {
        left_on(DrivingSide::Right, tags, direction)
    }

    fn left_on(
        side: DrivingSide,
        tags: &Tags<'_>,
        direction: Direction,
    ) -> (Option<u8>, Option<u8>, Option<u8>) {
        let lanes = open_lanes(1, tags, direction, side, &mut Oddities::default());
        (lanes.total, lanes.forward, lanes.backward)
    }

    #[test]
    fn bus_lanes_that_are_counted_by_number_are_left_out() {
        let four = ("lanes", "4");
        let both = |tags: &Tags<'_>| left(tags, Direction::Both);
        assert_eq!(both(&[four, ("lanes:psv:forward", "1")]), (Some(3), Some(1), Some(2)));
        assert_eq!(both(&[four, ("lanes:bus", "2")]), (Some(2), None, None));
        assert_eq!(both(&[("lanes", "3"), ("lanes:bus:backward", "1")]), (Some(2), None, None));
        let split = [("lanes", "5"), ("lanes:forward", "3"), ("lanes:psv:forward", "1")];
        assert_eq!(both(&split), (Some(4), Some(2), None));
        assert_eq!(left(&[("lanes", "3"), ("lanes:psv", "1")], Direction::Forward).0, Some(2));
        // Nothing would be left, and what is no number says nothing.
        assert_eq!(left(&[("lanes", "1"), ("lanes:psv", "1")], Direction::Forward).0, Some(1));
        assert_eq!(both(&[four, ("lanes:psv", "many")]), (Some(4), None, None));
        assert_eq!(both(&[four, ("lanes:psv", "255"), ("lanes:bus", "3")]).0, Some(2));
    }

    #[test]
    fn bus_lanes_that_are_told_by_their_side_are_left_out() {
        let four = ("lanes", "4");
        assert_eq!(left(&[four, ("busway", "lane")], Direction::Both), (Some(2), None, None));
        let right = [four, ("busway:right", "lane")];
        assert_eq!(left(&right, Direction::Both), (Some(3), Some(1), Some(2)));
        assert_eq!(left(&right, Direction::Forward), (Some(3), None, None));
        let left_hand = left_on(DrivingSide::Left, &right, Direction::Both);
        assert_eq!(left_hand, (Some(3), Some(2), Some(1)));
        assert_eq!(left(&[four, ("busway", "opposite_lane")], Direction::Forward).0, Some(4));
    }

    #[test]
    fn what_is_told_lane_by_lane_is_not_taken_twice() {
        let tags = [("lanes", "3"), ("lanes:psv", "1"), ("access:lanes", "yes|yes|private")];
        assert_eq!(left(&tags, Direction::Forward).0, Some(2));
    }
}

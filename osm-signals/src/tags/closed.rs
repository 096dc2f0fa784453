//! Lanes that are closed to motor vehicles: bus lanes, which `lanes` counts, and cycle lanes, which it does not. Tags tell
//! them lane by lane, or bus lanes by their number or side (`lanes:bus`, `lanes:psv`, `busway`).

use super::lanes::{LaneTags, MAX_LANES};
use super::{Direction, Tags, closes, lane_by_lane, tag};
use crate::driving_side::DrivingSide;
use crate::oddities::Oddities;

/// Tags that say lane by lane whether buses may use it.
const BUS_ACCESS: [&str; 3] = ["bus:lanes", "psv:lanes", "taxi:lanes"];

/// The tag that says lane by lane whether bicycles may use it.
const CYCLE_ACCESS: [&str; 1] = ["bicycle:lanes"];

/// Tags with numbers of lanes for buses.
const NUMBERS: [&str; 2] = ["lanes:bus", "lanes:psv"];

/// Values of `busway` that are a lane of the road in the direction of traffic.
const LANE: &str = "lane";

/// Lanes of one direction of which some are closed to motor vehicles and some are not.
struct Closed {
    lanes: u8,
    closed: u8,
    /// Those of them that are no cycle lanes.
    wide: u8,
}

impl Closed {
    fn of(tags: &Tags<'_>, suffix: &str) -> Option<Self> {
        if !tags.iter().any(|(key, _)| key.contains(":lanes")) {
            return None;
        }
        let access =
            lane_by_lane(tags, suffix).filter(|lanes| lanes.len() <= usize::from(MAX_LANES))?;
        let are_for = |keys: &[&str], i: usize| {
            let mut lanes = keys.iter().filter_map(|key| tag(tags, &format!("{key}{suffix}")));
            lanes.any(|lanes| {
                matches!(lanes.split('|').nth(i).map(str::trim), Some("designated" | "yes"))
            })
        };
        let shut: Vec<usize> = (0..access.len()).filter(|i| closes(access[*i])).collect();
        let narrow = |i: &&usize| are_for(&CYCLE_ACCESS, **i) && !are_for(&BUS_ACCESS, **i);
        let closed = shut.len() as u8;
        let wide = closed - shut.iter().filter(narrow).count() as u8;
        let lanes = access.len() as u8;
        (closed > 0 && closed < lanes).then_some(Self { lanes, closed, wide })
    }

    /// Returns how many of the closed lanes are among the lanes of their direction, of which there are so
    /// many: all if there are as many as are listed, none if there are fewer. Where the number is not known,
    /// bus lanes are among them and cycle lanes are not.
    fn among(&self, lanes: Option<u8>) -> u8 {
        match lanes {
            Some(lanes) if lanes == self.lanes => self.closed,
            Some(_) => 0,
            None => self.wide,
        }
    }
}

pub(super) fn open_lanes(
    way: i64,
    tags: &Tags<'_>,
    direction: Direction,
    side: DrivingSide,
    oddities: &mut Oddities,
) -> LaneTags {
    let mut lanes = LaneTags::parse(way, tags, direction, oddities);
    if !leave_out_closed(&mut lanes, tags, direction) {
        leave_out_bus_lanes(&mut lanes, tags, direction, side);
    }
    lanes
}

/// Leaves out the lanes that are closed where they are counted; returns whether tags say lane by lane which are.
fn leave_out_closed(lanes: &mut LaneTags, tags: &Tags<'_>, direction: Direction) -> bool {
    if direction == Direction::Both {
        let (forward, backward) = (Closed::of(tags, ":forward"), Closed::of(tags, ":backward"));
        let is_listed = forward.is_some() || backward.is_some();
        let given = |own: Option<u8>, closed: &Option<Closed>| {
            own.or(closed.as_ref().map(|closed| closed.lanes))
        };
        let rest = |other: Option<u8>| {
            lanes.total?.checked_sub(lanes.both_ways.unwrap_or(0))?.checked_sub(other?)
        };
        let counted = (
            lanes.forward.or_else(|| rest(given(lanes.backward, &backward))),
            lanes.backward.or_else(|| rest(given(lanes.forward, &forward))),
        );
        let less = |closed: &Option<Closed>, counted| {
            closed.as_ref().map_or(0, |closed| closed.among(counted))
        };
        let (fewer_forward, fewer_backward) =
            (less(&forward, counted.0), less(&backward, counted.1));
        // Where no number says how many lanes a direction has, those that are listed do.
        let open = |closed: &Option<Closed>| {
            let closed = closed.as_ref().filter(|c| lanes.total.is_none_or(|t| c.lanes < t))?;
            Some(closed.lanes - closed.closed)
        };
        let (forward, backward) = match (lanes.forward, lanes.backward) {
            (None, None) => (open(&forward), open(&backward)),
            (own, other) => (
                own.map(|n| n.saturating_sub(fewer_forward)),
                other.map(|n| n.saturating_sub(fewer_backward)),
            ),
        };
        (lanes.forward, lanes.backward) = (forward, backward);
        lanes.total = lanes.total.map(|n| n.saturating_sub(fewer_forward + fewer_backward));
        return is_listed;
    }
    let forward = direction == Direction::Forward;
    let closed = Closed::of(tags, if forward { ":forward" } else { ":backward" });
    let Some(closed) = closed.or_else(|| Closed::of(tags, "")) else { return false };
    let fewer = closed.among(lanes.one_way(forward));
    let own = if forward { &mut lanes.forward } else { &mut lanes.backward };
    *own = own.map(|n| n.saturating_sub(fewer));
    lanes.total = lanes.total.map(|n| n.saturating_sub(fewer));
    true
}

/// Leaves bus lanes out of the numbers of lanes, where something is left.
/// `side` tells which direction of a two-way street has the lanes on the left.
fn leave_out_bus_lanes(
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
    use super::*;

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

    #[test]
    fn bus_lanes_that_are_counted_are_left_out_and_cycle_lanes_are_not_counted() {
        let numbers = |tags: &Tags<'_>| {
            let lanes =
                open_lanes(1, tags, Direction::Both, DrivingSide::Right, &mut Oddities::default());
            (lanes.total, lanes.forward, lanes.backward)
        };
        let closed = ("vehicle:lanes:forward", "yes|yes|no");
        let buses = ("bus:lanes:forward", "yes|yes|designated");
        let (total, forward, backward) =
            (("lanes", "4"), ("lanes:forward", "3"), ("lanes:backward", "1"));
        let left = (Some(3), Some(2), Some(1));
        assert_eq!(numbers(&[total, forward, backward, closed]), left);
        assert_eq!(numbers(&[total, forward, closed]), (Some(3), Some(2), None));
        assert_eq!(numbers(&[total, backward, closed]), (Some(3), None, Some(1)));
        assert_eq!(numbers(&[total, closed, buses]), (Some(3), Some(2), None));
        assert_eq!(numbers(&[total, closed]), (Some(3), Some(2), None));
        let bicycles = ("bicycle:lanes:forward", "||designated");
        assert_eq!(numbers(&[total, closed, bicycles]), (Some(4), Some(2), None));
        assert_eq!(numbers(&[total, closed, bicycles, buses]), (Some(3), Some(2), None));
        // A cycle lane: two lanes of three that are listed.
        let cycles = [("lanes", "3"), ("lanes:forward", "2"), closed];
        assert_eq!(numbers(&cycles), (Some(3), Some(2), None));
        // Nothing is open that could be counted.
        let all = [("lanes", "2"), ("vehicle:lanes:forward", "no"), ("lanes:forward", "1")];
        assert_eq!(numbers(&all), (Some(2), Some(1), None));
    }
}

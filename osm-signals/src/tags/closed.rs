//! Lanes that are closed to motor vehicles: bus lanes, which `lanes` counts, and cycle lanes, which it does not.

use super::access::{closes, lane_by_lane};
use super::bus_lanes::leave_out_bus_lanes;
use super::direction::Direction;
use super::lanes::{LaneTags, MAX_LANES};
use super::value::{Tags, tag};
use crate::driving_side::DrivingSide;
use crate::oddities::Oddities;

/// Tags that say lane by lane whether buses may use it.
const BUS_ACCESS: [&str; 3] = ["bus:lanes", "psv:lanes", "taxi:lanes"];

/// The tag that says lane by lane whether bicycles may use it.
const CYCLE_ACCESS: [&str; 1] = ["bicycle:lanes"];

/// Lanes of one direction of which some are closed to motor vehicles and some are not.
struct Closed {
    /// All that are listed.
    lanes: u8,
    /// Those that are closed.
    closed: u8,
    /// Those of them that are no cycle lanes.
    wide: u8,
}

impl Closed {
    /// Returns what is listed for a suffix of `lanes`.
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

/// Returns the numbers of lanes without those that are closed to motor vehicles, such as bus lanes.
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

#[cfg(test)]
mod tests {
    use super::*;

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

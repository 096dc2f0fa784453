//! Which way traffic goes on a street.

use super::access::is_closed;
use super::value::{Tags, tag};

/// Which way traffic goes, relative to the order of a way's nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Both ways.
    Both,
    /// One-way, as the nodes go.
    Forward,
    /// One-way, against the nodes (`oneway=-1`).
    Backward,
}

impl Direction {
    /// Returns whether traffic goes as the nodes go (`true`) or against them (`false`).
    pub fn allows(self, forward: bool) -> bool {
        match self {
            Self::Both => true,
            Self::Forward => forward,
            Self::Backward => !forward,
        }
    }
}

/// Returns which way traffic goes, as OSMnx reads `oneway`; a motorway is one-way unless it says otherwise,
/// as OpenStreetMap has it.
///
/// Deviation: `oneway=no` on a roundabout does not make it two-way in OSMnx either, but
/// `junction=circular` counts as a roundabout here.
pub(super) fn direction(tags: &Tags<'_>) -> Direction {
    let roundabout = matches!(tag(tags, "junction"), Some("roundabout" | "circular"));
    match tag(tags, "oneway") {
        Some("-1" | "reverse" | "T") => Direction::Backward,
        Some("yes" | "true" | "1" | "F") => Direction::Forward,
        _ if roundabout => Direction::Forward,
        None if tag(tags, "highway") == Some("motorway") => Direction::Forward,
        // A two-way street that vehicles, but not buses or bicycles, may use in one direction only.
        _ => match (is_closed(tags, ":forward"), is_closed(tags, ":backward")) {
            (false, true) => Direction::Forward,
            (true, false) => Direction::Backward,
            _ => Direction::Both,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_that_is_closed_to_motor_vehicles_makes_a_street_one_way() {
        assert_eq!(direction(&[("motor_vehicle:backward", "no")]), Direction::Forward);
        assert_eq!(direction(&[("vehicle:forward", "private")]), Direction::Backward);
        let open = [("access:backward", "no"), ("motorcar:backward", "yes")];
        assert_eq!(direction(&open), Direction::Both);
        let neither = [("access:backward", "no"), ("access:forward", "no")];
        assert_eq!(direction(&neither), Direction::Both);
        let tagged = [("oneway", "-1"), ("vehicle:backward", "no")];
        assert_eq!(direction(&tagged), Direction::Backward);
    }
}

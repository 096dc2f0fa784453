//! Who may use a lane.

use super::value::{Tags, tag};

/// Tags that say lane by lane whether motor vehicles may use it.
const LANE_ACCESS: [&str; 3] = ["motor_vehicle:lanes", "vehicle:lanes", "access:lanes"];

/// Returns what is said of motor vehicles lane by lane, for a suffix of `turn:lanes`.
pub(super) fn lane_by_lane<'a>(tags: &Tags<'a>, suffix: &str) -> Option<Vec<&'a str>> {
    let mut found = LANE_ACCESS.iter().filter_map(|key| tag(tags, &format!("{key}{suffix}")));
    found.next().map(|text| text.split('|').map(str::trim).collect())
}

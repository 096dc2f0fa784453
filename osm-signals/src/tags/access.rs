//! Who may use a lane.

use super::value::{Tags, tag};

/// Tags that say lane by lane whether motor vehicles may use it.
const LANE_ACCESS: [&str; 3] = ["motor_vehicle:lanes", "vehicle:lanes", "access:lanes"];

/// Values of access tags that keep the public's motor vehicles out.
const CLOSED: [&str; 2] = ["no", "private"];

/// Values of access tags that let the public's motor vehicles in, whatever a more general tag says.
const OPEN: [&str; 4] = ["yes", "designated", "permissive", "destination"];

/// Tags that say who may drive, the most specific first.
const WHO: [&str; 4] = ["motorcar", "motor_vehicle", "vehicle", "access"];

/// Returns whether a value keeps the public's motor vehicles out.
pub(super) fn closes(value: &str) -> bool {
    CLOSED.contains(&value)
}

/// Returns whether the public's motor vehicles are kept out: the most specific tag that says so or the
/// opposite decides.
///
/// # Arguments
///
/// * `suffix` — empty, or of one direction, such as `:forward`.
pub(super) fn is_closed(tags: &Tags<'_>, suffix: &str) -> bool {
    let values = WHO.iter().filter_map(|key| match suffix {
        "" => tag(tags, key),
        suffix => tag(tags, &format!("{key}{suffix}")),
    });
    let mut values = values.filter(|value| closes(value) || OPEN.contains(value));
    values.next().is_some_and(closes)
}

/// Returns what is said of motor vehicles lane by lane, for a suffix of `turn:lanes`.
pub(super) fn lane_by_lane<'a>(tags: &Tags<'a>, suffix: &str) -> Option<Vec<&'a str>> {
    let mut found = LANE_ACCESS.iter().filter_map(|key| tag(tags, &format!("{key}{suffix}")));
    found.next().map(|text| text.split('|').map(str::trim).collect())
}

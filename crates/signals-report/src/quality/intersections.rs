//! The table of intersections on the page on quality.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use minijinja::{Value, context};

use super::link::map_link;
use super::text::percent;
use signals::city::flag::Flag;
use signals::city::quality::Quality;
use signals::city::spots::Spot;

/// Rows that are shown, so that the page stays small; the others are in the files beside it.
const ROWS: usize = 3000;

/// What stands where there is nothing.
const NONE: &str = "\u{2013}";

/// Returns a row per intersection.
pub(super) fn rows(q: &Quality) -> Vec<Value> {
    q.spots.iter().take(ROWS).map(row).collect()
}

/// Returns how many intersections have no row.
pub(super) fn more(q: &Quality) -> usize {
    q.spots.len().saturating_sub(ROWS)
}

/// Returns the names of the streets of an intersection.
pub(super) fn streets(spot: &Spot) -> String {
    match spot.streets.is_empty() {
        true => "streets without a name".to_owned(),
        false => spot.streets.join(" / "),
    }
}

/// Returns the flags of an intersection in words.
pub(super) fn flags(spot: &Spot) -> String {
    let words: Vec<&str> = spot.flags.iter().map(|f| Flag::words(*f)).collect();
    if words.is_empty() { NONE.to_owned() } else { words.join("; ") }
}

/// Returns what is worth a look, each with the number of intersections, most frequent first.
pub(super) fn categories(q: &Quality) -> Vec<(&'static str, usize)> {
    let mut counts: BTreeMap<Flag, usize> = BTreeMap::new();
    for flag in q.spots.iter().flat_map(|s| &s.flags) {
        *counts.entry(*flag).or_default() += 1;
    }
    let mut counts: Vec<(Flag, usize)> = counts.into_iter().collect();
    counts.sort_by_key(|(flag, n)| (Reverse(*n), *flag));
    counts.into_iter().map(|(flag, n)| (flag.words(), n)).collect()
}

fn row(spot: &Spot) -> Value {
    context! {
        id => spot.id.as_str(),
        streets => streets(spot),
        link => map_link(spot.latitude, spot.longitude),
        arms => spot.arms,
        known => percent(spot.known),
        flags => flags(spot),
    }
}

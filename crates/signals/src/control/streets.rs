//! Streets of several signals: rows of stop lines that vehicles pass straight on, in one direction. The other direction is
//! another street.

use std::collections::BTreeSet;

use osm_signals::Turn;

use super::{Onward, SignalSpec};

/// Lanes in common, the way, and both movements, as signal and movement.
type Link<'a> = (usize, &'a Onward, (usize, usize), (usize, usize));

/// A stop line of a street.
#[derive(Debug, Clone, PartialEq)]
pub struct Stop {
    /// The signal.
    pub signal: usize,
    /// The movement straight on.
    pub movement: usize,
    /// Time from the first stop line at the speed limit, seconds.
    pub after_s: f64,
    /// Distance from the first stop line, metres.
    pub at_m: f64,
}

/// Signals that vehicles pass straight on one after the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Street {
    /// Its stop lines in the order of travel.
    pub stops: Vec<Stop>,
}

/// Returns the streets of a network: every row of at least two signals, as long as it goes. A movement belongs to one
/// street; where several lead to it or from it, to that of the most lanes, of equal ones the nearest.
pub fn streets(signals: &[SignalSpec]) -> Vec<Street> {
    let is_through = |signal: usize, m: usize| signals[signal].movements[m].turn == Turn::Through;
    let mut links: Vec<Link> = Vec::new();
    for (signal, spec) in signals.iter().enumerate() {
        for (m, _) in spec.movements.iter().enumerate().filter(|(m, _)| is_through(signal, *m)) {
            for (next, other) in signals.iter().enumerate() {
                for (n, movement) in other.movements.iter().enumerate() {
                    let leads = (spec.onward.iter())
                        .filter(|o| o.movement == m && o.signal == next)
                        .filter(|o| movement.lanes.contains(&o.lane));
                    let lanes = leads.clone().count();
                    let nearest = leads.min_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
                    if let Some(nearest) = nearest.filter(|_| is_through(next, n)) {
                        links.push((lanes, nearest, (signal, m), (next, n)));
                    }
                }
            }
        }
    }
    let nearer = |a: &Link, b: &Link| a.1.distance_m.total_cmp(&b.1.distance_m);
    links.sort_by(|a, b| b.0.cmp(&a.0).then(nearer(a, b)).then(a.2.cmp(&b.2)));
    let (mut from, mut to) = (BTreeSet::new(), BTreeSet::new());
    links.retain(|(_, _, a, b)| {
        let free = !from.contains(a) && !to.contains(b);
        if free {
            from.insert(*a);
            to.insert(*b);
        }
        free
    });
    // A row begins where nothing leads; of rings, which have no beginning, at the first movement.
    let mut left = links;
    let mut streets = Vec::new();
    while !left.is_empty() {
        let begins = left.iter().position(|link| !left.iter().any(|other| other.3 == link.2));
        let first = left[begins.unwrap_or(0)].2;
        let mut stops = vec![Stop { signal: first.0, movement: first.1, after_s: 0.0, at_m: 0.0 }];
        let mut at = first;
        while let Some(i) = left.iter().position(|link| link.2 == at) {
            let (_, way, _, next) = left.remove(i);
            if stops.iter().any(|stop| stop.signal == next.0) {
                break;
            }
            let last = &stops[stops.len() - 1];
            let (after_s, at_m) = (last.after_s + way.travel_s, last.at_m + way.distance_m);
            stops.push(Stop { signal: next.0, movement: next.1, after_s, at_m });
            at = next;
        }
        if stops.len() > 1 {
            streets.push(Street { stops });
        }
    }
    streets
}

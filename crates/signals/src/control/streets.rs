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

/// Signals that vehicles pass straight on one after the other: stop lines in the order of travel.
pub type Street = Vec<Stop>;

/// Returns the streets of a network: every row of at least two signals, as long as it goes. A movement belongs to one
/// street; where several lead to it or from it, to that of the most lanes, of equal ones the nearest.
pub fn streets(signals: &[SignalSpec]) -> Vec<Street> {
    let through = |signal: usize| {
        let movements = signals[signal].movements.iter().enumerate();
        movements.filter(|(_, m)| m.turn == Turn::Through).map(move |(m, _)| (signal, m))
    };
    let all: Vec<(usize, usize)> = (0..signals.len()).flat_map(through).collect();
    let mut links: Vec<Link> = Vec::new();
    for (from, to) in all.iter().flat_map(|from| all.iter().map(move |to| (*from, *to))) {
        let lanes = &signals[to.0].movements[to.1].lanes;
        let leads =
            |o: &&Onward| (o.movement, o.signal) == (from.1, to.0) && lanes.contains(&o.lane);
        let leads = signals[from.0].onward.iter().filter(leads);
        let nearest = leads.clone().min_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
        links.extend(nearest.map(|nearest| (leads.count(), nearest, from, to)));
    }
    let nearer = |a: &Link, b: &Link| a.1.distance_m.total_cmp(&b.1.distance_m);
    links.sort_by(|a, b| b.0.cmp(&a.0).then(nearer(a, b)).then(a.2.cmp(&b.2)));
    let (mut from, mut to) = (BTreeSet::new(), BTreeSet::new());
    links.retain(|(_, _, a, b)| {
        !from.contains(a) && !to.contains(b) && from.insert(*a) && to.insert(*b)
    });
    // A row begins where nothing leads; of rings, which have no beginning, at the first movement.
    let mut streets = Vec::new();
    while !links.is_empty() {
        let begins = links.iter().position(|link| !links.iter().any(|other| other.3 == link.2));
        let mut at = links[begins.unwrap_or(0)].2;
        let mut stops = vec![Stop { signal: at.0, movement: at.1, after_s: 0.0, at_m: 0.0 }];
        while let Some(i) = links.iter().position(|link| link.2 == at) {
            let (_, way, _, next) = links.remove(i);
            if stops.iter().any(|stop| stop.signal == next.0) {
                break;
            }
            let last = &stops[stops.len() - 1];
            let (after_s, at_m) = (last.after_s + way.travel_s, last.at_m + way.distance_m);
            stops.push(Stop { signal: next.0, movement: next.1, after_s, at_m });
            at = next;
        }
        if stops.len() > 1 {
            streets.push(stops);
        }
    }
    streets
}

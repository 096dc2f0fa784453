//! The vehicles of an approach, by where they go.

use std::collections::BTreeMap;

use osm_signals::Turn;

use super::lanes::{Movement, Ways};
use crate::family::approaches::{Approach, Arrivals, Counted, Intersection, MOST_EXITS};
use crate::family::doubts::Said;

/// Gives an arm the movements of its lane groups and their volumes.
pub(super) fn give(arm: &mut Approach, own: &[&Movement<'_>], ways: &Ways<'_>, said: &mut Said) {
    let at = format!("node {}", arm.intersection);
    let lost = |m: &Movement<'_>| format!("{at} {}: {:.0} veh/h", m.column, m.volume_vph);
    const NO_EXIT: &str =
        "movements have no exit or no lanes, and their vehicles are not simulated";
    if arm.lanes_in == 0 {
        own.iter().filter(|m| m.volume_vph > 0.0).for_each(|m| said.say(NO_EXIT, lost(m)));
        return;
    }
    let of_lanes = |turn| own.iter().find(|m| m.lanes > 0 && m.turn == turn);
    let beside = of_lanes(Turn::Through).or_else(|| of_lanes(Turn::Left));
    let shares = |m: &Movement<'_>| {
        let shared = beside.map_or(0, |beside| beside.shared);
        m.turn == Turn::Left && shared & 1 == 1 || m.turn == Turn::Right && shared & 2 == 2
    };
    let mut volumes: BTreeMap<Turn, f64> = BTreeMap::new();
    let mut divided: BTreeMap<Turn, f64> = BTreeMap::new();
    let mut exits_vph = [0.0; MOST_EXITS];
    let (mut peaks, mut heavy, mut total) = (0.0, 0.0, 0.0);
    for m in own.iter().filter(|m| m.lanes > 0 || m.volume_vph > 0.0 || shares(m)) {
        let Some(turn) = ways.turn(m) else {
            if m.volume_vph > 0.0 {
                said.say(NO_EXIT, lost(m));
            }
            continue;
        };
        if turn != m.turn {
            let about = "movements lead elsewhere than their names say, by the coordinates of nodes; lanes and volumes follow the \
                 coordinates";
            said.say(about, format!("{at} {} is {}", m.column, turn.name()));
        }
        if m.lanes == 0 && m.volume_vph > 0.0 && !shares(m) {
            let about =
                "volumes of movements without a lane and without a shared one use the other lanes";
            said.say(about, lost(m));
        }
        *volumes.entry(turn).or_default() += m.volume_vph;
        total += m.volume_vph;
        peaks += m.volume_vph / m.peak_hour_factor.unwrap_or(1.0);
        heavy += m.volume_vph * m.heavy.unwrap_or_default();
        let exits = ways.exits_of(m);
        for exit in &exits {
            // More exits than a network may have are refused with the intersection.
            if let Some(vph) = exits_vph.get_mut(*exit) {
                *vph += m.volume_vph / exits.len() as f64;
            }
        }
        if exits.len() > 1 && m.volume_vph > 0.0 {
            *divided.entry(turn).or_default() += m.volume_vph;
        }
    }
    for (turn, volume) in &divided {
        let about = "turns with several exits divide their vehicles equally among them";
        said.say(about, format!("{at} {} {}: {volume:.0} veh/h", arm.arm, turn.name()));
    }
    let several = volumes.iter().any(|(turn, vph)| *vph > 0.0 && ways.has_several(*turn));
    arm.movements = [Turn::Left, Turn::Through, Turn::Right]
        .into_iter()
        .filter(|turn| volumes.contains_key(turn))
        .map(letter)
        .collect();
    let vph = |turn| volumes.get(&turn).copied().unwrap_or_default();
    let has_factor = own.iter().any(|m| m.peak_hour_factor.is_some()) && total > 0.0;
    let has_heavy = own.iter().any(|m| m.heavy.is_some()) && total > 0.0;
    arm.counted = Some(Counted {
        left_vph: vph(Turn::Left),
        through_vph: vph(Turn::Through),
        right_vph: vph(Turn::Right),
        arrivals: has_factor.then(|| Arrivals::PeakHourFactor((total / peaks * 1e4).round() / 1e4)),
        heavy_vehicles: has_heavy.then(|| (heavy / total * 1e4).round() / 1e4),
        pedestrians_per_h: None,
        exits_vph: several.then_some(exits_vph),
    });
}

/// Returns the vehicles per hour of the arms of an intersection that were counted.
pub(super) fn volumes(intersection: &Intersection) -> impl Iterator<Item = f64> {
    intersection.arms.iter().filter_map(|arm| arm.counted).map(|counted| counted.total_vph())
}

/// Returns the letter of a turn in the table of approaches.
pub(super) fn letter(turn: Turn) -> char {
    match turn {
        Turn::Left => 'l',
        Turn::Through => 's',
        Turn::Right => 'r',
    }
}

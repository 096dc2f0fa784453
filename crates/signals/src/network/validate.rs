//! Checks a built network against the intersection that it was built from.
//!
//! Which paths meet within the junction and who yields is read from netconvert's own right-of-way
//! matrix, independently of the geometry that chose the phases: of two links that meet, at most
//! one may be unconditionally green, and a permissive one must yield.

use std::collections::BTreeSet;

use super::bays::pieces;
use super::intersection::IntersectionSpec;
use super::lanes::{LaneLayout, layout};
use super::phases::PHASES_PROGRAM;
use super::plain::{DEFAULT_PROGRAM, SIGNAL};
use crate::junction::{Conflicts, incoming_edge, outgoing_edge};
use crate::network::error::NetworkError;
use crate::program::ProgramPhase;
use crate::sim::net_file::{NetFile, NetLane, NetLink};

/// How far a length or speed may be off: netconvert writes two decimals.
const ROUNDING: f64 = 0.0101;

/// Checks a network; the first failed check is the error.
/// Fails with [`NetworkError::Unsound`] naming the failed check.
pub fn validate(
    spec: &IntersectionSpec,
    net: &NetFile,
    exit_length_m: f64,
) -> Result<(), NetworkError> {
    let layout = layout(spec)?;
    check_lanes(spec, &layout, net, exit_length_m)
        .and_then(|()| check_connections(&layout, net))
        .and_then(|()| check_programs(&layout, net))
        .map_err(|reason| NetworkError::Unsound { point: spec.point.clone(), reason })
}

fn check_lanes(
    spec: &IntersectionSpec,
    layout: &LaneLayout,
    net: &NetFile,
    exit_length_m: f64,
) -> Result<(), String> {
    for (i, arm) in spec.arms.iter().enumerate() {
        let street = pieces(spec, i).into_iter().map(|p| (p.edge, p.lanes, p.length_m));
        let mut expected: Vec<_> = street.collect();
        if arm.lanes_in == 0 {
            expected.push((incoming_edge(i), 0, 0.0));
        }
        expected.push((outgoing_edge(i), layout.exit_lanes[i], exit_length_m));
        for (edge, lanes, length_m) in expected {
            let found: Vec<_> = net.lanes.iter().filter(|l| l.edge == edge).collect();
            let fits = |lane: &&NetLane| {
                (lane.length_m - length_m).abs() <= ROUNDING
                    && (lane.speed_mps - arm.speed_mps).abs() <= ROUNDING
            };
            if found.len() != lanes as usize || !found.iter().all(fits) {
                let speed_mps = arm.speed_mps;
                return Err(format!(
                    "{edge} has {found:?} instead of {lanes} lanes of {length_m} m with {speed_mps} m/s"
                ));
            }
        }
    }
    Ok(())
}

fn check_connections(layout: &LaneLayout, net: &NetFile) -> Result<(), String> {
    let asked = layout.connections.iter().map(|c| {
        let (from, to) = (c.movement.from_edge(), c.movement.to_edge());
        format!("{from}_{} to {to}_{}", c.from_lane, c.to_lane)
    });
    let asked: BTreeSet<String> = asked.collect();
    let found = net.links.iter().filter(|link| link.signal == SIGNAL).map(name).collect();
    if let Some(connection) = asked.symmetric_difference(&found).next() {
        return Err(format!("connection {connection} is missing or was not asked for"));
    }
    let mut places: Vec<_> = net.links.iter().map(|l| l.link).collect();
    places.sort_unstable();
    if places != (0..layout.connections.len()).collect::<Vec<_>>() {
        return Err("links of the signal are not numbered from 0 without gaps".to_owned());
    }
    Ok(())
}

fn check_programs(layout: &LaneLayout, net: &NetFile) -> Result<(), String> {
    for id in [DEFAULT_PROGRAM, PHASES_PROGRAM] {
        let phases = net.program(id).ok_or_else(|| format!("no program {id:?}"))?;
        for (number, phase) in phases.iter().enumerate() {
            let clears = id == DEFAULT_PROGRAM && number > 0 && has(&phases[number - 1], b'y');
            let serves = has(phase, b'G') || has(phase, b'g') || has(phase, b'y') || clears;
            let checked =
                if serves { check_phase(net, phase) } else { Err("serves nothing".into()) };
            checked.map_err(|e| format!("program {id:?}, phase {number}: {e}"))?;
        }
        let green = |l: &NetLink| phases.iter().any(|p| is_green(letter(p, l)));
        if let Some(link) = net.links.iter().find(|l| !green(l)) {
            return Err(format!("program {id:?}: {} is never green", name(link)));
        }
    }
    let starts = net.programs.last().is_some_and(|(_, id, _)| id == DEFAULT_PROGRAM);
    if !starts || net.programs.iter().any(|(_, id, _)| id.as_str() > DEFAULT_PROGRAM) {
        return Err(format!("program {DEFAULT_PROGRAM:?} is not the one that SUMO starts with"));
    }
    let movement = |l: &NetLink| {
        layout.movements.iter().find(|m| m.from_edge() == l.from && m.to_edge() == l.to)
    };
    for phase in net.program(PHASES_PROGRAM).unwrap_or_default() {
        for (a, b) in pairs(net).filter(|(a, b)| both_protected(phase, a, b)) {
            if movement(a).zip(movement(b)).is_some_and(|(a, b)| a.conflicts_with(b)) {
                return Err(format!("{} and {} cross but are both protected", name(a), name(b)));
            }
        }
    }
    Ok(())
}

fn check_phase(net: &NetFile, phase: &ProgramPhase) -> Result<(), String> {
    if phase.state.len() != net.links.len() {
        return Err(format!("{} letters for {} links", phase.state.len(), net.links.len()));
    }
    let rows = net.conflicts.get(SIGNAL).map_or(0, Conflicts::count);
    if let Some(link) = net.links.iter().find(|l| l.link >= rows) {
        return Err(format!("{} has no row in the right-of-way matrix", name(link)));
    }
    for (a, b) in pairs(net) {
        if !is_green(letter(phase, a)) || !is_green(letter(phase, b)) || !net.meet(a, b) {
            continue;
        }
        if both_protected(phase, a, b) {
            return Err(format!("{} and {} meet but are both protected", name(a), name(b)));
        }
        let yields = |link, to| letter(phase, link) == b'g' && net.yields(link, to);
        if !yields(a, b) && !yields(b, a) {
            return Err(format!("{} and {} meet but neither yields", name(a), name(b)));
        }
    }
    Ok(())
}

fn pairs(net: &NetFile) -> impl Iterator<Item = (&NetLink, &NetLink)> {
    net.links.iter().enumerate().flat_map(|(i, a)| net.links[i + 1..].iter().map(move |b| (a, b)))
}

fn letter(phase: &ProgramPhase, link: &NetLink) -> u8 {
    phase.state.as_bytes().get(link.link).copied().unwrap_or(b'r')
}

fn has(phase: &ProgramPhase, letter: u8) -> bool {
    phase.state.as_bytes().contains(&letter)
}

fn is_green(letter: u8) -> bool {
    letter.eq_ignore_ascii_case(&b'g')
}

fn both_protected(phase: &ProgramPhase, a: &NetLink, b: &NetLink) -> bool {
    letter(phase, a) == b'G' && letter(phase, b) == b'G'
}

fn name(link: &NetLink) -> String {
    format!("{}_{} to {}_{}", link.from, link.from_lane, link.to, link.to_lane)
}

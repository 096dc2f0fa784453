//! Checks a built network against the intersection that it was built from.
//!
//! Which paths meet within the junction and who yields is read from netconvert's own right-of-way
//! matrix, independently of the geometry that chose the phases: of two links that meet, at most
//! one may be unconditionally green, and a permissive one must yield.

use super::bays::pieces;
use super::intersection::IntersectionSpec;
use super::lanes::{LaneLayout, layout};
use super::phases::PHASES_PROGRAM;
use super::plain::{DEFAULT_PROGRAM, SIGNAL};
use crate::junction::{Conflicts, incoming_edge, outgoing_edge};
use crate::network::error::NetworkError;
use crate::sim::net_file::{NetFile, NetLink, ProgramPhase};

/// How far a length or speed may be off: netconvert writes two decimals.
const ROUNDING: f64 = 0.0101;

/// Checks a network; the first failed check is the error.
///
/// # Errors
///
/// [`NetworkError::Unsound`] naming the failed check.
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
        let street = if arm.lanes_in > 0 { pieces(spec, i, SIGNAL) } else { Vec::new() };
        let outgoing = (outgoing_edge(i), layout.exit_lanes[i], exit_length_m);
        let none = (incoming_edge(i), 0, 0.0);
        let incoming = street.into_iter().map(|p| (p.edge, p.lanes, p.length_m));
        for (edge, lanes, length_m) in
            [none].into_iter().filter(|_| arm.lanes_in == 0).chain(incoming).chain([outgoing])
        {
            let found: Vec<_> = net.lanes.iter().filter(|l| l.edge == edge).collect();
            if found.len() != lanes as usize {
                return Err(format!("{edge} has {} lanes instead of {lanes}", found.len()));
            }
            for lane in found {
                if (lane.length_m - length_m).abs() > ROUNDING {
                    return Err(format!(
                        "{edge} is {} m long instead of {length_m}",
                        lane.length_m
                    ));
                }
                if (lane.speed_mps - arm.speed_mps).abs() > ROUNDING {
                    let (found, expected) = (lane.speed_mps, arm.speed_mps);
                    return Err(format!("{edge} allows {found} m/s instead of {expected}"));
                }
            }
        }
    }
    Ok(())
}

fn check_connections(layout: &LaneLayout, net: &NetFile) -> Result<(), String> {
    let matches = |link: &NetLink| {
        layout.connections.iter().any(|c| {
            (&c.movement.from_edge(), &c.movement.to_edge()) == (&link.from, &link.to)
                && (c.from_lane, c.to_lane) == (link.from_lane, link.to_lane)
        })
    };
    if let Some(link) = net.links.iter().find(|l| l.signal != SIGNAL || !matches(l)) {
        return Err(format!("connection {} was not asked for", name(link)));
    }
    for m in &layout.movements {
        let (from, to) = (m.from_edge(), m.to_edge());
        if !net.links.iter().any(|l| l.from == from && l.to == to) {
            return Err(format!("movement {from} to {to} has no connection"));
        }
    }
    for c in &layout.connections {
        let (from, lane) = (c.movement.from_edge(), c.from_lane);
        if !net.links.iter().any(|l| l.from == from && l.from_lane == lane) {
            return Err(format!("lane {lane} of {from} leads nowhere"));
        }
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
            serves
                .then_some(())
                .ok_or_else(|| "serves nothing".to_owned())
                .and_then(|()| check_phase(net, phase))
                .map_err(|e| program_error(id, number, &e))?;
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

/// Names program and phase; what netconvert itself did wrong, only another intersection avoids.
fn program_error(id: &str, phase: usize, reason: &str) -> String {
    let way_out = match id {
        DEFAULT_PROGRAM => {
            "; this is netconvert's own program, so change the lanes or leave it out"
        }
        _ => "",
    };
    format!("program {id:?}, phase {phase}: {reason}{way_out}")
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
        if !is_green(letter(phase, a)) || !is_green(letter(phase, b)) {
            continue;
        }
        if !net.meet(a, b) {
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

//! The streets that leave a site: legs, slip lanes, and what lies between the site's junctions.

use std::collections::{BTreeMap, HashSet};

use super::extract::Place;
use super::geometry::{along, bearing_deg, beyond};
use super::graph::{Chain, Graph, Step};
use super::settings::IntersectionSettings;
use super::sites::Site;
use crate::angle::turn_degrees;

/// A street or carriageway that leads from a site to the next junction.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Leg {
    pub(super) chain: Chain,
    pub(super) inbound: bool,
    pub(super) outbound: bool,
    pub(super) length_m: f64,
    /// Direction from its start to the place where the bearing is taken, degrees.
    pub(super) direction_deg: f64,
    pub(super) towards: Place,
}

impl Leg {
    pub(super) fn first(&self) -> Step {
        self.chain.steps[0]
    }
}

/// A one-way street that lets traffic turn before the junction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Slip {
    pub(super) steps: Vec<Step>,
    pub(super) kind: SlipKind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SlipKind {
    /// It leaves the street of this step, as traffic comes in, before the junction.
    Before(Step),
    /// It leaves from the junction itself and joins a street behind it.
    Behind,
    /// It only leads back to where traffic came from.
    UTurn,
}

/// Largest angle between the carriageways of one street, degrees: a slip lane from one to the other only leads back.
const SAME_STREET_DEG: f64 = 45.0;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Surroundings {
    pub(super) legs: Vec<Leg>,
    pub(super) slips: Vec<Slip>,
    /// Steps between its junctions, in both directions.
    pub(super) inside: Vec<Step>,
}

pub(super) fn surroundings(
    graph: &Graph<'_>,
    site: &Site,
    settings: &IntersectionSettings,
) -> Surroundings {
    let mut ignored = HashSet::new();
    let mut slips = Vec::new();
    loop {
        let (legs, inside) = legs(graph, site, settings, &ignored);
        let Some(slip) = find_slip(graph, site, settings, &legs, &ignored) else {
            return Surroundings { legs, slips, inside };
        };
        ignored.extend(slip.steps.iter().map(|s| s.piece));
        slips.push(slip);
    }
}

fn legs(
    graph: &Graph<'_>,
    site: &Site,
    settings: &IntersectionSettings,
    ignored: &HashSet<u32>,
) -> (Vec<Leg>, Vec<Step>) {
    let is_inside = |node: u32| site.nodes.binary_search(&node).is_ok();
    let (mut legs, mut inside) = (Vec::new(), Vec::new());
    for node in &site.nodes {
        for step in graph.steps(*node).iter().filter(|s| !ignored.contains(&s.piece)) {
            let chain = graph.chain(*step, ignored, &|n| is_inside(n) || graph.is_open_fork(n));
            let length_m = graph.length_m(&chain.steps);
            let within = site.together || length_m <= settings.max_extent_m;
            if is_inside(chain.end) && within {
                inside.extend(&chain.steps);
            } else {
                legs.push(leg(graph, chain, length_m, settings.bearing_at_m));
            }
        }
    }
    (legs, inside)
}

fn leg(graph: &Graph<'_>, chain: Chain, length_m: f64, bearing_at_m: f64) -> Leg {
    let places = graph.places(&chain);
    let first = chain.steps[0];
    let at = along(&places, bearing_at_m).and_then(|(lat, lon)| Place::from_degrees(lat, lon));
    let end = places[places.len() - 1];
    // A short leg goes on as it leads, so that a place beside the centre is no direction of its own.
    let beyond_m = (bearing_at_m - length_m).max(0.0);
    let towards = at.unwrap_or_else(|| beyond(end, bearing_deg(places[0], end), beyond_m));
    Leg {
        inbound: graph.allowed(first.reversed()),
        outbound: graph.allowed(first),
        length_m,
        direction_deg: bearing_deg(places[0], towards),
        towards,
        chain,
    }
}

/// Returns a slip lane that is not yet ignored: a one-way street from the end of a near inbound leg
/// to the end of a near outbound one, or to the site itself.
fn find_slip(
    graph: &Graph<'_>,
    site: &Site,
    settings: &IntersectionSettings,
    legs: &[Leg],
    ignored: &HashSet<u32>,
) -> Option<Slip> {
    let near = |l: &&Leg| l.length_m <= settings.slip_reach_m;
    let merges: BTreeMap<u32, &Leg> =
        legs.iter().filter(|l| l.outbound).filter(near).map(|l| (l.chain.end, l)).collect();
    let is_inside = |node: u32| site.nodes.binary_search(&node).is_ok();
    for leg in legs.iter().filter(|l| l.inbound).filter(near) {
        let fork = leg.chain.end;
        let last = leg.chain.steps[leg.chain.steps.len() - 1];
        if graph.neighbours(fork, ignored).len() != 3 && !graph.is_open_fork(fork) {
            continue;
        }
        let others = graph.steps(fork).iter().filter(|s| {
            **s != last.reversed()
                && !ignored.contains(&s.piece)
                && graph.allowed(**s)
                && graph.is_one_way(**s)
        });
        for step in others {
            let chain = graph.chain(*step, ignored, &is_inside);
            let length_m = graph.length_m(&chain.steps);
            let joins = merges.get(&chain.end).is_some_and(|l| l.chain.start != leg.chain.end)
                && chain.end != fork
                && graph.neighbours(chain.end, ignored).len() == 3;
            let slip = (joins || is_inside(chain.end))
                && length_m <= 2.0 * settings.slip_reach_m
                && graph.all_allowed(&chain.steps)
                && turns_off(graph, *step, last.reversed(), joins);
            if slip {
                let back = merges.get(&chain.end).is_some_and(|l| {
                    joins
                        && turn_degrees(leg.direction_deg, l.direction_deg).abs() < SAME_STREET_DEG
                });
                let kind = if back { SlipKind::UTurn } else { SlipKind::Before(last.reversed()) };
                return Some(Slip { steps: chain.steps, kind });
            }
        }
    }
    find_connector(graph, site, settings, legs, ignored)
}

/// Returns a one-way street from the site to the end of another near outbound leg.
fn find_connector(
    graph: &Graph<'_>,
    site: &Site,
    settings: &IntersectionSettings,
    legs: &[Leg],
    ignored: &HashSet<u32>,
) -> Option<Slip> {
    let is_inside = |node: u32| site.nodes.binary_search(&node).is_ok();
    let near = |l: &&Leg| l.outbound && l.length_m <= settings.slip_reach_m;
    for (i, off) in legs.iter().enumerate().filter(|(_, l)| near(l) && !l.inbound) {
        let merge = off.chain.end;
        if is_inside(merge) || graph.neighbours(merge, ignored).len() != 3 {
            continue;
        }
        let others = legs.iter().enumerate().filter(|(j, l)| *j != i && near(l));
        for (_, on) in others.filter(|(_, l)| l.chain.end == merge) {
            let last = |l: &Leg| l.chain.steps[l.chain.steps.len() - 1].reversed();
            let branches =
                graph.all_allowed(&off.chain.steps) && turns_off(graph, last(off), last(on), false);
            if branches {
                return Some(Slip { steps: off.chain.steps.clone(), kind: SlipKind::Behind });
            }
        }
    }
    None
}

/// Returns whether a street turns off at a fork while another goes on: it is a link and the other
/// is none, or it turns more. Where a ramp forks, all are links, and the one that passes the
/// junction and `joins` an outbound leg turns off, even if it bends less.
fn turns_off(graph: &Graph<'_>, off: Step, on: Step, joins: bool) -> bool {
    let is_link = |s: Step| graph.way(s).street.highway.is_link();
    if is_link(off) != is_link(on) {
        return is_link(off);
    }
    if is_link(off) && joins {
        return true;
    }
    let fork = graph.source(off);
    let before = graph.steps(fork).iter().find(|s| ![off.piece, on.piece].contains(&s.piece));
    let Some(before) = before else { return is_lesser(graph, off, on) };
    let turn = |s: Step| turn_degrees(graph.direction(before.reversed()), graph.direction(s)).abs();
    turn(off) > turn(on)
}

fn is_lesser(graph: &Graph<'_>, one: Step, other: Step) -> bool {
    let (one, other) = (&graph.way(one).street, &graph.way(other).street);
    let unnamed = one.name.is_none() && other.name.is_some();
    one.highway > other.highway || (one.highway == other.highway && unnamed)
}

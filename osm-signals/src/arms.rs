//! The arms of a site: legs of one street joined, with lanes, speed and length.

use std::cmp::Reverse;
use std::collections::HashSet;

use geo::{Coord, Densify, Distance, Euclidean, LineString, Point};

use super::extract::Place;
use super::geometry::{Plane, bearing_deg, middle};
use super::graph::{Chain, Graph, Step};
use super::legs::{Leg, Slip, SlipKind, Surroundings};
use super::settings::Settings;
use super::streets::{Lanes, Source, Streets};
use super::tags::Highway;
use crate::angle::{normalise_degrees, turn_degrees};

/// Largest angle between the two carriageways of one street, degrees: of one name, where a name is
/// missing, and where the name changes.
const CARRIAGEWAYS_DEG: [f64; 3] = [45.0, 30.0, 15.0];

/// Longest carriageways around an island at the end of a street, which are one arm at any angle, metres.
const FLARE_M: f64 = 80.0;

/// Smallest angle between the bearings of two arms, degrees; nearer ones are one arm.
const APART_DEG: f64 = 5.0;

/// Largest angle between streets of one name that run side by side, such as frontage roads, degrees.
const SIDE_BY_SIDE_DEG: f64 = 20.0;

/// Largest angle between one-way streets from one node, or to it, that are one arm, degrees: a ramp that leaves
/// beside the street.
const BESIDE_DEG: f64 = 15.0;

/// Largest angle between legs that no network could keep apart, degrees.
const SAME_DEG: f64 = 10.0;

/// Farthest that two drawings of one street may be apart, metres: less than half a lane.
const OVER_M: f64 = 1.5;

/// How far two drawings of one street are compared, and at least have to be, metres.
const COMPARED_M: f64 = 60.0;
const LEAST_M: f64 = 15.0;

/// Distance of the places that are compared, metres.
const STEP_M: f64 = 5.0;

/// One arm of an intersection.
#[derive(Debug, Clone, PartialEq)]
pub struct Arm {
    /// Direction from the centre to the arm, degrees clockwise from north.
    pub bearing_deg: f64,
    /// Lanes towards the signal, slip lanes included.
    pub lanes_in: u32,
    /// Lanes away from it.
    pub lanes_out: u32,
    /// Lanes among `lanes_in` for left turns only.
    pub left_turn_lanes: u32,
    /// Lanes among `lanes_in` for right turns only, slip lanes included.
    pub right_turn_lanes: u32,
    /// Lanes among `lanes_in` that turn off before the junction.
    pub slip_lanes: u32,
    /// Lanes among `lanes_in` that lie between the directions.
    pub centre_lanes: u32,
    /// What the numbers of lanes rest on.
    pub lanes_source: Source,
    /// Whether turns are marked.
    pub marked: bool,
    /// Speed limit, miles per hour.
    pub speed_mph: f64,
    /// What the speed limit rests on.
    pub speed_source: Source,
    /// Length to the next junction, metres.
    pub length_m: f64,
    /// Whether the extract ends before the next junction.
    pub cut: bool,
    /// Whether the length is outside the settings' limits and is not used as it is.
    pub clamped: bool,
    /// Whether two ways of the map are drawn over each other, of which one is counted.
    pub drawn_twice: bool,
    /// Class of the street.
    pub highway: Highway,
    /// Name of the street.
    pub name: Option<String>,
    /// The street from the junction outwards.
    pub places: Vec<Place>,
    /// Positions of its legs, and of the slip lanes that leave it, around its site.
    pub(crate) legs: Vec<usize>,
    pub(crate) slips: Vec<usize>,
}

pub(crate) fn arms(
    graph: &Graph<'_>,
    streets: &Streets,
    settings: &Settings,
    around: &Surroundings,
    centre: Place,
) -> Vec<Arm> {
    let mut groups = join(graph, &around.legs);
    loop {
        let mut arms: Vec<Arm> = groups
            .into_iter()
            .map(|legs| arm(graph, streets, settings, around, centre, legs))
            .collect();
        arms.sort_by(|a, b| {
            a.bearing_deg.total_cmp(&b.bearing_deg).then_with(|| a.legs.cmp(&b.legs))
        });
        let next = |i: usize| (i + 1) % arms.len();
        let near = |i: &usize| {
            turn_degrees(arms[*i].bearing_deg, arms[next(*i)].bearing_deg).abs() < APART_DEG
        };
        let Some(first) = (0..arms.len()).filter(|_| arms.len() > 1).find(near) else {
            return arms;
        };
        let second = next(first);
        let mut both = [&*arms[first].legs, &*arms[second].legs].concat();
        both.sort_unstable();
        let others = (0..arms.len()).filter(|i| ![first, second].contains(i));
        groups = others.map(|i| arms[i].legs.clone()).chain([both]).collect();
    }
}

fn join(graph: &Graph<'_>, legs: &[Leg]) -> Vec<Vec<usize>> {
    let mut group: Vec<usize> = (0..legs.len()).collect();
    let mut merge = |a: usize, b: usize| {
        let (from, to) = (group[a].max(group[b]), group[a].min(group[b]));
        for g in group.iter_mut().filter(|g| **g == from) {
            *g = to;
        }
    };
    let mut carriageways = Vec::new();
    for (i, a) in legs.iter().enumerate() {
        for (j, b) in legs.iter().enumerate().skip(i + 1) {
            let angle = turn_degrees(a.direction_deg, b.direction_deg).abs();
            let (name, other) = (name(graph, a), name(graph, b));
            let same_name = name.is_some() && name == other;
            let forked = a.chain.end == b.chain.end && graph.is_open_fork(a.chain.end);
            // Exits of one node, or entries, that no network could keep apart either.
            let beside = a.chain.start == b.chain.start
                && (a.inbound, a.outbound) == (b.inbound, b.outbound)
                && a.inbound != a.outbound
                && angle <= BESIDE_DEG;
            if forked || beside || angle <= SAME_DEG || (same_name && angle <= SIDE_BY_SIDE_DEG) {
                merge(i, j);
            } else if a.inbound != b.inbound && a.outbound != b.outbound {
                let (inward, outward) = if a.inbound { (a, b) } else { (b, a) };
                let flare = inward.chain.end == outward.chain.end
                    && graph.steps(a.chain.end).len() == 3
                    && (same_name || name.is_none() || other.is_none())
                    && a.length_m.max(b.length_m) <= FLARE_M;
                let limit_deg = match (name, other) {
                    _ if same_name => CARRIAGEWAYS_DEG[0],
                    (Some(_), Some(_)) => CARRIAGEWAYS_DEG[2],
                    _ => CARRIAGEWAYS_DEG[1],
                };
                // Seen outwards, traffic that keeps to the right leaves to the right.
                let turn = turn_degrees(inward.direction_deg, outward.direction_deg);
                let sides = same_name || turn > -SAME_DEG;
                if flare {
                    merge(i, j);
                } else if sides && angle <= limit_deg {
                    carriageways.push((!same_name, angle, i, j));
                }
            }
        }
    }
    carriageways.sort_by(|a, b| {
        a.0.cmp(&b.0).then_with(|| a.1.total_cmp(&b.1)).then_with(|| (a.2, a.3).cmp(&(b.2, b.3)))
    });
    let mut paired = HashSet::new();
    for (_, _, i, j) in carriageways {
        if !paired.contains(&i) && !paired.contains(&j) {
            paired.extend([i, j]);
            merge(i, j);
        }
    }
    let mut groups: Vec<usize> = group.clone();
    groups.sort_unstable();
    groups.dedup();
    groups.into_iter().map(|g| (0..legs.len()).filter(|l| group[*l] == g).collect()).collect()
}

fn name<'a>(graph: &Graph<'a>, leg: &Leg) -> Option<&'a str> {
    graph.way(leg.first()).street.name.as_deref()
}

fn arm(
    graph: &Graph<'_>,
    streets: &Streets,
    settings: &Settings,
    around: &Surroundings,
    centre: Place,
    members: Vec<usize>,
) -> Arm {
    let legs: Vec<&Leg> = members.iter().map(|l| &around.legs[*l]).collect();
    let stop_line_m = settings.streets.stop_line_m;
    let lanes = |leg: &Leg, inwards: bool| at_stop_line(graph, streets, leg, inwards, stop_line_m);
    let counted_once = once(graph, &legs, &|leg| {
        let (lanes, _) = lanes(leg, leg.inbound);
        (lanes.source, Reverse(lanes.lanes))
    });
    let drawn_twice = counted_once.len() < legs.len();
    let stop_lines: Vec<(Lanes, usize, &Leg)> = counted_once
        .iter()
        .filter(|l| l.inbound)
        .map(|l| {
            let (lanes, piece) = lanes(l, true);
            (lanes, piece, *l)
        })
        .collect();
    let inward: Vec<(Lanes, &Leg)> = stop_lines.iter().map(|(lanes, _, l)| (*lanes, *l)).collect();
    let outward: Vec<Lanes> =
        counted_once.iter().filter(|l| l.outbound).map(|l| lanes(l, false).0).collect();
    // The widest inbound leg stands for the street.
    let main = inward.iter().max_by_key(|(lanes, _)| lanes.lanes).map_or(legs[0], |(_, l)| *l);
    let toward = if main.inbound { main.first().reversed() } else { main.first() };
    let street = &graph.way(toward).street;
    let (speed_mph, speed_source) = speed_mph(graph, streets, main);
    let (length_m, places, end) = extent(graph, &legs, main);
    let slips: Vec<usize> = (0..around.slips.len())
        .filter(|s| match around.slips[*s].kind {
            SlipKind::Before(leaves) => legs.iter().any(|l| is_on(l, leaves)),
            SlipKind::Behind | SlipKind::UTurn => false,
        })
        .collect();
    let sum = |f: &dyn Fn(&Lanes) -> u32| inward.iter().map(|(lanes, _)| f(lanes)).sum::<u32>();
    let (mut left, mut right) = (sum(&|l| l.left_only), sum(&|l| l.right_only));
    let mut slip_lanes = 0;
    let mut counted = 0;
    for slip in slips.iter().map(|s| &around.slips[*s]) {
        let first = slip.steps[0];
        let tagged = streets.lanes(&graph.way(first).street, first.forward);
        // What is usual for a class of links says nothing about a slip lane.
        let lanes = if tagged.source == Source::Tagged { tagged.lanes } else { 1 };
        slip_lanes += lanes;
        if stop_lines.iter().any(|(lanes, piece, leg)| forks_after(leg, *piece, slip, lanes)) {
            // They are among the lanes before the fork, and marked there if turns are.
            counted += lanes;
            continue;
        }
        match turns_left(graph, slip) {
            true => left += lanes,
            false => right += lanes,
        }
    }
    let sources = inward.iter().map(|(lanes, _)| lanes.source);
    let lanes_source = match inward.is_empty() {
        false => sources.max(),
        true => outward.iter().map(|lanes| lanes.source).max(),
    };
    Arm {
        bearing_deg: bearing(centre, &legs),
        lanes_in: sum(&|l| l.lanes) + slip_lanes - counted,
        lanes_out: outward.iter().map(|lanes| lanes.lanes - u32::from(lanes.centre)).sum(),
        left_turn_lanes: left,
        right_turn_lanes: right,
        slip_lanes,
        centre_lanes: sum(&|l| u32::from(l.centre)),
        lanes_source: lanes_source.unwrap_or(Source::Default),
        marked: inward.iter().any(|(lanes, _)| lanes.marked),
        speed_mph,
        speed_source,
        length_m,
        cut: graph.cut.contains(&end) || graph.is_open_fork(end),
        clamped: !(settings.intersections.min_length_m..=settings.intersections.max_length_m)
            .contains(&length_m),
        drawn_twice,
        highway: street.highway,
        name: street.name.as_deref().map(str::to_owned),
        places,
        legs: members,
        slips,
    }
}

/// That of the tagged piece nearest to the junction, or what the class of the first piece suggests.
fn speed_mph(graph: &Graph<'_>, streets: &Streets, leg: &Leg) -> (f64, Source) {
    let limit = |step: &Step| {
        let travel = if leg.inbound { step.reversed() } else { *step };
        streets.speed_mph(&graph.way(travel).street, travel.forward)
    };
    let mut limits = leg.chain.steps.iter().map(limit);
    limits.find(|(_, source)| *source == Source::Tagged).unwrap_or(limit(&leg.first()))
}

/// Whether a slip lane leaves between a piece of a leg and the junction, so that it is among the lanes of the piece.
fn forks_after(leg: &Leg, piece: usize, slip: &Slip, lanes: &Lanes) -> bool {
    let SlipKind::Before(leaves) = slip.kind else { return false };
    let fork = leg.chain.steps.iter().position(|s| s.piece == leaves.piece);
    fork.is_some_and(|fork| piece > fork) && lanes.lanes > 1
}

/// The lanes and their piece, by its position from the junction: near it the first with marked turns, as long as it has the
/// lanes of the very first piece or that one is untagged; else the first with a tagged number; else the very first.
fn at_stop_line(
    graph: &Graph<'_>,
    streets: &Streets,
    leg: &Leg,
    inwards: bool,
    stop_line_m: f64,
) -> (Lanes, usize) {
    let lanes = |step: &Step| {
        let forward = if inwards { !step.forward } else { step.forward };
        streets.lanes(&graph.way(*step).street, forward)
    };
    let mut metres = 0.0;
    let mut near = Vec::new();
    for step in &leg.chain.steps {
        let travel = if inwards { step.reversed() } else { *step };
        if metres > stop_line_m || !graph.allowed(travel) {
            break;
        }
        metres += graph.step_m(*step);
        near.push(lanes(step));
    }
    let first = lanes(&leg.chain.steps[0]);
    let fits = |l: &&Lanes| first.source != Source::Tagged || l.lanes == first.lanes;
    let marked = near.iter().position(|l| l.marked && inwards && fits(&l));
    let tagged = near.iter().position(|l| l.source == Source::Tagged);
    marked.or(tagged).map_or((first, 0), |piece| (near[piece], piece))
}

/// Where its carriageways join before the next junction, the street goes on.
fn extent(graph: &Graph<'_>, legs: &[&Leg], main: &Leg) -> (f64, Vec<Place>, u32) {
    let (mut length_m, mut places) = (main.length_m, graph.places(&main.chain));
    let end = main.chain.end;
    let halves = legs.iter().filter(|l| l.chain.end == end).count();
    let used: Vec<u32> = legs.iter().flat_map(|l| l.chain.steps.iter().map(|s| s.piece)).collect();
    let mut onwards = graph.steps(end).iter().filter(|s| !used.contains(&s.piece));
    if let (2, 3, Some(step)) = (halves, graph.steps(end).len(), onwards.next()) {
        let none = HashSet::new();
        let chain: Chain = graph.chain(*step, &none, &|_| false);
        length_m += graph.length_m(&chain.steps);
        places.extend(graph.places(&chain).into_iter().skip(1));
        return (length_m, places, chain.end);
    }
    (length_m, places, end)
}

fn bearing(centre: Place, legs: &[&Leg]) -> f64 {
    let middle = middle(legs.iter().map(|leg| leg.towards));
    middle.map_or(0.0, |middle| normalise_degrees(bearing_deg(centre, middle)))
}

fn is_on(leg: &Leg, step: Step) -> bool {
    leg.chain.steps.iter().any(|s| s.piece == step.piece)
}

fn turns_left(graph: &Graph<'_>, slip: &Slip) -> bool {
    let SlipKind::Before(leaves) = slip.kind else { return false };
    let last = slip.steps[slip.steps.len() - 1];
    turn_degrees(graph.direction(leaves), graph.direction(last)) < 0.0
}

/// Returns the legs without those that are drawn over another one which carries their traffic too: of two that
/// carry the same, the better one by `worth` stays.
fn once<'l, W: Ord>(
    graph: &Graph<'_>,
    legs: &[&'l Leg],
    worth: &dyn Fn(&Leg) -> W,
) -> Vec<&'l Leg> {
    let covers = |a: &Leg, b: &Leg| (a.inbound || !b.inbound) && (a.outbound || !b.outbound);
    let stays = |i: usize| {
        let b = legs[i];
        !legs.iter().enumerate().any(|(j, a)| {
            let better = || (worth(a), j) < (worth(b), i);
            i != j && covers(a, b) && (!covers(b, a) || better()) && is_over(graph, a, b)
        })
    };
    (0..legs.len()).filter(|i| stays(*i)).map(|i| legs[i]).collect()
}

/// Returns whether two legs are one street, drawn twice: as far as both go they are nowhere apart.
fn is_over(graph: &Graph<'_>, a: &Leg, b: &Leg) -> bool {
    let (a, b) = (graph.places(&a.chain), graph.places(&b.chain));
    let plane = Plane::around(a[0]);
    let flat = |places: &[Place]| -> LineString<f64> {
        let at = |p: &Place| plane.flat(Coord { x: p.longitude(), y: p.latitude() });
        places.iter().map(at).collect()
    };
    let (a_line, b_line) = (flat(&a), flat(&b));
    let start = a_line.0[0];
    let far = |line: &LineString<f64>| {
        let from_start = |c: &Coord<f64>| (c.x - start.x).hypot(c.y - start.y);
        line.0.iter().map(from_start).fold(0.0, f64::max)
    };
    let reach_m = far(&a_line).min(far(&b_line)).min(COMPARED_M);
    let near = |line: &LineString<f64>, other: &LineString<f64>| {
        let points = Euclidean.densify(line, STEP_M).into_inner();
        let within = |c: &&Coord<f64>| (c.x - start.x).hypot(c.y - start.y) <= reach_m;
        points.iter().filter(within).all(|c| Euclidean.distance(&Point(*c), other) <= OVER_M)
    };
    reach_m >= LEAST_M && near(&a_line, &b_line) && near(&b_line, &a_line)
}

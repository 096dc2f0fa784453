//! From an extract to its signalised intersections, and to the reasons why other signals are none.

use std::collections::BTreeSet;

use rayon::prelude::*;
use rstar::RTree;
use serde::Serialize;

use super::across::{Restrictions, crossings};
use super::arms::{Arm, arms};
use super::extract::{Place, SignalNode};
use super::flags::Flag;
pub use super::flags::Skip;
use super::geometry::{chord, middle};
use super::graph::{Graph, Step};
use super::legs::{Leg, Surroundings, surroundings};
use super::settings::Settings;
use super::sites::{Site, sites};
use super::streets::Streets;
use super::tags::Highway;
use super::turn::{Turns, exits};
use crate::angle::turn_degrees;

/// Most arms of an intersection: what has more is probably several that were joined.
pub const MAX_ARMS: usize = 6;

/// Most lanes of an arm in one direction: more are probably a mistake of the map.
pub const MAX_LANES: u32 = 12;

/// Angle between neighbouring arms below which they may be one, degrees.
const CLOSE_DEG: f64 = 25.0;

/// Number of arms from which on an intersection may be several.
const MANY_ARMS: usize = 5;

/// Lanes of an approach from which on they may be counted twice.
const MANY_LANES: u32 = 7;

/// Right-only lanes of an approach from which on a slip lane may be counted twice.
const MANY_RIGHT: u32 = 2;

/// Distance from its place in the signal list beyond which a match is doubtful, metres: more than a junction is wide.
const FAR_M: f64 = 25.0;

/// Distance of intersections that may have one controller, metres: fewer than eight cars fit between.
const NEAR_M: f64 = 60.0;

/// A signalised intersection.
#[derive(Debug, Clone, PartialEq)]
pub struct Intersection {
    /// Stable id: `n` and the smallest id of its signal nodes, or of its nodes without any.
    pub id: String,
    /// Its middle.
    pub centre: Place,
    /// Ids of its junction nodes, sorted.
    pub nodes: Vec<i64>,
    /// Where its junction and signal nodes are.
    pub places: Vec<Place>,
    /// Distance to its place in the signal list, metres, if there is a list.
    pub list_distance_m: Option<f64>,
    /// Ids of its signal nodes, sorted.
    pub signals: Vec<i64>,
    /// Its arms, sorted by bearing.
    pub arms: Vec<Arm>,
    /// Per arm the turns that exist; `None` for an arm without incoming lanes, and where the map leaves no way across.
    pub turns: Vec<Option<Turns>>,
    /// What is worth a look about its signals.
    pub flags: Vec<Flag>,
}

impl Intersection {
    /// Returns the places at which it can be met: its middle and its nodes.
    pub fn places(&self) -> impl Iterator<Item = Place> {
        std::iter::once(self.centre).chain(self.places.iter().copied())
    }

    /// Returns the names of its streets, each once, in alphabetical order.
    pub fn streets(&self) -> BTreeSet<&str> {
        self.arms.iter().filter_map(|a| a.name.as_deref()).collect()
    }

    /// Returns what is worth a look about its signals and its arms.
    pub fn all_flags(&self) -> Vec<Flag> {
        let approaches = || self.arms.iter().zip(&self.turns).filter(|(arm, _)| arm.lanes_in > 0);
        let any = |is: &dyn Fn(&Arm, &Option<Turns>) -> bool| approaches().any(|(a, t)| is(a, t));
        let next = |index: usize| &self.arms[(index + 1) % self.arms.len()];
        let close = self.arms.iter().enumerate().any(|(index, arm)| {
            turn_degrees(arm.bearing_deg, next(index).bearing_deg).abs() < CLOSE_DEG
        });
        let flags = [
            (Flag::NoWayAcross, any(&|_, turns| turns.is_none())),
            (Flag::DrawnTwice, self.arms.iter().any(|arm| arm.drawn_twice)),
            (Flag::CloseArms, close),
            (Flag::ManyArms, self.arms.len() >= MANY_ARMS),
            (Flag::ManyLanes, any(&|arm, _| arm.lanes_in >= MANY_LANES)),
            (Flag::ManyRight, any(&|arm, _| arm.right_turn_lanes >= MANY_RIGHT)),
            (Flag::NotOnMap, self.signals.is_empty() && !self.flags.contains(&Flag::CrossingsOnly)),
            (Flag::FarFromList, self.list_distance_m.is_some_and(|metres| metres > FAR_M)),
            (Flag::Cut, any(&|arm, _| arm.cut)),
            (Flag::OtherLength, any(&|arm, _| arm.clamped && !arm.cut)),
        ];
        let applying = flags.into_iter().filter(|(_, applies)| *applies).map(|(flag, _)| flag);
        let mut all: Vec<Flag> = self.flags.iter().copied().chain(applying).collect();
        all.sort_unstable();
        all
    }
}

/// A signal, or several of one junction, that is no intersection.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Skipped {
    /// Ids of the signal nodes.
    pub signals: Vec<i64>,
    /// Where the first of them is.
    #[serde(skip)]
    pub place: Place,
    /// Why.
    pub reason: Skip,
}

/// What an extract has.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Found {
    /// Intersections, by id of their first signal.
    pub intersections: Vec<Intersection>,
    /// Signals that are none.
    pub skipped: Vec<Skipped>,
}

/// `listed` have a signal, whatever the map says; those of `together` are one intersection, however far apart they are.
pub(crate) fn intersections(
    graph: &Graph<'_>,
    settings: &Settings,
    listed: &[u32],
    together: &[Vec<u32>],
) -> Found {
    let extract = graph.extract;
    let streets = Streets::new(extract, &settings.streets);
    let restrictions = Restrictions::new(extract, settings.streets.time_of_day);
    let (sites, left) = sites(graph, &settings.intersections, listed, together);
    let made: Vec<Result<Intersection, Skipped>> = sites
        .par_iter()
        .map(|site| intersection(graph, &streets, &restrictions, settings, site))
        .collect();
    let mut found = Found::default();
    for result in made {
        match result {
            Ok(intersection) => found.intersections.push(intersection),
            Err(skipped) => found.skipped.push(skipped),
        }
    }
    found.skipped.extend(left.into_iter().map(|(signal, reason)| {
        let signal = &extract.signals[signal];
        let reason = match reason {
            Skip::NoJunction | Skip::EndOfStreet if meters(graph, signal) => Skip::RampMeter,
            reason => reason,
        };
        Skipped { signals: vec![signal.id], place: signal.place, reason }
    }));
    let first = |signals: &[i64], nodes: &[i64]| signals.first().or(nodes.first()).copied();
    found.intersections.sort_by_key(|i| first(&i.signals, &i.nodes));
    flag_near(&mut found.intersections);
    found.skipped.sort_by_key(|s| first(&s.signals, &[]));
    found
}

fn intersection(
    graph: &Graph<'_>,
    streets: &Streets,
    restrictions: &Restrictions<'_>,
    settings: &Settings,
    site: &Site,
) -> Result<Intersection, Skipped> {
    let extract = graph.extract;
    let nodes: Vec<i64> = site.nodes.iter().map(|n| extract.nodes.ids[*n as usize]).collect();
    let signals: Vec<i64> = site.signals.iter().map(|s| extract.signals[*s].id).collect();
    let centre = centre(graph, &site.nodes);
    let skip = |reason| Err(Skipped { signals: signals.clone(), place: centre, reason });
    let on_roundabout = |n: &u32| graph.steps(*n).iter().any(|s| graph.way(*s).street.roundabout);
    if site.nodes.iter().any(on_roundabout) {
        return skip(Skip::Roundabout);
    }
    let around = surroundings(graph, site, &settings.intersections);
    // Signals at the entries of a roundabout stand before its fork, too.
    let reach_m = settings.intersections.signal_reach_m;
    let enters = |l: &Leg| l.outbound && l.length_m <= reach_m && on_roundabout(&l.chain.end);
    let entry = around.legs.iter().any(enters);
    let circle = |l: &&Leg| l.length_m <= reach_m && on_roundabout(&l.chain.end);
    if entry && around.legs.len() - around.legs.iter().filter(circle).count() <= 1 {
        return skip(Skip::Roundabout);
    }
    let skip = |reason| match reason {
        Skip::RampMeter | Skip::FewArms | Skip::FewApproaches if entry => skip(Skip::Roundabout),
        reason => skip(reason),
    };
    let metered =
        !site.signals.is_empty() && site.signals.iter().all(|s| extract.signals[*s].tags.meter);
    let merges = around.legs.iter().filter(|l| l.outbound).count() <= 1;
    let on_motorway = |l: &Leg| graph.way(l.first()).street.highway.is_motorway();
    if metered || (merges && around.legs.iter().all(on_motorway)) {
        return skip(Skip::RampMeter);
    }
    let mut arms = arms(graph, streets, settings, &around, centre);
    if site.nodes.iter().any(|n| graph.cut.contains(n)) {
        // An arm is missing, whatever is left.
        return skip(Skip::Border);
    }
    if arms.len() < 3 {
        return skip(Skip::FewArms);
    }
    let exits = arms.iter().filter(|a| a.lanes_out > 0).count();
    for arm in arms.iter_mut().filter(|a| exits <= usize::from(a.lanes_out > 0)) {
        // Nobody comes in where the only way out is back.
        (arm.lanes_in, arm.left_turn_lanes, arm.right_turn_lanes) = (0, 0, 0);
        (arm.slip_lanes, arm.centre_lanes) = (0, 0);
    }
    if arms.iter().filter(|a| a.lanes_in > 0).count() < 2 {
        return skip(Skip::FewApproaches);
    }
    if arms.len() > MAX_ARMS {
        return skip(Skip::ManyArms);
    }
    if arms.iter().any(|a| a.lanes_in.max(a.lanes_out) > MAX_LANES) {
        return skip(Skip::ManyLanes);
    }
    let turns = turns(graph, restrictions, &around, &arms);
    for (arm, turns) in arms.iter_mut().zip(&turns) {
        let Some(turns) = turns else { continue };
        if !turns.left {
            // A centre lane is there for left turns; other lanes turn where they can.
            arm.lanes_in -= arm.centre_lanes;
            (arm.left_turn_lanes, arm.centre_lanes) = (0, 0);
        }
        if !turns.right {
            arm.right_turn_lanes = 0;
        }
    }
    if !site.listed && crosses_one_street(graph, site, &around, &arms) {
        return skip(Skip::Crossing);
    }
    let flags = flags(site, graph);
    let first = signals.first().or(nodes.first()).copied().unwrap_or_default();
    let junctions = site.nodes.iter().map(|n| graph.place(*n));
    let places = junctions.chain(site.signals.iter().map(|s| extract.signals[*s].place)).collect();
    Ok(Intersection {
        id: format!("n{first}"),
        centre,
        nodes,
        places,
        list_distance_m: None,
        signals,
        arms,
        turns,
        flags,
    })
}

fn flag_near(intersections: &mut [Intersection]) {
    let at = |i: &Intersection| chord(i.centre);
    let tree = RTree::bulk_load(intersections.iter().map(at).collect());
    for i in intersections {
        if tree.locate_within_distance(chord(i.centre), NEAR_M * NEAR_M).count() > 1 {
            i.flags.push(Flag::NearSignal);
        }
    }
}

/// Returns whether a signal without a junction meters a ramp: the map says so, or it is on a ramp only.
fn meters(graph: &Graph<'_>, signal: &SignalNode) -> bool {
    let steps = graph.extract.nodes.index(signal.id).map(|n| graph.steps(n as u32));
    let on_ramp = |s: &Step| graph.way(*s).street.highway == Highway::MotorwayLink;
    signal.tags.meter
        || (!signal.tags.crossing
            && steps.is_some_and(|steps| !steps.is_empty() && steps.iter().all(on_ramp)))
}

fn flags(site: &Site, graph: &Graph<'_>) -> Vec<Flag> {
    let signals = || site.signals.iter().map(|s| &graph.extract.signals[*s]);
    let holds = [
        (Flag::CrossingsOnly, site.signals.is_empty() && !site.listed),
        (Flag::OneController, site.together),
        (Flag::JoinedRamps, site.ramps),
        (Flag::AllCrossings, !site.signals.is_empty() && signals().all(|s| s.tags.crossing)),
    ];
    holds.into_iter().filter(|(_, holds)| *holds).map(|(flag, _)| flag).collect()
}

/// Returns whether all signals of a site are pedestrian crossings before the junction, on one of its arms.
fn crosses_one_street(graph: &Graph<'_>, site: &Site, around: &Surroundings, arms: &[Arm]) -> bool {
    let extract = graph.extract;
    let signals: Vec<u32> = site
        .signals
        .iter()
        .map(|s| &extract.signals[*s])
        .filter(|s| s.tags.crossing)
        .filter_map(|s| extract.nodes.index(s.id).map(|n| n as u32))
        .collect();
    let on_arm = |arm: &Arm, node: u32| {
        let mut steps = arm.legs.iter().flat_map(|l| &around.legs[*l].chain.steps);
        steps.any(|s| graph.target(*s) == node)
    };
    !site.signals.is_empty()
        && signals.len() == site.signals.len()
        && arms.iter().any(|arm| signals.iter().all(|node| on_arm(arm, *node)))
}

fn centre(graph: &Graph<'_>, nodes: &[u32]) -> Place {
    middle(nodes.iter().map(|n| graph.place(*n))).expect("an intersection has nodes")
}

fn turns(
    graph: &Graph<'_>,
    restrictions: &Restrictions<'_>,
    around: &Surroundings,
    arms: &[Arm],
) -> Vec<Option<Turns>> {
    let crossings = crossings(graph, restrictions, around, arms);
    let of = |from: usize| {
        let others = arms.iter().enumerate().filter(|(to, arm)| *to != from && arm.lanes_out > 0);
        exits(arms[from].bearing_deg, others.map(|(to, arm)| (to, arm.bearing_deg)))
            .into_iter()
            .filter(|(to, _)| crossings.contains(&(from, *to)))
            .fold(None, |turns: Option<Turns>, (_, turn)| {
                Some(turns.unwrap_or(Turns::NONE).with(turn))
            })
    };
    (0..arms.len()).map(|from| if arms[from].lanes_in > 0 { of(from) } else { None }).collect()
}

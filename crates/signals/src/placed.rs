//! Existing plans on the arms of intersections: which movements of the network a plan's names are.
//!
//! - **Names** are directions of travel and turns, as on the ground. Where the names of all arms begin with a direction, as
//!   those of UTDF do, that direction counts, else the compass.
//! - **Several exits on one side**: `NBL` is all of them. Where the plan has `NBL2` too, as plans of methods have, `NBL` is the
//!   first of their links and `NBL2` the others, as in results.
//! - **Movements without a phase**: right turns go with the through movement of their approach, and left turns from shared
//!   lanes yield in its phases. This is said, unless the right turn shares a lane with it. Any other movement needs a phase.
//! - **Movements that cross** may not both have the right of way. Right turns are no part of this: they yield.

use std::collections::{BTreeMap, BTreeSet};

use osm_signals::angle::normalise_degrees;
use osm_signals::{DrivingSide, Turn};
use sheet::Fault;

use crate::existing::{ExistingPlan, NamedPlan, Plans};
use crate::family::approaches::Intersection;
use crate::family::doubts::Doubt;
use crate::family::load::LoadedScenario;
use crate::junction::Movement as ArmMovement;
use crate::network::error::NetworkError;
use crate::network::intersection::{IntersectionSpec, intersections};
use crate::network::lanes::{LaneLayout, layout, link_order};
use crate::settings::{Detail, LeftTurns};
use crate::turning::{few, matched_arms, meant};
use crate::vocabulary::{Heading, movement_names, number_in, on_side};
use evaluation::family::columns::at;
use evaluation::family::error::FamilyError;

/// Plans of point MDPs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Placed {
    /// By point MDP.
    pub of_point: BTreeMap<String, ExistingPlan>,
    /// The same as they were given.
    pub given: Vec<NamedPlan>,
    /// Plans that cannot be simulated, with the reason.
    pub refused: Vec<(NamedPlan, String)>,
    /// What is doubtful.
    pub doubts: Vec<Doubt>,
}

/// Gives plans to the intersections of a scenario. A plan that cannot be simulated is no error, see [`Placed::refused`].
pub fn placed(loaded: &LoadedScenario, plans: &Plans) -> Result<Placed, FamilyError> {
    let wrong = |line: u64, message: String| at(&plans.file, Fault { line, message });
    if loaded.scenario.family.detail != Detail::PerApproach || loaded.intersections.is_empty() {
        let message = "existing plans belong to real intersections; give a scenario with approaches and detail = \
                       \"per-approach\" in [family]";
        return Err(wrong(1, message.to_owned()));
    }
    let specs = intersections(loaded).map_err(|e| wrong(1, e.to_string()))?;
    let known = few(loaded.intersections.iter().map(|i| i.id.clone()));
    let all = &plans.all;
    let meant_by = |plan: &NamedPlan| {
        let is_point = loaded.family.points.iter().any(|point| point.id == plan.intersection);
        match meant(&plan.intersection, loaded.intersections.iter().map(|i| i.id.as_str())) {
            Err(_) if is_point => Ok(None),
            meant => meant.map_err(|message| wrong(plan.line, message)),
        }
    };
    let meant_by: Vec<Option<&str>> = all.iter().map(meant_by).collect::<Result<_, _>>()?;
    let mut placed = Placed::default();
    let (mut used, mut notes, mut without) = (vec![false; all.len()], Vec::new(), Vec::new());
    for ((point, members), spec) in loaded.family.points.iter().zip(&loaded.members).zip(&specs) {
        let intersection = &loaded.intersections[members[0]];
        let of = |rank: usize| -> Vec<usize> {
            let is_own = |i: &usize| {
                let is_meant = meant_by[*i] == Some(intersection.id.as_str());
                match rank {
                    // Reports call an intersection in a period by the id of its point MDP.
                    0 => all[*i].intersection == point.id && all[*i].period.is_empty(),
                    1 => is_meant && all[*i].period == intersection.period,
                    _ => is_meant && all[*i].period.is_empty(),
                }
            };
            (0..all.len()).filter(is_own).collect()
        };
        let found = (0..3).map(of).find(|found| !found.is_empty()).unwrap_or_default();
        let index = match found[..] {
            [] => {
                without.push(named_in(&intersection.id, &intersection.period));
                continue;
            }
            [one] => one,
            [a, b, ..] => {
                let [a, b] = [a, b].map(|i| &all[i]);
                let message = format!(
                    "{} and {} are plans of one intersection, {}; give it one per period",
                    a.intersection, b.intersection, intersection.id
                );
                return Err(wrong(b.line, message));
            }
        };
        let named = &all[index];
        used[index] = true;
        match place(&named.plan, intersection, spec) {
            Ok((plan, said)) => {
                let at = named_in(&intersection.id, &intersection.period);
                notes.extend(said.into_iter().map(|note| format!("intersection {at}: {note}")));
                placed.of_point.insert(point.id.clone(), plan);
                placed.given.extend((!placed.given.contains(named)).then(|| named.clone()));
            }
            Err(reason) => placed.refused.push((named.clone(), reason)),
        }
    }
    if !used.contains(&true) {
        let own = few(all.iter().map(|plan| plan.intersection.clone()));
        let message = format!(
            "no intersection with a plan ({own}) is in the scenario ({known}), in a period that it has; call them alike"
        );
        return Err(wrong(all.first().map_or(1, |plan| plan.line), message));
    }
    let unused = all.iter().zip(&used).filter(|(_, used)| !**used);
    let unused = unused.map(|(plan, _)| {
        let name = named_in(&plan.intersection, &plan.period);
        format!("{name}: {}, line {}", plans.file, plan.line)
    });
    let doubts = [
        Doubt::of(
            "existing plans of intersections or periods that the scenario does not have",
            unused.collect(),
        ),
        Doubt::of("intersections without an existing plan", without),
        Doubt::of("existing plans are not quite as they look", notes),
    ];
    placed.doubts = doubts.into_iter().flatten().collect();
    Ok(placed)
}

/// Returns the intersections of a scenario to build: left turns, and what goes into one leg together, as the existing plan of
/// each has them, where the settings say so.
pub fn with_plans(loaded: &LoadedScenario) -> Result<Vec<IntersectionSpec>, NetworkError> {
    let mut specs = intersections(loaded)?;
    let signal = &loaded.scenario.signal;
    let has_lefts = signal.left_turns == LeftTurns::Existing;
    let is_asked = has_lefts || signal.no_merging_greens;
    let Some(plans) = loaded.plans.as_ref().filter(|_| is_asked) else { return Ok(specs) };
    // What is wrong with plans is told by whoever simulates them.
    let Ok(placed) = placed(loaded, plans) else { return Ok(specs) };
    for spec in &mut specs {
        let Some(plan) = placed.of_point.get(&spec.point) else { continue };
        let layout = layout(spec)?;
        let merging = plan.merging.iter().filter(|_| signal.no_merging_greens).flatten();
        spec.merging = merging.filter_map(|name| plan.ways.get(name)).flatten().cloned().collect();
        for (arm, of) in spec.arms.iter_mut().enumerate().filter(|_| has_lefts) {
            of.left_turns = left_turns(plan, &layout, arm);
        }
    }
    Ok(specs)
}

/// Returns how a plan signals the left turns of an arm; `None` without a phase for them.
fn left_turns(plan: &ExistingPlan, layout: &LaneLayout, arm: usize) -> Option<LeftTurns> {
    let lefts = layout.movements.iter().filter(|m| (m.from, m.turn) == (arm, Turn::Left));
    let lefts: Vec<_> = lefts.map(|m| (m.from_edge(), m.to_edge())).collect();
    let has = |names: &[String]| {
        names.iter().filter_map(|name| plan.ways.get(name)).flatten().any(|way| lefts.contains(way))
    };
    let protects = plan.phases.iter().any(|phase| has(&phase.movements));
    let yields = plan.phases.iter().any(|phase| has(&phase.yielding));
    match (protects, yields) {
        (true, true) => Some(LeftTurns::ProtectedPermissive),
        (true, false) => Some(LeftTurns::Protected),
        (false, true) => Some(LeftTurns::Permissive),
        (false, false) => None,
    }
}

impl Placed {
    /// Refuses plans that cannot be simulated, unless they are of a network: those are left out.
    pub fn whole(self, plans: &Plans) -> Result<Self, FamilyError> {
        match self.refused.first().filter(|_| !plans.is_utdf) {
            None => Ok(self),
            Some((named, reason)) => {
                let message = format!("intersection {}: {reason}", named.intersection);
                Err(at(&plans.file, Fault { line: named.line, message }))
            }
        }
    }

    /// Returns what is to be said of plans that cannot be simulated and are left out.
    pub fn left_out(&self) -> Option<Doubt> {
        let refused = self.refused.iter();
        let said = refused.map(|(plan, why)| format!("intersection {}: {why}", plan.intersection));
        Doubt::of("existing plans that cannot be simulated are left out", said.collect())
    }
}

/// Returns an intersection with its period, as messages call it.
fn named_in(intersection: &str, period: &str) -> String {
    let separator = if period.is_empty() { "" } else { ", " };
    format!("{intersection}{separator}{period}")
}

/// Returns the position in the network of every arm: they are numbered by their bearings as the network has them.
fn order_of_arms(intersection: &Intersection, side: DrivingSide) -> Vec<usize> {
    let bearing_deg =
        |i: usize| side.bearing_deg(normalise_degrees(intersection.arms[i].bearing_deg));
    let mut order: Vec<usize> = (0..intersection.arms.len()).collect();
    order.sort_by(|a, b| bearing_deg(*a).total_cmp(&bearing_deg(*b)));
    (0..order.len())
        .map(|arm| order.iter().position(|other| *other == arm).unwrap_or(arm))
        .collect()
}

/// Returns the movements of the network in the order of their first links, from right to left on every approach. That is the
/// order in which results number movements of one name.
fn by_link(spec: &IntersectionSpec, layout: &LaneLayout) -> Vec<ArmMovement> {
    let links = link_order(spec, layout);
    let first_link = |m: &ArmMovement| {
        let own = layout.connections.iter().zip(&links).filter(|(c, _)| c.movement == *m);
        own.map(|(_, link)| *link).min()
    };
    let mut movements = layout.movements.clone();
    movements.sort_by_key(first_link);
    movements
}

/// Returns a plan with the ways of its movements, and what of it is not as it looks.
fn place(
    plan: &ExistingPlan,
    intersection: &Intersection,
    spec: &IntersectionSpec,
) -> Result<(ExistingPlan, Vec<String>), String> {
    let mut notes = plan.check()?;
    let layout = layout(spec).map_err(|e| e.to_string())?;
    let named = plan.phases.iter().flat_map(|phase| phase.all_movements());
    let headings: BTreeSet<Heading> =
        named.filter_map(|name| Some(Heading::of_movement(name, spec.side)?.0)).collect();
    let headings: Vec<Heading> = headings.into_iter().collect();
    let order = order_of_arms(intersection, spec.side);
    let (matched, _) = matched_arms(&headings, &intersection.arms, &[]);
    let mut arms = BTreeMap::new();
    for (heading, arm) in headings.into_iter().zip(matched) {
        let arm = arm.ok_or_else(|| {
            format!(
                "it has movements of {heading} traffic, but no approach goes that way; correct the movements, or bearing_deg \
                 of the arms"
            )
        })?;
        arms.insert(heading, order[arm]);
    }
    let by_link = by_link(spec, &layout);
    let (mut plan, mut ways) = (plan.clone(), ways_of(plan, spec.side, &by_link, &arms)?);
    notes.extend(complete(&mut plan, &mut ways, &layout, (spec.side, &by_link, &arms))?);
    plan.merging = no_crossing(&plan, &ways, &layout)?;
    notes.extend(plan.merging.iter().map(|[one, other]| {
        format!("{one} and {other} have the right of way into one leg together, in lanes of their own: a continuous-green T")
    }));
    for (name, own) in ways {
        plan.ways.insert(name, own.iter().map(|m| (m.from_edge(), m.to_edge())).collect());
    }
    Ok((plan, notes))
}

/// The movements that every name of a plan is.
type Ways = BTreeMap<String, Vec<ArmMovement>>;

/// Returns which movements of the network every name of a plan is: those of its turn from its number on to that of the
/// next name, of the first name also those before. A U-turn is all of its turn.
fn ways_of(
    plan: &ExistingPlan,
    side: DrivingSide,
    by_link: &[ArmMovement],
    arms: &BTreeMap<Heading, usize>,
) -> Result<Ways, String> {
    let named =
        || plan.phases.iter().flat_map(|p| p.all_movements().map(move |name| (p.number, name)));
    let is_u = |name: &str| name.ends_with('U');
    let mut ways = Ways::new();
    for (phase, name) in named() {
        let Some((heading, turn)) = Heading::of_movement(name, side) else {
            continue;
        };
        let arm = arms[&heading];
        let exits: Vec<ArmMovement> = (by_link.iter().copied())
            .filter(|m| (m.from, m.turn) == (arm, on_side(turn, side)))
            .collect();
        let number = number_in(name) as usize;
        if number > exits.len() {
            let of_arm = by_link.iter().filter(|m| m.from == arm);
            let has = movement_names(of_arm.map(|m| (heading, on_side(m.turn, side))));
            return Err(format!(
                "phase {phase} has {name}, but that approach has {}; correct the phase, or movements and bearing_deg of \
                 the arm",
                has.join(" ")
            ));
        }
        let of_turn = |other: &&String| {
            Heading::of_movement(other, side) == Some((heading, turn)) && !is_u(other)
        };
        let numbers: BTreeSet<usize> = named()
            .map(|(_, name)| name)
            .filter(of_turn)
            .map(|name| number_in(name) as usize)
            .collect();
        let begin = if numbers.first() == Some(&number) { 0 } else { number - 1 };
        let end = numbers.range(number + 1..).next().map_or(exits.len(), |next| next - 1);
        let own = if is_u(name) { exits } else { exits[begin..end].to_vec() };
        ways.insert(name.clone(), own);
    }
    Ok(ways)
}

/// Gives movements without a phase one, where it is clear which, and says so.
fn complete(
    plan: &mut ExistingPlan,
    ways: &mut Ways,
    layout: &LaneLayout,
    (side, by_link, arms): (DrivingSide, &[ArmMovement], &BTreeMap<Heading, usize>),
) -> Result<Vec<String>, String> {
    let mut notes = Vec::new();
    let way = |m: &ArmMovement| (m.from, m.turn);
    let served: BTreeSet<(usize, Turn)> = ways.values().flatten().map(way).collect();
    let mut all: Vec<(usize, Turn)> = layout.movements.iter().map(way).collect();
    all.dedup();
    for (arm, turn) in all.into_iter().filter(|way| !served.contains(way)) {
        let Some((heading, _)) = arms.iter().find(|(_, of)| **of == arm) else {
            return Err(format!(
                "an approach has no phase (edge in{arm} of the network); give its movements to phases"
            ));
        };
        let name = format!("{heading}{}", on_side(turn, side).letter());
        let lanes = |turn: Turn| -> BTreeSet<u32> {
            let own = layout.connections.iter();
            own.filter(|c| way(&c.movement) == (arm, turn)).map(|c| c.from_lane).collect()
        };
        let others = [Turn::Through, Turn::Right, Turn::Left].into_iter();
        let other = others.filter(|of| *of != turn).find(|of| served.contains(&(arm, *of)));
        let is_shared = other.is_some_and(|other| !lanes(turn).is_disjoint(&lanes(other)));
        let may_go_along = turn == Turn::Right || turn == Turn::Left && is_shared;
        let Some(other) = other.filter(|_| may_go_along) else {
            return Err(format!("{name} has no phase; add it to movements or yielding of one"));
        };
        let has = |names: &[String]| {
            let own = names.iter().filter_map(|name| ways.get(name)).flatten();
            own.into_iter().any(|m| way(m) == (arm, other))
        };
        let mut numbers = Vec::new();
        for phase in &mut plan.phases {
            let (own, yields) = (has(&phase.movements), has(&phase.yielding));
            if own && turn != Turn::Left {
                phase.movements.push(name.clone());
            } else if own || yields {
                phase.yielding.push(name.clone());
            } else {
                continue;
            }
            numbers.push(phase.number.to_string());
        }
        let own = by_link.iter().filter(|m| way(m) == (arm, turn)).copied().collect();
        if turn == Turn::Left || !is_shared {
            let as_what = if turn == Turn::Left { " and yields" } else { "" };
            let with = numbers.join(" and ");
            notes.push(format!(
                "{name} has no phase of its own and goes with phase {with}{as_what}"
            ));
        }
        ways.insert(name, own);
    }
    Ok(notes)
}

/// Refuses phases that give crossing movements the right of way together. Returns those that go into one leg, each into lanes
/// of its own.
fn no_crossing(
    plan: &ExistingPlan,
    ways: &Ways,
    layout: &LaneLayout,
) -> Result<Vec<[String; 2]>, String> {
    let exits = |m: &ArmMovement| -> BTreeSet<u32> {
        let own = layout.connections.iter().filter(|c| c.movement == *m);
        own.map(|c| c.to_lane).collect()
    };
    let merge = |m: &ArmMovement, o: &ArmMovement| {
        m.from != o.from && m.to == o.to && exits(m).is_disjoint(&exits(o))
    };
    let mut merging = Vec::new();
    let ahead =
        |name: &String| ways.get(name).into_iter().flatten().filter(|m| m.turn != Turn::Right);
    for pair in plan.pairs() {
        let phases = pair.iter().map(|p| &plan.phases[*p]);
        let all: Vec<_> =
            phases.flat_map(|p| p.movements.iter().map(move |name| (p, name))).collect();
        for (i, (a, one)) in all.iter().enumerate() {
            let any = |other: &String, is: &dyn Fn(&ArmMovement, &ArmMovement) -> bool| {
                ahead(one).any(|m| ahead(other).any(|o| is(m, o)))
            };
            for (_, other) in &all[..i] {
                let pair = [(*other).clone(), (*one).clone()];
                if any(other, &merge) && !merging.contains(&pair) {
                    merging.push(pair);
                }
            }
            let crosses = |m: &ArmMovement, o: &ArmMovement| m.conflicts_with(o) && !merge(m, o);
            let Some((b, other)) = all[..i].iter().find(|(_, other)| any(other, &crosses)) else {
                continue;
            };
            let numbers = match a.number == b.number {
                true => format!("phase {} has", a.number),
                false => format!(
                    "phases {} and {} are green together (barrier {}) and have",
                    b.number, a.number, a.barrier
                ),
            };
            return Err(format!(
                "{numbers} {other} and {one}, which cross, or lead into one lane; correct ring and barrier, or put a turn \
                 across opposing traffic under yielding"
            ));
        }
    }
    Ok(merging)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::existing::Control;
    use crate::existing::testing::{phase, plan};
    use crate::family::load::from_text;

    /// A scenario of one intersection whose arms have these bearings, with a left lane each.
    fn scenario(bearings_deg: &[f64], settings: &str) -> LoadedScenario {
        let mut table = "intersection,arm,latitude,longitude,bearing_deg,lanes_in,lanes_out,left_turn_lanes,right_turn_lanes,\
                         speed_mph,length_m,aadt_veh_per_day_per_lane,movements\n"
            .to_owned();
        for bearing_deg in bearings_deg {
            table.push_str(&format!("7,a{bearing_deg},,,{bearing_deg},2,2,1,0,30,200,9000,\n"));
        }
        let text = format!("name = \"s\"\n[family]\napproaches = \"a.csv\"\n{settings}");
        from_text(&text, "s.toml", &[], &|_| Ok(table.clone())).unwrap()
    }

    const CROSS: [f64; 4] = [0.0, 90.0, 180.0, 270.0];

    fn plans(plan: ExistingPlan) -> Plans {
        let named = NamedPlan { intersection: "7".into(), period: String::new(), plan, line: 2 };
        Plans { file: "e.csv".into(), all: vec![named], ..Plans::default() }
    }

    fn tried(change: &dyn Fn(&mut ExistingPlan)) -> Placed {
        let mut plan = plan(Control::Pretimed);
        change(&mut plan);
        placed(&scenario(&CROSS, ""), &plans(plan)).unwrap()
    }

    fn refused(change: &dyn Fn(&mut ExistingPlan)) -> String {
        tried(change).refused.remove(0).1
    }

    #[test]
    fn movements_are_ways_of_the_network() {
        let placed = tried(&|_| ());
        let plan = &placed.of_point["i0007"];
        let way = |name: &str| plan.ways[name].clone();
        assert_eq!(way("NBL"), [("in2".to_owned(), "out3".to_owned())]);
        assert_eq!(way("EBT"), [("in3".to_owned(), "out1".to_owned())]);
        assert_eq!(placed.doubts, []);
    }

    #[test]
    fn movements_into_lanes_of_their_own_of_one_leg_are_a_continuous_green_t() {
        let phases = [
            phase(2, [1, 1, 1], "NBT NBR"),
            phase(6, [1, 2, 1], "SBT sbl"),
            phase(8, [2, 1, 1], "WBL WBR SBT"),
        ];
        let plan = ExistingPlan::new(Control::Actuated, phases.to_vec());
        let bearings_deg = [0.0, 90.0, 180.0];
        let plain = scenario(&bearings_deg, "[signal]\nno_merging_greens = true\n");
        let found = placed(&plain, &plans(plan.clone())).unwrap();
        let pair = ["WBL", "SBT"].map(str::to_owned);
        assert_eq!(found.of_point["i0007"].merging, [pair]);
        assert!(found.doubts[0].brief().contains("a continuous-green T"), "{:?}", found.doubts);
        let loaded = LoadedScenario { plans: Some(plans(plan.clone())), ..plain };
        let ways = [("in1", "out2"), ("in0", "out2")].map(|(a, b)| (a.into(), b.into()));
        assert_eq!(with_plans(&loaded).unwrap()[0].merging, ways);
        // Both through lanes lead into the lane of the left turn.
        let mut loaded = loaded;
        loaded.intersections[0].arms[0].left_turn_lanes = 0;
        let refused = placed(&loaded, &plans(plan)).unwrap().refused.remove(0).1;
        assert!(refused.contains("phase 8 has WBL and SBT, which cross"), "{refused}");
    }

    #[test]
    fn left_turns_are_as_the_plan_has_them_where_the_settings_say_so() {
        use LeftTurns::{Permissive, Protected, ProtectedPermissive};
        let mut plan = plan(Control::Pretimed);
        plan.phases[1].yielding.push("NBL".into());
        let found = |settings: &str| {
            let plans = Some(plans(plan.clone()));
            let loaded = LoadedScenario { plans, ..scenario(&CROSS, settings) };
            let arms = with_plans(&loaded).unwrap().remove(0).arms;
            arms.iter().map(|arm| arm.left_turns).collect::<Vec<_>>()
        };
        let expected = [Protected, Permissive, ProtectedPermissive, Permissive].map(Some);
        assert_eq!(found("[signal]\nleft_turns = \"existing\"\n"), expected);
        assert_eq!(found("[signal]\nleft_turns = \"by-rule\"\n"), [None; 4]);
    }

    #[test]
    fn left_hand_traffic_is_mirrored() {
        let loaded = scenario(&CROSS, "[network]\ndriving_side = \"left\"\n");
        // On the left side right turns cross opposing traffic.
        let mut plan = plan(Control::Pretimed);
        let swap = |name: &mut String| {
            *name = name.replace('L', "_").replace('R', "L").replace('_', "R");
        };
        for phase in &mut plan.phases {
            phase.movements.iter_mut().for_each(swap);
            phase.yielding.iter_mut().for_each(swap);
        }
        // The left lanes of the ground are right lanes of the mirror image, and every arm has one.
        let placed = placed(&loaded, &plans(plan)).unwrap();
        assert_eq!(placed.refused, []);
        // Northbound traffic comes from arm 2, and its right turn leads east, which the mirror has in the west.
        let ways = &placed.of_point["i0007"].ways;
        assert_eq!(ways["NBR"], [("in2".to_owned(), "out3".to_owned())]);
        assert_eq!(ways["EBT"], [("in1".to_owned(), "out3".to_owned())]);
    }

    #[test]
    fn right_turns_go_with_the_through_movement_and_other_movements_need_a_phase() {
        let without = |name: &'static str| {
            move |p: &mut ExistingPlan| {
                for phase in &mut p.phases {
                    phase.movements.retain(|n| n != name);
                    phase.yielding.retain(|n| n != name);
                }
            }
        };
        let placed = tried(&without("NBR"));
        assert_eq!(placed.of_point["i0007"].phases[1].movements, ["NBT", "NBR"]);
        assert_eq!(placed.doubts, [], "it shares a lane");
        for (change, name) in
            [(&without("NBT") as &dyn Fn(&mut ExistingPlan), "NBT"), (&without("EBL"), "EBL")]
        {
            let expected = format!("{name} has no phase; add it to movements or yielding of one");
            assert_eq!(refused(change), expected);
        }
    }

    #[test]
    fn what_the_intersection_does_not_have_is_named() {
        let e = refused(&|p| p.phases[1].movements.push("NET".into()));
        assert!(e.contains("it has movements of NE traffic, but no approach goes that way"), "{e}");
        let mut tee = plan(Control::Pretimed);
        tee.phases.retain(|p| p.number != 8 && p.number != 1);
        tee.phases[0].movements = vec!["NBT".into()];
        let placed = placed(&scenario(&[0.0, 180.0, 270.0], ""), &plans(tee)).unwrap();
        assert!(
            placed.refused[0].1.contains("phase 4 has EBT, but that approach has EBR EBL"),
            "{placed:?}"
        );
    }

    /// The movements of the only intersection, one per phase, with the arms to which they lead.
    fn placed_ways(bearings_deg: &[f64], phases: &[&str]) -> BTreeMap<String, Vec<String>> {
        let phases = (1..).zip(phases).map(|(k, names)| phase(k, [1, 1, k], names));
        let plan = ExistingPlan::new(Control::Actuated, phases.collect());
        let placed = placed(&scenario(bearings_deg, ""), &plans(plan)).unwrap();
        assert_eq!(placed.refused, []);
        let to =
            |ways: &[(String, String)]| ways.iter().map(|(_, to)| to.clone()).collect::<Vec<_>>();
        placed.of_point["i0007"].ways.iter().map(|(name, ways)| (name.clone(), to(ways))).collect()
    }

    #[test]
    fn three_exits_on_one_side_have_three_names() {
        let bearings_deg = [0.0, 180.0, 225.0, 270.0, 315.0];
        let others = ["SBT SBR", "NEL NER", "EBL EBR", "SEL SER"];
        let of = |names: &str| {
            let ways = placed_ways(&bearings_deg, &[&[names][..], &others].concat());
            ["NBL", "NBL2", "NBL3"].map(|name| ways.get(name).map(|to| to.join(" ")))
        };
        let to = |text: &str| Some(text.to_owned());
        assert_eq!(of("NBT NBL NBL2 NBL3"), [to("out4"), to("out3"), to("out2")]);
        assert_eq!(of("NBT NBL NBL2"), [to("out4"), to("out3 out2"), None]);
        assert_eq!(of("NBT NBL NBL3"), [to("out4 out3"), None, to("out2")]);
        assert_eq!(of("NBT NBL2"), [None, to("out4 out3 out2"), None]);
    }

    #[test]
    fn plans_of_other_intersections_and_two_of_one_are_said() {
        let loaded = scenario(&CROSS, "");
        let mut twice = plans(plan(Control::Pretimed));
        twice.all.push(NamedPlan { intersection: "007".into(), line: 9, ..twice.all[0].clone() });
        let e = placed(&loaded, &twice).unwrap_err().to_string();
        assert!(e.contains("line 9: 7 and 007 are plans of one intersection"), "{e}");
        let mut more = plans(plan(Control::Pretimed));
        more.all.push(NamedPlan { intersection: "9".into(), line: 9, ..more.all[0].clone() });
        assert!(placed(&loaded, &more).unwrap().doubts[0].brief().contains("does not have (9: "));
    }
}

//! Existing plans on the arms of intersections: which movements of the network a plan's names are.
//!
//! - **Names** are directions of travel and turns, as on the ground. Where the names of all arms begin with a direction, as
//!   those of UTDF do, that direction counts, else the compass.
//! - **Several exits on one side**: `NBL` is all of them. Where the plan has `NBL2` too, as plans of methods have, `NBL` is the
//!   first of their links and `NBL2` the others, as in results.
//! - **Names of results** have the turns that SUMO sees. Of two exits that are nearly straight on, it may take the other one for
//!   straight on than the network does. Where a plan has a name for each exit of an approach, these are in the order of the links.
//! - **Right turns without a phase** go with the through movement of their approach, and left turns from shared lanes yield
//!   in its phases. This is said, unless the right turn shares a lane with it. Any other movement needs a phase.
//! - **Movements that cross** may not both have the right of way. Where one yields that is no left turn across opposing
//!   traffic, this is said, and where both lead into lanes of one arm side by side. Right turns are no part of this: they yield.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use osm_signals::angle::{normalise_degrees, turn_degrees};
use osm_signals::turn::THROUGH_LIMIT_DEG;
use osm_signals::{DrivingSide, Turn};
use sheet::Fault;

use crate::existing::ran::{of_program, unusual};
use crate::existing::{Control, ExistingPlan, NamedPlan, NamedProgram, Plans};
use crate::family::approaches::Intersection;
use crate::family::doubts::Doubt;
use crate::family::load::LoadedScenario;
use crate::junction::Movement as ArmMovement;
use crate::network::intersection::{IntersectionSpec, intersections};
use crate::network::lanes::{LaneLayout, layout, link_order};
use crate::network::plain::SIGNAL;
use crate::settings::Detail;
use crate::turning::{matched_arms, meant};
use crate::vocabulary::{Heading, movement_names, number_in, on_side};
use evaluation::family::columns::at;
use evaluation::family::error::FamilyError;

/// Arms between which no street goes straight on are opposite if their bearings are so far apart, degrees: those of a Y are,
/// those of streets that cross at an angle of more than 60 degrees are not.
const LEAST_OPPOSITE_DEG: f64 = 120.0;

/// Most names that a message lists.
const FEW: usize = 6;

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

/// Gives plans to the intersections of a scenario.
///
/// # Errors
///
/// [`FamilyError`] where no plan belongs to an intersection, two belong to one, or intersections have no approaches of
/// their own. A plan that cannot be simulated is no error, see [`Placed::refused`].
pub fn placed(loaded: &LoadedScenario, plans: &Plans) -> Result<Placed, FamilyError> {
    let wrong = |line: u64, message: String| at(&plans.file, Fault { line, message });
    if loaded.scenario.family.detail != Detail::PerApproach || loaded.intersections.is_empty() {
        return Err(wrong(
            1,
            "existing plans belong to real intersections; give a scenario with approaches and detail = \"per-approach\" in \
             [family]"
                .to_owned(),
        ));
    }
    let specs = intersections(loaded).map_err(|e| wrong(1, e.to_string()))?;
    let side = loaded.scenario.network.driving_side;
    let mut placed = Placed::default();
    let mut plans = plans.clone();
    let (mut odd, mut unread, mut elsewhere) = (Vec::new(), Vec::new(), Vec::new());
    for program in &plans.programs {
        match of_states(program, loaded, &specs, side) {
            Ok(Some((plan, notes))) => {
                odd.extend(notes);
                unread.extend((!program.unread.is_empty()).then(|| {
                    format!("signal {}: {}", program.program.signal, program.unread.join(", "))
                }));
                plans.all.push(plan);
            }
            Ok(None) => elsewhere.push(program.program.signal.clone()),
            Err(message) => return Err(wrong(program.line, message)),
        }
    }
    if let (Some(first), true) = (plans.programs.first(), plans.all.is_empty()) {
        let mut known = loaded.intersections.iter().map(|i| i.id.clone());
        let message = format!(
            "no tlLogic ({}) is an intersection of the scenario ({}); give each the id of its intersection, or of its point MDP",
            few(&mut elsewhere.into_iter()),
            few(&mut known)
        );
        return Err(wrong(first.line, message));
    }
    let points: BTreeSet<&str> = loaded.family.points.iter().map(|p| p.id.as_str()).collect();
    let mut meant_by = Vec::with_capacity(plans.all.len());
    for plan in &plans.all {
        let ids = loaded.intersections.iter().map(|i| i.id.as_str());
        meant_by.push(match meant(&plan.intersection, ids) {
            Err(_) if points.contains(plan.intersection.as_str()) => None,
            meant => meant.map_err(|message| wrong(plan.line, message))?,
        });
    }
    let (mut used, mut notes, mut without) = (vec![false; plans.all.len()], Vec::new(), Vec::new());
    for ((point, members), spec) in loaded.family.points.iter().zip(&loaded.members).zip(&specs) {
        let intersection = &loaded.intersections[members[0]];
        let of = |is_own: &dyn Fn(usize, &NamedPlan) -> bool| {
            plans.all.iter().enumerate().filter(|(i, plan)| is_own(*i, plan)).collect::<Vec<_>>()
        };
        // Reports call an intersection in a period by the id of its point MDP.
        let mut found = of(&|_, plan| plan.intersection == point.id && plan.period.is_empty());
        for period in [intersection.period.as_str(), ""] {
            if found.is_empty() {
                let is_same = |i: usize| meant_by[i] == Some(intersection.id.as_str());
                found = of(&|i, plan| is_same(i) && plan.period == period);
            }
        }
        let (index, named) = match found[..] {
            [] => {
                without.push(named_in(intersection));
                continue;
            }
            [one] => one,
            [(_, a), (_, b), ..] => {
                let message = format!(
                    "{} and {} are plans of one intersection, {}; give it one per period",
                    a.intersection, b.intersection, intersection.id
                );
                return Err(wrong(b.line, message));
            }
        };
        used[index] = true;
        match place(&named.plan, intersection, spec, side) {
            Ok((plan, said)) => {
                notes.extend(
                    said.into_iter()
                        .map(|note| format!("intersection {}: {note}", named_in(intersection))),
                );
                placed.of_point.insert(point.id.clone(), plan);
                placed.given.extend((!placed.given.contains(named)).then(|| named.clone()));
            }
            Err(reason) => placed.refused.push((named.clone(), reason)),
        }
    }
    if !used.contains(&true) {
        let own = few(&mut plans.all.iter().map(|plan| plan.intersection.clone()));
        let table = few(&mut loaded.intersections.iter().map(|i| i.id.clone()));
        let message = format!(
            "no intersection with a plan ({own}) is in the scenario ({table}), in a period that it has; call \
             them alike"
        );
        return Err(wrong(plans.all.first().map_or(1, |plan| plan.line), message));
    }
    let unused = plans.all.iter().zip(&used).filter(|(_, used)| !**used);
    let unused: Vec<String> = unused
        .map(|(plan, _)| match plan.period.as_str() {
            "" => plan.intersection.clone(),
            period => format!("{}, {period}", plan.intersection),
        })
        .chain(elsewhere)
        .collect();
    placed.doubts.extend(Doubt::of(
        "existing plans of intersections or periods that the scenario does not have",
        unused,
    ));
    placed.doubts.extend(Doubt::of("intersections without an existing plan", without));
    placed.doubts.extend(Doubt::of("existing plans are not quite as they look", notes));
    placed.doubts.extend(Doubt::of(
        "programs of SUMO are shown as phases of one ring; check that the states have the links of the network in its order",
        odd,
    ));
    placed.doubts.extend(Doubt::of("parameters of programs that have no effect here", unread));
    Ok(placed)
}

impl Placed {
    /// Refuses plans that cannot be simulated, unless they are of a network: those are left out.
    ///
    /// # Errors
    ///
    /// [`FamilyError::Csv`] with file and line of the first of them.
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
        let said = self
            .refused
            .iter()
            .map(|(named, why)| format!("intersection {}: {why}", named.intersection));
        Doubt::of("existing plans that cannot be simulated are left out", said.collect())
    }
}

/// Returns names as messages list them.
fn few(names: &mut dyn Iterator<Item = String>) -> String {
    let mut names: Vec<String> = names.collect();
    names.dedup();
    let more = if names.len() > FEW { ", ..." } else { "" };
    format!("{}{more}", names[..names.len().min(FEW)].join(", "))
}

/// Returns the plan that a program of SUMO is, and what of it is not as it looks; `None` for one of another signal.
///
/// # Errors
///
/// What of the program does not fit to the intersection, with the way out.
fn of_states(
    named: &NamedProgram,
    loaded: &LoadedScenario,
    specs: &[IntersectionSpec],
    side: DrivingSide,
) -> Result<Option<(NamedPlan, Vec<String>)>, String> {
    let program = &named.program;
    let id = program.signal.as_str();
    let first = |members: &Vec<usize>| &loaded.intersections[members[0]];
    let is_only = || loaded.members.iter().all(|m| first(m).id == first(&loaded.members[0]).id);
    let mut points = loaded.family.points.iter().zip(&loaded.members).zip(specs);
    let exact =
        points.clone().find(|((point, members), _)| point.id == id || first(members).id == id);
    let found = match exact {
        Some(exact) => Some(exact),
        None => {
            let same = meant(id, loaded.members.iter().map(|m| first(m).id.as_str()))?;
            points.find(|((_, members), _)| {
                same == Some(first(members).id.as_str()) || (id == SIGNAL && is_only())
            })
        }
    };
    let Some(((point, members), spec)) = found else { return Ok(None) };
    let fail = |message: String| format!("signal {id}: {message}");
    let intersection = first(members);
    let layout = layout(spec).map_err(|e| e.to_string())?;
    let headings = headings(intersection, side).map_err(fail)?;
    let movements = by_link(spec, &layout);
    let way = |m: &ArmMovement| (headings[&m.from], on_side(m.turn, side));
    let told = movement_names(movements.iter().map(way));
    let name_of: BTreeMap<ArmMovement, String> = movements.into_iter().zip(told).collect();
    let of_links = layout.connections.iter().map(|c| name_of[&c.movement].clone());
    let names: BTreeMap<usize, String> =
        link_order(spec, &layout).into_iter().zip(of_links).collect();
    let letters = program.phases[0].state.len();
    if letters != names.len() {
        let links: Vec<&str> = names.values().map(String::as_str).collect();
        return Err(fail(format!(
            "states have {letters} letters, but the intersection has {} links ({}); give each its letter, in this order",
            links.len(),
            links.join(" ")
        )));
    }
    let plan = of_program(program, &names).expect("static and actuated programs are read");
    if plan.phases.is_empty() {
        return Err(fail("no phase has a green; give it one".to_owned()));
    }
    let intersection = match point.id == id {
        true => point.id.clone(),
        false => intersection.id.clone(),
    };
    let stages = unusual(program).into_iter();
    let notes = stages.map(|stage| {
        format!("intersection {intersection}: after phase {stage} lights end one by one in the file, and together here")
    });
    let notes = notes.collect();
    let line = named.line;
    Ok(Some((NamedPlan { intersection, period: String::new(), plan, line }, notes)))
}

/// Returns how vehicles travel that come from an arm, by its position in the network.
fn headings(
    intersection: &Intersection,
    side: DrivingSide,
) -> Result<BTreeMap<usize, Heading>, String> {
    let incoming = || intersection.arms.iter().filter(|arm| arm.lanes_in > 0);
    let headings_deg: Vec<f64> = incoming().map(|arm| arm.bearing_deg + 180.0).collect();
    let told = Heading::told(incoming().map(|arm| arm.arm.as_str()));
    let told: BTreeSet<Heading> =
        told.unwrap_or_else(|| Heading::of_approaches(&headings_deg)).into_iter().collect();
    if told.len() < headings_deg.len() {
        let said =
            "two approaches have the same direction of travel; give the plan as a table of phases";
        return Err(said.to_owned());
    }
    let (arms, _) = arms_of(&told, intersection, side)?;
    Ok(arms.into_iter().map(|(heading, arm)| (arm, heading)).collect())
}

/// Returns an intersection with its period, as messages call it.
fn named_in(intersection: &Intersection) -> String {
    match intersection.period.as_str() {
        "" => intersection.id.clone(),
        period => format!("{}, {period}", intersection.id),
    }
}

/// Returns a plan with the ways of its movements, and what of it is not as it looks.
///
/// # Errors
///
/// What the plan lacks, or has and the intersection has not, with the way out.
fn place(
    plan: &ExistingPlan,
    intersection: &Intersection,
    spec: &IntersectionSpec,
    side: DrivingSide,
) -> Result<(ExistingPlan, Vec<String>), String> {
    let mut notes = plan.check()?;
    let mut plan = plan.clone();
    let headings: BTreeSet<Heading> = (plan.phases.iter())
        .flat_map(|phase| phase.all_movements())
        .filter_map(|name| Some(Heading::of_movement(name, side)?.0))
        .collect();
    let (arms, is_ambiguous) = arms_of(&headings, intersection, side)?;
    if is_ambiguous {
        notes.push(
            "directions of the compass may belong to other arms, because the streets lie between them; compare the \
             movements"
                .to_owned(),
        );
    }
    let layout = layout(spec).map_err(|e| e.to_string())?;
    let by_link = by_link(spec, &layout);
    let mut ways = ways(&plan, &arms, spec, &by_link, side);
    for phase in &plan.phases {
        for name in phase.all_movements() {
            let Some([]) = ways.get(name).map(Vec::as_slice) else { continue };
            let arm = Heading::of_movement(name, side).and_then(|(heading, _)| arms.get(&heading));
            let of_arm = layout.movements.iter().filter(|m| Some(&m.from) == arm);
            let mut others: Vec<&str> = of_arm.map(|m| word(on_side(m.turn, side))).collect();
            others.dedup();
            return Err(format!(
                "phase {} has {name}, but that approach only leads {}; correct the phase, or movements and bearing_deg \
                 of the arm",
                phase.number,
                others.join(" and ")
            ));
        }
    }
    notes.extend(people_without_walk(&plan, intersection));
    complete(&mut plan, &arms, &layout, &by_link, &mut ways, side, &mut notes)?;
    no_crossing(&plan, spec, &layout, &ways, &mut notes)?;
    for (name, own) in ways {
        plan.ways.insert(name, own.iter().map(|m| (m.from_edge(), m.to_edge())).collect());
    }
    Ok((plan, notes))
}

/// Says how many people cross where a plan has no walk.
fn people_without_walk(plan: &ExistingPlan, intersection: &Intersection) -> Option<String> {
    let counted = intersection.arms.iter().filter_map(|arm| arm.counted?.pedestrians_per_h);
    let per_h: f64 = counted.sum();
    let has_walk = plan.phases.iter().any(|phase| phase.walk_s.is_some());
    // Beside the greens of a fixed cycle people cross anyway.
    let is_fixed = plan.control == Control::Pretimed;
    (per_h > 0.0 && !has_walk && !is_fixed).then(|| {
        format!(
            "{per_h:.0} people an hour cross there, and the plan has no walk: where they push buttons, nobody serves them"
        )
    })
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

/// A name of a movement after its turn and its number among those of the turn: names of an approach are in the order of its links.
type Called<'a> = (Reverse<Turn>, u32, &'a String);

/// Returns which movements of the network every name of a plan is; none for a turn that its approach does not have.
///
/// # Arguments
///
/// * `by_link` — all movements, in the order of their links.
fn ways(
    plan: &ExistingPlan,
    arms: &BTreeMap<Heading, usize>,
    spec: &IntersectionSpec,
    by_link: &[ArmMovement],
    side: DrivingSide,
) -> BTreeMap<String, Vec<ArmMovement>> {
    let names: BTreeSet<&String> = plan.phases.iter().flat_map(|p| p.all_movements()).collect();
    let mut ways = BTreeMap::new();
    let mut of_arms: BTreeMap<usize, Vec<Called<'_>>> = BTreeMap::new();
    for name in names {
        let Some((heading, turn)) = Heading::of_movement(name, side) else { continue };
        let Some(arm) = arms.get(&heading) else { continue };
        let turn = on_side(turn, side);
        if name.ends_with('U') {
            let own = by_link.iter().filter(|m| (m.from, m.turn) == (*arm, turn));
            ways.insert(name.clone(), own.copied().collect());
        } else {
            of_arms.entry(*arm).or_default().push((Reverse(turn), number_in(name), name));
        }
    }
    for (arm, mut names) in of_arms {
        names.sort_unstable();
        let exits: Vec<ArmMovement> = by_link.iter().filter(|m| m.from == arm).copied().collect();
        let is_called = |i: usize| may_be_called(names[i].0.0, &exits[i], spec);
        if names.len() == exits.len() && (0..exits.len()).all(is_called) {
            let of_names = names.iter().zip(&exits);
            ways.extend(of_names.map(|((.., name), exit)| ((*name).clone(), vec![*exit])));
            continue;
        }
        for turn in [Turn::Right, Turn::Through, Turn::Left] {
            let own = names.iter().filter(|(of, ..)| of.0 == turn);
            let numbered: Vec<(u32, &String)> =
                own.map(|(_, number, name)| (*number, *name)).collect();
            let exits: Vec<ArmMovement> =
                exits.iter().filter(|m| m.turn == turn).copied().collect();
            ways.extend(shared_out(&numbered, &exits));
        }
    }
    ways
}

/// Returns the exits of one turn by the names that a plan has for them: each name has those from its number on to that of the
/// next name, the first one also those before.
fn shared_out(names: &[(u32, &String)], exits: &[ArmMovement]) -> Vec<(String, Vec<ArmMovement>)> {
    let begin = |k: usize| match k {
        0 => 0,
        _ => (names[k].0 as usize - 1).min(exits.len().saturating_sub(1)),
    };
    let own = |k: usize| {
        let next = if k + 1 < names.len() { begin(k + 1) } else { exits.len() };
        let end = next.max(begin(k) + 1).min(exits.len());
        (names[k].1.clone(), exits[begin(k)..end].to_vec())
    };
    (0..names.len()).map(own).collect()
}

/// Whether results may call a movement of the network so: SUMO may call one that is nearly straight on through or a turn to its
/// side, whatever the network does.
fn may_be_called(turn: Turn, movement: &ArmMovement, spec: &IntersectionSpec) -> bool {
    let bearing_deg = |arm: usize| spec.arms[arm].bearing_deg;
    let off_deg = turn_degrees(bearing_deg(movement.from) + 180.0, bearing_deg(movement.to));
    let aside = if off_deg < 0.0 { Turn::Left } else { Turn::Right };
    let is_nearly_straight = off_deg.abs() <= THROUGH_LIMIT_DEG;
    turn == movement.turn || is_nearly_straight && (turn == Turn::Through || turn == aside)
}

/// Returns the arms that vehicles with these directions come from, as positions in the network, and whether other ones may
/// be meant.
fn arms_of(
    headings: &BTreeSet<Heading>,
    intersection: &Intersection,
    side: DrivingSide,
) -> Result<(BTreeMap<Heading, usize>, bool), String> {
    let arms = &intersection.arms;
    // Arms are numbered by their bearings as the network has them.
    let mut order: Vec<usize> = (0..arms.len()).collect();
    let bearing_deg = |i: usize| side.bearing_deg(normalise_degrees(arms[i].bearing_deg));
    order.sort_by(|a, b| bearing_deg(*a).total_cmp(&bearing_deg(*b)));
    let place = |arm: usize| order.iter().position(|other| *other == arm).unwrap_or(arm);
    let wanted: Vec<Heading> = headings.iter().copied().collect();
    let matched = matched_arms(&wanted, arms, &[]);
    let mut of = BTreeMap::new();
    for (heading, arm) in wanted.iter().zip(matched.arms) {
        let arm = arm.ok_or_else(|| {
            format!(
                "it has movements of {heading} traffic, but no approach goes that way; correct the movements, or bearing_deg \
                 of the arms"
            )
        })?;
        of.insert(*heading, place(arm));
    }
    Ok((of, matched.is_ambiguous))
}

/// Gives movements without a phase one, where it is clear which.
///
/// # Arguments
///
/// * `by_link` — all movements, in the order of their links.
/// * `ways` — which of them the names of the plan are; gets those of the names that are added.
fn complete(
    plan: &mut ExistingPlan,
    arms: &BTreeMap<Heading, usize>,
    layout: &LaneLayout,
    by_link: &[ArmMovement],
    ways: &mut BTreeMap<String, Vec<ArmMovement>>,
    side: DrivingSide,
    notes: &mut Vec<String>,
) -> Result<(), String> {
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
        let lanes = |turn: Turn| {
            let own = layout.connections.iter();
            own.filter(move |c| (c.movement.from, c.movement.turn) == (arm, turn))
                .map(|c| c.from_lane)
                .collect::<BTreeSet<u32>>()
        };
        let goes_with = [Turn::Through, Turn::Right, Turn::Left]
            .into_iter()
            .find(|other| *other != turn && served.contains(&(arm, *other)));
        let is_shared = goes_with.is_some_and(|other| !lanes(turn).is_disjoint(&lanes(other)));
        let Some(other) =
            goes_with.filter(|_| turn == Turn::Right || (turn == Turn::Left && is_shared))
        else {
            return Err(format!("{name} has no phase; add it to movements or yielding of one"));
        };
        let mut numbers = Vec::new();
        for phase in &mut plan.phases {
            let is_other = |name: &String| {
                ways.get(name).is_some_and(|own| own.iter().any(|m| way(m) == (arm, other)))
            };
            let has = |names: &[String]| names.iter().any(is_other);
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
        ways.insert(name.clone(), own);
        if turn == Turn::Right && is_shared {
            continue;
        }
        let as_what = if turn == Turn::Left { " and yields" } else { "" };
        notes.push(format!(
            "{name} has no phase of its own and goes with phase {}{as_what}",
            numbers.join(" and ")
        ));
    }
    Ok(())
}

/// Refuses phases that give crossing movements the right of way together. Notes where one yields that is no left turn across
/// opposing traffic, and where both lead into lanes side by side: programs at skew arms have such, and so may a mistake.
fn no_crossing(
    plan: &ExistingPlan,
    spec: &IntersectionSpec,
    layout: &LaneLayout,
    ways: &BTreeMap<String, Vec<ArmMovement>>,
    notes: &mut Vec<String>,
) -> Result<(), String> {
    let ways = |name: &str| -> Vec<&ArmMovement> {
        let own = ways.get(name).into_iter().flatten();
        own.filter(|m| m.turn != Turn::Right).collect()
    };
    for pair in plan.pairs() {
        let of = |p: usize| {
            let phase = &plan.phases[p];
            let yields = phase.yielding.iter().map(move |name| (p, name, true));
            phase.movements.iter().map(move |name| (p, name, false)).chain(yields)
        };
        let all: Vec<(usize, &String, bool)> = pair.iter().flat_map(|p| of(*p)).collect();
        for (i, (a, one, one_yields)) in all.iter().enumerate() {
            for (b, other, other_yields) in &all[..i] {
                let meets = |m: &ArmMovement, o: &ArmMovement| {
                    m.conflicts_with(o)
                        && !(*one_yields && turns_across(m, o, spec, &layout.movements))
                        && !(*other_yields && turns_across(o, m, spec, &layout.movements))
                };
                let both = ways(one)
                    .into_iter()
                    .flat_map(|m| ways(other).into_iter().map(move |o| (m, o)));
                let meeting: Vec<_> = both.filter(|(m, o)| meets(m, o)).collect();
                if meeting.is_empty() {
                    continue;
                }
                let [a, b] = [a, b].map(|p| &plan.phases[*p]);
                let numbers = match a.number == b.number {
                    true => format!("phase {} has", a.number),
                    false => format!(
                        "phases {} and {} are green together (barrier {}) and have",
                        b.number, a.number, a.barrier
                    ),
                };
                let how = match (*one_yields, *other_yields) {
                    (true, _) => format!("which cross, and {one} yields"),
                    (false, true) => format!("which cross, and {other} yields"),
                    (false, false)
                        if meeting.iter().all(|(m, o)| are_side_by_side(m, o, spec, layout)) =>
                    {
                        "which lead into lanes side by side".to_owned()
                    }
                    (false, false) => {
                        return Err(format!(
                            "{numbers} {other} and {one}, which cross; correct ring and barrier, or put a turn across opposing \
                             traffic under yielding"
                        ));
                    }
                };
                let note = format!("{numbers} {other} and {one}, {how}");
                if !notes.contains(&note) {
                    notes.push(note);
                }
            }
        }
    }
    Ok(())
}

/// Returns whether two movements lead into lanes of one arm side by side, without crossing: the further clockwise from that arm
/// vehicles come from, the further left they drive away.
fn are_side_by_side(
    a: &ArmMovement,
    b: &ArmMovement,
    spec: &IntersectionSpec,
    layout: &LaneLayout,
) -> bool {
    let arms = spec.arms.len();
    let around = |m: &ArmMovement| (m.from + arms - m.to) % arms;
    let [right, left] = if around(a) < around(b) { [*a, *b] } else { [*b, *a] };
    let lanes = |movement: ArmMovement| {
        layout.connections.iter().filter(move |c| c.movement == movement).map(|c| c.to_lane)
    };
    a.to == b.to && lanes(right).max() < lanes(left).min()
}

/// Returns whether a movement is a left turn and another one comes from the opposite arm.
fn turns_across(
    own: &ArmMovement,
    other: &ArmMovement,
    spec: &IntersectionSpec,
    all: &[ArmMovement],
) -> bool {
    let leads = |from: usize, to: usize| {
        all.iter().any(|m| (m.from, m.to, m.turn) == (from, to, Turn::Through))
    };
    let bearing_deg = |arm: usize| spec.arms[arm].bearing_deg;
    let apart_deg = turn_degrees(bearing_deg(own.from), bearing_deg(other.from)).abs();
    let is_opposite = leads(own.from, other.from)
        || leads(other.from, own.from)
        || apart_deg >= LEAST_OPPOSITE_DEG;
    own.turn == Turn::Left && is_opposite
}

fn word(turn: Turn) -> &'static str {
    if turn == Turn::Through { "straight on" } else { turn.name() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::existing::testing::{phase, plan};
    use crate::family::approaches::Counted;
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

    #[test]
    fn people_who_cross_where_no_phase_has_a_walk_are_said() {
        let mut intersection = scenario(&CROSS, "").intersections[0].clone();
        let people = Counted { pedestrians_per_h: Some(30.0), ..Counted::default() };
        intersection.arms[0].counted = Some(people);
        let mut actuated = plan(Control::Actuated);
        let said = people_without_walk(&actuated, &intersection).unwrap();
        assert!(
            said.starts_with("30 people an hour cross there, and the plan has no walk"),
            "{said}"
        );
        assert_eq!(people_without_walk(&plan(Control::Pretimed), &intersection), None);
        actuated.phases[1].walk_s = Some([7.0, 12.0]);
        assert_eq!(people_without_walk(&actuated, &intersection), None);
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
    fn left_hand_traffic_is_mirrored() {
        let loaded = scenario(&CROSS, "[network]\ndriving_side = \"left\"\n");
        // On the left side right turns cross opposing traffic.
        let mut plan = plan(Control::Pretimed);
        let swap = |name: &mut String| {
            *name = match name.split_at(2) {
                (heading, "L") => format!("{heading}R"),
                (heading, "R") => format!("{heading}L"),
                (heading, turn) => format!("{heading}{turn}"),
            };
        };
        for phase in &mut plan.phases {
            phase.movements.iter_mut().for_each(swap);
            phase.yielding.iter_mut().for_each(swap);
        }
        for phase in plan.phases.iter_mut().filter(|p| p.movements.contains(&"NBR".to_owned())) {
            phase.movements.push("NBU".into());
        }
        // The left lanes of the ground are right lanes of the mirror image, and every arm has one.
        let placed = placed(&loaded, &plans(plan)).unwrap();
        assert_eq!(placed.refused, []);
        // Northbound traffic comes from arm 2, and its right turn leads east, which the mirror has in the west.
        let ways = &placed.of_point["i0007"].ways;
        assert_eq!(ways["NBR"], [("in2".to_owned(), "out3".to_owned())]);
        assert_eq!(ways["NBU"], ways["NBR"], "U-turns cross opposing traffic");
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
        let left = tried(&|p| p.phases[2].yielding.clear()).refused.remove(0).1;
        assert_eq!(
            left, "EBL has no phase; add it to movements or yielding of one",
            "it has a lane of its own"
        );
        assert_eq!(
            refused(&without("NBT")),
            "NBT has no phase; add it to movements or yielding of one"
        );
        assert_eq!(
            refused(&without("NBL")),
            "NBL has no phase; add it to movements or yielding of one"
        );
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
            placed.refused[0]
                .1
                .contains("phase 4 has EBT, but that approach only leads left and right"),
            "{placed:?}"
        );
    }

    #[test]
    fn movements_that_lead_into_lanes_side_by_side_are_said_and_not_refused() {
        let tried = |first: &str| {
            let phases = [first, "NBT NBR", "WBL", "SBL SBT SBR", "EBL EBT EBR"];
            let phases = (1..).zip(phases).map(|(k, names)| phase(k, [1, 1, k], names));
            let plan = ExistingPlan::new(Control::Actuated, phases.collect());
            let placed = placed(&scenario(&CROSS, ""), &plans(plan)).unwrap();
            let refused = placed.refused.into_iter().map(|(_, why)| why).collect::<String>();
            (refused, placed.doubts.iter().map(Doubt::brief).collect::<String>())
        };
        // The left lane of the south leads to the left lane of the west, and the right lane of the east to the right one.
        let (refused, said) = tried("WBT WBR NBL");
        let expected = "phase 1 has WBT and NBL, which lead into lanes side by side";
        assert!(refused.is_empty() && said.contains(expected), "{refused}{said}");
        let (refused, _) = tried("WBT WBR NBL NBT");
        assert!(refused.contains("phase 1 has WBT and NBT, which cross"), "{refused}");
    }

    #[test]
    fn several_exits_on_one_side_are_told_apart_where_the_plan_does() {
        let tried = |names: [&str; 2]| {
            let [first, second] = names;
            let phases = vec![
                phase(1, [1, 1, 1], first),
                phase(2, [1, 1, 2], second),
                phase(3, [1, 1, 3], "SBL SBT SBR"),
                phase(4, [1, 1, 4], "WBL WBT WBR"),
                phase(5, [1, 1, 5], "NEL NER"),
            ];
            let plan = ExistingPlan::new(Control::Actuated, phases);
            placed(&scenario(&[0.0, 90.0, 180.0, 225.0, 270.0], ""), &plans(plan)).unwrap()
        };
        // From the south the west (arm 4) is the first left, the southwest (arm 3) the second one, which does not cross what
        // comes from the west.
        let apart = tried(["NBL NBT NBR", "EBL EBT EBR NBL2"]);
        assert_eq!(apart.refused, []);
        let way = |placed: &Placed, name: &str| placed.of_point["i0007"].ways[name].clone();
        let to = |arm: u32| ("in2".to_owned(), format!("out{arm}"));
        assert_eq!((way(&apart, "NBL"), way(&apart, "NBL2")), (vec![to(4)], vec![to(3)]));
        let both = vec![to(3), to(4)];
        for name in ["NBL", "NBL2"] {
            let mut alone = way(&tried([format!("{name} NBT NBR").as_str(), "EBL EBT EBR"]), name);
            alone.sort_unstable();
            assert_eq!(alone, both);
        }
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
    fn where_results_take_another_exit_for_straight_on_the_order_of_the_links_counts() {
        let phases =
            ["EBL EBT EBR EBR2", "SBL SBT SBR", "WBL WBT WBR", "NWL NWT NWR", "NEL NET NER"];
        // From the west (arm 4) arms 1 and 2 lie 36 degrees to the left and to the right: the network takes the right one for
        // straight on, and SUMO the left one.
        let ways = placed_ways(&[0.0, 72.0, 144.0, 216.0, 288.0], &phases);
        let of = ["EBR", "EBR2", "EBT", "EBL"].map(|name| ways[name].join(" "));
        assert_eq!(of, ["out3", "out2", "out1", "out0"]);
        assert_eq!(ways["WBT"], ["out4"], "with one name per turn the network's turns count");
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
    fn in_a_y_a_left_turn_yields_to_the_approach_that_comes_closest_to_opposite() {
        let tried = |bearings_deg: &[f64], phases: &[&str]| {
            let phases = (1..).zip(phases).map(|(k, names)| phase(2 * k, [k, 1, 1], names));
            let plan = ExistingPlan::new(Control::Actuated, phases.collect());
            let placed = placed(&scenario(bearings_deg, ""), &plans(plan)).unwrap();
            let refused = placed.refused.into_iter().map(|(_, why)| why).collect::<String>();
            (refused, placed.doubts.iter().map(Doubt::brief).collect::<String>())
        };
        let wye = [0.0, 120.0, 240.0];
        let nothing = (String::new(), String::new());
        assert_eq!(tried(&wye, &["NEL NER SBR sbl", "NWL NWR"]), nothing);
        let (e, _) = tried(&wye, &["NEL NER SBR SBL", "NWL NWR"]);
        assert!(e.contains("phase 2 has NEL and SBL, which cross"), "{e}");
        // Streets that cross at an angle of 62 degrees.
        let phases = ["NBT NBR swl", "NBL", "SBL SBT SBR", "NEL NET NER", "SWT SWR"];
        let (e, said) = tried(&[0.0, 62.0, 180.0, 242.0], &phases);
        assert!(said.contains("phase 2 has NBT and SWL, which cross, and SWL yields"), "{e}{said}");
    }

    #[test]
    fn plans_of_other_intersections_and_two_of_one_are_said() {
        let loaded = scenario(&CROSS, "");
        let mut other = plans(plan(Control::Pretimed));
        other.all[0].intersection = "9".into();
        let e = placed(&loaded, &other).unwrap_err().to_string();
        assert!(
            e.contains("e.csv, line 2: no intersection with a plan (9) is in the scenario"),
            "{e}"
        );
        let mut twice = plans(plan(Control::Pretimed));
        twice.all.push(NamedPlan { intersection: "007".into(), line: 9, ..twice.all[0].clone() });
        let e = placed(&loaded, &twice).unwrap_err().to_string();
        assert!(e.contains("line 9: 7 and 007 are plans of one intersection"), "{e}");
        let mut more = plans(plan(Control::Pretimed));
        more.all.push(NamedPlan { intersection: "9".into(), line: 9, ..more.all[0].clone() });
        assert!(placed(&loaded, &more).unwrap().doubts[0].brief().contains("does not have (9)"));
    }

    #[test]
    fn an_exact_name_goes_before_a_similar_one_and_several_similar_ones_are_refused() {
        let mut table =
            "intersection,arm,latitude,longitude,bearing_deg,lanes_in,lanes_out,left_turn_lanes,right_turn_lanes,\
             speed_mph,length_m,aadt_veh_per_day_per_lane,movements\n"
                .to_owned();
        for id in ["7", "007"] {
            for bearing_deg in CROSS {
                table += &format!("{id},a{bearing_deg},,,{bearing_deg},2,2,1,0,30,200,9000,\n");
            }
        }
        let text = "name = \"s\"\n[family]\napproaches = \"a.csv\"\n";
        let loaded = from_text(text, "s.toml", &[], &|_| Ok(table.clone())).unwrap();
        let of = |ids: &[&str]| {
            let one = plans(plan(Control::Pretimed));
            let named = |id: &&str| NamedPlan { intersection: (*id).into(), ..one.all[0].clone() };
            let given = Plans { all: ids.iter().map(named).collect(), ..one.clone() };
            let placed = placed(&loaded, &given).unwrap();
            (placed.of_point.len(), placed.doubts.iter().map(Doubt::brief).collect::<Vec<_>>())
        };
        assert_eq!(of(&["7", "007"]), (2, vec![]));
        let without = "intersections without an existing plan (007)".to_owned();
        assert_eq!(of(&["7"]), (1, vec![without]));
        let mut either = plans(plan(Control::Pretimed));
        either.all[0].intersection = "07".into();
        let e = placed(&loaded, &either).unwrap_err().to_string();
        let expected = "07 may be intersection 007 or 7; call it exactly like one of them";
        assert_eq!(e, format!("e.csv, line 2: {expected}"));
        let mut either = program(["GGgrrrGGgrrr", "rrrGGgrrrGGg"]);
        either.programs[0].program.signal = "07".into();
        let e = placed(&loaded, &either).unwrap_err().to_string();
        assert!(e.contains(expected), "{e}");
    }

    #[test]
    fn one_way_streets_need_phases_for_what_comes_in() {
        let mut plan = plan(Control::Pretimed);
        plan.phases = vec![phase(2, [1, 1, 1], "NBT NBL NBR"), phase(4, [2, 1, 1], "EBT")];
        plan.cycle_s = None;
        plan.reference.clear();
        let placed = placed(&scenario(&CROSS, ""), &plans(plan)).unwrap();
        assert!(placed.refused[0].1.contains("an approach has no phase"), "{placed:?}");
    }

    #[test]
    fn a_plan_may_be_called_by_the_id_of_its_point_mdp() {
        let mut given = plans(plan(Control::Pretimed));
        given.all[0].intersection = "i0007".into();
        assert_eq!(placed(&scenario(&CROSS, ""), &given).unwrap().of_point.len(), 1);
    }

    /// An additional file with a program for the crossing, whose 12 links are right, through and left of each arm from
    /// north on, once per lane.
    fn program(states: [&str; 2]) -> Plans {
        let [a, b] = states;
        let yellow = |state: &str| state.replace(['G', 'g'], "y");
        let text = format!(
            "<additional><tlLogic id='7' type='static' offset='5'><phase duration='30' state='{a}'/><phase duration='4' \
             state='{}'/><phase duration='20' state='{b}'/><phase duration='4' state='{}'/></tlLogic></additional>",
            yellow(a),
            yellow(b)
        );
        crate::existing::read(&text, "p.add.xml").unwrap()
    }

    #[test]
    fn the_states_of_a_program_are_movements_in_the_order_of_the_links() {
        let placed = placed(&scenario(&CROSS, ""), &program(["GGgrrrGGgrrr", "rrrGGgrrrGGg"]));
        let placed = placed.unwrap();
        let plan = &placed.of_point["i0007"];
        let told: Vec<_> = (plan.phases.iter())
            .map(|p| (p.movements.join(" "), p.yielding.join(" "), p.max_green_s, p.yellow_s))
            .collect();
        let text = str::to_owned;
        assert_eq!(
            told,
            [
                (text("NBT NBR SBT SBR"), text("NBL SBL"), 30.0, 4.0),
                (text("EBT EBR WBT WBR"), text("EBL WBL"), 20.0, 4.0),
            ]
        );
        assert_eq!(
            (plan.offset_s, plan.cycle_s, plan.control),
            (Some(5.0), Some(58.0), Control::Pretimed)
        );
        assert_eq!(plan.ways["NBT"], [("in2".to_owned(), "out0".to_owned())]);
        assert_eq!(placed.given[0].intersection, "7");
    }

    #[test]
    fn parameters_of_a_program_that_are_not_read_are_told() {
        let mut given = program(["GGgrrrGGgrrr", "rrrGGgrrrGGg"]);
        given.programs[0].unread = vec!["jam-threshold".to_owned()];
        let placed = placed(&scenario(&CROSS, ""), &given).unwrap();
        let told: Vec<String> = placed.doubts.iter().map(Doubt::brief).collect();
        let expected =
            "parameters of programs that have no effect here (signal 7: jam-threshold)".to_owned();
        assert!(told.contains(&expected), "{told:?}");
    }

    #[test]
    fn the_states_of_a_program_tell_several_exits_on_one_side_apart() {
        // Five arms from north on, each with right turns, through and left turns; the second left turn from the south is
        // green with the approach from the west.
        let states = [
            "rrrrrrrrGGGrrrrrrrrr", "rrrrrrrrrrrGrrrrGGGG", "GGGGrrrrrrrrrrrrrrrr",
            "rrrrGGGGrrrrrrrrrrrr", "rrrrrrrrrrrrGGGGrrrr",
        ];
        let phase =
            |state: &str, seconds: u32| format!("<phase duration='{seconds}' state='{state}'/>");
        let phases: Vec<String> = states
            .iter()
            .map(|s| format!("{}{}", phase(s, 20), phase(&s.replace('G', "y"), 4)))
            .collect();
        let text = format!(
            "<additional><tlLogic id='7' type='static' offset='0'>{}</tlLogic></additional>",
            phases.concat()
        );
        let given = crate::existing::read(&text, "p.add.xml").unwrap();
        let loaded = scenario(&[0.0, 90.0, 180.0, 225.0, 270.0], "");
        let placed = placed(&loaded, &given).unwrap();
        assert_eq!(placed.refused, []);
        let plan = &placed.of_point["i0007"];
        let told: Vec<String> = plan.phases.iter().map(|p| p.movements.join(" ")).collect();
        assert_eq!(told[..2], ["NBL NBT NBR", "NBL2 EBL EBT EBR EBR2"]);
        assert_eq!(plan.ways["NBL2"], [("in2".to_owned(), "out3".to_owned())]);
    }

    #[test]
    fn states_that_do_not_fit_are_refused_with_the_order_of_the_links() {
        let of = |plans: &Plans| placed(&scenario(&CROSS, ""), plans).unwrap_err().to_string();
        let e = of(&program(["GGrr", "rrGG"]));
        let expected = "signal 7: states have 4 letters, but the intersection has 12 links (SBR SBT SBL WBR WBT WBL NBR NBT";
        assert!(e.contains("p.add.xml, line 1") && e.contains(expected), "{e}");
        let left = scenario(&CROSS, "[network]\ndriving_side = \"left\"\n");
        let e = placed(&left, &program(["GGrr", "rrGG"])).unwrap_err().to_string();
        let expected = "(NBL NBT NBR WBL WBT WBR SBL SBT SBR EBL EBT EBR)";
        assert!(e.contains(expected), "anticlockwise from the southern arm: {e}");
        let mut other = program(["GGgrrrGGgrrr", "rrrGGgrrrGGg"]);
        other.programs[0].program.signal = "gneJ1".into();
        let e = of(&other);
        assert!(
            e.contains(
                "no tlLogic (gneJ1) is an intersection of the scenario (7); give each the id"
            ),
            "{e}"
        );
        let e = placed(&scenario(&CROSS, ""), &program(["GGGrrrGGGrrr", "rrrGGgrrrGGg"])).unwrap();
        assert!(e.refused[0].1.contains("which cross"), "{e:?}");
    }
}

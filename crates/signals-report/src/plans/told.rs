//! Plans as they are told to people: all of them as phases, existing ones as they were given.

use std::collections::{BTreeMap, BTreeSet};

use super::TaskPlan;
use crate::shown::Seen;
use evaluation::store::manifest::PointRow;
use osm_signals::{DrivingSide, Turn};
use signals::control::existing;
use signals::environment::existing_plan;
use signals::existing::ran::{of_program, of_rings};
use signals::existing::{ExistingPlan, PlanPhase};
use signals::movement_results::MovementResult;
use signals::network::plain::SIGNAL;
use signals::network_files::GENERATED;
use signals::places::DrawnIntersection;
use signals::program::{ProgramKind, SignalProgram};
use signals::vocabulary::{Heading, listed, on_side};

/// The plan of a signal as phases.
pub(crate) struct Told {
    /// Position of the method in the manifest.
    pub(crate) method: usize,
    /// Position of the point MDP in the manifest.
    pub(crate) point: usize,
    /// Which of several trainings.
    pub(crate) replicate: u32,
    /// Mean objective of its evaluation episodes.
    pub(crate) objective: Option<f64>,
    /// SUMO's id of the signal.
    pub(crate) signal: String,
    /// The plan.
    pub(crate) plan: ExistingPlan,
    /// Per movement the edges from which and to which it leads.
    pub(crate) ways: BTreeMap<String, Vec<(String, String)>>,
    /// Whether its phases are stages of a program.
    pub(crate) is_stages: bool,
    /// Whether its signal is the only one of the task.
    pub(crate) is_alone: bool,
}

impl Told {
    /// Returns the plan as files have it that a run takes back. A stage whose walk goes on through later ones has none there,
    /// because a phase lasts until its walk and clearance are over.
    pub(crate) fn given_back(&self) -> ExistingPlan {
        let mut plan = self.plan.clone();
        for phase in plan.phases.iter_mut().filter(|_| self.is_stages) {
            let least_s = phase.min_green_s;
            phase.walk_s = phase.walk_s.filter(|[walk_s, clear_s]| walk_s + clear_s <= least_s);
        }
        plan
    }
}

/// Returns the plans of all signals of a task; nothing for methods that decide while they run.
pub(super) fn of_task(seen: Seen<'_>, task: &TaskPlan) -> Vec<Told> {
    let Seen { data, shown } = seen;
    let told = |signal: &str, mut plan: ExistingPlan, is_stages: bool| {
        let is_given = !plan.ways.is_empty();
        if !is_given {
            rename(&mut plan, &renamed(seen, task.point));
            number(&mut plan, &Numbers::new(seen, task.point, signal));
        }
        let ways = if is_given { plan.ways.clone() } else { ways(seen, task.point, signal) };
        let TaskPlan { method, point, replicate, objective, .. } = *task;
        let (signal, is_alone) = (signal.to_owned(), true);
        let mut told =
            Told { method, point, replicate, objective, signal, plan, ways, is_stages, is_alone };
        if !is_given {
            told.plan.merging = merging(&told, side(seen));
        }
        told
    };
    let identity = &data.manifest.identity;
    let point = &identity.points[task.point];
    if let Some(plan) = given_plan(point, &identity.methods[task.method]) {
        let mut ran = task.rings.iter().chain(&task.programs);
        let plan = ran.next().map_or(plan.clone(), |program| plan.retimed(&program.greens_s));
        // A record may come from a stranger.
        let is_one = plan.check().is_ok();
        return is_one.then(|| told(SIGNAL, plan, false)).into_iter().collect();
    }
    let of_results = shown.link_names(task.point);
    let names = |program: &SignalProgram| -> BTreeMap<usize, String> {
        match program.links.is_empty() {
            true => of_results.get(&program.signal).cloned().unwrap_or_default(),
            false => program.links.iter().cloned().enumerate().collect(),
        }
    };
    let rings = task.rings.iter().filter_map(|signal| {
        let is_stages = signal.kind != ProgramKind::DualRing;
        let plan = match is_stages {
            false => of_rings(signal),
            true => of_program(signal, &names(signal))?,
        };
        Some(told(&signal.signal, plan, is_stages))
    });
    let programs = task.programs.iter().filter_map(|program| {
        let mut plan = of_program(program, &names(program))?;
        // Records do not have the offset of a program of a network that is not ours.
        if program.own && point.environment != GENERATED {
            plan.offset_s = None;
        }
        Some(told(&program.signal, plan, true)).filter(|told| !told.plan.phases.is_empty())
    });
    let mut all: Vec<Told> = rings.chain(programs).collect();
    let is_alone = all.len() == 1;
    all.iter_mut().for_each(|told| told.is_alone = is_alone);
    all
}

/// Returns the plan of every method that has one at every intersection of one signal whose movements are known: of several
/// trainings that of the best objective.
pub(crate) fn best(seen: Seen<'_>) -> Vec<Told> {
    best_of_all_signals(seen).into_iter().filter(|told| told.is_alone).collect()
}

/// Returns what [`best`] does, with the plans of point MDPs of several signals: one plan per signal. Plans of a method on a
/// point MDP stand together.
pub(crate) fn best_of_all_signals(seen: Seen<'_>) -> Vec<Told> {
    let direction = seen.data.direction();
    let mut best: BTreeMap<(usize, usize), (&TaskPlan, Vec<Told>)> = BTreeMap::new();
    for task in &seen.shown.plans {
        let mut of_task = of_task(seen, task);
        of_task.retain(|told| told.plan.phases.iter().any(|p| p.all_movements().next().is_some()));
        if of_task.is_empty() {
            continue;
        }
        let key = (task.point, task.method);
        if best.get(&key).is_none_or(|(other, _)| task.is_better_than(other, direction)) {
            best.insert(key, (task, of_task));
        }
    }
    best.into_values().flat_map(|(_, of_task)| of_task).collect()
}

/// Returns the plan that a method runs on a point MDP, where it was given; `None` also where the manifest has something else
/// in its place.
pub(crate) fn given_plan(point: &PointRow, method: &str) -> Option<ExistingPlan> {
    existing_plan(point, method).ok().flatten()
}

/// Returns what movements of an intersection are called in plans, by the name that they have in results: as the plan that was
/// given for it calls them, else after the directions with which the names of its arms begin. Plans that are given are read so.
fn renamed(seen: Seen<'_>, point: usize) -> BTreeMap<String, String> {
    let Seen { data, shown } = seen;
    let identity = &data.manifest.identity;
    let Some(results) = shown.movements.iter().find(|task| task.point == point) else {
        return BTreeMap::new();
    };
    let existing = plan_of_today(seen, point);
    let drawn = shown.drawing(&identity.points[point].point);
    let name = |m: &MovementResult| {
        let way = (m.from.clone(), m.to.clone());
        let name = match &existing {
            Some(plan) => plan.ways.iter().find(|(_, ways)| ways.contains(&way))?.0.clone(),
            None => on_arm(&m.movement, &m.from, drawn?)?,
        };
        Some((m.movement.clone(), name))
    };
    results.results.iter().filter_map(name).collect()
}

/// Which numbers phases have by their movements.
struct Numbers {
    /// Of the through phase of each approach.
    through: BTreeMap<Heading, u32>,
    /// Of movements that have the right of way in one phase of the existing plan.
    of_movement: BTreeMap<String, u32>,
    /// All numbers of the existing plan.
    taken: BTreeSet<u32>,
    side: DrivingSide,
}

impl Numbers {
    /// Returns them for a signal: those of its existing plan, else 2 and 6 for the street with most lanes and 4 and 8 for the
    /// other one, of which 2 and 4 go by [`Heading`]: north before east before south before west.
    fn new(seen: Seen<'_>, point: usize, signal: &str) -> Self {
        let side = side(seen);
        let today = plan_of_today(seen, point).map(|plan| Self::of(&plan, side));
        today.filter(|numbers| !numbers.through.is_empty()).unwrap_or_else(|| Self {
            through: approaches(seen, point, signal),
            of_movement: BTreeMap::new(),
            taken: BTreeSet::new(),
            side,
        })
    }

    /// Returns those of an existing plan, where they are unambiguous.
    fn of(plan: &ExistingPlan, side: DrivingSide) -> Self {
        let only = |has: &dyn Fn(&PlanPhase) -> bool| {
            let mut phases = plan.phases.iter().filter(|p| p.also.is_none() && has(p));
            phases.next().map(|phase| phase.number).filter(|_| phases.next().is_none())
        };
        let names: BTreeSet<&String> = plan.phases.iter().flat_map(|p| p.all_movements()).collect();
        let ways = || names.iter().filter_map(|name| Some((*name, ahead_of(name, side)?)));
        let through = |(name, (heading, turn)): (&String, (Heading, Turn))| {
            let is_through = |way: Heading| ways().any(|w| w.1 == (way, Turn::Through));
            let is_first = turn == Turn::Through || !is_through(heading);
            let number = only(&|phase| phase.all_movements().any(|other| other == name));
            Some((heading, number.filter(|_| is_first)?))
        };
        let own = |name: &&String| {
            Some(((*name).clone(), only(&|phase| phase.movements.contains(name))?))
        };
        Self {
            through: ways().filter_map(through).collect(),
            of_movement: names.iter().filter_map(own).collect(),
            taken: plan.phases.iter().flat_map(|p| [Some(p.number), p.also]).flatten().collect(),
            side,
        }
    }

    /// Returns the number of the phase in which a movement other than a right turn has the right of way.
    fn of_way(&self, name: &String, (heading, turn): (Heading, Turn)) -> Option<u32> {
        if let Some(number) = self.of_movement.get(name) {
            return Some(*number);
        }
        let through = *self.through.get(&heading)?;
        // The left turn that opposes phase 2 is 1, that of phase 2 is 5.
        let opposite = (through + 3) % 8 + 1;
        let is_opposed = self.through.values().any(|number| *number == opposite);
        if turn == Turn::Through || !is_opposed {
            return Some(through);
        }
        let is_usual = through <= 8 && through.is_multiple_of(2);
        Some(opposite - 1).filter(|left| is_usual && !self.taken.contains(left))
    }

    /// Returns the numbers of the phases that a phase is at once; nothing where one of its movements has none. In rings a phase
    /// goes by its through movements.
    fn of_phase(&self, phase: &PlanPhase, has_rings: bool) -> BTreeSet<u32> {
        let ways = phase.movements.iter().filter_map(|n| Some((n, ahead_of(n, self.side)?)));
        let mut ways: Vec<(&String, (Heading, Turn))> = ways.collect();
        let is_through = |way: &(&String, (Heading, Turn))| way.1.1 == Turn::Through;
        if has_rings && ways.iter().any(is_through) {
            ways.retain(is_through);
        }
        if ways.is_empty() {
            let ahead = |name: &String| Some((Heading::begins(name)?, Turn::Through));
            ways = phase.all_movements().filter_map(|n| Some((n, ahead(n)?))).collect();
        }
        let numbers = ways.iter().map(|(name, way)| self.of_way(name, *way));
        numbers.collect::<Option<_>>().unwrap_or_default()
    }
}

/// Returns direction and turn of a movement, as in right-hand traffic, that is no right turn.
fn ahead_of(name: &str, side: DrivingSide) -> Option<(Heading, Turn)> {
    let (heading, turn) = Heading::of_movement(name, side)?;
    Some((heading, on_side(turn, side))).filter(|(_, turn)| *turn != Turn::Right)
}

/// Returns the plan that the signal of a point MDP has today, else the first that was given for it.
fn plan_of_today(seen: Seen<'_>, point: usize) -> Option<ExistingPlan> {
    let identity = &seen.data.manifest.identity;
    let methods = identity.methods.iter().map(String::as_str);
    let mut methods = std::iter::once(existing::METHOD.name).chain(methods);
    methods.find_map(|method| given_plan(&identity.points[point], method))
}

/// Returns the numbers of the through phases of a signal whose existing plan is not known.
fn approaches(seen: Seen<'_>, point: usize, signal: &str) -> BTreeMap<Heading, u32> {
    let renamed = renamed(seen, point);
    let results = seen.shown.movements.iter().find(|task| task.point == point);
    // Lanes of the lane groups of each approach.
    let mut approaches: BTreeMap<Heading, BTreeMap<&str, u32>> = BTreeMap::new();
    for result in results.iter().flat_map(|task| &task.results).filter(|r| r.signal == signal) {
        let name = renamed.get(&result.movement).unwrap_or(&result.movement);
        let Some(heading) = Heading::begins(name) else { continue };
        let lanes = result.supply.iter().map(|s| (s.group.as_str(), s.group_lanes));
        approaches.entry(heading).or_default().extend(lanes);
    }
    let mut streets: Vec<(u32, Vec<Heading>)> = Vec::new();
    for (heading, groups) in approaches {
        let lanes: u32 = groups.values().sum();
        match streets.iter_mut().find(|street| street.1[0] == heading.clockwise(4)) {
            Some(street) => (street.0, street.1) = (street.0 + lanes, vec![street.1[0], heading]),
            None => streets.push((lanes, vec![heading])),
        }
    }
    streets.sort_by_key(|street| std::cmp::Reverse(street.0));
    let numbers = [[2, 6], [4, 8]];
    let of = |(street, numbers): (&(u32, Vec<Heading>), [u32; 2])| {
        street.1.iter().copied().zip(numbers).collect::<Vec<_>>()
    };
    streets.iter().zip(numbers).flat_map(of).collect()
}

/// Returns the side of the street that traffic keeps to.
fn side(seen: Seen<'_>) -> DrivingSide {
    let side = seen.data.manifest.identity.settings.pointer("/network/driving_side");
    let is_left = side.and_then(serde_json::Value::as_str) == Some("left");
    if is_left { DrivingSide::Left } else { DrivingSide::Right }
}

/// Returns the ways of the movements of a signal: the edges from which and to which they lead.
fn ways(seen: Seen<'_>, point: usize, signal: &str) -> BTreeMap<String, Vec<(String, String)>> {
    let renamed = renamed(seen, point);
    let results = seen.shown.movements.iter().find(|task| task.point == point);
    let mut ways: BTreeMap<String, Vec<(String, String)>> = BTreeMap::new();
    for m in results.iter().flat_map(|t| &t.results).filter(|r| r.signal == signal) {
        let name = renamed.get(&m.movement).unwrap_or(&m.movement);
        ways.entry(name.clone()).or_default().push((m.from.clone(), m.to.clone()));
    }
    ways
}

/// Returns pairs of movements, right turns apart, that have the right of way into one leg together.
fn merging(told: &Told, side: DrivingSide) -> Vec<[String; 2]> {
    let ways = |name: &String| told.ways.get(name).into_iter().flatten();
    let merge = |a: &String, b: &String| {
        a < b && ways(a).any(|(from, to)| ways(b).any(|other| *to == other.1 && *from != other.0))
    };
    let mut found = BTreeSet::new();
    for pair in told.plan.pairs() {
        let names = || pair.iter().flat_map(|p| &told.plan.phases[*p].movements);
        let names = || names().filter(|name| ahead_of(name, side).is_some());
        for a in names() {
            let merging = names().filter(|b| merge(a, b));
            found.extend(merging.map(|b| [a.clone(), b.clone()]));
        }
    }
    found.into_iter().collect()
}

/// Numbers the phases of a plan: each is a phase, or two at once of different rings. One that is neither, or that another is
/// already, counts on from 9, so no number stands for two things at a signal.
fn number(plan: &mut ExistingPlan, numbers: &Numbers) {
    let has_rings = plan.phases.iter().any(|phase| phase.ring > 1);
    let ring_of = |number: u32| if number > 4 { 2 } else { 1 };
    let side_of = |number: u32| (number - 1) / 2 % 2;
    let mut numbered = ExistingPlan { phases: Vec::new(), ..plan.clone() };
    for phase in &plan.phases {
        let (number, also) =
            match numbers.of_phase(phase, has_rings).into_iter().collect::<Vec<_>>()[..] {
                [one] => (one, None),
                [one, two]
                    if !has_rings
                        && two <= 8
                        && ring_of(one) != ring_of(two)
                        && side_of(one) == side_of(two) =>
                {
                    (one, Some(two))
                }
                _ => (0, None),
            };
        numbered.push(PlanPhase { number, also, ..phase.clone() });
    }
    let mut taken = numbers.taken.clone();
    taken.extend(numbered.phases.iter().map(|phase| phase.number));
    let mut known = BTreeSet::from([0]);
    for phase in numbered.phases.iter_mut().filter(|phase| !known.insert(phase.number)) {
        phase.number = (9..).find(|number| taken.insert(*number)).expect("there are more");
        phase.also = None;
    }
    // Rings before a barrier stay apart, and change places where most of their phases are usual in the other one.
    let of_barriers: BTreeSet<u32> = numbered.phases.iter().map(|phase| phase.barrier).collect();
    for barrier in of_barriers.into_iter().filter(|_| has_rings) {
        let own = || numbered.phases.iter().filter(|p| p.barrier == barrier && p.number <= 8);
        let others = own().filter(|phase| ring_of(phase.number) != phase.ring).count();
        if 2 * others > own().count() {
            let own = numbered.phases.iter_mut().filter(|phase| phase.barrier == barrier);
            own.for_each(|phase| phase.ring = 3 - phase.ring);
        }
    }
    let of = |old: &u32| plan.phases.iter().position(|phase| phase.number == *old);
    let references = plan.reference.iter().filter_map(of);
    numbered.reference = references.map(|at| numbered.phases[at].number).collect();
    if !numbers.through.is_empty() && numbered.check().is_ok() {
        *plan = numbered;
    }
}

/// Returns the name of a movement with the direction with which that of its arm begins; `None` where names of arms say none.
fn on_arm(movement: &str, from_edge: &str, drawn: &DrawnIntersection) -> Option<String> {
    let incoming = || drawn.arms.iter().filter(|arm| !arm.lanes.is_empty());
    let told = Heading::told(incoming().map(|arm| arm.name.as_str()))?;
    let arm = incoming().position(|arm| arm.edge == from_edge)?;
    Some(format!("{}{}", told[arm], movement.get(2..)?))
}

/// Calls movements of a plan otherwise; several may get one name.
fn rename(plan: &mut ExistingPlan, renamed: &BTreeMap<String, String>) {
    for phase in &mut plan.phases {
        for names in [&mut phase.movements, &mut phase.yielding] {
            *names = listed(names.iter().map(|name| renamed.get(name).unwrap_or(name).as_str()));
        }
        let protected = &phase.movements;
        phase.yielding.retain(|name| !protected.contains(name));
    }
}

#[cfg(test)]
pub(super) mod tests {
    use signals::existing::Control;
    use signals::places::DrawnArm;

    use super::*;

    #[test]
    fn movements_are_called_after_arms_whose_names_begin_with_directions() {
        let arm = |name: &str, edge: &str, lanes: &[&str]| DrawnArm {
            name: name.to_owned(),
            edge: edge.to_owned(),
            lanes: lanes.iter().map(|turns| (*turns).to_owned()).collect(),
            ..DrawnArm::default()
        };
        let drawn = |name: &str| DrawnIntersection {
            arms: vec![
                arm("an exit", "in0", &[]),
                arm("EB Main St", "in1", &["sl"]),
                arm(name, "in2", &["r"]),
            ],
            ..DrawnIntersection::default()
        };
        let called = |edge: &str, name: &str| on_arm("SBL2", edge, &drawn(name));
        assert_eq!(called("in1", "NB 5th").as_deref(), Some("EBL2"));
        assert_eq!(called("in2", "NB 5th").as_deref(), Some("NBL2"));
        assert_eq!(called("in0", "NB 5th"), None);
        assert_eq!(called("in1", "B"), None, "the compass counts");
    }

    #[test]
    fn movements_that_get_one_name_are_there_once() {
        let phase = phase();
        let other = PlanPhase { movements: vec!["NBL".into(), "NBL2".into()], ..phase.clone() };
        let mut plan = ExistingPlan::new(Control::Actuated, vec![phase, other]);
        let renamed = BTreeMap::from([("NBL2".to_owned(), "NBL".to_owned())]);
        rename(&mut plan, &renamed);
        assert_eq!(plan.phases[0].movements, ["NBL", "NBT"]);
        assert_eq!(plan.phases[0].yielding, ["NBR"]);
        assert_eq!(plan.phases[1].movements, ["NBL"]);
    }

    #[test]
    fn stages_have_the_numbers_of_the_phases_that_they_are() {
        let numbered = |stages: &[&str], through: &[(Heading, u32)], side| {
            let phases = (1u32..).zip(stages).map(|(number, names)| PlanPhase {
                movements: names.split(' ').map(str::to_owned).collect(),
                yielding: Vec::new(),
                position: number,
                number,
                ..phase()
            });
            let mut plan = ExistingPlan::new(Control::Pretimed, phases.collect());
            plan.reference = vec![1];
            let through = through.iter().copied().collect();
            let (of_movement, taken) = (BTreeMap::new(), BTreeSet::new());
            number(&mut plan, &Numbers { through, of_movement, taken, side });
            let labels: Vec<String> = plan.phases.iter().map(PlanPhase::label).collect();
            (labels.join(" "), plan.reference)
        };
        use Heading::{East, North, West};
        let streets = [(East, 2), (West, 6), (North, 8)];
        let stages = ["WBT WBL NBR", "EBT EBR WBT", "NBL NBR EBR"];
        let expected = ("1+6 2+6 8".to_owned(), vec![1]);
        assert_eq!(numbered(&stages, &streets, DrivingSide::Right), expected);
        let mirrored = ["WBT WBR NBL", "EBT EBL WBT", "NBR NBL EBL"];
        assert_eq!(numbered(&mirrored, &streets, DrivingSide::Left), expected);
        // No phase is both, two stages are one phase, and an approach has no number.
        for (stages, expected) in [
            (["EBT NBL", "WBT", "EBL"], "9 6 5"),
            (["EBT", "EBT", "WBT"], "2 9 6"),
            (["EBT", "SBT", "WBT"], "2 9 6"),
        ] {
            assert_eq!(numbered(&stages, &streets, DrivingSide::Right).0, expected);
        }
    }

    #[test]
    fn rings_have_the_numbers_of_the_existing_plan() {
        let rings = |phases: &[(u32, [u32; 3], &str)]| {
            let phase = |(number, [barrier, ring, position], names): &(u32, [u32; 3], &str)| {
                let movements = names.split(' ').map(str::to_owned).collect();
                let (number, yielding) = (*number, Vec::new());
                let [barrier, ring, position] = [*barrier, *ring, *position];
                PlanPhase { number, barrier, ring, position, movements, yielding, ..phase() }
            };
            ExistingPlan::new(Control::Actuated, phases.iter().map(phase).collect())
        };
        let today = rings(&[
            (2, [1, 1, 2], "NBT NBR"),
            (1, [1, 1, 1], "SBL"),
            (6, [1, 2, 2], "SBT SBR"),
            (5, [1, 2, 1], "NBL"),
            (4, [2, 1, 2], "EBT EBR"),
            (3, [2, 1, 1], "WBL"),
            (8, [2, 2, 2], "WBT WBR"),
            (7, [2, 2, 1], "EBL"),
        ]);
        // The side street is split, and the rings of the main street are the other way round.
        let mut plan = rings(&[
            (2, [1, 1, 2], "SBT SBR"),
            (1, [1, 1, 1], "NBL"),
            (6, [1, 2, 2], "NBT NBR"),
            (5, [1, 2, 1], "SBL"),
            (4, [2, 1, 1], "WBT WBR WBL"),
            (10, [3, 1, 1], "EBL EBT EBR"),
        ]);
        number(&mut plan, &Numbers::of(&today, DrivingSide::Right));
        let of = |p: &PlanPhase| (p.number, p.ring, p.barrier);
        let expected = [(6, 2, 1), (5, 2, 1), (2, 1, 1), (1, 1, 1), (8, 2, 2), (4, 1, 3)];
        assert_eq!(plan.phases.iter().map(of).collect::<Vec<_>>(), expected);
    }

    pub(in crate::plans) fn phase() -> PlanPhase {
        let table = "intersection,control,phase,ring,barrier,position,movements,yielding,min_green_s,max_green_s,yellow_s,all_red_s\n\
                     7,actuated,2,1,1,1,NBL NBT,NBL2 NBR,5,20,4,1\n";
        signals::existing::read(table, "e.csv").unwrap().all.remove(0).plan.phases.remove(0)
    }
}

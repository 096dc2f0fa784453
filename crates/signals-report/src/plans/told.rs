//! Plans as they are told to people: all of them as phases, existing ones as they were given.

use std::collections::BTreeMap;

use super::TaskPlan;
use crate::shown::Seen;
use evaluation::store::manifest::PointRow;
use signals::environment::existing_plan;
use signals::existing::ExistingPlan;
use signals::existing::ran::{of_program, of_rings};
use signals::movement_results::MovementResult;
use signals::network::plain::SIGNAL;
use signals::network_files::GENERATED;
use signals::places::DrawnIntersection;
use signals::program::{ProgramKind, SignalProgram};
use signals::vocabulary::Heading;

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
    /// Whether its phases are stages of a program.
    pub(crate) is_stages: bool,
    /// Whether its signal is the only one of the task.
    pub(crate) is_alone: bool,
}

impl Told {
    /// Returns the plan as files have it that a run takes back. A stage whose walk goes on through later ones has none there,
    /// because a phase lasts until its walk and clearance are over.
    pub(super) fn given_back(&self) -> ExistingPlan {
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
        if plan.ways.is_empty() {
            rename(&mut plan, &renamed(seen, task.point));
        }
        let TaskPlan { method, point, replicate, objective, .. } = *task;
        let signal = signal.to_owned();
        Told { method, point, replicate, objective, signal, plan, is_stages, is_alone: true }
    };
    let identity = &data.manifest.identity;
    let point = &identity.points[task.point];
    if let Some(plan) = given_plan(point, &identity.methods[task.method]) {
        return vec![told(SIGNAL, plan, false)];
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
pub(crate) fn renamed(seen: Seen<'_>, point: usize) -> BTreeMap<String, String> {
    let Seen { data, shown } = seen;
    let identity = &data.manifest.identity;
    let Some(results) = shown.movements.iter().find(|task| task.point == point) else {
        return BTreeMap::new();
    };
    let given = |method: &String| given_plan(&identity.points[point], method);
    let existing = identity.methods.iter().find_map(given);
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
            let mut of_network: Vec<String> = Vec::new();
            for name in names.iter() {
                let name = renamed.get(name).unwrap_or(name);
                if !of_network.contains(name) {
                    of_network.push(name.clone());
                }
            }
            *names = of_network;
        }
        let protected = &phase.movements;
        phase.yielding.retain(|name| !protected.contains(name));
    }
}

#[cfg(test)]
pub(super) mod tests {
    use signals::existing::{Control, PlanPhase};
    use signals::places::DrawnArm;

    use super::*;

    #[test]
    fn movements_are_called_after_arms_whose_names_begin_with_directions() {
        let arm = |name: &str, edge: &str, lanes: &[&str]| DrawnArm {
            name: name.to_owned(),
            edge: edge.to_owned(),
            bearing_deg: 0.0,
            lanes: lanes.iter().map(|turns| (*turns).to_owned()).collect(),
            lanes_out: 1,
            speed_mph: 30.0,
            left_storage_m: None,
            right_storage_m: None,
        };
        let drawn = |name: &str| DrawnIntersection {
            point: "p".to_owned(),
            intersection: "7".to_owned(),
            period: String::new(),
            is_left_hand: false,
            arms: vec![
                arm("an exit", "in0", &[]),
                arm("EB Main St", "in1", &["sl"]),
                arm(name, "in2", &["r"]),
            ],
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

    pub(in crate::plans) fn phase() -> PlanPhase {
        let table = "intersection,control,phase,ring,barrier,position,movements,yielding,min_green_s,max_green_s,yellow_s,all_red_s\n\
                     7,actuated,2,1,1,1,NBL NBT,NBL2 NBR,5,20,4,1\n";
        signals::existing::read(table, "e.csv").unwrap().all.remove(0).plan.phases.remove(0)
    }
}

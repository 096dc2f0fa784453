//! Plans for whoever keys them in: as UTDF that Synchro takes back (`plans/METHOD.utdf.csv`), and as a page to print per
//! intersection (`plans/POINT.html`).
//!
//! All plans are told as phases, those of existing plans as they were given:
//! - **Dual ring**: its phases, actuated.
//! - **Programs**: each stage, a green with the change after it, is a phase of ring 1, one after the other. A movement of
//!   several stages has several phases. SUMO's `actuated` has passage times of 3 s, its own.
//!
//! UTDF needs nodes that are numbers: intersections whose ids are none are left out, which is said. Its columns are
//! those of the network that the existing plan came with, else the directions of the compass.

use std::collections::BTreeMap;
use std::path::Path;

use minijinja::{Value, context};

use super::cabinet::{self, existing_of, of_plan, seconds};
use super::table::greens;
use super::task_plan::TaskPlan;
use crate::shown::Seen;
use basics::files::{FileError, write_atomically};
use evaluation::report::figures::shown as named;
use evaluation::report::page::render;
use evaluation::report::{ReportError, format};
use signals::env::by_movement::listed_before;
use signals::environment::existing_plan;
use signals::existing::{Control, ExistingPlan, PlanPhase, Recall};
use signals::program::{ProgramKind, RingPhase, SignalProgram};
use signals::utdf::to_utdf;

/// Gap between vehicles after which SUMO's actuated programs end a green, seconds (its default).
const SUMO_GAP_S: f64 = 3.0;

/// Most intersections with a page each.
const MOST_PAGES: usize = 500;

/// Most names that a note lists.
const FEW: usize = 6;

/// What was written.
#[derive(Debug, Default)]
pub(crate) struct Written {
    /// Notes for people.
    pub(crate) notes: Vec<String>,
}

/// Writes UTDF and pages into the folder of plans.
///
/// # Errors
///
/// [`ReportError`] when a file cannot be written.
pub(crate) fn write(folder: &Path, seen: Seen<'_>) -> Result<Written, ReportError> {
    let all = told(seen);
    let mut written = Written::default();
    if all.is_empty() {
        return Ok(written);
    }
    std::fs::create_dir_all(folder).map_err(FileError::at("create", folder))?;
    write_utdf(folder, seen, &all, &mut written)?;
    if seen.data.points.len() > MOST_PAGES {
        written.notes.push(format!(
            "no pages of plans per intersection: more than {MOST_PAGES} intersections"
        ));
        return Ok(written);
    }
    for point in 0..seen.data.points.len() {
        let own: Vec<&Told> = all.iter().filter(|told| told.point == point).collect();
        if own.is_empty() {
            continue;
        }
        let html = render(
            "cabinet_page.html",
            include_str!("../templates/cabinet_page.html"),
            page(seen, point, &own),
        )
        .map_err(ReportError::Template)?;
        write_atomically(&folder.join(page_name(seen, point)), html.as_bytes())?;
    }
    Ok(written)
}

/// Returns the name of the page of an intersection.
pub(crate) fn page_name(seen: Seen<'_>, point: usize) -> String {
    format!("{}.html", seen.data.points[point].row.point)
}

/// A plan as phases.
struct Told {
    method: usize,
    point: usize,
    plan: ExistingPlan,
    /// Whether its phases are stages of a program.
    is_stages: bool,
}

/// Returns the plan of every method that has one at every intersection: of several trainings that of the best objective.
fn told(seen: Seen<'_>) -> Vec<Told> {
    let Seen { data, shown } = seen;
    let direction = data.direction();
    let mut best: BTreeMap<(usize, usize), (&TaskPlan, Told)> = BTreeMap::new();
    for task in &shown.plans {
        let (method, point) = (task.method, task.point);
        let names = shown.link_names(point);
        let found = if let Some(plan) = existing_of(data, task) {
            Some((plan, false))
        } else if let [signal] = task.rings.as_slice() {
            Some((of_rings(signal), false))
        } else {
            match (task.programs(), task.is_whole()) {
                ([program], true) => {
                    of_program(program, names.get(&program.signal)).map(|plan| (plan, true))
                }
                _ => None,
            }
        };
        let Some((plan, is_stages)) = found else { continue };
        let plan = with_names_of_the_network(seen, point, plan);
        let is_better = best.get(&(point, method)).is_none_or(|(other, _)| {
            match (task.objective, other.objective) {
                (Some(own), Some(other)) => direction.is_worse(other, own),
                (own, other) => own.is_some() && other.is_none(),
            }
        });
        if is_better {
            best.insert((point, method), (task, Told { method, point, plan, is_stages }));
        }
    }
    best.into_values().map(|(_, told)| told).collect()
}

fn of_rings(signal: &SignalProgram) -> ExistingPlan {
    let people = |phase: &RingPhase| {
        let both =
            phase.walk_s.zip(phase.clearance_s).map(|(walk, clear)| [walk, clear].map(f64::from));
        both.filter(|both| both.iter().all(|s| *s > 0.0))
    };
    let phase = |p: &RingPhase| PlanPhase {
        number: p.number,
        ring: p.ring,
        barrier: p.barrier,
        position: p.position,
        movements: p.movements.clone(),
        yielding: p.yielding.clone(),
        min_green_s: p.min_green_s.into(),
        max_green_s: p.max_green_s.into(),
        passage_s: p.passage_s.into(),
        yellow_s: p.yellow_s.into(),
        all_red_s: p.all_red_s.into(),
        walk_s: people(p),
        recall: if p.recall { Recall::Min } else { Recall::None },
        dual_entry: p.number.is_multiple_of(2),
        inhibit_max: false,
    };
    plan(Control::Actuated, None, Vec::new(), signal.rings.iter().map(phase).collect())
}

/// Returns the stages of a program as phases of one ring; `None` for other kinds, and where movements have no names.
fn of_program(
    program: &SignalProgram,
    names: Option<&BTreeMap<usize, String>>,
) -> Option<ExistingPlan> {
    let names = names?;
    let is_fixed = program.kind == ProgramKind::Static;
    if !is_fixed && program.kind != ProgramKind::Actuated {
        return None;
    }
    let of = |state: &str, letter: char| {
        let links = state.char_indices().filter(|(_, c)| *c == letter);
        let mut found: Vec<String> = Vec::new();
        for name in links.filter_map(|(link, _)| names.get(&link)) {
            if !found.contains(name) {
                found.push(name.clone());
            }
        }
        found.sort_by_key(|name| listed_before(name));
        found
    };
    let phases: Vec<PlanPhase> = (1u32..)
        .zip(greens(program, true))
        .map(|(number, green)| {
            let movements = of(&green.state, 'G');
            let mut yielding = of(&green.state, 'g');
            yielding.retain(|name| !movements.contains(name));
            PlanPhase {
                number,
                ring: 1,
                barrier: 1,
                position: number,
                movements,
                yielding,
                min_green_s: green.green_s,
                max_green_s: green.max_s.unwrap_or(green.green_s),
                passage_s: if is_fixed { 0.0 } else { SUMO_GAP_S },
                yellow_s: green.yellow_s,
                all_red_s: green.all_red_s,
                walk_s: None,
                recall: if is_fixed { Recall::Max } else { Recall::Min },
                dual_entry: true,
                inhibit_max: false,
            }
        })
        .collect();
    let cycle_s = is_fixed.then(|| phases.iter().map(PlanPhase::split_s).sum());
    let control = if is_fixed { Control::Pretimed } else { Control::Actuated };
    Some(plan(control, cycle_s, if is_fixed { vec![1] } else { Vec::new() }, phases))
}

fn plan(
    control: Control,
    cycle_s: Option<f64>,
    reference: Vec<u32>,
    phases: Vec<PlanPhase>,
) -> ExistingPlan {
    ExistingPlan {
        control,
        cycle_s,
        offset_s: 0.0,
        reference,
        referenced_to: 0,
        phases,
        ways: BTreeMap::new(),
    }
}

/// Calls movements as the existing plan of an intersection does, where there is one.
fn with_names_of_the_network(seen: Seen<'_>, point: usize, mut plan: ExistingPlan) -> ExistingPlan {
    let Seen { data, shown } = seen;
    if !plan.ways.is_empty() {
        return plan;
    }
    let Ok(Some(existing)) = existing_plan(&data.manifest.identity.points[point]) else {
        return plan;
    };
    let Some(results) = shown.movements.iter().find(|task| task.point == point) else {
        return plan;
    };
    let renamed: BTreeMap<&str, &String> = (results.results.iter())
        .filter_map(|m| {
            let way = (m.from.clone(), m.to.clone());
            let (name, _) = existing.ways.iter().find(|(_, ways)| ways.contains(&way))?;
            Some((m.movement.as_str(), name))
        })
        .collect();
    for phase in &mut plan.phases {
        for name in phase.movements.iter_mut().chain(&mut phase.yielding) {
            if let Some(other) = renamed.get(name.as_str()) {
                *name = (*other).clone();
            }
        }
    }
    plan
}

/// Returns the number of an intersection and its period, from the id of its point MDP; `None` for an id that is a name.
fn node(point: &str) -> Option<(u32, &str)> {
    let rest = point.strip_prefix('i')?;
    let (number, period) = rest.split_once('-').unwrap_or((rest, ""));
    let is_number = number.len() >= 4 && number.bytes().all(|b| b.is_ascii_digit());
    Some((number.parse().ok().filter(|_| is_number)?, period))
}

fn write_utdf(
    folder: &Path,
    seen: Seen<'_>,
    all: &[Told],
    written: &mut Written,
) -> Result<(), ReportError> {
    let identity = &seen.data.manifest.identity;
    let mut files: BTreeMap<String, Vec<(u32, ExistingPlan)>> = BTreeMap::new();
    let (mut nameless, mut refused) = (Vec::new(), Vec::new());
    for told in all {
        let (point, method) = (&identity.points[told.point].point, &identity.methods[told.method]);
        let Some((number, period)) = node(point) else {
            nameless.push(point.clone());
            continue;
        };
        // One plan that UTDF cannot say does not keep the others from being written.
        if let Err(reason) = to_utdf(&[(number, told.plan.clone())]) {
            refused.push(format!("{method}, {reason}"));
            continue;
        }
        let dot = if period.is_empty() { "" } else { "." };
        let name = format!("{method}{dot}{period}.utdf.csv");
        files.entry(name).or_default().push((number, told.plan.clone()));
    }
    for (name, plans) in files {
        let text = to_utdf(&plans).expect("each of them was written");
        write_atomically(&folder.join(name), text.as_bytes())?;
    }
    nameless.dedup();
    let few = |names: &[String]| {
        let more = if names.len() > FEW { ", ..." } else { "" };
        format!("{}{more}", names[..names.len().min(FEW)].join(", "))
    };
    if !nameless.is_empty() {
        let about = format::count(nameless.len(), "intersection");
        written.notes.push(format!(
            "no UTDF of {about} whose id is no number ({}); UTDF has numbered nodes",
            few(&nameless)
        ));
    }
    if !refused.is_empty() {
        written.notes.push(format!("no UTDF of plans that it cannot say ({})", few(&refused)));
    }
    Ok(())
}

/// Returns what the page of an intersection shows.
fn page(seen: Seen<'_>, point: usize, own: &[&Told]) -> Value {
    let Seen { data, shown } = seen;
    let identity = &data.manifest.identity;
    let row = &data.points[point].row;
    let plans = own.iter().map(|told| {
        let delay_s =
            data.points[point].results[told.method].as_ref().map(|r| format!("{:.1}", r.objective));
        let phases: Vec<Value> = cabinet::by_number(
            told.plan.phases.iter().map(|p| (p.number, cabinet::existing_cells(&told.plan, p))),
        );
        context! {
            method => named(data, &identity.methods[told.method]),
            of => of_plan(&told.plan),
            delay_s,
            phases,
            is_stages => told.is_stages,
            is_existing => identity.methods[told.method] == signals::control::existing::METHOD.name,
            rings => rings(&told.plan),
        }
    });
    context! {
        title => shown.title(row),
        point => row.point.as_str(),
        plans => plans.collect::<Vec<_>>(),
        simulator => identity.simulator.as_str(),
        version => identity.tsc_family.as_str(),
    }
}

/// Returns the rings of a plan as boxes whose widths are splits: rows of `(label, percent, whether a barrier follows)`.
fn rings(plan: &ExistingPlan) -> Vec<Vec<Value>> {
    let sides = plan.sides();
    let ring_s = |ring: &Vec<usize>| ring.iter().map(|i| plan.phases[*i].split_s()).sum::<f64>();
    let side_s: Vec<f64> = sides.iter().map(|s| ring_s(&s[0]).max(ring_s(&s[1]))).collect();
    let total_s: f64 = side_s.iter().sum();
    let is_used = |ring: usize| sides.iter().any(|side| !side[ring].is_empty());
    (0..2)
        .filter(|ring| is_used(*ring))
        .map(|ring| {
            let mut boxes = Vec::new();
            for (side, whole_s) in sides.iter().zip(&side_s) {
                let own = &side[ring];
                let mut left_s = *whole_s;
                for (place, index) in own.iter().enumerate() {
                    let phase = &plan.phases[*index];
                    let is_last = place + 1 == own.len();
                    // A ring that is done waits for the other one.
                    let split_s = if is_last { left_s } else { phase.split_s() };
                    left_s -= split_s;
                    boxes.push(context! {
                        number => phase.number,
                        names => phase.all_movements().cloned().collect::<Vec<_>>().join(" "),
                        split => seconds(phase.split_s()),
                        percent => format!("{:.2}", 100.0 * split_s / total_s),
                        barrier => is_last,
                    });
                }
                if own.is_empty() {
                    boxes.push(context! {
                        number => "",
                        names => "",
                        split => "",
                        percent => format!("{:.2}", 100.0 * whole_s / total_s),
                        barrier => true,
                    });
                }
            }
            boxes
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_the_numbers_of_ids_and_periods_what_follows() {
        assert_eq!(node("i0001"), Some((1, "")));
        assert_eq!(node("i12345-am"), Some((12345, "am")));
        assert_eq!(node("Main-and-5th-02587130"), None);
        assert_eq!(node("i9"), None, "no id of a number");
    }

    #[test]
    fn stages_of_a_program_are_phases_one_after_the_other() {
        let phase = |state: &str, duration_s: f64| signals::program::ProgramPhase {
            state: state.to_owned(),
            duration_s,
            min_s: None,
            max_s: None,
        };
        let program = SignalProgram {
            signal: "c".into(),
            own: false,
            kind: ProgramKind::Static,
            phases: vec![
                phase("Gg", 20.0),
                phase("yy", 4.0),
                phase("rr", 1.0),
                phase("rG", 10.0),
                phase("ry", 3.0),
            ],
            rings: vec![],
        };
        let names = BTreeMap::from([(0, "NBT".to_owned()), (1, "NBL".to_owned())]);
        let plan = of_program(&program, Some(&names)).unwrap();
        let told: Vec<_> = (plan.phases.iter())
            .map(|p| (p.position, p.movements.join(" "), p.yielding.join(" "), p.split_s()))
            .collect();
        let text = |s: &str| s.to_owned();
        assert_eq!(told, [(1, text("NBT"), text("NBL"), 25.0), (2, text("NBL"), text(""), 13.0)]);
        assert_eq!((plan.cycle_s, plan.check()), (Some(38.0), Ok(vec![])));
        assert_eq!(of_program(&program, None), None, "movements without names");
    }
}

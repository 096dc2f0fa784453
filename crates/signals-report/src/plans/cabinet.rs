//! What an engineer keys into a cabinet: `cabinet.csv`, and a table on the page where there are few intersections.
//!
//! - **Dual ring**: one row per phase, with ring, barrier and position.
//! - **Programs**: one row per stage, a green with the change after it. Movements that yield in it stand apart. Where the
//!   movements of links are not known, the columns of movements are empty.
//!
//! - **Existing plans** are as they were given, with tenths of seconds; the simulation runs whole ones.
//!
//! Methods that decide while they run have no row.

use std::collections::BTreeMap;

use minijinja::{Value, context};

use super::table::{Green, greens};
use super::task_plan::TaskPlan;
use crate::shown::Seen;
use evaluation::analysis::Analysis;
use evaluation::report::csv;
use evaluation::report::figures::shown as named;
use signals::control::existing;
use signals::env::by_movement::listed_before;
use signals::environment::existing_plan;
use signals::existing::{Control, ExistingPlan, PlanPhase};
use signals::network::plain::SIGNAL;
use signals::program::{ProgramKind, RingPhase, SignalProgram};

/// Name of the table in the report's folder.
pub(crate) const TABLE: &str = "cabinet.csv";

/// Most intersections whose phases the page shows.
const FEW: usize = 12;

const HEADER: [&str; 24] = [
    "point",
    "method",
    "replicate",
    "signal",
    "kind",
    "number",
    "ring",
    "barrier",
    "position",
    "movements",
    "yielding",
    "min_green_s",
    "passage_s",
    "max_green_s",
    "yellow_s",
    "all_red_s",
    "walk_s",
    "clearance_s",
    "recall",
    "cycle_s",
    "split_s",
    "control",
    "offset_s",
    "reference",
];

/// Names of movements by signal and link index.
type Names = BTreeMap<String, BTreeMap<usize, String>>;

/// Returns the table of all plans that a cabinet can be told.
pub(crate) fn table(seen: Seen<'_>) -> String {
    let Seen { data, shown } = seen;
    let titles = shown.titles(data);
    let titled = csv::Titled(titles.as_deref());
    let rows = shown.plans.iter().flat_map(|plan| {
        let names = shown.link_names(plan.point);
        let rows = rows(data, plan, &names).into_iter();
        rows.map(move |cells| titled.row(plan.point, cells)).collect::<Vec<_>>()
    });
    csv::table(&titled.header(HEADER.map(str::to_owned).to_vec()), rows)
}

fn rows(data: &Analysis, plan: &TaskPlan, names: &Names) -> Vec<Vec<String>> {
    let identity = &data.manifest.identity;
    let head = |signal: &str, kind: &str| {
        vec![
            identity.points[plan.point].point.clone(),
            identity.methods[plan.method].clone(),
            plan.replicate.to_string(),
            signal.to_owned(),
            kind.to_owned(),
        ]
    };
    let mut rows = Vec::new();
    if let Some(existing) = existing_of(data, plan) {
        let row =
            |phase: &PlanPhase| [head(SIGNAL, "phase"), existing_cells(&existing, phase)].concat();
        return existing.phases.iter().map(row).collect();
    }
    for signal in &plan.rings {
        for phase in &signal.rings {
            rows.push([head(&signal.signal, "phase"), phase_cells(phase)].concat());
        }
    }
    for program in
        plan.programs().iter().filter(|p| plan.is_whole() && p.kind != ProgramKind::Other)
    {
        let of_signal = names.get(&program.signal);
        for (i, green) in greens(program, true).iter().enumerate() {
            let cells = stage_cells(program, i, green, of_signal);
            rows.push([head(&program.signal, "stage"), cells].concat());
        }
    }
    rows
}

/// Returns the plan that a task of the method `existing` ran, as it was given.
pub(super) fn existing_of(data: &Analysis, plan: &TaskPlan) -> Option<ExistingPlan> {
    let identity = &data.manifest.identity;
    let is_existing = identity.methods[plan.method] == existing::METHOD.name;
    existing_plan(&identity.points[plan.point]).ok().flatten().filter(|_| is_existing)
}

/// Returns a time without digits that come from adding tenths.
pub(super) fn seconds(value: f64) -> String {
    ((value * 1000.0).round() / 1000.0).to_string()
}

pub(super) fn existing_cells(plan: &ExistingPlan, phase: &PlanPhase) -> Vec<String> {
    let [walk_s, clearance_s] =
        [0, 1].map(|i| phase.walk_s.map_or_else(String::new, |both| seconds(both[i])));
    let reference: Vec<String> = plan.reference.iter().map(u32::to_string).collect();
    vec![
        phase.number.to_string(),
        phase.ring.to_string(),
        phase.barrier.to_string(),
        phase.position.to_string(),
        phase.movements.join(" "),
        phase.yielding.join(" "),
        seconds(phase.min_green_s),
        seconds(phase.passage_s),
        seconds(phase.max_green_s),
        seconds(phase.yellow_s),
        seconds(phase.all_red_s),
        walk_s,
        clearance_s,
        phase.recall.name().to_owned(),
        plan.cycle_s.map_or_else(String::new, seconds),
        seconds(phase.split_s()),
        plan.control.name().to_owned(),
        seconds(plan.offset_s),
        reference.join(" "),
    ]
}

fn optional(value: Option<u32>) -> String {
    value.map_or_else(String::new, |v| v.to_string())
}

fn phase_cells(phase: &RingPhase) -> Vec<String> {
    vec![
        phase.number.to_string(),
        phase.ring.to_string(),
        phase.barrier.to_string(),
        phase.position.to_string(),
        phase.movements.join(" "),
        phase.yielding.join(" "),
        phase.min_green_s.to_string(),
        phase.passage_s.to_string(),
        phase.max_green_s.to_string(),
        phase.yellow_s.to_string(),
        phase.all_red_s.to_string(),
        optional(phase.walk_s),
        optional(phase.clearance_s),
        if phase.recall { "min" } else { "none" }.to_owned(),
        String::new(),
        String::new(),
        Control::Actuated.name().to_owned(),
        String::new(),
        String::new(),
    ]
}

fn stage_cells(
    program: &SignalProgram,
    index: usize,
    green: &Green,
    names: Option<&BTreeMap<usize, String>>,
) -> Vec<String> {
    let with = |letter: char| {
        let mut found: Vec<&str> = Vec::new();
        for (link, _) in green.state.char_indices().filter(|(_, c)| *c == letter) {
            let name = names.and_then(|names| names.get(&link)).map(String::as_str);
            found.extend(name.filter(|name| !found.contains(name)));
        }
        found
    };
    let sorted = |letter: char| {
        let mut names = with(letter);
        names.sort_by_key(|name| listed_before(name));
        names
    };
    let protected = sorted('G');
    // A movement whose links differ has the right of way on some of its lanes.
    let yielding: Vec<&str> =
        sorted('g').into_iter().filter(|name| !protected.contains(name)).collect();
    let cycle_s: f64 = program.phases.iter().map(|p| p.duration_s).sum();
    let is_fixed = program.kind == ProgramKind::Static;
    let split_s = green.green_s + green.yellow_s + green.all_red_s;
    let empty = String::new;
    vec![
        (index + 1).to_string(),
        empty(),
        empty(),
        empty(),
        protected.join(" "),
        yielding.join(" "),
        green.green_s.to_string(),
        empty(),
        green.max_s.unwrap_or(green.green_s).to_string(),
        green.yellow_s.to_string(),
        green.all_red_s.to_string(),
        empty(),
        empty(),
        empty(),
        if is_fixed { cycle_s.to_string() } else { empty() },
        if is_fixed { split_s.to_string() } else { empty() },
        if is_fixed { Control::Pretimed } else { Control::Actuated }.name().to_owned(),
        if is_fixed { "0".to_owned() } else { empty() },
        empty(),
    ]
}

/// Returns the phases of the signals that run in two rings, and those of existing plans, for the page; undefined where
/// there are none or too many.
pub(crate) fn values(seen: Seen<'_>) -> Option<Value> {
    let Seen { data, shown } = seen;
    let identity = &data.manifest.identity;
    let mut sheets: Vec<Value> = Vec::new();
    for plan in &shown.plans {
        let title = || shown.title(&data.points[plan.point].row);
        let method = named(data, &identity.methods[plan.method]);
        let existing = existing_of(data, plan);
        let signals: Vec<Value> = if let Some(existing) = &existing {
            let phases =
                by_number(existing.phases.iter().map(|p| (p.number, existing_cells(existing, p))));
            vec![context! { signal => None::<&str>, phases, of => of_plan(existing) }]
        } else {
            let alone = plan.rings.len() == 1;
            let of = |signal: &SignalProgram| {
                let phases = by_number(signal.rings.iter().map(|p| (p.number, phase_cells(p))));
                context! { signal => (!alone).then_some(signal.signal.as_str()), phases, of => "" }
            };
            plan.rings.iter().map(of).collect()
        };
        if !signals.is_empty() {
            let page = format!("plans/{}", super::sheets::page_name(seen, plan.point));
            sheets.push(context! { title => title(), method, signals, page });
        }
    }
    if sheets.is_empty() {
        return None;
    }
    let many = data.points.len() > FEW;
    let has_existing = identity.methods.iter().any(|m| m == existing::METHOD.name);
    if many {
        sheets.clear();
    }
    Some(context! { sheets, many, few => FEW, has_existing })
}

/// Returns what an existing plan is, for a caption.
pub(super) fn of_plan(plan: &ExistingPlan) -> String {
    let mut text = plan.control.name().to_owned();
    if let Some(cycle_s) = plan.cycle_s {
        text.push_str(&format!(
            ", cycle {} s, offset {} s",
            seconds(cycle_s),
            seconds(plan.offset_s)
        ));
    }
    let reference: Vec<String> = plan.reference.iter().map(u32::to_string).collect();
    match reference.as_slice() {
        [] => {}
        [one] => text.push_str(&format!(", reference phase {one}")),
        all => text.push_str(&format!(", reference phases {}", all.join(" and "))),
    }
    text
}

/// Returns the cells of phases for the page, by number.
pub(super) fn by_number(phases: impl Iterator<Item = (u32, Vec<String>)>) -> Vec<Value> {
    let mut phases: Vec<(u32, Vec<String>)> = phases.collect();
    phases.sort_by_key(|(number, _)| *number);
    phases.into_iter().map(|(_, cells)| phase_value(&cells)).collect()
}

fn phase_value(cells: &[String]) -> Value {
    let dash = |i: usize| if cells[i].is_empty() { "-".to_owned() } else { cells[i].clone() };
    context! {
        number => dash(0),
        ring => dash(1),
        barrier => dash(2),
        position => dash(3),
        movements => cells[4].as_str(),
        yielding => cells[5].as_str(),
        min => dash(6),
        passage => dash(7),
        max => dash(8),
        yellow => dash(9),
        red => dash(10),
        split => dash(15),
        walk => dash(11),
        clearance => dash(12),
        recall => match cells[13].as_str() {
            "min" => "minimum",
            "max" => "maximum",
            "ped" => "pedestrian",
            _ => "none",
        },
    }
}

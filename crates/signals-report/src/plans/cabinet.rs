//! What an engineer keys into a cabinet: `cabinet.csv`, and a table on the page where there are few intersections.
//!
//! - **Dual ring**: one row per phase, with ring, barrier and position.
//! - **Programs**: one row per stage, a green with the change after it. Movements that yield in it stand apart. Where the
//!   movements of links are not known, the columns of movements are empty.
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
use signals::env::by_movement::listed_before;
use signals::program::{ProgramKind, RingPhase, SignalProgram};

/// Name of the table in the report's folder.
pub(crate) const TABLE: &str = "cabinet.csv";

/// Most intersections whose phases the page shows.
const FEW: usize = 12;

const HEADER: [&str; 20] = [
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
        String::new(),
        phase.min_green_s.to_string(),
        phase.passage_s.to_string(),
        phase.max_green_s.to_string(),
        phase.yellow_s.to_string(),
        phase.all_red_s.to_string(),
        optional(phase.walk_s),
        optional(phase.clearance_s),
        if phase.recall { "min" } else { "none" }.to_owned(),
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
    ]
}

/// Returns the phases of the signals that run in two rings, for the page; undefined where there are none or too many.
pub(crate) fn values(seen: Seen<'_>) -> Option<Value> {
    let Seen { data, shown } = seen;
    let rings: Vec<&TaskPlan> = shown.plans.iter().filter(|plan| !plan.rings.is_empty()).collect();
    if rings.is_empty() {
        return None;
    }
    let many = data.points.len() > FEW;
    let identity = &data.manifest.identity;
    let sheet = |plan: &&TaskPlan| {
        let title = shown.title(&data.points[plan.point].row);
        let method = named(data, &identity.methods[plan.method]);
        let signals = plan.rings.iter().map(|signal| {
            let mut phases: Vec<&RingPhase> = signal.rings.iter().collect();
            phases.sort_by_key(|phase| phase.number);
            let phases: Vec<Value> = phases.into_iter().map(phase_value).collect();
            let alone = plan.rings.len() == 1;
            context! { signal => (!alone).then_some(signal.signal.as_str()), phases }
        });
        context! { title, method, signals => signals.collect::<Vec<_>>() }
    };
    let sheets: Vec<Value> = rings.iter().filter(|_| !many).map(sheet).collect();
    Some(context! { sheets, many, few => FEW })
}

fn phase_value(phase: &RingPhase) -> Value {
    let dash = |value: Option<u32>| value.map_or_else(|| "-".to_owned(), |v| v.to_string());
    context! {
        number => phase.number,
        ring => phase.ring,
        barrier => phase.barrier,
        position => phase.position,
        movements => phase.movements.join(" "),
        min => phase.min_green_s,
        passage => phase.passage_s,
        max => phase.max_green_s,
        yellow => phase.yellow_s,
        red => phase.all_red_s,
        walk => dash(phase.walk_s),
        clearance => dash(phase.clearance_s),
        recall => if phase.recall { "minimum" } else { "none" },
    }
}

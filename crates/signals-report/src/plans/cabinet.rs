//! What an engineer keys into a cabinet: `cabinet.csv`, and what the page says of it.
//!
//! A row is a phase, or a stage of a program (a green with the change after it), in the columns of tables of existing plans
//! ([`signals::existing::table`]). Existing plans are as they were given, with tenths of seconds; the simulation runs whole
//! ones. Where the movements of links are not known, the columns of movements are empty. Methods that decide while they run
//! have no row.

use std::collections::BTreeSet;

use minijinja::{Value, context};

use super::told::{Told, best_of_all_signals, of_task};
use crate::shown::Seen;
use evaluation::report::csv;
use signals::control::existing;
use signals::existing::table::{WRITTEN, cells, name};
use signals::existing::{Control, ExistingPlan, PlanPhase, Recall};

/// Name of the table in the report's folder.
pub(crate) const TABLE: &str = "cabinet.csv";

/// Most intersections whose sheets the page names.
const FEW: usize = 12;

/// By how much adding tenths of seconds may miss a sum, seconds.
const ROUNDING_S: f64 = 0.01;

/// Columns before those of a plan; the point MDP is called as `--existing` calls it.
const WHOSE: [&str; 5] = ["intersection", "method", "replicate", "signal", "kind"];

/// Returns the table of all plans that a cabinet can be told.
pub(crate) fn table(seen: Seen<'_>) -> String {
    let Seen { data, shown } = seen;
    let identity = &data.manifest.identity;
    let titles = shown.titles(data);
    let titled = csv::Titled(titles.as_deref());
    let rows = shown.plans.iter().flat_map(|task| {
        let whose = [
            identity.points[task.point].point.clone(),
            identity.methods[task.method].clone(),
            task.replicate.to_string(),
        ];
        let row = move |told: &Told, phase: &PlanPhase| {
            let kind = if told.is_stages { "stage" } else { "phase" };
            let signal = [told.signal.clone(), kind.to_owned()];
            let cells = whose.iter().cloned().chain(signal).chain(cells(&told.plan, phase));
            titled.row(task.point, cells.collect())
        };
        let all = of_task(seen, task);
        let of = |told: &Told| told.plan.phases.iter().map(|p| row(told, p)).collect::<Vec<_>>();
        all.iter().flat_map(of).collect::<Vec<_>>()
    });
    let header = WHOSE.into_iter().chain(WRITTEN.iter().copied()).map(str::to_owned).collect();
    csv::table(&titled.header(header), rows)
}

/// Returns a time without digits that come from adding tenths.
pub(crate) fn seconds(value: f64) -> String {
    ((value * 1000.0).round() / 1000.0).to_string()
}

/// Returns what the page says of plans for cabinets; undefined where no signal runs in two rings or by a given plan.
pub(crate) fn values(seen: Seen<'_>) -> Option<Value> {
    let has_phases = |task| of_task(seen, task).iter().any(|told| !told.is_stages);
    let methods = &seen.data.manifest.identity.methods;
    let has_existing = methods.iter().any(|method| method == existing::METHOD.name);
    let printed: BTreeSet<usize> = best_of_all_signals(seen).iter().map(|t| t.point).collect();
    let page = |point: &usize| {
        let title = seen.shown.title(&seen.data.points[*point].row);
        context! { title, page => format!("plans/{}", super::sheets::page_name(seen, *point)) }
    };
    let few = printed.iter().filter(|_| printed.len() <= FEW);
    let pages: Vec<Value> = few.map(page).collect();
    seen.shown.plans.iter().any(has_phases).then(|| context! { has_existing, pages })
}

/// Returns what an existing plan is, for a caption.
pub(crate) fn of_plan(plan: &ExistingPlan) -> String {
    let mut text = name(&plan.control);
    if let Some(cycle_s) = plan.cycle_s {
        text.push_str(&format!(", cycle {} s", seconds(cycle_s)));
        if let Some(offset_s) = plan.offset_s {
            text.push_str(&format!(", offset {} s", seconds(offset_s)));
        }
    }
    let reference: Vec<String> = plan.reference.iter().map(u32::to_string).collect();
    match reference.as_slice() {
        [] => {}
        [one] => text.push_str(&format!(", reference phase {one}")),
        all => text.push_str(&format!(", reference phases {}", all.join(" and "))),
    }
    text
}

/// Whether a phase's shortest green contains walk and clearance although its recall is not that of pedestrians: keyed so, it
/// shows WALK only after a push of the button.
pub(crate) fn hides_walk(plan: &ExistingPlan) -> bool {
    plan.phases.iter().any(|phase| {
        let is_within = |[walk_s, clearance_s]: [f64; 2]| {
            walk_s > 0.0 && phase.min_green_s >= walk_s + clearance_s - ROUNDING_S
        };
        matches!(phase.recall, Recall::None | Recall::Min) && phase.walk_s.is_some_and(is_within)
    })
}

/// Returns the numbers of the phases of a fixed cycle that are for pedestrians alone, whom nothing serves there.
pub(crate) fn unserved_people(plan: &ExistingPlan) -> Vec<String> {
    let phases = plan.phases.iter().filter(|_| plan.control == Control::Pretimed);
    phases.filter(|p| p.is_for_people()).map(|p| p.number.to_string()).collect()
}

/// Returns the phases of a plan for pages, by number.
pub(crate) fn phases(plan: &ExistingPlan) -> Vec<Value> {
    let mut phases: Vec<&PlanPhase> = plan.phases.iter().collect();
    phases.sort_by_key(|phase| phase.number);
    let value = |phase: &PlanPhase| {
        let people =
            |i: usize| phase.walk_s.map_or_else(|| "-".to_owned(), |both| seconds(both[i]));
        context! {
            number => phase.number,
            ring => phase.ring,
            barrier => phase.barrier,
            position => phase.position,
            movements => phase.movements.join(" "),
            yielding => phase.yielding.join(" "),
            min => seconds(phase.min_green_s),
            passage => seconds(phase.passage_s),
            max => seconds(phase.max_green_s),
            yellow => seconds(phase.yellow_s),
            red => seconds(phase.all_red_s),
            split => seconds(phase.split_s()),
            walk => people(0),
            clearance => people(1),
            recall => match phase.recall {
                Recall::Min => "minimum",
                Recall::Max => "maximum",
                Recall::Ped => "pedestrian",
                Recall::None => "none",
            },
        }
    };
    phases.into_iter().map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::super::told::tests::phase;
    use super::*;

    #[test]
    fn a_shortest_green_with_walk_and_clearance_needs_the_recall_of_pedestrians() {
        let hides = |min_green_s: f64, walk_s: Option<[f64; 2]>, recall: Recall| {
            let phase = PlanPhase { min_green_s, walk_s, recall, yielding: vec![], ..phase() };
            let mut alone = ExistingPlan::new(Control::Pretimed, vec![phase.clone()]);
            assert_eq!(unserved_people(&alone), Vec::<String>::new());
            alone.phases[0].movements.clear();
            assert_eq!(unserved_people(&alone).len(), usize::from(walk_s.is_some()));
            hides_walk(&ExistingPlan::new(Control::Actuated, vec![phase]))
        };
        let people = Some([7.0, 11.0]);
        assert!(hides(18.0, people, Recall::None) && hides(18.0, people, Recall::Min));
        assert!(!hides(18.0, people, Recall::Ped) && !hides(18.0, people, Recall::Max));
        assert!(!hides(7.0, people, Recall::None) && !hides(18.0, None, Recall::None));
    }
}

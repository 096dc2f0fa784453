//! What an engineer keys into a cabinet: `cabinet.csv`, and a table on the page where there are few intersections.
//!
//! A row is a phase, or a stage of a program (a green with the change after it), in the columns of tables of existing plans
//! ([`signals::existing::table`]). Existing plans are as they were given, with tenths of seconds; the simulation runs whole
//! ones. Where the movements of links are not known, the columns of movements are empty. Methods that decide while they run
//! have no row.

use std::collections::BTreeSet;

use minijinja::{Value, context};
use serde_json::Value as Json;

use super::told::{Told, best_of_all_signals, of_task};
use crate::shown::Seen;
use basics::units::mph_to_mps;
use evaluation::analysis::Analysis;
use evaluation::report::csv;
use evaluation::report::figures::shown as named;
use signals::control::existing;
use signals::existing::table::{WRITTEN, cells};
use signals::existing::{Control, ExistingPlan, PlanPhase, Recall};
use signals::places::{DrawnArm, DrawnIntersection};
use signals::timing::{SLOWEST_MPS, kinematic_yellow_s};

/// Name of the table in the report's folder.
pub(crate) const TABLE: &str = "cabinet.csv";

/// Most intersections whose phases the page shows.
const FEW: usize = 12;

/// Name in settings of changes whose length follows from speed and width.
const KINEMATIC: &str = "kinematic";

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

/// Returns the phases of the signals that run in two rings, and those of existing plans, for the page; undefined where
/// there are none or too many.
pub(crate) fn values(seen: Seen<'_>) -> Option<Value> {
    let Seen { data, shown } = seen;
    let identity = &data.manifest.identity;
    let many = data.points.len() > FEW;
    // Those that a page to print is written for.
    let printed: BTreeSet<usize> = match many {
        true => BTreeSet::new(),
        false => best_of_all_signals(seen).iter().map(|told| told.point).collect(),
    };
    let mut sheets: Vec<Value> = Vec::new();
    for task in &shown.plans {
        let all: Vec<Told> =
            of_task(seen, task).into_iter().filter(|told| !told.is_stages).collect();
        let alone = all.len() == 1;
        let signals: Vec<Value> = (all.iter())
            .map(|told| {
                let is_given = !told.plan.ways.is_empty();
                let has_cycle = told.plan.cycle_s.is_some();
                context! {
                    signal => (!alone).then_some(told.signal.as_str()),
                    phases => phases(&told.plan),
                    of => if is_given || has_cycle { of_plan(&told.plan) } else { String::new() },
                    has_cycle => has_cycle && !is_given,
                    is_given,
                }
            })
            .collect();
        if !signals.is_empty() {
            let title = shown.title(&data.points[task.point].row);
            let method = named(data, &identity.methods[task.method]);
            let page = printed
                .contains(&task.point)
                .then(|| format!("plans/{}", super::sheets::page_name(seen, task.point)));
            sheets.push(context! { title, method, signals, page });
        }
    }
    if sheets.is_empty() {
        return None;
    }
    let has_existing = identity.methods.iter().any(|m| m == existing::METHOD.name);
    if many {
        sheets.clear();
    }
    Some(context! { sheets, many, few => FEW, has_existing })
}

/// Returns what an existing plan is, for a caption.
pub(crate) fn of_plan(plan: &ExistingPlan) -> String {
    let mut text = plan.control.name().to_owned();
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

/// Returns the yellow of ITE's formula before it is rounded, in words by speed limit; `None` where yellow does not follow
/// from speeds, or those are not known.
pub(crate) fn unrounded_yellow(data: &Analysis, drawn: &DrawnIntersection) -> Option<String> {
    let settings = &data.manifest.identity.settings;
    let interval = settings.pointer("/signal/change_interval").and_then(Json::as_str)?;
    (interval == KINEMATIC).then(|| by_speed(&drawn.arms))
}

/// Says the yellow at the speed limits of the arms with traffic to the signal, the slowest first.
fn by_speed(arms: &[DrawnArm]) -> String {
    let arms = arms.iter().filter(|arm| !arm.lanes.is_empty());
    let mut speeds: Vec<f64> = arms.map(|arm| arm.speed_mph.round()).collect();
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    let said = speeds.iter().map(|mph| {
        format!("{:.1} s at {mph} mph", kinematic_yellow_s(mph_to_mps(*mph).max(SLOWEST_MPS)))
    });
    said.collect::<Vec<_>>().join(", ")
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
    use super::*;

    #[test]
    fn yellow_is_said_to_a_tenth_for_every_speed_to_the_signal() {
        let arm = |speed_mph: f64, lanes: &[&str]| DrawnArm {
            name: String::new(),
            edge: String::new(),
            bearing_deg: 0.0,
            lanes: lanes.iter().map(|turns| (*turns).to_owned()).collect(),
            lanes_out: 1,
            speed_mph,
            left_storage_m: None,
            right_storage_m: None,
        };
        // 1 s + 17.88 / 6.1, and 1 s + 13.41 / 6.1.
        let arms = [arm(40.0, &["s"]), arm(30.0, &["s"]), arm(30.0, &["s"]), arm(55.0, &[])];
        assert_eq!(by_speed(&arms), "3.2 s at 30 mph, 3.9 s at 40 mph");
    }

    #[test]
    fn a_shortest_green_with_walk_and_clearance_needs_the_recall_of_pedestrians() {
        let hides = |min_green_s: f64, walk_s: Option<[f64; 2]>, recall: Recall| {
            let phase = PlanPhase {
                number: 2,
                ring: 1,
                barrier: 1,
                position: 1,
                movements: vec!["NBT".to_owned()],
                yielding: Vec::new(),
                min_green_s,
                max_green_s: 60.0,
                passage_s: 3.0,
                yellow_s: 4.0,
                all_red_s: 1.0,
                walk_s,
                recall,
                dual_entry: true,
                inhibit_max: false,
            };
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

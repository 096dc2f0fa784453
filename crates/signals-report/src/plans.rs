//! The signal programs of methods whose behaviour is one: tables, files for SUMO, and what shows the
//! best method of a point MDP.
//!
//! - **Several trainings** have several plans. All are in the table; the files have that of the
//!   best recorded objective.

pub(super) mod cabinet;
pub mod episode;
mod files;
mod program_xml;
pub(super) mod told;

use minijinja::{Value, context};

use crate::shown::{Seen, TaskPlan};
use evaluation::report::format;

pub(super) use files::{FOLDER, TABLE, remove_earlier, write};

/// Returns the section on signal plans; undefined without a finished task.
pub(super) fn values(seen: Seen<'_>) -> Option<Value> {
    let Seen { data, shown } = seen;
    let identity = &data.manifest.identity;
    let rows: Vec<Value> = identity
        .methods
        .iter()
        .enumerate()
        .filter_map(|(index, method)| {
            let plans: Vec<&TaskPlan> = shown.plans.iter().filter(|p| p.method == index).collect();
            let wins = || {
                let best = |p: &usize| data.winners[*p].as_ref().is_some_and(|w| w.best == index);
                (0..data.points.len()).filter(best)
            };
            let weight: f64 = wins().map(|p| data.points[p].weight).sum();
            (!plans.is_empty()).then(|| {
                context! {
                    name => method.clone(),
                    wins => wins().count(),
                    share => format::percent(weight),
                    behaviour => behaviour(&plans),
                }
            })
        })
        .collect();
    (!rows.is_empty())
        .then(|| context! { rows, chosen => data.points.len(), whole => shown.plans.iter().any(|p| !p.programs.is_empty()) })
}

/// Says what a method does, and where that can be had.
fn behaviour(plans: &[&TaskPlan]) -> &'static str {
    let own = |p: &&TaskPlan| p.programs.iter().all(|program| program.own);
    if plans.iter().all(|p| p.programs.is_empty()) {
        "no program to load in its records"
    } else if plans.iter().all(own) {
        "the network\u{2019}s own program: nothing to load"
    } else {
        "a program"
    }
}

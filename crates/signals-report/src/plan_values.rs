//! What the page says of signal plans: who wins where, and whose behaviour is a program.

use minijinja::{Value, context};

use super::plans::TaskPlan;
use super::shown::Seen;
use evaluation::report::figures::shown as named;
use evaluation::report::format;

/// Returns the section on signal plans; undefined without a finished task.
pub(super) fn plan_values(seen: Seen<'_>) -> Option<Value> {
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
                    name => named(data, method),
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

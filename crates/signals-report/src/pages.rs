//! A page per intersection, to print on two sheets: a sketch to scale, what changes between today and the best method,
//! movements, and on the second sheet plans and their schedule (`intersections/POINT.html`).
//!
//! Periods of an intersection are point MDPs of their own and stand on one page. Intervals are Student's, over evaluation
//! seeds, with the same vehicles for both methods; they contain no error of the model.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use minijinja::{Value, context};

use super::answers::{delay_on_foot, is_coordinated, today};
use super::level_of_service::letter;
use super::movements;
use super::plans::cabinet::{in_order, plan, seconds};
use super::plans::remove_earlier;
use super::plans::told::{Told, best};
use super::savings::{
    FOLDER, MOST_PAGES, Page, by_seed, hours, hours_in_words, intersections, interval, per, savings,
};
use super::shown::{OfTask, Seen};
use super::sketch::sketch;
use basics::files::{FileError, write_atomically};
use evaluation::analysis::Analysis;
use evaluation::report::page::render;
use evaluation::report::{ReportError, format};
use evaluation::stats::score::mean;
use signals::existing::ExistingPlan;
use signals::movement_results::MovementResult;
use signals::places::DrawnIntersection;
use signals::vocabulary::listed;

fn pages(seen: Seen<'_>) -> Vec<Page<'_>> {
    Some(intersections(seen)).filter(|all| all.len() <= MOST_PAGES).unwrap_or_default()
}

/// Returns the page of each point MDP that has one, as seen from the folder of the report.
pub(super) fn links(seen: Seen<'_>) -> BTreeMap<usize, String> {
    let all = pages(seen);
    let of = |page: &Page<'_>| {
        let link = format!("{FOLDER}/{}", page.name);
        page.periods.iter().map(|(point, _)| (*point, link.clone())).collect::<Vec<_>>()
    };
    all.iter().flat_map(of).collect()
}

/// Writes the pages into the folder of a report; those of an earlier report are replaced.
pub(super) fn write(folder: &Path, seen: Seen<'_>) -> Result<(), ReportError> {
    let own = folder.join(FOLDER);
    remove_earlier(&own)?;
    let pages = pages(seen);
    if pages.is_empty() {
        return Ok(());
    }
    fs::create_dir_all(&own).map_err(FileError::at("create", &own))?;
    let (plans, savings, per) = (best(seen), savings(seen, &pages), per(seen.data, &pages));
    for page in &pages {
        let saving = savings.iter().find(|saving| std::ptr::eq(saving.page, page));
        let saved = saving.map(|own| {
            let [method, against] =
                [own.method, own.against].map(|m| seen.data.manifest.identity.methods[m].clone());
            context! { hours => hours_in_words(&own.saved_h), stays => method == against, method, against, per => per.as_str() }
        });
        let values = values(seen, page, &plans, saved);
        let template = include_str!("templates/intersection_page.html");
        let html = render("intersection_page.html", template, values);
        let html = html.map_err(ReportError::Template)?;
        write_atomically(&own.join(&page.name), html.as_bytes())?;
    }
    Ok(())
}

/// What is compared in a period: positions of methods in the manifest.
struct Compared {
    point: usize,
    period: String,
    reference: usize,
    best: Option<usize>,
    runner_up: Option<usize>,
    /// Hours of the year that the period has, where the scenario says it.
    hours: Option<f64>,
}

fn compared(seen: Seen<'_>, (point, drawn): &(usize, &DrawnIntersection)) -> Option<Compared> {
    let data = seen.data;
    let identity = &data.manifest.identity;
    let name = today(data).unwrap_or(&identity.baseline);
    let reference = identity.methods.iter().position(|m| m == name)?;
    let winner = data.winners[*point].as_ref();
    Some(Compared {
        point: *point,
        period: drawn.period.clone(),
        reference,
        best: winner.map(|w| w.best),
        runner_up: winner.and_then(|w| w.runner_up),
        hours: hours(data, drawn),
    })
}

/// Returns the stops per vehicle of a method, over all its trainings as its delay is; `None` where they were not recorded.
fn stops(seen: Seen<'_>, point: usize, method: usize) -> Option<f64> {
    let of_task = |results: &[MovementResult]| {
        let (mut vehicles, mut stops) = (0.0, 0.0);
        for m in results.iter().filter(|m| m.vehicles_veh > 0.0) {
            vehicles += m.vehicles_veh;
            stops += m.stops? * m.vehicles_veh;
        }
        (vehicles > 0.0).then(|| stops / vehicles)
    };
    let own = seen.shown.movements.iter().filter(|t| (t.point, t.method) == (point, method));
    mean(&own.map(|task| of_task(&task.results)).collect::<Option<Vec<_>>>()?)
}

/// Returns the change of delay from the reference to another method, with the same evaluation seeds.
fn change(data: &Analysis, c: &Compared, method: usize) -> Option<(f64, Option<f64>)> {
    let own = by_seed(data, c.point, method).filter(|_| method != c.reference)?;
    let other = by_seed(data, c.point, c.reference)?;
    interval(&own.iter().zip(&other).map(|(a, b)| a - b).collect::<Vec<_>>())
}

/// Says a number with half the width of its interval.
fn with_width((middle, half): (f64, Option<f64>), sign: bool) -> String {
    let middle = if sign { format!("{middle:+.1}") } else { format!("{middle:.1}") };
    half.map_or(middle.clone(), |half| format!("{middle} \u{b1} {half:.1}"))
}

/// Says the delay at the crosswalk of each approach, over all trainings, such as `NB 14, EB not served`; nothing where people on
/// foot do not count.
fn crosswalks(seen: Seen<'_>, point: usize, method: usize) -> String {
    let own = || seen.shown.movements.iter().filter(|t| (t.point, t.method) == (point, method));
    let mut said: Vec<String> = Vec::new();
    for m in own().next().iter().flat_map(|task| &task.results) {
        let of_task = |t: &OfTask<Vec<MovementResult>>| {
            t.results.iter().find(|r| r.from == m.from)?.crosswalk_delay_s
        };
        let delay = own().map(of_task).collect::<Option<Vec<_>>>().and_then(|all| mean(&all));
        let unserved = m.crosswalk_unserved.then(|| "not served".to_owned());
        let wait = delay.map(|s| format!("{s:.0}")).or(unserved);
        let text = wait.zip(m.movement.get(..2)).map(|(wait, name)| format!("{name} {wait}"));
        said.extend(text.filter(|text| !said.contains(text)));
    }
    said.join(", ")
}

fn row(seen: Seen<'_>, c: &Compared, method: usize) -> Option<Value> {
    let data = seen.data;
    let result = data.points[c.point].results[method].as_ref()?;
    let delay = by_seed(data, c.point, method).and_then(|own| interval(&own));
    let delay = with_width(delay.unwrap_or((result.objective, None)), false);
    let winner = data.winners[c.point].as_ref().filter(|_| c.best == Some(method));
    let probability = winner.and_then(|w| w.probability).map(format::percent);
    let own = if today(data).is_some() { "today" } else { "baseline" };
    let role = match (method == c.reference, c.best == Some(method)) {
        (true, true) => format!("{own}, and best"),
        (true, false) => own.to_owned(),
        (false, true) => "best".to_owned(),
        _ => "runner-up".to_owned(),
    };
    Some(context! {
        role,
        method => data.manifest.identity.methods[method].clone(),
        delay,
        level => letter(result.objective).to_string(),
        on_foot => delay_on_foot(data, c.point, method).map(|s| format!("{s:.1}")),
        crosswalks => crosswalks(seen, c.point, method),
        change => change(data, c, method).map(|change| with_width(change, true)),
        probability,
        stops => stops(seen, c.point, method).map(|stops| format!("{stops:.2}")),
    })
}

/// Returns the row of a plan in the schedule: cycle, offset, reference, and the split of each phase.
fn schedule(plan: &ExistingPlan) -> Value {
    let splits =
        in_order(plan).into_iter().map(|p| format!("{}: {}", p.label(), seconds(p.split_s())));
    let reference: Vec<String> = plan.reference.iter().map(u32::to_string).collect();
    context! {
        control => signals::existing::table::name(&plan.control),
        cycle => plan.cycle_s.map_or_else(|| "free".to_owned(), seconds),
        offset => plan.cycle_s.and(plan.offset_s).map_or_else(|| "-".to_owned(), seconds),
        reference => if reference.is_empty() { "-".to_owned() } else { reference.join(" ") },
        splits => splits.collect::<Vec<_>>().join(", "),
    }
}

/// Returns per arm the phases of its movements.
fn phases_of_arms(drawn: &DrawnIntersection, told: &Told) -> Vec<String> {
    let phases = in_order(&told.plan);
    let with_phases = |name: String| {
        let own = phases.iter().filter(|p| p.all_movements().any(|other| *other == name));
        let numbers: Vec<String> = own.map(|p| p.label()).collect();
        (!numbers.is_empty()).then(|| format!("{name} {}", numbers.join("+")))
    };
    let of_arm = |edge: &str| {
        let own = told.ways.iter().filter(|(_, ways)| ways.iter().any(|(from, _)| from == edge));
        let names = listed(own.map(|(name, _)| name.as_str()));
        names.into_iter().filter_map(with_phases).collect::<Vec<_>>().join(", ")
    };
    drawn.arms.iter().map(|arm| of_arm(&arm.edge)).collect()
}

/// Returns what a page shows.
fn values(seen: Seen<'_>, page: &Page<'_>, plans: &[Told], saved: Option<Value>) -> Value {
    let data = seen.data;
    let identity = &data.manifest.identity;
    let all: Vec<(Compared, &DrawnIntersection)> =
        page.periods.iter().filter_map(|p| Some((compared(seen, p)?, p.1))).collect();
    let (first, drawn) = (page.periods[0].0, page.periods[0].1);
    let title = page.title(seen);
    // The best method of those that a cabinet can be told.
    let proposed = |c: &Compared| {
        let delay = |told: &&Told| {
            data.points[c.point].results[told.method]
                .as_ref()
                .map_or(f64::INFINITY, |r| r.objective)
        };
        let own = plans.iter().filter(|told| told.point == c.point);
        own.min_by(|a, b| delay(a).total_cmp(&delay(b)))
    };
    let said = all.first().and_then(|(c, _)| Some(phases_of_arms(drawn, proposed(c)?)));
    let said = said.unwrap_or_else(|| vec![String::new(); drawn.arms.len()]);
    let periods: Vec<Value> = all
        .iter()
        .map(|(c, _)| {
            let mut methods = vec![c.reference];
            for method in [c.best, c.runner_up].into_iter().flatten() {
                if !methods.contains(&method) {
                    methods.push(method);
                }
            }
            let rows: Vec<Value> =
                methods.iter().filter_map(|method| row(seen, c, *method)).collect();
            let own =
                |method: usize| plans.iter().find(|t| (t.point, t.method) == (c.point, method));
            let mut shown_plans: Vec<&Told> = own(c.reference).into_iter().collect();
            if let Some(told) = proposed(c).filter(|told| told.method != c.reference) {
                shown_plans.push(told);
            }
            context! {
                name => c.period.as_str(),
                hours => c.hours.map(seconds),
                rows,
                movements => movements::point(seen, c.point, None),
                has_people => methods.iter().any(|m| !crosswalks(seen, c.point, *m).is_empty()),
                plans => shown_plans.into_iter().map(|told| context! { schedule => schedule(&told.plan), ..plan(seen, told) }).collect::<Vec<_>>(),
            }
        })
        .collect();
    let today_is_coordinated =
        |c: &Compared| is_coordinated(&identity.points[c.point], &identity.methods[c.reference]);
    let point = data.points[first].row.point.as_str();
    let sketch = sketch(drawn, &title, &said);
    context! {
        title,
        point,
        several => page.periods.len() > 1,
        sketch,
        has_phases => said.iter().any(|text| !text.is_empty()),
        periods,
        is_today => today(data).is_some(),
        is_coordinated => all.iter().any(|(c, _)| today_is_coordinated(c)),
        saved,
        seeds => format::count(identity.evaluation_seeds.len(), "evaluation seed"),
        has_sheet => plans.iter().any(|told| told.point == first),
        simulator => identity.simulator.as_str(),
        version => identity.tsc_family.as_str(),
    }
}

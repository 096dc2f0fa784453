//! Plans for whoever keys them in: as a table that `--existing` takes back (`plans/METHOD.csv`), as UTDF that Synchro takes
//! back (`plans/METHOD.utdf.csv`), and as a page to print per intersection (`plans/POINT.html`). A SUMO scenario of several
//! signals has only the page, with a sheet per signal.
//!
//! UTDF needs nodes that are numbers: intersections whose ids are none are left out, which is said. Its columns are
//! those of the network that the existing plan came with, else those with which the names of all arms begin, else the
//! directions of the compass.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use minijinja::{Value, context};

use super::cabinet::{hides_walk, of_plan, phases, seconds, unserved_people};
use super::told::{Told, best_of_all_signals};
use crate::shown::Seen;
use basics::files::{FileError, write_atomically};
use evaluation::family::names::safe_id;
use evaluation::report::ReportError;
use evaluation::report::page::render;
use signals::existing::table::to_csv;
use signals::existing::{Control, ExistingPlan, NamedPlan};
use signals::family::load::number_of_intersection;
use signals::utdf::to_utdf;

/// Most intersections with a page each.
const MOST_PAGES: usize = 500;

/// Most arms of which UTDF calls the movements as the model does.
const PLAIN_ARMS: usize = 4;

/// Most names that a note lists.
const FEW: usize = 6;

/// Writes tables, UTDF and pages into the folder of plans, and returns notes for people.
pub(crate) fn write(folder: &Path, seen: Seen<'_>) -> Result<Vec<String>, ReportError> {
    let (alone, several): (Vec<Told>, Vec<Told>) =
        best_of_all_signals(seen).into_iter().partition(|told| told.is_alone);
    let mut notes = Vec::new();
    if alone.is_empty() && several.is_empty() {
        return Ok(notes);
    }
    std::fs::create_dir_all(folder).map_err(FileError::at("create", folder))?;
    write_tables(folder, seen, &alone)?;
    write_utdf(folder, seen, &alone, &mut notes)?;
    if seen.data.points.len() > MOST_PAGES {
        notes.push(format!(
            "no pages of plans per intersection: more than {MOST_PAGES} intersections"
        ));
        return Ok(notes);
    }
    for point in 0..seen.data.points.len() {
        let of_point = |told: &&Told| told.point == point;
        let mut by_signal: Vec<&Told> = several.iter().filter(of_point).collect();
        // All methods of a signal stand together.
        by_signal.sort_by(|a, b| a.signal.cmp(&b.signal));
        let own: Vec<&Told> = alone.iter().filter(of_point).chain(by_signal).collect();
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
    Ok(notes)
}

pub(crate) fn page_name(seen: Seen<'_>, point: usize) -> String {
    format!("{}.html", seen.data.points[point].row.point)
}

/// Writes the plans of each method as a table, by point MDP.
fn write_tables(folder: &Path, seen: Seen<'_>, all: &[Told]) -> Result<(), ReportError> {
    let identity = &seen.data.manifest.identity;
    let mut tables: BTreeMap<&str, Vec<NamedPlan>> = BTreeMap::new();
    for told in all {
        tables.entry(&identity.methods[told.method]).or_default().push(NamedPlan {
            intersection: identity.points[told.point].point.clone(),
            period: String::new(),
            plan: told.given_back(),
            line: 1,
        });
    }
    for (method, plans) in tables {
        write_atomically(&folder.join(format!("{method}.csv")), to_csv(&plans).as_bytes())?;
    }
    Ok(())
}

fn write_utdf(
    folder: &Path,
    seen: Seen<'_>,
    all: &[Told],
    notes: &mut Vec<String>,
) -> Result<(), ReportError> {
    let identity = &seen.data.manifest.identity;
    let mut files: BTreeMap<String, Vec<(u32, ExistingPlan)>> = BTreeMap::new();
    let (mut left_out, mut many_arms) = (Vec::new(), BTreeSet::new());
    for told in all {
        let (point, method) = (&identity.points[told.point].point, &identity.methods[told.method]);
        let drawn = seen.shown.drawing(point);
        let numbered =
            drawn.and_then(|d| Some((number_of_intersection(&d.intersection)?, &d.period)));
        let Some((number, period)) = numbered else {
            left_out.push(format!("{point}: its id is no number"));
            continue;
        };
        // One plan that UTDF cannot say does not keep the others from being written.
        if let Err(reason) = to_utdf(&[(number, told.given_back())]) {
            left_out.push(format!("{method}, {reason}"));
            continue;
        }
        if drawn.is_some_and(|drawn| drawn.arms.len() > PLAIN_ARMS) {
            many_arms.insert(number.to_string());
        }
        let dot = if period.is_empty() { String::new() } else { format!(".{}", safe_id(period)) };
        let name = format!("{method}{dot}.utdf.csv");
        files.entry(name).or_default().push((number, told.given_back()));
    }
    let has_numbers = !files.is_empty();
    for (name, plans) in files {
        let text = to_utdf(&plans).expect("each of them was written");
        write_atomically(&folder.join(name), text.as_bytes())?;
    }
    left_out.dedup();
    let few = |names: &[String]| {
        let more = if names.len() > FEW { ", ..." } else { "" };
        format!("{}{more}", names[..names.len().min(FEW)].join(", "))
    };
    // Where no intersection has a number, nobody came from UTDF.
    if has_numbers && !left_out.is_empty() {
        notes.push(format!("no UTDF of plans that it cannot say ({})", few(&left_out)));
    }
    if !many_arms.is_empty() {
        let names: Vec<String> = many_arms.into_iter().collect();
        notes.push(format!(
            "UTDF of intersections with more than {PLAIN_ARMS} arms ({}) names movements after where they lead: compare the \
             columns of [Lanes] with those of your network before you merge them",
            few(&names)
        ));
    }
    Ok(())
}

/// Returns what the page of an intersection shows.
fn page(seen: Seen<'_>, point: usize, own: &[&Told]) -> Value {
    let Seen { data, shown } = seen;
    let identity = &data.manifest.identity;
    let row = &data.points[point].row;
    let plans = own.iter().map(|told| {
        // Of the training whose plan it is.
        let of_training = told.objective.map(|delay_s| format!("{delay_s:.1}"));
        let trainings = shown.training(data, point, told.method).map_or(1, |(_, count)| count);
        context! {
            method => identity.methods[told.method].clone(),
            of => of_plan(&told.plan),
            delay_s => of_training,
            training => (trainings > 1).then(|| format!("training {} of {trainings}", told.replicate + 1)),
            phases => phases(&told.plan),
            signal => (!told.is_alone).then_some(told.signal.as_str()),
            is_stages => told.is_stages,
            is_coordinated => told.plan.control == Control::Coordinated,
            hides_walk => hides_walk(&told.plan),
            unserved_people => unserved_people(&told.plan).join(", "),
            is_today => identity.methods[told.method] == signals::control::existing::METHOD.name,
            is_given => !told.plan.ways.is_empty(),
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
pub(crate) fn rings(plan: &ExistingPlan) -> Vec<Vec<Value>> {
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

//! What an engineer keys into a cabinet: `cabinet.csv`, and what the page says of it.
//!
//! A row is a phase, or a stage of a program (a green with the change after it), in the columns of tables of existing plans
//! ([`signals::existing::table`]). Existing plans are as they were given, with tenths of seconds; the simulation runs whole
//! ones. Where the movements of links are not known, the columns of movements are empty. Methods that decide while they run
//! have no row.
//!
//! Plans are written for whoever keys them in, too: as a table that `--existing` takes back (`plans/METHOD.csv`), as UTDF that Synchro takes
//! back (`plans/METHOD.utdf.csv`), and as a page to print per intersection (`plans/POINT.html`). A SUMO scenario of several
//! signals has only the page, with a sheet per signal.
//!
//! UTDF needs nodes that are numbers: intersections whose ids are none are left out, which is said. Its columns are
//! those of the network that the existing plan came with, else those with which the names of all arms begin, else the
//! directions of the compass.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use minijinja::{Value, context};
use osm_signals::Turn;
use osm_signals::angle::turn_degrees;

use super::told::{Told, best_of_all_signals, of_task};
use crate::audit::{checks, in_words};
use crate::shown::Seen;
use basics::files::{FileError, write_atomically};
use evaluation::family::names::safe_id;
use evaluation::report::page::render;
use evaluation::report::{ReportError, csv};
use signals::control::{existing, retime};
use signals::existing::table::{WRITTEN, cells, name, to_csv};
use signals::existing::{Control, ExistingPlan, NamedPlan, PlanPhase, Recall, schedule};
use signals::family::load::number_of_intersection;
use signals::places::{DrawnArm, DrawnIntersection};
use signals::settings::SignalSettings;
use signals::timing::{Change, nearest_s};
use signals::utdf::to_utdf;
use signals::vocabulary::{Heading, on_side};

/// Name of the table in the report's folder.
pub(crate) const TABLE: &str = "cabinet.csv";

/// Most intersections whose sheets the page names.
const FEW: usize = 12;

/// Most intersections with a page each.
const MOST_PAGES: usize = 500;

/// Most names that a note lists.
const FEW_NAMES: usize = 6;

/// By how much adding tenths of seconds may miss a sum, seconds.
const ROUNDING_S: f64 = 0.01;

/// What legs are called, clockwise from north.
const LEGS: [&str; 8] =
    ["north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west"];

/// Angles from the leg that a left turn comes from to the one that it goes to, degrees.
const LEFT_DEG: std::ops::RangeInclusive<f64> = 30.0..=150.0;

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
        context! { title, page => format!("plans/{}", page_name(seen, *point)) }
    };
    let few = printed.iter().filter(|_| printed.len() <= FEW);
    let pages: Vec<Value> = few.map(page).collect();
    seen.shown.plans.iter().any(has_phases).then(|| context! { has_existing, pages })
}

fn of_plan(plan: &ExistingPlan) -> String {
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
    for [one, other] in &plan.merging {
        text.push_str(&format!("; continuous-green T ({one} and {other} into one leg)"));
    }
    text
}

/// Whether a phase's shortest green contains walk and clearance although its recall is not that of pedestrians: keyed so, it
/// shows WALK only after a push of the button.
fn hides_walk(plan: &ExistingPlan) -> bool {
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

/// Returns the phases of a plan by number, those of a single ring in their order.
pub(crate) fn in_order(plan: &ExistingPlan) -> Vec<&PlanPhase> {
    let mut phases: Vec<&PlanPhase> = plan.phases.iter().collect();
    let is_one_ring = phases.iter().all(|phase| (phase.ring, phase.barrier) == (1, 1));
    phases.sort_by_key(|phase| if is_one_ring { phase.position } else { phase.number });
    phases
}

fn phases(plan: &ExistingPlan) -> Vec<Value> {
    let phases = in_order(plan);
    let value = |phase: &PlanPhase| {
        let people =
            |i: usize| phase.walk_s.map_or_else(|| "-".to_owned(), |both| seconds(both[i]));
        context! {
            number => phase.label(),
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
            dual_entry => phase.dual_entry,
            inhibit_max => phase.inhibit_max,
            detectors => phase.detectors.as_str(),
        }
    };
    phases.into_iter().map(value).collect()
}

/// Returns the phases of a plan whose yellow and all-red are rounded in the simulation, with what ran.
fn simulated(plan: &ExistingPlan) -> String {
    let (timed, _) = schedule(plan);
    let of = |phase: &PlanPhase| {
        let at = plan.phases.iter().position(|other| other.number == phase.number)?;
        let change_s = phase.change_s();
        let Change { yellow_s, all_red_s } = match plan.control {
            // Other methods keep to the limits.
            _ if plan.ways.is_empty() => Change::holding(change_s),
            Control::Actuated => Change::of(nearest_s(change_s.iter().sum()), change_s),
            Control::Pretimed | Control::Coordinated => timed[at].change,
        };
        let is_rounded = change_s != [yellow_s, all_red_s].map(f64::from);
        is_rounded.then(|| format!("{}: {yellow_s} + {all_red_s} s", phase.label()))
    };
    in_order(plan).into_iter().filter_map(of).collect::<Vec<_>>().join(", ")
}

/// Says over which legs the WALK of each phase is, by the rules of the simulation, and which turns with the right of way yield
/// there: the left turn of a T's stem, and a right turn out of the leg.
fn walks(told: &Told, drawn: &DrawnIntersection, limits: &SignalSettings) -> String {
    let (side, timing) = (drawn.side(), drawn.timing(limits));
    let arms: Vec<&DrawnArm> = drawn.incoming().collect();
    let mut plan = ExistingPlan { ways: told.ways.clone(), ..told.plan.clone() };
    let states = drawn.states(&plan);
    let walking: Vec<Option<String>> =
        plan.phases.iter().zip(&states).map(|(p, s)| p.walk_s.map(|_| s.clone())).collect();
    plan.phases.iter_mut().for_each(|phase| phase.yielding.clear());
    let protected = drawn.states(&plan);
    let serves = |p: usize, c: usize| {
        let letters = states[p].chars().zip(protected[p].chars());
        let state: String = letters.map(|(all, own)| if all == own { all } else { 'g' }).collect();
        timing.serves_crossing(&state, c)
    };
    let yields = |name: &&String, c: usize| {
        let turn = Heading::of_movement(name, side).map(|(_, turn)| on_side(turn, side));
        let ways = told.ways.get(*name).map_or(&[][..], Vec::as_slice);
        let from = arms.iter().find(|arm| ways.iter().any(|(from, _)| *from == arm.edge));
        let degrees = |arm: &DrawnArm| side.bearing_deg(arm.bearing_deg);
        from.is_some_and(|from| match turn {
            Some(Turn::Left) => LEFT_DEG.contains(&turn_degrees(degrees(from), degrees(arms[c]))),
            turn => turn == Some(Turn::Right) && from.edge == arms[c].edge,
        })
    };
    let of_phase = |phase: &PlanPhase| {
        let p = plan.phases.iter().position(|other| other.number == phase.number)?;
        let walks = |c: &usize| timing.walker(&walking, *c) == Some(p);
        let is_own = |c: &usize| if told.is_stages { serves(p, *c) } else { walks(c) };
        let leg = |c: usize| {
            let own = phase.movements.iter().filter(|name| yields(name, c));
            let own: Vec<&str> = own.map(String::as_str).collect();
            let note = format!(" (no arrow for {}: people go first)", own.join(", "));
            let leg = LEGS[(arms[c].bearing_deg / 45.0).round() as usize % LEGS.len()];
            format!("{leg}{}", if own.is_empty() { "" } else { &note })
        };
        phase.walk_s?;
        let legs: Vec<String> = (0..timing.crossings()).filter(is_own).map(leg).collect();
        let none = legs.is_empty().then_some("no leg of its own");
        Some(format!("phase {}: {}", phase.label(), none.unwrap_or(&legs.join(", "))))
    };
    in_order(&plan).into_iter().filter_map(of_phase).collect::<Vec<_>>().join("; ")
}

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

fn page_name(seen: Seen<'_>, point: usize) -> String {
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
    let mut left_out = Vec::new();
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
    // Where no intersection has a number, nobody came from UTDF.
    if has_numbers && !left_out.is_empty() {
        let more = if left_out.len() > FEW_NAMES { ", ..." } else { "" };
        left_out.truncate(FEW_NAMES);
        notes.push(format!("no UTDF of plans that it cannot say ({}{more})", left_out.join(", ")));
    }
    Ok(())
}

/// Returns what every page shows of a plan.
pub(crate) fn plan(seen: Seen<'_>, told: &Told) -> Value {
    let identity = &seen.data.manifest.identity;
    let drawn = seen.shown.drawing(&identity.points[told.point].point);
    let limits = identity.settings.get("signal").cloned().unwrap_or_default();
    let limits = serde_json::from_value(limits).ok();
    context! {
        method => identity.methods[told.method].as_str(),
        of => of_plan(&told.plan),
        phases => phases(&told.plan),
        rings => rings(&told.plan),
        simulated => simulated(&told.plan),
        walks => drawn.zip(limits.as_ref()).map(|(drawn, limits)| walks(told, drawn, limits)),
        is_stages => told.is_stages,
        checks => in_words(&checks(seen, told)),
        hides_walk => hides_walk(&told.plan),
    }
}

/// Returns what the page of an intersection shows.
fn page(seen: Seen<'_>, point: usize, own: &[&Told]) -> Value {
    let Seen { data, shown } = seen;
    let identity = &data.manifest.identity;
    let row = &data.points[point].row;
    let plans = own.iter().map(|told| {
        let trainings = shown.training(data, point, told.method).map_or(1, |(_, count)| count);
        context! {
            // Of the training whose plan it is.
            delay_s => told.objective.map(|delay_s| format!("{delay_s:.1}")),
            training => (trainings > 1).then(|| format!("training {} of {trainings}", told.replicate + 1)),
            signal => (!told.is_alone).then_some(told.signal.as_str()),
            is_coordinated => told.plan.control == Control::Coordinated,
            unserved_people => unserved_people(&told.plan).join(", "),
            has_detectors => told.plan.phases.iter().any(|phase| !phase.detectors.is_empty()),
            is_today => identity.methods[told.method] == existing::METHOD.name,
            is_retimed => identity.methods[told.method] == retime::METHOD.name,
            is_given => !told.plan.ways.is_empty(),
            ..plan(seen, told)
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
            let mut add = |phase: Option<&PlanPhase>, split_s: f64, barrier: bool| {
                boxes.push(context! {
                    number => phase.map(PlanPhase::label),
                    names => phase.map(|p| p.all_movements().cloned().collect::<Vec<_>>().join(" ")),
                    split => phase.map(|p| seconds(p.split_s())),
                    percent => format!("{:.2}", 100.0 * split_s / total_s),
                    barrier,
                });
            };
            for (side, whole_s) in sides.iter().zip(&side_s) {
                let own = &side[ring];
                let mut left_s = *whole_s;
                for (place, index) in own.iter().enumerate() {
                    let phase = &plan.phases[*index];
                    let is_last = place + 1 == own.len();
                    // A ring that is done waits for the other one.
                    let split_s = if is_last { left_s } else { phase.split_s() };
                    left_s -= split_s;
                    add(Some(phase), split_s, is_last);
                }
                if own.is_empty() {
                    add(None, *whole_s, true);
                }
            }
            boxes
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::told::tests::phase;
    use super::*;

    #[test]
    fn each_walk_has_its_legs_and_the_turns_that_yield_there() {
        let phase = |(number, movements, yielding): (u32, &str, &str)| {
            let [movements, yielding] = [movements, yielding]
                .map(|names| names.split_whitespace().map(str::to_owned).collect());
            let walk_s = (number % 2 == 0).then_some([7.0, 12.0]);
            PlanPhase { number, position: number, movements, yielding, walk_s, ..phase() }
        };
        let arm = |(bearing_deg, lanes): (f64, &[&str])| DrawnArm {
            edge: format!("{bearing_deg}"),
            bearing_deg,
            lanes: lanes.iter().map(|turns| (*turns).to_owned()).collect(),
            lanes_out: 1,
            speed_mph: 30.0,
            ..DrawnArm::default()
        };
        let arms: [(f64, &[&str]); 3] =
            [(90.0, &["s", "l"]), (180.0, &["r", "l"]), (270.0, &["sr"])];
        let drawn =
            DrawnIntersection { arms: arms.map(arm).to_vec(), ..DrawnIntersection::default() };
        let from = [
            ("WBL", "90"),
            ("WBT", "90"),
            ("NBL", "180"),
            ("NBR", "180"),
            ("EBT", "270"),
            ("EBR", "270"),
        ];
        let way =
            |(name, from): (&str, &str)| (name.to_owned(), vec![(from.to_owned(), String::new())]);
        let limits = SignalSettings { pedestrians: true, ..SignalSettings::default() };
        let told = |phases: [(u32, &str, &str); 3], is_stages: bool| Told {
            method: 0,
            point: 0,
            replicate: 0,
            objective: None,
            signal: String::new(),
            plan: ExistingPlan::new(Control::Pretimed, phases.map(phase).to_vec()),
            ways: from.map(way).into(),
            is_stages,
            is_alone: true,
        };
        let rings = told([(1, "WBL", ""), (2, "EBT EBR", ""), (8, "NBL NBR", "")], false);
        let stem = "phase 8: east, west (no arrow for NBL: people go first)";
        assert_eq!(walks(&rings, &drawn, &limits), format!("phase 2: south; {stem}"));
        let stages =
            told([(1, "WBL WBT", ""), (2, "EBT EBR WBT", "WBL"), (8, "NBL NBR EBR", "")], true);
        let stem = stem.replace("NBL", "NBL, EBR");
        assert_eq!(walks(&stages, &drawn, &limits), format!("phase 2: south; {stem}"));
    }

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

//! Results by movement: `movements.csv`, and a table on the page where there are few intersections.
//!
//! Levels of service are those of the simulator's delay, and F where the volume of the lane group exceeds its capacity, as in
//! the Highway Capacity Manual (chapter 19).
//!
//! Deviation: the manual has control delay; the simulator's also contains slowing down and waiting to enter.

use minijinja::{Value, context};
use osm_signals::DrivingSide;
use serde_json::Value as Json;

use super::answers::today;
use super::capacity::{Basis, Capacity};
use super::demand::{HOUR_S, horizon_s};
use super::level_of_service::letter;
use super::shown::{OfTask, Seen};
use basics::units::FOOT_M;
use evaluation::analysis::Analysis;
use evaluation::report::table::{Cell, Columns};
use signals::movement_results::MovementResult;
use signals::places::DrawnIntersection;

/// Name of the table in the report's folder.
pub(crate) const TABLE: &str = "movements.csv";

/// Most intersections whose movements the page shows.
const FEW: usize = 12;

/// Street that a vehicle of a queue takes, metres (HCM: 25 ft).
const VEHICLE_M: f64 = 7.6;

/// Speed limits in miles per hour are multiples of this.
const ROUND_MPH: f64 = 5.0;

/// Share of unfinished vehicles from which on a movement is marked: more arrive than leave.
const UNSERVED: f64 = 0.1;

/// Returns the table of all movements.
pub(crate) fn table(seen: Seen<'_>) -> String {
    type Row<'a> = (&'a OfTask<Vec<MovementResult>>, &'a MovementResult, Option<Capacity>);
    let Seen { data, shown } = seen;
    let (identity, hours) = (&data.manifest.identity, hours(data));
    let titles = shown.titles(data);
    let rows = shown.movements.iter().flat_map(|task| {
        let capacities = basis(data).map(|basis| basis.capacities(&task.results));
        let capacity = move |i: usize| capacities.as_ref().and_then(|all| all[i]);
        task.results.iter().enumerate().map(move |(i, m)| (task, m, capacity(i)))
    });
    let green =
        |m: &MovementResult| m.supply.as_ref().map(|s| s.protected_share + s.permissive_share);
    let mut columns = Columns::new()
        .text("point", "", |(task, ..): &Row<'_>| identity.points[task.point].point.clone())
        .text("method", "", |(task, ..)| identity.methods[task.method].clone())
        .file("replicate", |(task, ..)| Cell::count(task.replicate as usize))
        .text("movement", "", |(_, m, _)| m.movement.clone())
        .text("from_edge", "", |(_, m, _)| m.from.clone())
        .text("to_edge", "", |(_, m, _)| m.to.clone())
        .file("volume_vph", move |(_, m, _)| Cell::exact(m.vehicles_veh / hours))
        .file("delay_s", |(_, m, _)| Cell::exact(m.delay_s))
        .text("level_of_service", "", |(_, m, c)| {
            level(m, *c).map(String::from).unwrap_or_default()
        })
        .file("stops_per_veh", |(_, m, _)| Cell::exact(m.stops))
        .file("unfinished_share", |(_, m, _)| Cell::exact(unfinished(m)))
        .file("queue_50_veh", |(_, m, _)| Cell::exact(m.queue_50_veh))
        .file("queue_95_veh", |(_, m, _)| Cell::exact(m.queue_95_veh))
        .text("lane_group", "", |(_, m, _)| {
            m.supply.as_ref().map(|s| s.group.clone()).unwrap_or_default()
        })
        .file("green_share", move |(_, m, _)| Cell::exact(green(m)))
        .file("capacity_vph", |(.., c)| Cell::exact(c.and_then(|c| c.group_vph)))
        .file("v_c", |(.., c)| Cell::exact(c.map(|c| c.ratio).filter(|ratio| ratio.is_finite())))
        .file("hcm_delay_s", |(.., c)| Cell::exact(c.and_then(|c| c.delay_s)))
        .file("storage_m", |(_, m, _)| Cell::exact(m.storage_m))
        .file("queue_storage_ratio", |(_, m, _)| Cell::exact(queue_ratio(m)));
    // Only where people on foot count.
    if shown.movements.iter().flat_map(|t| &t.results).any(|m| m.crosswalk_delay_s.is_some()) {
        columns = columns.file("crosswalk_delay_s", |(_, m, _)| Cell::exact(m.crosswalk_delay_s));
    }
    if let Some(titles) = &titles {
        columns = columns.text("title", "", |(task, ..)| titles[task.point].clone());
    }
    columns.table(rows).csv()
}

/// Returns the section on movements; undefined where no record has them.
pub(crate) fn values(seen: Seen<'_>) -> Option<Value> {
    let Seen { data, shown } = seen;
    shown.movements.first()?;
    let identity = &data.manifest.identity;
    let many = data.points.len() > FEW;
    let pages = super::pages::links(seen);
    let points: Vec<Value> = (0..data.points.len())
        .filter(|_| !many)
        .filter_map(|p| point(seen, p, pages.get(&p).map(String::as_str)))
        .collect();
    Some(context! {
        points,
        many,
        few => FEW,
        chosen => data.points.len(),
        baseline => identity.baseline.as_str(),
        saturation => basis(data).map(|basis| basis.saturation_vph),
    })
}

/// Returns the movements of an intersection under the best method, and under what is done today or else the baseline.
/// * `page` — where the page of the intersection is, if it has one.
pub(crate) fn point(seen: Seen<'_>, point: usize, page: Option<&str>) -> Option<Value> {
    let Seen { data, shown } = seen;
    let identity = &data.manifest.identity;
    let of = |method: usize| {
        let replicate = shown.training(data, point, method)?.0.replicate;
        let is = |t: &&OfTask<Vec<MovementResult>>| {
            (t.point, t.method, t.replicate) == (point, method, replicate)
        };
        shown.movements.iter().find(is)
    };
    let best = data.winners[point].as_ref().map(|winner| winner.best)?;
    let rival = today(data).unwrap_or(&identity.baseline);
    let rival = identity.methods.iter().position(|m| *m == rival);
    let compared: Vec<usize> = [Some(best), rival.filter(|b| *b != best)]
        .into_iter()
        .flatten()
        .filter(|m| of(*m).is_some())
        .collect();
    let all = of(*compared.first()?)?;
    let hours = hours(data);
    let in_feet = shown.drawing(&data.points[point].row.point).is_some_and(has_miles);
    let capacities: Vec<Option<Vec<Option<Capacity>>>> = (compared.iter())
        .map(|method| Some(basis(data)?.capacities(&of(*method)?.results)))
        .collect();
    let rows: Vec<Value> = all
        .results
        .iter()
        .map(|m| {
            let cells = compared.iter().zip(&capacities).map(|(method, capacities)| {
                let own = of(*method).and_then(|task| {
                    let mut all = task.results.iter().enumerate();
                    all.find(|(_, r)| (&r.from, &r.to) == (&m.from, &m.to))
                });
                own.map(|(i, own)| {
                    let capacity = capacities.as_ref().and_then(|all| all[i]);
                    let unserved = unfinished(own).is_some_and(|share| share > UNSERVED);
                    context! {
                        delay => own.delay_s.map(|s| format!("{s:.1}")),
                        level => level(own, capacity).map(|level| level.to_string()),
                        ratio => capacity.map_or_else(|| "-".to_owned(), |c| ratio_text(c.ratio)),
                        stops => own.stops.map(|stops| format!("{stops:.2}")),
                        queue => format!("{:.0}", own.queue_95_veh),
                        queue_m => length(own.queue_95_veh * VEHICLE_M, in_feet),
                        spills => queue_ratio(own).is_some_and(|ratio| ratio > 1.0),
                        unserved,
                    }
                })
            });
            context! {
                movement => m.movement.as_str(),
                volume => format!("{:.0}", m.vehicles_veh / hours),
                storage => m.storage_m.map(|length_m| length(length_m, in_feet)),
                cells => cells.collect::<Vec<_>>(),
            }
        })
        .collect();
    let called = |method: &usize| {
        let name = identity.methods[*method].clone();
        match shown.training(data, point, *method) {
            Some((task, count)) if count > 1 => {
                format!("{name}, training {} of {count}, the best", task.replicate + 1)
            }
            _ => name,
        }
    };
    let names: Vec<String> = compared.iter().map(called).collect();
    Some(context! {
        title => shown.title(&data.points[point].row),
        names,
        rows,
        page,
        in_feet,
    })
}

/// Whether the speed limits of an intersection are round numbers of miles per hour, as where lengths are feet.
fn has_miles(drawn: &DrawnIntersection) -> bool {
    let is_round = |mph: f64| (mph / ROUND_MPH - (mph / ROUND_MPH).round()).abs() < 0.01;
    drawn.arms.iter().all(|arm| is_round(arm.speed_mph))
}

/// Says a length in metres, and in feet in brackets.
fn length(length_m: f64, in_feet: bool) -> String {
    match in_feet {
        true => format!("{length_m:.0} ({:.0})", length_m / FOOT_M),
        false => format!("{length_m:.0}"),
    }
}

/// Returns the level of service of a movement: F where its lane group is above capacity.
fn level(movement: &MovementResult, capacity: Option<Capacity>) -> Option<char> {
    let delay_s = movement.delay_s?;
    Some(if capacity.is_some_and(|c| c.ratio > 1.0) { 'F' } else { letter(delay_s) })
}

fn ratio_text(ratio: f64) -> String {
    if ratio.is_finite() { format!("{ratio:.2}") } else { "no green".to_owned() }
}

/// Returns the queue that is not exceeded for 95% of the time as a share of the storage length; `None` without one.
///
/// Deviation: the manual has the 95% back of queue per cycle, which is longer. It is not recorded.
fn queue_ratio(movement: &MovementResult) -> Option<f64> {
    Some(movement.queue_95_veh * VEHICLE_M / movement.storage_m?)
}

/// Returns what capacities are computed with; `None` where the settings do not say it.
pub(crate) fn basis(data: &Analysis) -> Option<Basis> {
    let settings = &data.manifest.identity.settings;
    let saturation_vph = settings.pointer("/fixed_time/saturation_flow_vph")?.as_f64()?;
    let side = settings.pointer("/network/driving_side").and_then(Json::as_str);
    let side = if side == Some("left") { DrivingSide::Left } else { DrivingSide::Right };
    Some(Basis { saturation_vph, hours: hours(data), side })
}

fn unfinished(movement: &MovementResult) -> Option<f64> {
    (movement.vehicles_veh > 0.0).then(|| movement.unfinished_veh / movement.vehicles_veh)
}

fn hours(data: &Analysis) -> f64 {
    horizon_s(&data.manifest.identity).unwrap_or(HOUR_S) / HOUR_S
}

#[cfg(test)]
mod tests {
    use signals::places::DrawnArm;

    use super::*;

    #[test]
    fn lengths_are_in_feet_too_where_speed_limits_are_miles_per_hour() {
        let has = |speeds_mph: [f64; 2]| {
            let arm = |speed_mph: f64| DrawnArm { speed_mph, ..DrawnArm::default() };
            let arms = speeds_mph.map(arm).to_vec();
            has_miles(&DrawnIntersection { arms, ..DrawnIntersection::default() })
        };
        assert!(has([30.0, 40.000_001]));
        // 50 and 80 km/h.
        assert!(!has([31.07, 30.0]) && !has([49.71, 49.71]));
        assert_eq!(length(45.72, true), "46 (150)");
        assert_eq!(length(45.72, false), "46");
    }
}

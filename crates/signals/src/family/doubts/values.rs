//! Values of a table of approaches that are implausible for their column, with the unit that they may be in.

use super::doubt::{Doubt, at_line, median};
use crate::family::approaches::{Approach, Intersection};
use basics::units::{FOOT_M, KMH_TO_MPH, MPS_PER_MPH};

/// Speed limit above which no approach of a signal is expected, miles per hour: MUTCD's tables for signals end
/// at 70.
const FAST_MPH: f64 = 70.0;

/// Median of speed limits that no city has in miles per hour, and the other way round in metres per second.
const MEDIAN_MPH: (f64, f64) = (15.0, 50.0);

/// Most of an approach's length, metres: junctions of a city are not farther apart.
const LONG_M: f64 = 3000.0;

/// Length of an approach on which hardly a car waits, metres.
const SHORT_M: f64 = 15.0;

/// Speed limit below which no street with signals is signed, miles per hour.
const SLOW_MPH: f64 = 10.0;

/// Traffic that no lane carries, vehicles per day (`osm_signals::counts::CountSettings`).
const BUSY_PER_LANE: f64 = 25_000.0;

/// Median above which counts are those of all lanes, vehicles per day and lane.
const MEDIAN_BUSY: f64 = 12_000.0;

/// Median below which counts are in thousands, vehicles per day and lane: FHWA's quietest urban streets have
/// 40 to 350 (Highway Functional Classification, 2013, table 3-6).
const MEDIAN_THOUSANDS: f64 = 100.0;

/// Median on streets of four lanes or more below which counts are those of an hour, vehicles per day and lane:
/// of those in Salt Lake City 99% have more than 660, and the median is 5,100.
const MEDIAN_HOURLY: f64 = 900.0;

/// Lanes of both directions of a street that carries much.
const WIDE: u32 = 4;

/// Flow that no lane carries, vehicles per hour: the base saturation flow of the Highway Capacity Manual, without any
/// red.
const MOST_VPH_PER_LANE: f64 = 1900.0;

/// Least rows of which a median tells a unit.
const ENOUGH: usize = 3;

/// Returns the doubts.
pub(super) fn values(intersections: &[Intersection]) -> Vec<Doubt> {
    let approaches: Vec<&Approach> =
        intersections.iter().flat_map(|i| &i.arms).filter(|a| a.lanes_in > 0).collect();
    let named: Vec<(String, f64)> =
        approaches.iter().map(|a| (format!("line {}", a.line), a.speed_mph)).collect();
    let mut doubts = speeds(&named);
    let rows = |is: Said<'_>| -> Vec<String> {
        approaches.iter().filter_map(|a| is(a).map(|text| at_line(a.line, text))).collect()
    };
    let long = rows(&|a| (a.length_m > LONG_M).then(|| format!("{} m", a.length_m)));
    doubts.extend(Doubt::of(
        format!("length_m above {LONG_M}: if it is in feet, multiply the column by {FOOT_M}"),
        long,
    ));
    let short = rows(&|a| (a.length_m < SHORT_M).then(|| format!("{} m", a.length_m)));
    doubts.extend(match short.len() >= ENOUGH && 2 * short.len() > approaches.len() {
        true => Some(Doubt::whole(format!(
            "length_m: more than half of the approaches are shorter than {SHORT_M} m; if the column is in km, multiply it by 1000"
        ))),
        false => Doubt::of(format!("length_m below {SHORT_M}, where hardly a car waits"), short),
    });
    doubts.extend(counts(&approaches, &rows));
    doubts.extend(volumes(&approaches, &rows));
    let without: Vec<&&Approach> = approaches.iter().filter(|a| !a.movements.is_empty()).collect();
    if without.len() >= ENOUGH && without.iter().all(|a| !a.movements.contains('s')) {
        doubts.push(Doubt::whole(
            "movements: nobody goes straight on at any approach; the letter for it is s or t",
        ));
    }
    doubts
}

/// Returns the doubts about vehicles that were counted by turn.
fn volumes(approaches: &[&Approach], rows: &dyn Fn(Said<'_>) -> Vec<String>) -> Vec<Doubt> {
    let per_lane = |a: &Approach| a.counted.map(|c| c.total_vph() / f64::from(a.lanes_in));
    let all: Vec<f64> = approaches.iter().filter_map(|a| per_lane(a)).collect();
    let middle = if all.len() < ENOUGH { None } else { median(all) };
    if let Some(middle) = middle.filter(|middle| *middle > MOST_VPH_PER_LANE) {
        return vec![Doubt::whole(format!(
            "left_vph, through_vph, right_vph: half of the approaches have {middle:.0} vehicles per hour and lane or \
             more, which no lane carries; if they are of a day, give those of an hour"
        ))];
    }
    let doubts = [
        Doubt::of(
            format!(
                "counted volumes above {MOST_VPH_PER_LANE} vehicles per hour and lane, which no lane carries: queues \
                 grow as long as the hour lasts"
            ),
            rows(&|a| {
                let vph = per_lane(a).filter(|vph| *vph > MOST_VPH_PER_LANE);
                vph.map(|vph| format!("{vph:.0} veh/h per lane"))
            }),
        ),
        Doubt::of(
            "nobody was counted on an approach",
            rows(&|a| per_lane(a).filter(|vph| *vph == 0.0).map(|_| format!("arm {}", a.arm))),
        ),
    ];
    doubts.into_iter().flatten().collect()
}

/// Returns the doubts about speed limits, each with the name of its row.
pub(super) fn speeds(named: &[(String, f64)]) -> Vec<Doubt> {
    let all: Vec<f64> = named.iter().map(|(_, mph)| *mph).collect();
    let enough = all.len() >= ENOUGH;
    let (slow, fast) = MEDIAN_MPH;
    let middle = median(all).filter(|_| enough);
    if middle.is_some_and(|middle| middle >= fast) {
        return vec![Doubt::whole(format!(
            "speed_mph: half of the approaches have {fast} mph or more, which hardly any street with signals has; \
             if the column is in km/h, multiply it by {KMH_TO_MPH}"
        ))];
    }
    if middle.is_some_and(|middle| middle < slow) {
        return vec![Doubt::whole(format!(
            "speed_mph: half of the approaches have less than {slow} mph; if the column is in m/s, multiply it by {:.6}",
            1.0 / MPS_PER_MPH
        ))];
    }
    let rows = |is: &dyn Fn(f64) -> bool| {
        let found = named.iter().filter(|(_, mph)| is(*mph));
        found.map(|(row, mph)| format!("{row}: {mph} mph")).collect()
    };
    let doubts = [
        Doubt::of(
            format!(
                "speed_mph above {FAST_MPH}, which no street with signals has; if it is in km/h, multiply it by {KMH_TO_MPH}"
            ),
            rows(&|mph| mph > FAST_MPH),
        ),
        Doubt::of(
            format!("speed_mph below {SLOW_MPH}, which no street with signals has"),
            rows(&|mph| mph < SLOW_MPH),
        ),
    ];
    doubts.into_iter().flatten().collect()
}

/// What is said of an approach, if anything.
type Said<'a> = &'a dyn Fn(&Approach) -> Option<String>;

fn counts(approaches: &[&Approach], rows: &dyn Fn(Said<'_>) -> Vec<String>) -> Vec<Doubt> {
    let lanes = |a: &Approach| a.lanes_in + a.lanes_out;
    let of = |is: &dyn Fn(&Approach) -> bool| -> Vec<f64> {
        let counted = approaches.iter().filter(|a| !a.imputed && a.counted.is_none() && is(a));
        counted.map(|a| a.aadt_veh_per_day_per_lane).collect()
    };
    let middle = |values: Vec<f64>| if values.len() < ENOUGH { None } else { median(values) };
    let column = "aadt_veh_per_day_per_lane";
    let all = middle(of(&|_| true));
    if let Some(middle) = all.filter(|middle| *middle < MEDIAN_THOUSANDS) {
        return vec![Doubt::whole(format!(
            "{column}: half of the approaches have {middle} vehicles a day and lane or less; if the counts are in \
             thousands, multiply them by 1000"
        ))];
    }
    let wide = middle(of(&|a| lanes(a) >= WIDE));
    if let Some(middle) = wide.filter(|middle| *middle < MEDIAN_HOURLY) {
        return vec![Doubt::whole(format!(
            "{column}: half of the approaches of streets with {WIDE} lanes or more have {middle} vehicles a day and lane \
             or less; if these are counts of an hour, divide them by the hour's share of the day \
             (family.hourly_share)"
        ))];
    }
    if let Some(middle) = all.filter(|middle| *middle > MEDIAN_BUSY) {
        return vec![Doubt::whole(format!(
            "{column}: half of the approaches have {middle} vehicles a day and lane or more; if these are counts of \
             all lanes, divide each by twice its lanes_in, on a one-way street by lanes_in"
        ))];
    }
    let busy = rows(&|a| {
        let per_lane = a.aadt_veh_per_day_per_lane;
        (per_lane > BUSY_PER_LANE).then(|| format!("{per_lane} veh/day per lane"))
    });
    let about = format!(
        "{column} above {BUSY_PER_LANE}, which no lane carries; a count of all lanes has to be divided by twice its \
         lanes_in, on a one-way street by lanes_in"
    );
    Doubt::of(about, busy).into_iter().collect()
}

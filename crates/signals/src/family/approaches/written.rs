//! Writes tables of approaches.

use std::collections::BTreeMap;

use basics::files::lines;

use super::{Approach, Arrivals, Counted, Intersection};

/// Digits after the point of what was counted, as a power of ten: means of several days have any number.
const COUNT: f64 = 100.0;

/// Digits after the point of a share, as a power of ten.
const SHARE: f64 = 1e4;

/// A column with its group. Optional groups, from 1, are written where a row has anything in one of their columns.
pub(super) type Column = (usize, &'static str, fn(&Approach) -> String);

pub(super) const WRITTEN: [Column; 24] = [
    (0, "intersection", |a| a.intersection.clone()),
    (0, "arm", |a| a.arm.clone()),
    (0, "latitude", |a| known(a.latitude)),
    (0, "longitude", |a| known(a.longitude)),
    (0, "bearing_deg", |a| format!("{:?}", a.bearing_deg)),
    (0, "lanes_in", |a| a.lanes_in.to_string()),
    (0, "lanes_out", |a| a.lanes_out.to_string()),
    (0, "left_turn_lanes", |a| a.left_turn_lanes.to_string()),
    (0, "right_turn_lanes", |a| a.right_turn_lanes.to_string()),
    (0, "speed_mph", |a| format!("{:?}", a.speed_mph)),
    (0, "length_m", |a| format!("{:?}", a.length_m)),
    (0, "aadt_veh_per_day_per_lane", |a| {
        let is_none = a.imputed || a.counted.is_some() && a.aadt_veh_per_day_per_lane == 0.0;
        if is_none { String::new() } else { format!("{:?}", a.aadt_veh_per_day_per_lane) }
    }),
    (0, "movements", |a| a.movements.clone()),
    (1, "left_storage_m", |a| a.left_storage_m.map_or_else(String::new, known)),
    (1, "right_storage_m", |a| a.right_storage_m.map_or_else(String::new, known)),
    (2, "period", |a| a.period.clone()),
    (3, "left_vph", |a| counted(a, |c| Some(number(c.left_vph)))),
    (3, "through_vph", |a| counted(a, |c| Some(number(c.through_vph)))),
    (3, "right_vph", |a| counted(a, |c| Some(number(c.right_vph)))),
    (3, "peak_hour_factor", |a| {
        counted(a, |c| match c.arrivals? {
            Arrivals::PeakHourFactor(factor) => Some(factor.to_string()),
            Arrivals::QuarterHours(_) => None,
        })
    }),
    (3, "quarter_hours", |a| {
        counted(a, |c| match c.arrivals? {
            Arrivals::PeakHourFactor(_) => None,
            Arrivals::QuarterHours(quarters) => Some(quarters.map(number).join(" ")),
        })
    }),
    (3, "heavy_vehicles", |a| {
        counted(a, |c| Some(((c.heavy_vehicles? * SHARE).round() / SHARE).to_string()))
    }),
    (4, "pedestrians_per_h", |a| counted(a, |c| c.pedestrians_per_h.map(number))),
    (5, "exits_vph", |a| {
        counted(a, |c| {
            let exits_vph = c.exits_vph?;
            // Without those at the end that have none.
            let used = exits_vph.iter().rposition(|vph| *vph > 0.0).map_or(1, |last| last + 1);
            Some(exits_vph[..used].iter().map(|vph| number(*vph)).collect::<Vec<_>>().join(" "))
        })
    }),
];

/// Returns a table of approaches as CSV, with the optional columns that any row uses. A count that is missing stays
/// empty.
pub fn to_csv(rows: &[Approach]) -> String {
    let has = |(_, _, cell): &Column| rows.iter().any(|row| !cell(row).is_empty());
    let is_used = |group: usize| WRITTEN.iter().any(|column| column.0 == group && has(column));
    let columns: Vec<&Column> =
        WRITTEN.iter().filter(|(group, ..)| *group == 0 || is_used(*group)).collect();
    let mut table = vec![columns.iter().map(|(_, name, _)| (*name).to_owned()).collect()];
    table.extend(
        rows.iter().map(|row| columns.iter().map(|(.., cell)| cell(row)).collect::<Vec<_>>()),
    );
    String::from_utf8(lines(&table)).expect("texts are UTF-8")
}

fn known(value: f64) -> String {
    if value.is_nan() { String::new() } else { format!("{value:?}") }
}

fn number(value: f64) -> String {
    ((value * COUNT).round() / COUNT).to_string()
}

fn counted(approach: &Approach, text: fn(Counted) -> Option<String>) -> String {
    approach.counted.and_then(text).unwrap_or_default()
}

/// Returns the intersections of complete rows, in the order of their first arms.
pub fn gathered(rows: Vec<Approach>) -> Vec<Intersection> {
    let mut intersections: Vec<Intersection> = Vec::new();
    let mut position: BTreeMap<(String, String), usize> = BTreeMap::new();
    for row in rows {
        let at =
            *position.entry((row.intersection.clone(), row.period.clone())).or_insert_with(|| {
                intersections.push(Intersection {
                    id: row.intersection.clone(),
                    period: row.period.clone(),
                    latitude: row.latitude,
                    longitude: row.longitude,
                    arms: Vec::new(),
                    imputed: 0,
                    line: row.line,
                });
                intersections.len() - 1
            });
        intersections[at].imputed += u32::from(row.imputed);
        intersections[at].arms.push(row);
    }
    intersections
}

#[cfg(test)]
mod tests {
    use super::super::read;
    use super::*;

    #[test]
    fn what_is_written_reads_back_as_the_same() {
        let header = "intersection,arm,latitude,longitude,bearing_deg,lanes_in,lanes_out,left_turn_lanes,\
            right_turn_lanes,speed_mph,length_m,aadt_veh_per_day_per_lane,movements";
        let plain = format!(
            "{header}\n7,A,40.125,-111.0,0.0,2,1,1,0,30.0,200.5,9000.0,lsr\n7,B,40.125,-111.0,90.0,0,2,0,0,30.0,90.0,0.0,\n"
        );
        let intersections = read(&plain, "a.csv").unwrap();
        let rows: Vec<Approach> = intersections.iter().flat_map(|i| i.arms.clone()).collect();
        assert_eq!(to_csv(&rows), plain);
        assert_eq!(gathered(rows), intersections);
        let storage = plain
            .replace("movements\n", "movements,left_storage_m,right_storage_m\n")
            .replace("lsr\n", "lsr,45.7,\n")
            .replace("0.0,\n", "0.0,,,\n");
        let rows: Vec<Approach> = read(&storage, "a.csv").unwrap().remove(0).arms;
        assert_eq!((to_csv(&rows), rows[0].left_storage_m), (storage, Some(45.7)));
        let counted = format!(
            "{header},period,left_vph,through_vph,right_vph,peak_hour_factor,quarter_hours,heavy_vehicles\n\
             7,A,,,0.0,2,1,1,0,30.0,200.5,,lsr,am,1,2.33,0,,1 1 1 0.33,0.05\n7,B,,,90.0,2,2,0,0,30.0,90.0,,,am,0,5,0,0.92,,\n"
        );
        let rows: Vec<Approach> = read(&counted, "a.csv").unwrap().remove(0).arms;
        assert_eq!(to_csv(&rows), counted);
        let walked = counted
            .replace("heavy_vehicles\n", "heavy_vehicles,pedestrians_per_h\n")
            .replace("0.05\n", "0.05,62.5\n")
            .replace("0.92,,\n", "0.92,,,\n");
        let rows: Vec<Approach> = read(&walked, "a.csv").unwrap().remove(0).arms;
        assert_eq!(to_csv(&rows), walked);
        let by_exit = counted
            .replace("heavy_vehicles\n", "heavy_vehicles,exits_vph\n")
            .replace("0.05\n", "0.05,0 1 2.33\n")
            .replace("0.92,,\n", "0.92,,,\n");
        let rows: Vec<Approach> = read(&by_exit, "a.csv").unwrap().remove(0).arms;
        assert_eq!(to_csv(&rows), by_exit);
        let computed = plain.replace("7,A", "'=1+1,'@A").replace("7,B", "'=1+1,-B");
        let rows: Vec<Approach> = read(&computed, "a.csv").unwrap().remove(0).arms;
        let names = [&rows[0].intersection, &rows[0].arm, &rows[1].arm];
        assert_eq!(names, ["=1+1", "@A", "-B"]);
        assert_eq!(to_csv(&rows), computed.replace(",-B", ",'-B"));
    }
}

//! Writes tables of approaches.

use std::collections::BTreeMap;

use basics::files::lines;

use super::{
    Approach, Arrivals, COLUMNS, EXITS, Intersection, MANNERS, MOST_EXITS, PEDESTRIANS, PERIOD,
    STORAGE, VOLUMES,
};

/// Digits after the point of what was counted, as a power of ten: means of several days have any number.
const COUNT: f64 = 100.0;

/// Returns a table of approaches as CSV, with the optional columns that any row uses. A count that is missing stays
/// empty.
pub fn to_csv(rows: &[Approach]) -> String {
    let has_period = rows.iter().any(|a| !a.period.is_empty());
    let has_counts = rows.iter().any(|a| a.counted.is_some());
    let walks = |a: &Approach| a.counted.and_then(|counted| counted.pedestrians_per_h);
    let has_pedestrians = rows.iter().any(|a| walks(a).is_some());
    let exits = |a: &Approach| a.counted.and_then(|counted| counted.exits_vph);
    let has_exits = rows.iter().any(|a| exits(a).is_some());
    let has_storage =
        rows.iter().any(|a| a.left_storage_m.is_some() || a.right_storage_m.is_some());
    let mut header = COLUMNS.to_vec();
    if has_storage {
        header.extend(STORAGE);
    }
    if has_period {
        header.push(PERIOD);
    }
    if has_counts {
        header.extend(VOLUMES.iter().chain(&MANNERS));
    }
    if has_pedestrians {
        header.push(PEDESTRIANS);
    }
    if has_exits {
        header.push(EXITS);
    }
    let mut table = vec![header.into_iter().map(str::to_owned).collect()];
    for a in rows {
        let place =
            |degrees: f64| if degrees.is_nan() { String::new() } else { format!("{degrees:?}") };
        let nothing = a.imputed || a.counted.is_some() && a.aadt_veh_per_day_per_lane == 0.0;
        let aadt =
            if nothing { String::new() } else { format!("{:?}", a.aadt_veh_per_day_per_lane) };
        let mut row = vec![
            a.intersection.clone(),
            a.arm.clone(),
            place(a.latitude),
            place(a.longitude),
            format!("{:?}", a.bearing_deg),
            a.lanes_in.to_string(),
            a.lanes_out.to_string(),
            a.left_turn_lanes.to_string(),
            a.right_turn_lanes.to_string(),
            format!("{:?}", a.speed_mph),
            format!("{:?}", a.length_m),
            aadt,
            a.movements.clone(),
        ];
        if has_storage {
            let length = |m: Option<f64>| m.map_or_else(String::new, |m| format!("{m:?}"));
            row.extend([a.left_storage_m, a.right_storage_m].map(length));
        }
        if has_period {
            row.push(a.period.clone());
        }
        if has_counts {
            row.extend(counted(a));
        }
        if has_pedestrians {
            let rounded = |per_h: f64| ((per_h * COUNT).round() / COUNT).to_string();
            row.push(walks(a).map_or_else(String::new, rounded));
        }
        if has_exits {
            row.push(exits(a).map_or_else(String::new, by_exit));
        }
        table.push(row);
    }
    String::from_utf8(lines(&table)).expect("texts are UTF-8")
}

fn counted(approach: &Approach) -> [String; VOLUMES.len() + MANNERS.len()] {
    let Some(counted) = &approach.counted else { return Default::default() };
    let number = |value: f64| ((value * COUNT).round() / COUNT).to_string();
    let (factor, quarters) = match counted.arrivals {
        None => Default::default(),
        Some(Arrivals::PeakHourFactor(factor)) => (factor.to_string(), String::new()),
        Some(Arrivals::QuarterHours(quarters)) => (String::new(), quarters.map(number).join(" ")),
    };
    let heavy = counted.heavy_vehicles.map(|share| ((share * 1e4).round() / 1e4).to_string());
    [
        number(counted.left_vph),
        number(counted.through_vph),
        number(counted.right_vph),
        factor,
        quarters,
        heavy.unwrap_or_default(),
    ]
}

/// Returns the vehicles to exits, without those at the end that have none.
fn by_exit(exits_vph: [f64; MOST_EXITS]) -> String {
    let used = exits_vph.iter().rposition(|vph| *vph > 0.0).map_or(1, |last| last + 1);
    let number = |vph: &f64| ((vph * COUNT).round() / COUNT).to_string();
    exits_vph[..used].iter().map(number).collect::<Vec<_>>().join(" ")
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

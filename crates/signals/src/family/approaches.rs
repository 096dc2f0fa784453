//! The approaches table: one row per arm of a real intersection.
//!
//! Columns, in any order: `intersection, arm, latitude, longitude, bearing_deg, lanes_in,
//! lanes_out, left_turn_lanes, right_turn_lanes, speed_mph, length_m,
//! aadt_veh_per_day_per_lane, movements`. An empty `aadt_veh_per_day_per_lane` is a count that is
//! missing and gets imputed; 0 is a count of no vehicle. What is believed although it is doubtful is named by
//! [`super::doubts`].
//!
//! Optional columns: the lengths of turn lanes ([`STORAGE`]), what was counted by turn ([`Counted`]), and the `period` of the day that the counts are of. An
//! intersection with rows of several periods is several point MDPs.

mod approach;
mod arms;
mod counted;
mod impute;
mod movements;
mod written;

use std::collections::BTreeSet;

use osm_signals::geometry::checked_place;
use osm_signals::intersections::MAX_LANES;
use sheet::{Fault, Row, Sheet};

pub use approach::{Approach, Intersection};
pub use arms::{ARMS, check_arms};
use basics::units::KMH_TO_MPH;
pub use counted::{Arrivals, Counted, MOST_EXITS, MOST_PEDESTRIANS_PER_H, MOST_VPH};
use evaluation::family::columns::{Columns, at};
use evaluation::family::error::FamilyError;
use evaluation::family::names::title;
use evaluation::settings::within;
use impute::impute;
pub use written::{gathered, to_csv};

/// The columns of the table.
pub const COLUMNS: [&str; 13] = [
    "intersection", "arm", "latitude", "longitude", "bearing_deg", "lanes_in", "lanes_out",
    "left_turn_lanes", "right_turn_lanes", "speed_mph", "length_m", "aadt_veh_per_day_per_lane",
    "movements",
];

/// Optional columns of the lengths of turn lanes, metres.
pub const STORAGE: [&str; 2] = ["left_storage_m", "right_storage_m"];

/// Shortest piece of a street upstream of a turn lane, metres: two vehicles. A turn lane that leaves less is as long as the
/// street.
pub const LEAST_PIECE_M: f64 = 15.0;

/// Lengths that a turn lane may have, metres.
const STORAGE_M: std::ops::RangeInclusive<f64> = 5.0..=1000.0;

/// Optional column of the period of the day.
pub const PERIOD: &str = "period";

/// Highest speed limit, miles per hour.
const MOST_MPH: f64 = 100.0;

/// Largest longitude, degrees.
const MOST_LONGITUDE_DEG: f64 = 180.0;

/// Reads an approaches table and imputes the counts that are missing.
///
/// # Errors
///
/// [`FamilyError::Csv`] with file and line for a malformed row, a value out of range or a table
/// without any count, [`FamilyError::Empty`] for a table without rows.
pub fn read(text: &str, file: &str) -> Result<Vec<Intersection>, FamilyError> {
    read_with(text, file, None)
}

/// Reads an approaches table to which turning counts are given, so that it may be without any count: a count that is
/// missing and cannot be imputed is not a number.
///
/// # Errors
///
/// As [`read`].
pub fn read_uncounted(text: &str, file: &str) -> Result<Vec<Intersection>, FamilyError> {
    read_with(text, file, Some(f64::NAN))
}

fn read_with(
    text: &str,
    file: &str,
    otherwise: Option<f64>,
) -> Result<Vec<Intersection>, FamilyError> {
    let fail = |fault| at(file, fault);
    let mut sheet = Sheet::of(text).map_err(fail)?;
    if sheet.headers.iter().all(str::is_empty) {
        return Err(FamilyError::Empty { file: file.to_owned() });
    }
    let header_line = sheet.header_line;
    let known = written::WRITTEN.map(|(_, name, _)| name);
    let columns = Columns::find(&sheet.headers, &COLUMNS)
        .and_then(|columns| columns.only(&known).map(|()| columns))
        .map_err(|message| fail(Fault::new(header_line, message)))?;
    let mut rows = Vec::new();
    let mut known = BTreeSet::new();
    while let Some(row) = sheet.next_row().map_err(fail)? {
        let line = row.line;
        let fail = |message| fail(Fault { line, message });
        let row = approach(&row, &columns).map_err(fail)?;
        check(&row).map_err(fail)?;
        if !known.insert((row.intersection.clone(), row.period.clone(), row.arm.clone())) {
            return Err(fail(format!(
                "intersection {} has arm {} twice; give each arm one row, of every period",
                row.intersection, row.arm
            )));
        }
        rows.push(row);
    }
    if rows.is_empty() {
        return Err(FamilyError::Empty { file: file.to_owned() });
    }
    movements::settle(&mut rows);
    let mut intersections = gathered(rows);
    for Intersection { id, line, arms, .. } in &intersections {
        if arms.iter().all(|a| a.lanes_in == 0) {
            let message = format!("intersection {id} has no incoming lane; remove it");
            return Err(fail(Fault { line: *line, message }));
        }
    }
    impute(&mut intersections, otherwise)
        .map_err(|message| fail(Fault { line: header_line, message }))?;
    Ok(intersections)
}

/// Returns the approach of a row.
fn approach(row: &Row, columns: &Columns) -> Result<Approach, String> {
    let text = |name: &str| row.text(columns.at(name)).to_owned();
    let number = |name: &str| columns.number(row, name);
    let optional = |name: &str| match columns.get(name) {
        Some(_) => columns.optional(row, name),
        None => Ok(None),
    };
    let placed = |name: &str| !row.text(columns.at(name)).is_empty();
    // A table without places is one of intersections that no map shows.
    let is_placed = placed("latitude") || placed("longitude");
    let coordinate = |name: &str| if is_placed { number(name) } else { Ok(f64::NAN) };
    Ok(Approach {
        intersection: title("intersection", row.text(columns.at("intersection")))?,
        arm: text("arm"),
        latitude: coordinate("latitude")?,
        longitude: match coordinate("longitude")? {
            // Some programs write 181 degrees for -179.
            beyond if beyond.abs() > MOST_LONGITUDE_DEG => {
                checked_place(coordinate("latitude")?, beyond)?.longitude()
            }
            longitude => longitude,
        },
        bearing_deg: number("bearing_deg")?,
        lanes_in: columns.whole(row, "lanes_in")?,
        lanes_out: columns.whole(row, "lanes_out")?,
        left_turn_lanes: columns.whole(row, "left_turn_lanes")?,
        right_turn_lanes: columns.whole(row, "right_turn_lanes")?,
        left_storage_m: optional(STORAGE[0])?,
        right_storage_m: optional(STORAGE[1])?,
        speed_mph: number("speed_mph")?,
        length_m: number("length_m")?,
        aadt_veh_per_day_per_lane: columns
            .optional_count(row, "aadt_veh_per_day_per_lane")?
            .unwrap_or(f64::NAN),
        movements: movements::letters(row.text(columns.at("movements")))?,
        period: match columns.get(PERIOD).map(|at| row.text(at)).unwrap_or_default() {
            "" => String::new(),
            period => title(PERIOD, period)?,
        },
        counted: counted::counted(row, columns)?,
        line: row.line,
        imputed: false,
    })
}

pub(crate) fn check(row: &Approach) -> Result<(), String> {
    let number = |name: &str, value: f64, low: f64, high: f64| {
        within(value, low, high).map_err(|expected| format!("{name} = {value}: {expected}"))
    };
    if !row.latitude.is_nan() {
        checked_place(row.latitude, row.longitude)?;
    }
    number("bearing_deg", row.bearing_deg, 0.0, 360.0)?;
    number("speed_mph", row.speed_mph, 1.0, MOST_MPH).map_err(|e| {
        match row.speed_mph > MOST_MPH {
            true => format!("{e}; if it is in km/h, multiply the column by {KMH_TO_MPH}"),
            false => e,
        }
    })?;
    number("length_m", row.length_m, 1.0, 100_000.0)?;
    for (name, storage_m, lanes) in [
        (STORAGE[0], row.left_storage_m, row.left_turn_lanes),
        (STORAGE[1], row.right_storage_m, row.right_turn_lanes),
    ] {
        let Some(storage_m) = storage_m else { continue };
        number(name, storage_m, *STORAGE_M.start(), *STORAGE_M.end())?;
        if lanes == 0 {
            return Err(format!(
                "{name} = {storage_m}, but the arm has no such turn lane; give the lanes, or leave {name} empty"
            ));
        }
    }
    if !row.aadt_veh_per_day_per_lane.is_nan() {
        number("aadt_veh_per_day_per_lane", row.aadt_veh_per_day_per_lane, 0.0, 1e7)?;
    }
    let (lanes_in, turn_lanes) =
        (row.lanes_in, row.left_turn_lanes.saturating_add(row.right_turn_lanes));
    if lanes_in > MAX_LANES || row.lanes_out > MAX_LANES || lanes_in + row.lanes_out == 0 {
        return Err(format!(
            "lanes_in = {lanes_in} and lanes_out = {}: expected up to {MAX_LANES} each, and at least one lane",
            row.lanes_out
        ));
    }
    if lanes_in == 0 && row.counted.is_some_and(|counted| counted.total_vph() > 0.0) {
        return Err(format!(
            "vehicles were counted on arm {}, which leads away only (lanes_in = 0); correct lanes_in, or give the \
             volumes to the arm that they come from",
            row.arm
        ));
    }
    if turn_lanes > lanes_in {
        return Err(format!(
            "left_turn_lanes and right_turn_lanes are {turn_lanes}, more than lanes_in = {lanes_in}, which counts them; \
             give lanes_in at least {turn_lanes}, or fewer turn lanes"
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "intersection,arm,latitude,longitude,bearing_deg,lanes_in,lanes_out,\
        left_turn_lanes,right_turn_lanes,speed_mph,length_m,aadt_veh_per_day_per_lane,movements\n";

    fn error(rows: &str) -> String {
        read(&format!("{HEADER}{rows}"), "a.csv").unwrap_err().to_string()
    }

    #[test]
    fn arms_of_an_intersection_are_gathered_in_order() {
        let text = format!(
            "{HEADER}7,A,40,-111,0,2,1,1,0,30,200,9000,lsr\n8,A,40,-111,0,1,1,0,0,30,200,1,\n\
             7,B,40,-111,90,0,1,0,0,30,200,9000,\n"
        );
        let read = read(&text, "a.csv").unwrap();
        assert_eq!(read.len(), 2);
        assert_eq!(read[0].arms.len(), 2);
        assert_eq!(read[0].arms[1].arm, "B");
    }

    #[test]
    fn a_word_for_a_number_names_line_and_column() {
        assert_eq!(
            error("7,A,40,-111,0,many,1,1,0,30,200,9000,lsr\n"),
            "a.csv, line 2: lanes_in = \"many\": expected a whole number that is not negative"
        );
    }

    #[test]
    fn letters_of_both_cases_mean_through_and_a_row_with_both_makes_t_a_u_turn() {
        let read = |movements: [&str; 2]| {
            let row = |arm: &str, m: &str| format!("7,{arm},40,-111,0,2,1,0,0,30,200,9000,{m}\n");
            let text = format!("{HEADER}{}{}", row("A", movements[0]), row("B", movements[1]));
            let read = read(&text, "a.csv").unwrap();
            read[0].arms.iter().map(|a| a.movements.clone()).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(read(["ltr", "LTR"]), "lsr lsr");
        assert_eq!(read(["lsr", "TR"]), "lsr sr");
        assert_eq!(read(["tlsr", "tlr"]), "tlsr tlr");
        assert_eq!(read(["ULSR", "ltr"]), "ulsr lsr");
    }

    #[test]
    fn what_cannot_be_says_what_it_may_be() {
        let e = error("7,A,-111.9,40.7,0,2,1,1,0,30,200,9000,lsr\n");
        assert!(e.ends_with("swap latitude and longitude"), "{e}");
        let e = error("7,A,40,-111,0,2,1,1,0,110,200,9000,lsr\n");
        assert!(e.ends_with("if it is in km/h, multiply the column by 0.621371"), "{e}");
    }

    #[test]
    fn storage_lengths_belong_to_turn_lanes() {
        let error = |row: &str| {
            let header = HEADER.replace("movements", "movements,left_storage_m,right_storage_m");
            read(&format!("{header}{row}"), "a.csv").unwrap_err().to_string()
        };
        let e = error("7,A,40,-111,0,2,1,1,0,30,200,9000,lsr,60,30\n");
        assert!(e.contains("right_storage_m = 30, but the arm has no such turn lane"), "{e}");
        let e = error("7,A,40,-111,0,2,1,1,0,30,200,9000,lsr,1,\n");
        assert!(e.contains("left_storage_m = 1: expected"), "{e}");
    }

    #[test]
    fn nan_and_negative_values_are_refused() {
        assert!(error("7,A,40,-111,0,2,1,1,0,NaN,200,9000,lsr\n").contains("speed_mph = \"NaN\""));
        assert!(error("7,A,40,-111,0,2,1,1,0,30,-5,9000,lsr\n").contains("length_m = -5"));
    }

    #[test]
    fn an_empty_count_is_missing_and_a_count_of_0_is_a_count() {
        let text = format!(
            "{HEADER}7,A,40,-111,0,2,1,1,0,30,200,9000,lsr\n7,B,40,-111,90,2,1,1,0,30,200, ,\n\
             7,C,40,-111,180,2,1,1,0,30,200,0,\n"
        );
        let read = read(&text, "a.csv").unwrap();
        let counts: Vec<f64> = read[0].arms.iter().map(|a| a.aadt_veh_per_day_per_lane).collect();
        assert_eq!((counts, read[0].imputed), (vec![9000.0, 4500.0, 0.0], 1));
    }

    #[test]
    fn a_table_without_any_count_is_refused() {
        assert_eq!(
            error("7,A,40,-111,0,2,1,1,0,30,200,,lsr\n"),
            "a.csv, line 1: aadt_veh_per_day_per_lane is empty on every approach that leads to a \
             signal; give at least one count"
        );
    }

    #[test]
    fn a_longitude_beyond_180_degrees_is_the_same_place() {
        let text = format!("{HEADER}7,A,-16.8,181,0,2,1,1,0,30,200,9000,lsr\n");
        assert_eq!(read(&text, "a.csv").unwrap()[0].arms[0].longitude, -179.0);
        let e = error("7,A,-16.8,420000,0,2,1,1,0,30,200,9000,lsr\n");
        assert!(e.contains("looks projected"), "{e}");
    }
}

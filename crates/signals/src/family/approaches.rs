//! The approaches table: one row per arm of a real intersection, and what was counted on it by turn.
//!
//! `COLUMNS` lists its columns, which may stand in any order; docs/own-city.md says what they are. An empty
//! `aadt_veh_per_day_per_lane` is a count that is missing and gets imputed; 0 is a count of no vehicle. What is believed
//! although it is doubtful is named by [`super::doubts`]. An intersection with rows of several periods is several point MDPs.
//!
//! - **Counted turns** are simulated as they were counted: neither the share of the hour nor the peak direction, the cap, the
//!   minimum or the turn shares of the settings apply to them.
//! - **Missing counts**: a hole in a source is no empty street. An arm without a count gets, per lane, the mean of the other
//!   counted arms that lead to the same signal. Where there is none, it gets the mean of the table's counted arms with as
//!   many incoming lanes, if they are at least three, else of all counted arms. All means are over counts as they stand,
//!   before the cap of the inflow. Source: this project's rule.
//! - **Movements**: `l` is a left and `r` a right turn, `s` and `t` are through (straight on), `u` is a U-turn, which nobody
//!   builds. In the table of Salt Lake City, and in those made like it, `t` is a U-turn: a row that has both `s` and `t` shows
//!   that, as no approach goes straight on twice, and then it holds for the whole table.

use std::collections::{BTreeMap, BTreeSet};

use basics::files::lines;
use evaluation::family::columns::{Columns, at};
use evaluation::family::error::FamilyError;
use evaluation::family::names::title;
use evaluation::settings::within;
use osm_signals::angle::normalise_degrees;
use osm_signals::geometry::checked_place;
use osm_signals::intersections::{MAX_ARMS, MAX_LANES};
use osm_signals::{DrivingSide, Turn};
use serde::{Deserialize, Serialize};
use sheet::{Fault, Row, Sheet};

use crate::settings::MIN_PEAK_HOUR_FACTOR;

/// Fewest and most arms that a network is built for.
pub const ARMS: std::ops::RangeInclusive<usize> = 2..=MAX_ARMS;

/// Shortest piece of a street upstream of a turn lane, metres: two vehicles. A turn lane that leaves less is as long as the
/// street.
pub const LEAST_PIECE_M: f64 = 15.0;

/// Most exits of an approach.
pub const MOST_EXITS: usize = MAX_ARMS - 1;

/// Most people of a crosswalk, per hour, as many as `signal.pedestrian_calls_per_h` may be.
pub const MOST_PEDESTRIANS_PER_H: f64 = 3600.0;

/// Most vehicles of a movement, per hour: eight lanes at 2,500, which no lane carries.
pub const MOST_VPH: f64 = 20_000.0;

/// Highest speed limit, miles per hour.
const MOST_MPH: f64 = 100.0;

/// How far rounding may bring the sum of quarters and that of turns apart: vehicles, and a share.
const ROUNDING_VEH: f64 = 4.0;
const ROUNDING: f64 = 0.02;

/// Fewest counted arms with as many lanes whose mean stands for the others.
const MIN_COUNTED: usize = 3;

/// Digits after the point of what was counted, as a power of ten: means of several days have any number.
const COUNT: f64 = 100.0;

/// Digits after the point of a share, as a power of ten.
const SHARE: f64 = 1e4;

/// The group of the columns that every table has, and the first group of what was counted.
const NEEDED: usize = 0;
const OF_COUNTS: usize = 5;

/// A column with its group. Optional groups, from 1, are written where a row has anything in one of their columns.
type Column = (usize, &'static str, fn(&Approach) -> String);

const COLUMNS: [Column; 26] = [
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
    (2, "shared_turns", |a| {
        let letters = [(a.shared_left, "l"), (a.shared_right, "r")];
        letters.into_iter().filter(|shared| shared.0).map(|shared| shared.1).collect()
    }),
    (3, "turn_on_red", |a| if a.no_turn_on_red { "no".to_owned() } else { String::new() }),
    (4, "period", |a| a.period.clone()),
    (5, "left_vph", |a| counted(a, |c| Some(number(c.left_vph)))),
    (5, "through_vph", |a| counted(a, |c| Some(number(c.through_vph)))),
    (5, "right_vph", |a| counted(a, |c| Some(number(c.right_vph)))),
    (5, "peak_hour_factor", |a| {
        counted(a, |c| match c.arrivals? {
            Arrivals::PeakHourFactor(factor) => Some(factor.to_string()),
            Arrivals::QuarterHours(_) => None,
        })
    }),
    (5, "quarter_hours", |a| {
        counted(a, |c| match c.arrivals? {
            Arrivals::PeakHourFactor(_) => None,
            Arrivals::QuarterHours(quarters) => Some(quarters.map(number).join(" ")),
        })
    }),
    (5, "heavy_vehicles", |a| {
        counted(a, |c| Some(((c.heavy_vehicles? * SHARE).round() / SHARE).to_string()))
    }),
    (6, "pedestrians_per_h", |a| counted(a, |c| c.pedestrians_per_h.map(number))),
    (7, "exits_vph", |a| {
        counted(a, |c| {
            let exits_vph = c.exits_vph?;
            // Without those at the end that have none.
            let used = exits_vph.iter().rposition(|vph| *vph > 0.0).map_or(1, |last| last + 1);
            Some(exits_vph[..used].iter().map(|vph| number(*vph)).collect::<Vec<_>>().join(" "))
        })
    }),
];

/// One arm of a real intersection in one period.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Approach {
    /// Intersection that the arm belongs to: an id or a name, any text.
    pub intersection: String,
    /// Name of the arm within its intersection.
    pub arm: String,
    /// Latitude of the intersection, degrees, WGS 84; not a number where the table has no places.
    pub latitude: f64,
    /// Longitude of the intersection, degrees, WGS 84.
    pub longitude: f64,
    /// Direction from the centre to the arm, degrees clockwise from north.
    pub bearing_deg: f64,
    /// Lanes towards the signal; 0 for a one-way street that leads away.
    pub lanes_in: u32,
    /// Lanes away from the signal.
    pub lanes_out: u32,
    /// Incoming lanes from which only a left turn is allowed; among `lanes_in`.
    pub left_turn_lanes: u32,
    /// Incoming lanes from which only a right turn is allowed; among `lanes_in`.
    pub right_turn_lanes: u32,
    /// Length of the left-turn lanes, metres; `None`: that of the approach.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_storage_m: Option<f64>,
    /// Length of the right-turn lanes, metres; `None`: that of the approach.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub right_storage_m: Option<f64>,
    /// Whether the lane beside the left-turn lanes turns left as well.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub shared_left: bool,
    /// Whether the lane beside the right-turn lanes turns right as well.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub shared_right: bool,
    /// Whether a sign forbids turns on red.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub no_turn_on_red: bool,
    /// Speed limit, miles per hour.
    pub speed_mph: f64,
    /// Length of the approach, metres.
    pub length_m: f64,
    /// Mean daily traffic of one direction, vehicles per day and lane towards the signal: AADT of both directions divided
    /// by `2 * lanes_in`, of a one-way street by `lanes_in`. Not a number as long as it is missing.
    pub aadt_veh_per_day_per_lane: f64,
    /// Turns that exist: `l` left, `s` straight, `r` right, `u` and `t` U-turn; empty when unknown.
    pub movements: String,
    /// Period of the day that the counts are of, such as `am`; empty where the table has one only.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub period: String,
    /// What was counted by turn; `None` where the inflow follows from the daily traffic.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counted: Option<Counted>,
    /// Line in its table.
    #[serde(skip)]
    pub line: u64,
    /// Whether its count was missing, so that the mean of others stands for it.
    #[serde(skip)]
    pub imputed: bool,
}

/// A real intersection in one period: its place and its arms.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Intersection {
    /// Id in the table: any text, so no name of a file.
    pub id: String,
    /// Period of the day; empty where the table has one only.
    pub period: String,
    /// Latitude, degrees; not a number where the table has no places.
    pub latitude: f64,
    /// Longitude, degrees.
    pub longitude: f64,
    /// Arms in the order of the table.
    pub arms: Vec<Approach>,
    /// How many of the arms that lead to the signal have an imputed count.
    pub imputed: u32,
    /// Line of the first arm in the table.
    pub line: u64,
}

/// What was counted of an approach in the hour that is simulated.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Counted {
    /// Vehicles per hour that turn left.
    pub left_vph: f64,
    /// Vehicles per hour that go straight on.
    pub through_vph: f64,
    /// Vehicles per hour that turn right.
    pub right_vph: f64,
    /// When they come; `None`: as the settings say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arrivals: Option<Arrivals>,
    /// Share of heavy vehicles; `None`: as the settings say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heavy_vehicles: Option<f64>,
    /// People per hour who cross the arm; `None`: as the settings say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pedestrians_per_h: Option<f64>,
    /// Vehicles per hour to each other arm that leads away, leftmost first as on the ground, then 0; `None`: exits of one
    /// turn have equal parts of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exits_vph: Option<[f64; MOST_EXITS]>,
}

/// When the vehicles of an approach come within the hour.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Arrivals {
    /// The second quarter is the peak, which this peak hour factor gives; the others are equal.
    PeakHourFactor(f64),
    /// As many vehicles in each quarter as counted, up to a common factor.
    QuarterHours([f64; 4]),
}

impl Counted {
    /// Returns what was counted, which is as on the ground, as right-hand traffic would have it. Exits stay in their order.
    #[must_use]
    pub fn as_right_hand(self, side: DrivingSide) -> Self {
        let (left_vph, right_vph) = side.swapped((self.left_vph, self.right_vph));
        Self { left_vph, right_vph, ..self }
    }

    /// Returns the vehicles per hour that turn so.
    pub fn turn_vph(&self, turn: Turn) -> f64 {
        match turn {
            Turn::Left => self.left_vph,
            Turn::Through => self.through_vph,
            Turn::Right => self.right_vph,
        }
    }

    /// Returns the vehicles of all turns, per hour.
    pub fn total_vph(&self) -> f64 {
        self.left_vph + self.through_vph + self.right_vph
    }
}

/// Reads an approaches table and imputes the counts that are missing.
///
/// # Errors
///
/// [`FamilyError::Csv`] with file and line for a malformed row, a value out of range or a table
/// without any count, [`FamilyError::Empty`] for a table without rows.
///
/// # Arguments
///
/// * `otherwise` — what stands for a count that is missing and cannot be imputed: not a number where turning counts are to come.
pub fn read(
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
    let needed = COLUMNS.iter().filter(|c| c.0 == NEEDED).map(|c| c.1).collect::<Vec<_>>();
    let known = COLUMNS.map(|c| c.1);
    let columns = Columns::find(&sheet.headers, &needed, &known)
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
    if !rows.iter().any(|a| a.movements.contains('s') && a.movements.contains('t')) {
        rows.iter_mut().for_each(|row| row.movements = row.movements.replace('t', "s"));
    }
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
    let text = |name: &str| columns.get(name).map(|at| row.text(at)).unwrap_or_default();
    let number = |name: &str| columns.number(row, name);
    let optional = |name: &str| match text(name) {
        "" => Ok(None),
        _ => columns.optional(row, name),
    };
    // A table without places is one of intersections that no map shows.
    let is_placed = ["latitude", "longitude"].iter().any(|name| !text(name).is_empty());
    let coordinate = |name: &str| if is_placed { number(name) } else { Ok(f64::NAN) };
    for (name, known) in
        [("shared_turns", ["l", "r", "lr"].as_slice()), ("turn_on_red", &["yes", "no"])]
    {
        if !text(name).is_empty() && !known.contains(&text(name)) {
            return Err(format!(
                "{name} = {:?}: expected {}, or nothing",
                text(name),
                known.join(", ")
            ));
        }
    }
    let mut movements = String::new();
    for letter in text("movements").to_lowercase().chars().filter(|c| c.is_alphanumeric()) {
        if !"lstru".contains(letter) {
            return Err(format!(
                "movements has the letter {letter:?}: expected some of l (left), s or t (through), r (right), u (U-turn)"
            ));
        }
        if !movements.contains(letter) {
            movements.push(letter);
        }
    }
    Ok(Approach {
        intersection: title("intersection", text("intersection"))?,
        arm: text("arm").to_owned(),
        latitude: coordinate("latitude")?,
        longitude: coordinate("longitude")?,
        bearing_deg: number("bearing_deg")?,
        lanes_in: columns.whole(row, "lanes_in")?,
        lanes_out: columns.whole(row, "lanes_out")?,
        left_turn_lanes: columns.whole(row, "left_turn_lanes")?,
        right_turn_lanes: columns.whole(row, "right_turn_lanes")?,
        left_storage_m: optional("left_storage_m")?,
        right_storage_m: optional("right_storage_m")?,
        shared_left: text("shared_turns").contains('l'),
        shared_right: text("shared_turns").contains('r'),
        no_turn_on_red: text("turn_on_red") == "no",
        speed_mph: number("speed_mph")?,
        length_m: number("length_m")?,
        aadt_veh_per_day_per_lane: columns
            .optional_count(row, "aadt_veh_per_day_per_lane")?
            .unwrap_or(f64::NAN),
        movements,
        period: match text("period") {
            "" => String::new(),
            period => title("period", period)?,
        },
        counted: counted_of(row, columns)?,
        line: row.line,
        imputed: false,
    })
}

/// Returns what a row says was counted; `None` where it says nothing.
fn counted_of(row: &Row, columns: &Columns) -> Result<Option<Counted>, String> {
    let text = |name: &str| columns.get(name).map(|at| row.text(at)).unwrap_or_default();
    if COLUMNS.iter().all(|(group, name, _)| *group < OF_COUNTS || text(name).is_empty()) {
        return Ok(None);
    }
    let number = |name: &str, low: f64, high: f64| {
        if text(name).is_empty() {
            return Ok(None);
        }
        let value = columns.optional_count(row, name)?.unwrap_or(f64::NAN);
        let checked = within(value, low, high);
        checked.map_err(|expected| format!("{name} = {value}: {expected}"))?;
        Ok::<_, String>(Some(value))
    };
    let volume = |name: &str| {
        number(name, 0.0, MOST_VPH)?.ok_or_else(|| {
            format!("{name} is empty beside other counts of the arm; write 0 if nobody was counted")
        })
    };
    let (left_vph, through_vph) = (volume("left_vph")?, volume("through_vph")?);
    let volumes =
        Counted { left_vph, through_vph, right_vph: volume("right_vph")?, ..Counted::default() };
    let several = |name: &str, most: usize| numbers(name, text(name), most, volumes.total_vph());
    let quarters = several("quarter_hours", 4)?.map(|quarters| match quarters[..] {
        [a, b, c, d] if a + b + c + d > 0.0 => Ok(Arrivals::QuarterHours([a, b, c, d])),
        _ => Err("quarter_hours: expected the vehicles of four quarters, not all of them 0, such as 110 140 130 120"),
    });
    let factor = number("peak_hour_factor", MIN_PEAK_HOUR_FACTOR, 1.0)?;
    let arrivals = match (factor.map(Arrivals::PeakHourFactor), quarters.transpose()?) {
        (Some(_), Some(_)) => {
            let both =
                "peak_hour_factor and quarter_hours both say when vehicles come; leave one empty";
            return Err(both.to_owned());
        }
        (factor, quarters) => factor.or(quarters),
    };
    let heavy_vehicles = number("heavy_vehicles", 0.0, 1.0)
        .map_err(|e| format!("{e}; it is a share: 0.03 for 3%"))?;
    let pedestrians_per_h = number("pedestrians_per_h", 0.0, MOST_PEDESTRIANS_PER_H)?;
    let exits_vph = several("exits_vph", MOST_EXITS)?
        .map(|given| std::array::from_fn(|exit| given.get(exit).copied().unwrap_or(0.0)));
    Ok(Some(Counted { arrivals, heavy_vehicles, pedestrians_per_h, exits_vph, ..volumes }))
}

/// Returns the vehicles of a field with several numbers, whose sum is that of the turns.
fn numbers(name: &str, text: &str, most: usize, total: f64) -> Result<Option<Vec<f64>>, String> {
    if text.is_empty() {
        return Ok(None);
    }
    let number = |word: &str| word.parse().ok().filter(|n: &f64| n.is_finite() && *n >= 0.0);
    let numbers: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
    let numbers = numbers.filter(|numbers| numbers.len() <= most).ok_or_else(|| {
        format!("{name} = {text:?}: expected at most {most} numbers of vehicles between blanks, such as 110 140 130")
    })?;
    let sum = numbers.iter().sum::<f64>();
    if (sum - total).abs() > ROUNDING_VEH + ROUNDING * total {
        return Err(format!(
            "{name} sum up to {sum}, and the turns to {total}; correct one of the two"
        ));
    }
    Ok(Some(numbers))
}

/// Checks the values of an arm; the error is what is wrong and the way out.
pub(crate) fn check(row: &Approach) -> Result<(), String> {
    if !row.latitude.is_nan() {
        checked_place(row.latitude, row.longitude)?;
    }
    let (lanes_in, aadt) = (row.lanes_in, row.aadt_veh_per_day_per_lane);
    let turn_lanes = row.left_turn_lanes.saturating_add(row.right_turn_lanes);
    for (name, value, low, high) in [
        ("longitude", Some(row.longitude).filter(|deg| !deg.is_nan()), -180.0, 180.0),
        ("bearing_deg", Some(row.bearing_deg), 0.0, 360.0),
        ("speed_mph", Some(row.speed_mph), 1.0, MOST_MPH),
        ("length_m", Some(row.length_m), 1.0, 100_000.0),
        ("left_storage_m", row.left_storage_m, 5.0, 1000.0),
        ("right_storage_m", row.right_storage_m, 5.0, 1000.0),
        ("aadt_veh_per_day_per_lane", Some(aadt).filter(|aadt| !aadt.is_nan()), 0.0, 1e7),
        ("lanes_in", Some(f64::from(lanes_in)), 0.0, f64::from(MAX_LANES)),
        ("lanes_out", Some(f64::from(row.lanes_out)), 0.0, f64::from(MAX_LANES)),
    ] {
        let Some(value) = value else { continue };
        within(value, low, high).map_err(|expected| format!("{name} = {value}: {expected}"))?;
    }
    for (name, storage_m, lanes) in [
        ("left_storage_m", row.left_storage_m, row.left_turn_lanes),
        ("right_storage_m", row.right_storage_m, row.right_turn_lanes),
    ] {
        if let Some(storage_m) = storage_m.filter(|_| lanes == 0) {
            return Err(format!(
                "{name} = {storage_m}, but the arm has no such turn lane; give the lanes, or leave {name} empty"
            ));
        }
    }
    if lanes_in + row.lanes_out == 0 {
        return Err("lanes_in = 0 and lanes_out = 0: expected at least one lane".to_owned());
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

/// Checks the arms of an intersection that is to be built as it is, with `detail = "per-approach"`.
///
/// # Errors
///
/// What is wrong with them, and the way out: they are too few or too many, two go in one direction, or one has
/// no way out.
pub fn check_arms(intersection: &Intersection) -> Result<(), String> {
    let (id, arms) = (&intersection.id, &intersection.arms);
    if !ARMS.contains(&arms.len()) {
        let (low, high) = (ARMS.start(), ARMS.end());
        return Err(format!(
            "intersection {id} has {} arms, and networks are built for {low} to {high}; join arms, or \
             remove the intersection",
            arms.len()
        ));
    }
    for (i, arm) in arms.iter().enumerate() {
        let bearing_deg = normalise_degrees(arm.bearing_deg);
        let same = arms[..i].iter().find(|a| normalise_degrees(a.bearing_deg) == bearing_deg);
        if let Some(same) = same {
            return Err(format!(
                "intersection {id}: arms {} and {} both have bearing_deg = {bearing_deg}; give each the \
                 direction from the centre to it",
                same.arm, arm.arm
            ));
        }
        let leads_away = arms.iter().enumerate().any(|(j, other)| j != i && other.lanes_out > 0);
        if arm.lanes_in > 0 && !leads_away {
            return Err(format!(
                "intersection {id}: vehicles from arm {} have no way out; give another arm lanes_out \
                 of at least 1",
                arm.arm
            ));
        }
    }
    Ok(())
}

/// Gives every arm of intersections a count. An arm that only leads away needs none and keeps 0 if it has
/// none; neither does an arm whose turns were counted, because nothing reads its daily count.
fn impute(intersections: &mut [Intersection], otherwise: Option<f64>) -> Result<(), String> {
    let counted = |arm: &Approach| {
        let aadt = arm.aadt_veh_per_day_per_lane;
        (arm.lanes_in > 0 && !aadt.is_nan()).then_some(aadt)
    };
    let mut all = Vec::new();
    let mut of_lanes: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for arm in intersections.iter().flat_map(|i| &i.arms) {
        if let Some(aadt) = counted(arm) {
            all.push(aadt);
            of_lanes.entry(arm.lanes_in).or_default().push(aadt);
        }
    }
    let typical = |lanes_in: u32| match of_lanes.get(&lanes_in) {
        Some(similar) if similar.len() >= MIN_COUNTED => mean(similar),
        _ => mean(&all),
    };
    for intersection in intersections {
        let own: Vec<f64> = intersection.arms.iter().filter_map(counted).collect();
        for arm in intersection.arms.iter_mut().filter(|a| a.aadt_veh_per_day_per_lane.is_nan()) {
            arm.imputed = arm.lanes_in > 0 && arm.counted.is_none();
            intersection.imputed += u32::from(arm.imputed);
            arm.aadt_veh_per_day_per_lane = match arm.imputed {
                true => mean(&own).or_else(|| typical(arm.lanes_in)).or(otherwise).ok_or(
                    "aadt_veh_per_day_per_lane is empty on every approach that leads to a signal; \
                     give at least one count",
                )?,
                false => 0.0,
            };
        }
    }
    Ok(())
}

/// Returns the mean, or nothing of nothing.
fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Returns a table of approaches as CSV, with the optional columns that any row uses. A count that is missing stays
/// empty.
pub fn to_csv(rows: &[Approach]) -> String {
    let has = |(_, _, cell): &Column| rows.iter().any(|row| !cell(row).is_empty());
    let is_used = |group: usize| COLUMNS.iter().any(|column| column.0 == group && has(column));
    let columns: Vec<&Column> =
        COLUMNS.iter().filter(|(group, ..)| *group == 0 || is_used(*group)).collect();
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
    use super::*;

    /// A table with these columns behind those that every table has.
    fn table(columns: &str, rows: &[&str]) -> Result<Vec<Intersection>, String> {
        let needed: Vec<&str> =
            COLUMNS.iter().filter(|c| c.0 == NEEDED).map(|column| column.1).collect();
        let text = format!("{}{columns}\n{}\n", needed.join(","), rows.join("\n"));
        read(&text, "a.csv", None).map_err(|e| e.to_string())
    }

    fn error(row: &str) -> String {
        table("", &[row]).unwrap_err()
    }

    #[test]
    fn arms_of_an_intersection_are_gathered_in_order_and_holes_get_the_mean() {
        let read = table(
            "",
            &[
                "7,A,40,-111,0,2,1,1,0,30,200,9000,lsr",
                "8,A,40,-111,0,1,1,0,0,30,200,1,",
                "7,B,40,-111,90,2,1,0,0,30,200, ,",
                "7,C,40,-111,180,2,1,0,0,30,200,0,",
            ],
        );
        let read = read.unwrap();
        let arms: Vec<(&str, f64)> =
            read[0].arms.iter().map(|a| (&*a.arm, a.aadt_veh_per_day_per_lane)).collect();
        assert_eq!((read.len(), &*arms), (2, &[("A", 9000.0), ("B", 4500.0), ("C", 0.0)][..]));
        assert_eq!(read[0].imputed, 1);
    }

    #[test]
    fn letters_of_both_cases_mean_through_and_a_row_with_both_makes_t_a_u_turn() {
        let read = |movements: [&str; 2]| {
            let row = |(arm, m): (&str, &str)| format!("7,{arm},40,-111,0,2,1,0,0,30,200,9000,{m}");
            let rows = ["A", "B"].into_iter().zip(movements).map(row).collect::<Vec<_>>();
            let read = table("", &[&rows[0], &rows[1]]).unwrap();
            read[0].arms.iter().map(|a| a.movements.clone()).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(read(["lttr", "L T/R"]), "lsr lsr");
        assert_eq!(read(["lsr", "TR"]), "lsr sr");
        assert_eq!(read(["tlsr", "tlr"]), "tlsr tlr");
        assert_eq!(read(["ULSR", "ltr"]), "ulsr lsr");
    }

    #[test]
    fn what_cannot_be_says_what_it_may_be() {
        for (row, expected) in [
            (
                "7,A,40,-111,0,many,1,1,0,30,200,9000,lsr",
                "a.csv, line 2: lanes_in = \"many\": expected a whole number that is not negative",
            ),
            ("7,A,-111.9,40.7,0,2,1,1,0,30,200,9000,lsr", "swap latitude and longitude"),
            (
                "7,A,40,-111,0,2,1,1,0,110,200,9000,lsr",
                "speed_mph = 110: expected a number from 1 to 100",
            ),
            ("7,A,40,-111,0,2,1,1,0,30,200,9000,lxr", "movements has the letter 'x': expected"),
            (
                "7,A,40,-111,0,2,1,1,0,30,200,,lsr",
                "a.csv, line 1: aadt_veh_per_day_per_lane is empty on every approach that leads to a signal",
            ),
        ] {
            let e = error(row);
            assert!(e.contains(expected), "{e}");
        }
        let error = |row: &str| table(",left_storage_m,right_storage_m", &[row]).unwrap_err();
        let e = error("7,A,40,-111,0,2,1,1,0,30,200,9000,lsr,60,30");
        assert!(e.contains("right_storage_m = 30, but the arm has no such turn lane"), "{e}");
    }

    /// Arms with these counts: volumes, peak hour factor, quarters, heavy vehicles.
    fn counted_arms(rows: [&str; 2]) -> Result<Vec<Approach>, String> {
        let columns =
            ",left_vph,through_vph,right_vph,peak_hour_factor,quarter_hours,heavy_vehicles";
        let [a, b] = rows;
        let a = format!("7,A,40,-111,0,2,1,1,0,30,200,,lsr,{a}");
        let b = format!("7,B,40,-111,180,2,1,1,0,30,200,,lsr,{b}");
        table(columns, &[&a, &b]).map(|mut read| read.remove(0).arms)
    }

    #[test]
    fn what_was_counted_needs_no_daily_count() {
        let arms = counted_arms(["12,488,0,,110 140 130 120,0.05", "0,0,90,0.9,,"]).unwrap();
        let [a, b] = [&arms[0], &arms[1]].map(|a| a.counted.unwrap());
        assert_eq!(a.total_vph(), 500.0);
        assert_eq!(a.arrivals, Some(Arrivals::QuarterHours([110.0, 140.0, 130.0, 120.0])));
        assert_eq!((a.heavy_vehicles, b.heavy_vehicles), (Some(0.05), None));
        assert_eq!(b.arrivals, Some(Arrivals::PeakHourFactor(0.9)));
    }

    #[test]
    fn what_cannot_be_counted_is_refused_with_the_way_out() {
        for (row, expected) in [
            ("12,,0,,,", "through_vph is empty beside other counts of the arm; write 0 if nobody"),
            ("1,0,0,0.2,,", "peak_hour_factor = 0.2: expected a number from 0.25"),
            ("1,0,0,0.9,1 0 0 0,", "leave one empty"),
            ("65,0,0,,30 30 30 30,", "sum up to 120, and the turns to 65; correct one of the two"),
            ("0,0,0,,0 0 0 0,", "not all of them 0"),
            ("1,0,0,,1 0 many 0,", "expected at most 4 numbers of vehicles"),
            ("1,0,0,,,5", "it is a share: 0.03 for 3%"),
        ] {
            let e = counted_arms([row, "0,0,90,,,"]).unwrap_err();
            assert!(e.contains(expected), "{row}: {e}");
        }
    }

    /// The counts of intersections whose arms have so many incoming lanes and such counts, when holes are filled.
    fn imputed(intersections: &[&[(u32, Option<f64>)]]) -> Result<Vec<Vec<f64>>, String> {
        let arm = |(lanes_in, aadt): &(u32, Option<f64>)| Approach {
            lanes_in: *lanes_in,
            aadt_veh_per_day_per_lane: aadt.unwrap_or(f64::NAN),
            ..Approach::default()
        };
        let raw = |arms: &&[(u32, Option<f64>)]| Intersection {
            arms: arms.iter().map(arm).collect(),
            ..Intersection::default()
        };
        let mut all: Vec<Intersection> = intersections.iter().map(raw).collect();
        impute(&mut all, None)?;
        let of = |i: &Intersection| i.arms.iter().map(|a| a.aadt_veh_per_day_per_lane).collect();
        Ok(all.iter().map(of).collect())
    }

    #[test]
    fn a_missing_count_is_the_mean_of_its_signal_else_of_arms_with_as_many_lanes_else_of_all() {
        let arms = [(1, Some(100.0)), (2, None), (2, Some(400.0)), (0, Some(9000.0)), (0, None)];
        assert_eq!(imputed(&[&arms]).unwrap()[0], [100.0, 250.0, 400.0, 9000.0, 0.0]);
        let counted = [(1, Some(10.0)), (2, Some(300.0)), (2, Some(400.0)), (2, Some(500.0))];
        assert_eq!(imputed(&[&counted, &[(2, None)]]).unwrap()[1], [400.0]);
        let few = [(1, Some(100.0)), (2, Some(200.0)), (2, Some(600.0))];
        assert_eq!(imputed(&[&few, &[(2, None)]]).unwrap()[1], [300.0]);
        assert!(imputed(&[&[(1, None), (0, Some(100.0))]]).is_err());
    }

    #[test]
    fn arms_that_no_network_can_have_are_named() {
        // Arms by their bearings and lanes out.
        let wrong = |arms: &[(f64, u32)]| {
            let arm = |((bearing_deg, lanes_out), name): (&(f64, u32), char)| Approach {
                arm: name.to_string(),
                bearing_deg: *bearing_deg,
                lanes_in: 2,
                lanes_out: *lanes_out,
                ..Approach::default()
            };
            let arms = arms.iter().zip('A'..).map(arm).collect();
            check_arms(&Intersection { id: "1".into(), arms, ..Intersection::default() })
                .unwrap_err()
        };
        let same = wrong(&[(0.0, 2), (180.0, 2), (360.0, 2)]);
        assert!(
            same.starts_with("intersection 1: arms A and C both have bearing_deg = 0"),
            "{same}"
        );
        assert_eq!(
            wrong(&[(0.0, 1), (90.0, 0), (180.0, 0)]),
            "intersection 1: vehicles from arm A have no way out; give another arm lanes_out of at least 1"
        );
        let seven: Vec<_> = (0..7).map(|i| (51.0 * f64::from(i), 2)).collect();
        assert!(wrong(&seven).contains("has 7 arms, and networks are built for 2 to 6"));
        assert!(wrong(&seven[..1]).contains("has 1 arms"));
    }

    #[test]
    fn what_is_written_reads_back_as_the_same() {
        let header = "intersection,arm,latitude,longitude,bearing_deg,lanes_in,lanes_out,left_turn_lanes,\
            right_turn_lanes,speed_mph,length_m,aadt_veh_per_day_per_lane,movements";
        let plain = format!(
            "{header}\n7,A,40.125,-111.0,0.0,2,1,1,0,30.0,200.5,9000.0,lsr\n7,B,40.125,-111.0,90.0,0,2,0,0,30.0,90.0,0.0,\n"
        );
        let intersections = read(&plain, "a.csv", None).unwrap();
        let rows: Vec<Approach> = intersections.iter().flat_map(|i| i.arms.clone()).collect();
        assert_eq!(to_csv(&rows), plain);
        assert_eq!(gathered(rows), intersections);
        let storage = plain
            .replace("movements\n", "movements,left_storage_m,right_storage_m\n")
            .replace("lsr\n", "lsr,45.7,\n")
            .replace("0.0,\n", "0.0,,,\n");
        let rows: Vec<Approach> = read(&storage, "a.csv", None).unwrap().remove(0).arms;
        assert_eq!((to_csv(&rows), rows[0].left_storage_m), (storage, Some(45.7)));
        let counted = format!(
            "{header},period,left_vph,through_vph,right_vph,peak_hour_factor,quarter_hours,heavy_vehicles\n\
             7,A,,,0.0,2,1,1,0,30.0,200.5,,lsr,am,1,2.33,0,,1 1 1 0.33,0.05\n7,B,,,90.0,2,2,0,0,30.0,90.0,,,am,0,5,0,0.92,,\n"
        );
        let rows: Vec<Approach> = read(&counted, "a.csv", None).unwrap().remove(0).arms;
        assert_eq!(to_csv(&rows), counted);
        let by_exit = counted
            .replace("heavy_vehicles\n", "heavy_vehicles,pedestrians_per_h,exits_vph\n")
            .replace("0.05\n", "0.05,62.5,0 1 2.33\n")
            .replace("0.92,,\n", "0.92,,,,\n");
        let rows: Vec<Approach> = read(&by_exit, "a.csv", None).unwrap().remove(0).arms;
        assert_eq!(to_csv(&rows), by_exit);
        let computed = plain.replace("7,A", "'=1+1,'@A").replace("7,B", "'=1+1,-B");
        let rows: Vec<Approach> = read(&computed, "a.csv", None).unwrap().remove(0).arms;
        let names = [&rows[0].intersection, &rows[0].arm, &rows[1].arm];
        assert_eq!(names, ["=1+1", "@A", "-B"]);
        assert_eq!(to_csv(&rows), computed.replace(",-B", ",'-B"));
    }
}

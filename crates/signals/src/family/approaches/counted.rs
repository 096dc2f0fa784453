//! What was counted of an approach: vehicles by turn in the hour that is simulated.
//!
//! Optional columns of the table of approaches:
//!
//! | column | unit |
//! | --- | --- |
//! | `left_vph`, `through_vph`, `right_vph` | vehicles per hour; all three, or none of them |
//! | `peak_hour_factor` | volume divided by four times that of the busiest quarter, from 0.25 to 1 |
//! | `quarter_hours` | vehicles in each quarter of the hour, such as `110 140 130 120` |
//! | `heavy_vehicles` | share of heavy vehicles, from 0 to 1 |
//! | `pedestrians_per_h` | people per hour who cross this arm |
//! | `exits_vph` | vehicles per hour to each exit, leftmost first, such as `80 310 45`; exits at the end that are left out have none |
//!
//! A counted approach is simulated as it was counted: neither the share of the hour nor the peak direction, the cap,
//! the minimum or the turn shares of the settings apply to it.

use evaluation::family::columns::Columns;
use evaluation::settings::within;
use osm_signals::intersections::MAX_ARMS;
use osm_signals::{DrivingSide, Turn};
use serde::{Deserialize, Serialize};
use sheet::Row;

use crate::settings::MIN_PEAK_HOUR_FACTOR;

/// Columns of vehicles by turn.
const VOLUMES: [&str; 3] = ["left_vph", "through_vph", "right_vph"];

/// Columns of how they arrive, what they are, who walks and where they go.
const MANNERS: [&str; 5] =
    ["peak_hour_factor", "quarter_hours", "heavy_vehicles", "pedestrians_per_h", "exits_vph"];

/// Most exits of an approach.
pub const MOST_EXITS: usize = MAX_ARMS - 1;

/// Most people of a crosswalk, per hour, as many as `signal.pedestrian_calls_per_h` may be.
pub const MOST_PEDESTRIANS_PER_H: f64 = 3600.0;

/// Most vehicles of a movement, per hour: eight lanes at 2,500, which no lane carries.
pub const MOST_VPH: f64 = 20_000.0;

/// How far rounding may bring the sum of quarters and that of turns apart: vehicles, and a share.
const ROUNDING_VEH: f64 = 4.0;
const ROUNDING: f64 = 0.02;

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

impl Arrivals {
    /// Returns the peak hour factor: volume divided by four times that of the busiest quarter.
    ///
    /// Source: Highway Capacity Manual, `V / (4 V15)`.
    pub fn peak_hour_factor(&self) -> f64 {
        match self {
            Self::PeakHourFactor(factor) => *factor,
            Self::QuarterHours(quarters) => {
                let busiest = quarters.iter().copied().fold(0.0, f64::max);
                quarters.iter().sum::<f64>() / (4.0 * busiest)
            }
        }
    }
}

/// Returns what a row says was counted; `None` where it says nothing.
pub(super) fn counted(row: &Row, columns: &Columns) -> Result<Option<Counted>, String> {
    let text = |name: &str| columns.get(name).map(|at| row.text(at)).unwrap_or_default();
    if VOLUMES.iter().all(|name| text(name).is_empty()) {
        let alone = MANNERS.into_iter().find(|name| !text(name).is_empty());
        return alone.map_or(Ok(None), |name| {
            let volumes = VOLUMES.join(", ");
            Err(format!("{name} is of counted vehicles, and {volumes} are empty; give them, or leave {name} empty"))
        });
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
            format!("{name} is empty beside other counted turns; write 0 if nobody was counted")
        })
    };
    let [left_vph, through_vph, right_vph] = VOLUMES.map(volume);
    let (left_vph, through_vph, right_vph) = (left_vph?, through_vph?, right_vph?);
    let several = |name: &str, most: usize| {
        numbers(name, text(name), most, left_vph + through_vph + right_vph)
    };
    let quarters = several("quarter_hours", 4)?.map(|quarters| match quarters[..] {
        [a, b, c, d] if a + b + c + d > 0.0 => Ok(Arrivals::QuarterHours([a, b, c, d])),
        _ => Err("quarter_hours: expected the vehicles of four quarters, not all of them 0, such as 110 140 130 120"),
    });
    let factor = number("peak_hour_factor", MIN_PEAK_HOUR_FACTOR, 1.0)?;
    let arrivals = match (factor, quarters.transpose()?) {
        (Some(_), Some(_)) => {
            return Err(
                "peak_hour_factor and quarter_hours both say when vehicles come; leave one empty"
                    .into(),
            );
        }
        (factor, quarters) => factor.map(Arrivals::PeakHourFactor).or(quarters),
    };
    let heavy_vehicles = number("heavy_vehicles", 0.0, 1.0)
        .map_err(|e| format!("{e}; it is a share: 0.03 for 3%"))?;
    let pedestrians_per_h = number("pedestrians_per_h", 0.0, MOST_PEDESTRIANS_PER_H)?;
    let exits_vph = several("exits_vph", MOST_EXITS)?
        .map(|given| std::array::from_fn(|exit| given.get(exit).copied().unwrap_or(0.0)));
    let volumes = Counted { left_vph, through_vph, right_vph, ..Counted::default() };
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

#[cfg(test)]
mod tests {
    use super::super::{Approach, read};
    use super::*;

    const HEADER: &str = "intersection,arm,latitude,longitude,bearing_deg,lanes_in,lanes_out,left_turn_lanes,\
        right_turn_lanes,speed_mph,length_m,aadt_veh_per_day_per_lane,movements,left_vph,through_vph,right_vph,\
        peak_hour_factor,quarter_hours,heavy_vehicles\n";

    fn arms(rows: [&str; 2]) -> Result<Vec<Approach>, String> {
        let [a, b] = rows;
        let text = format!(
            "{HEADER}7,A,40,-111,0,2,1,1,0,30,200,,lsr,{a}\n7,B,40,-111,180,2,1,1,0,30,200,,lsr,{b}\n"
        );
        read(&text, "a.csv").map(|read| read[0].arms.clone()).map_err(|e| e.to_string())
    }

    #[test]
    fn what_was_counted_needs_no_daily_count() {
        let arms = arms(["12,488,0,,110 140 130 120,0.05", "0,0,90,0.9,,"]).unwrap();
        let [a, b] = [&arms[0], &arms[1]].map(|a| a.counted.unwrap());
        assert_eq!(a.total_vph(), 500.0);
        assert_eq!(a.arrivals, Some(Arrivals::QuarterHours([110.0, 140.0, 130.0, 120.0])));
        assert!((a.arrivals.unwrap().peak_hour_factor() - 500.0 / 560.0).abs() < 1e-12);
        assert_eq!((a.heavy_vehicles, b.heavy_vehicles), (Some(0.05), None));
        assert_eq!(b.arrivals, Some(Arrivals::PeakHourFactor(0.9)));
    }

    #[test]
    fn vehicles_by_exit_are_those_of_the_turns() {
        let by_exit = |text, total| numbers("exits_vph", text, MOST_EXITS, total);
        assert_eq!(by_exit("80 310 45", 435.0), Ok(Some(vec![80.0, 310.0, 45.0])));
        assert!(by_exit("80 310", 435.0).unwrap_err().contains("the turns to 435"));
        assert!(by_exit("1 2 3 4 5 6", 21.0).unwrap_err().contains("at most 5"));
        assert!(by_exit("80 many", 80.0).unwrap_err().contains("expected at most 5 numbers"));
    }

    #[test]
    fn what_cannot_be_counted_is_refused_with_the_way_out() {
        let ok = "0,0,90,,,";
        let wrong = |row: &str| arms([row, ok]).unwrap_err();
        assert!(wrong("12,,0,,,").ends_with(
            "through_vph is empty beside other counted turns; write 0 if nobody was counted"
        ));
        assert!(wrong(",,,0.9,,").contains("peak_hour_factor is of counted vehicles"));
        assert!(wrong("-1,0,0,,,").contains("left_vph = -1: expected a number from 0"));
        assert!(
            wrong("1,0,0,0.2,,").contains("peak_hour_factor = 0.2: expected a number from 0.25")
        );
        assert!(wrong("1,0,0,0.9,1 0 0 0,").contains("leave one empty"));
        assert!(
            wrong("65,0,0,,30 30 30 30,")
                .ends_with("sum up to 120, and the turns to 65; correct one of the two")
        );
        assert!(wrong("1,0,0,,1 0 0,").contains("such as 110 140 130 120"));
        assert!(wrong("0,0,0,,0 0 0 0,").contains("not all of them 0"));
        assert!(wrong("1,0,0,,,5").ends_with("it is a share: 0.03 for 3%"));
    }
}

//! An approach of a real intersection, and the intersection with all of its.

use serde::{Deserialize, Serialize};

use super::counted::Counted;

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

//! What was counted where, and what of it belongs to a street.

use crate::extract::Place;
use crate::oddities::Oddities;

/// A count that belongs to a street.
#[derive(Debug, Clone, PartialEq)]
pub struct CountMatch {
    /// The count: annual average daily traffic of the road, vehicles per day, of both directions
    /// unless the road is one-way.
    pub aadt_veh_per_day: f64,
    /// Mean distance of the street from the counted line, metres.
    pub distance_m: f64,
    /// Mean angle between their axes, degrees; 0 for a station without a bearing.
    pub angle_deg: f64,
    /// Id of the counted line or station, or else its number in the file, such as `feature 7`.
    pub id: String,
}

/// Where something was counted.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shape {
    /// Along lines.
    Lines(Vec<Vec<Place>>),
    /// At a station, with the axis of its road in degrees clockwise from north if it is known.
    Station(Place, Option<f64>),
}

/// A line or station with its count.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Counted {
    pub(super) id: String,
    pub(super) aadt_veh_per_day: f64,
    /// Direction of travel that was counted, in capital letters, if the file says it.
    pub(super) direction: Option<String>,
    pub(super) shape: Shape,
}

/// Usual names of the column or property with the direction of travel.
pub(super) const DIRECTION: [&str; 5] =
    ["direction", "dir", "travel_direction", "direction_of_travel", "travel_dir"];

/// Returns a direction of travel as it is compared; `None` for an empty one.
pub(super) fn direction(text: &str) -> Option<String> {
    Some(text.trim().to_uppercase()).filter(|direction| !direction.is_empty())
}

/// What a reader finds in a file.
pub(super) struct Found {
    pub(super) counted: Vec<Counted>,
    pub(super) field: String,
    pub(super) oddities: Oddities,
}

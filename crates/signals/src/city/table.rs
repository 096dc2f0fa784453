//! The table of approaches of a city.

use std::path::Path;

use osm_signals::Turns;
use osm_signals::settings::IntersectionSettings;

use super::error::CityError;
use super::sites::{City, Site};
use crate::family::approaches::Approach;

/// Returns the table of approaches of a city, one row per arm.
pub fn approaches(city: &City, settings: &IntersectionSettings) -> Vec<Approach> {
    city.sites().flat_map(|site| rows(&site, settings)).collect()
}

fn rows(site: &Site<'_>, settings: &IntersectionSettings) -> Vec<Approach> {
    let i = site.found;
    let (shortest_m, longest_m) = (settings.min_length_m, settings.max_length_m);
    let arms = i.arms.iter().zip(&i.turns).zip(site.traffic).enumerate();
    arms.map(|(index, ((arm, turns), traffic))| Approach {
        intersection: i.id.clone(),
        arm: arm_name(index),
        latitude: i.centre.latitude(),
        longitude: i.centre.longitude(),
        bearing_deg: rounded(arm.bearing_deg).rem_euclid(360.0),
        lanes_in: arm.lanes_in,
        lanes_out: arm.lanes_out,
        left_turn_lanes: arm.left_turn_lanes,
        right_turn_lanes: arm.right_turn_lanes,
        left_storage_m: None,
        right_storage_m: None,
        speed_mph: rounded(arm.speed_mph),
        length_m: rounded(arm.length_m.clamp(shortest_m, longest_m)),
        aadt_veh_per_day_per_lane: traffic.aadt_per_lane.round(),
        movements: turns.map_or_else(String::new, letters),
        period: String::new(),
        counted: None,
        line: 0,
        imputed: false,
    })
    .collect()
}

/// Refuses a city without any intersection.
///
/// # Arguments
///
/// * `culprit` — the file that is to blame.
///
/// # Errors
///
/// [`CityError::NoIntersection`].
pub fn check(rows: &[Approach], city: &City, culprit: &Path) -> Result<(), CityError> {
    if !rows.is_empty() {
        return Ok(());
    }
    let (reasons, covered) = (city.skips(), city.survey().covered);
    Err(CityError::NoIntersection { path: culprit.to_path_buf(), reasons, covered })
}

/// Returns the name of an arm: A, B, C clockwise from north.
pub(super) fn arm_name(index: usize) -> String {
    char::from(b'A' + index as u8).to_string()
}

fn letters(turns: Turns) -> String {
    let letters = [(turns.left, 'l'), (turns.through, 's'), (turns.right, 'r')];
    letters.iter().filter(|(exists, _)| *exists).map(|(_, letter)| *letter).collect()
}

/// Returns a value with one digit after the point.
fn rounded(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}

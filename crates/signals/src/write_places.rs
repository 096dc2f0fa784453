//! Where the intersections of a run are: what its reports show on maps and call by their streets.

use std::collections::BTreeMap;
use std::path::Path;

use osm_signals::Turn;
use osm_signals::angle::turn_degrees;

use super::city::surroundings::{Named, read_names, read_streets};
use super::family::load::LoadedScenario;
use super::junction::incoming_edge;
use super::network::intersection::{IntersectionSpec, intersections};
use super::network::lanes::layout;
use super::places::{DrawnArm, DrawnIntersection, FILE, MappedIntersection, Places, StreetsOfRank};
use super::settings::Detail;
use basics::files::write_atomically;
use basics::units::MPS_PER_MPH;
use evaluation::run::fault::Cause;
use evaluation::store::Layout;

/// Distance from which on a name on the map belongs to another intersection, degrees: the table was
/// edited since.
const ELSEWHERE_DEG: f64 = 1e-3;

/// Writes where the intersections of a run's family are, unless none is known.
///
/// # Arguments
///
/// * `stands` — per point MDP the one that stands for it, if any.
/// * `folder` — that of a city, which has names and streets beside the scenario.
///
/// # Errors
///
/// What cannot be read or written.
pub(super) fn write(
    layout: &Layout,
    loaded: &LoadedScenario,
    stands: &[Option<usize>],
    folder: Option<&Path>,
) -> Result<(), Cause> {
    if loaded.intersections.is_empty() {
        return Ok(());
    }
    let names = folder.map(read_names).transpose()?.unwrap_or_default();
    let streets = folder.map(read_streets).transpose()?.unwrap_or_default();
    let mut mapped: Vec<(usize, MappedIntersection)> = Vec::new();
    for (point, members) in loaded.members.iter().enumerate() {
        for member in members {
            let intersection = &loaded.intersections[*member];
            let at = (intersection.latitude, intersection.longitude);
            if !at.0.is_finite() || !at.1.is_finite() {
                continue;
            }
            let id = |point: usize| loaded.family.points[point].id.clone();
            let place = MappedIntersection {
                id: intersection.id.clone(),
                streets: streets_of(&names, &intersection.id, at),
                latitude: at.0,
                longitude: at.1,
                point: id(point),
                stands: stands[point].map(id),
            };
            mapped.push((*member, place));
        }
    }
    mapped.sort_by_key(|i| i.0);
    let places = Places {
        intersections: mapped.into_iter().map(|i| i.1).collect(),
        streets: streets.into_iter().map(|(rank, lines)| StreetsOfRank { rank, lines }).collect(),
        drawings: drawings(loaded, stands)?,
    };
    if !places.intersections.is_empty() || !places.drawings.is_empty() {
        write_atomically(&layout.root().join(FILE), places.to_json().as_bytes())?;
    }
    Ok(())
}

/// Returns how the simulated intersections are drawn; none where four equal arms stand for others.
fn drawings(
    loaded: &LoadedScenario,
    stands: &[Option<usize>],
) -> Result<Vec<DrawnIntersection>, Cause> {
    if loaded.scenario.family.detail != Detail::PerApproach {
        return Ok(Vec::new());
    }
    let specs = intersections(loaded)?;
    let points = specs.iter().zip(&loaded.members).zip(stands).enumerate();
    let simulated = points.filter(|(point, (_, stands))| **stands == Some(*point));
    let drawn = simulated.map(|(_, ((spec, members), _))| drawn(loaded, spec, members[0]));
    drawn.collect()
}

/// Returns how an intersection is drawn; what the network has mirrored is as on the ground again.
fn drawn(
    loaded: &LoadedScenario,
    spec: &IntersectionSpec,
    member: usize,
) -> Result<DrawnIntersection, Cause> {
    let intersection = &loaded.intersections[member];
    let layout = layout(spec)?;
    let arm = |(i, arm): (usize, &crate::network::intersection::Arm)| {
        let bearing_deg = spec.side.bearing_deg(arm.bearing_deg);
        let off_deg = |row: &&crate::family::approaches::Approach| {
            turn_degrees(row.bearing_deg, bearing_deg).abs()
        };
        let own = intersection.arms.iter().min_by(|a, b| off_deg(a).total_cmp(&off_deg(b)));
        let turns = |lane: u32| -> String {
            let of_lane = |turn: Turn| {
                let mut own = layout.connections.iter();
                own.any(|c| (c.movement.from, c.movement.turn, c.from_lane) == (i, turn, lane))
            };
            let (left, right) = spec.side.swapped((Turn::Left, Turn::Right));
            let letters = [(left, 'l'), (Turn::Through, 's'), (right, 'r')];
            letters
                .into_iter()
                .filter(|(turn, _)| of_lane(*turn))
                .map(|(_, letter)| letter)
                .collect()
        };
        let (left_storage_m, right_storage_m) =
            spec.side.swapped((arm.left_storage_m, arm.right_storage_m));
        DrawnArm {
            name: own.map_or_else(String::new, |row| row.arm.clone()),
            edge: incoming_edge(i),
            bearing_deg,
            lanes: (0..arm.lanes_in).map(turns).collect(),
            lanes_out: layout.exit_lanes[i],
            speed_mph: arm.speed_mps / MPS_PER_MPH,
            left_storage_m,
            right_storage_m,
        }
    };
    Ok(DrawnIntersection {
        point: spec.point.clone(),
        intersection: intersection.id.clone(),
        period: intersection.period.clone(),
        is_left_hand: !spec.side.is_right(),
        arms: spec.arms.iter().enumerate().map(arm).collect(),
    })
}

fn streets_of(names: &BTreeMap<String, Named>, id: &str, at: (f64, f64)) -> Vec<String> {
    let near = |named: &&Named| {
        (named.at.0 - at.0).abs() < ELSEWHERE_DEG && (named.at.1 - at.1).abs() < ELSEWHERE_DEG
    };
    names.get(id).filter(near).map(|named| named.streets.clone()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_from_elsewhere_is_not_taken() {
        let named = Named { streets: vec!["Main Street".into()], at: (40.0, -111.0) };
        let names = BTreeMap::from([("n1".to_owned(), named)]);
        assert_eq!(streets_of(&names, "n1", (40.0001, -111.0)), ["Main Street"]);
        assert!(streets_of(&names, "n1", (40.1, -111.0)).is_empty());
        assert!(streets_of(&names, "n2", (40.0, -111.0)).is_empty());
    }
}

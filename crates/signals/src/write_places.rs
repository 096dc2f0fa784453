//! Where the intersections of a run are: what its reports show on maps and call by their streets.

use std::collections::BTreeMap;
use std::path::Path;

use super::city::surroundings::{Named, read_names, read_streets};
use super::family::load::LoadedScenario;
use super::places::{FILE, MappedIntersection, Places, StreetsOfRank};
use basics::files::write_atomically;
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
    let mut intersections: Vec<(usize, MappedIntersection)> = Vec::new();
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
            intersections.push((*member, place));
        }
    }
    intersections.sort_by_key(|i| i.0);
    let places = Places {
        intersections: intersections.into_iter().map(|i| i.1).collect(),
        streets: streets.into_iter().map(|(rank, lines)| StreetsOfRank { rank, lines }).collect(),
    };
    if !places.intersections.is_empty() {
        write_atomically(&layout.root().join(FILE), places.to_json().as_bytes())?;
    }
    Ok(())
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

//! A signal list against the map: which junctions it names, and which intersections are its own.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use rstar::RTree;
use rstar::primitives::GeomWithData;
use serde::Serialize;

use super::extract::Place;
use super::geometry::EARTH_RADIUS_M;
use super::graph::Graph;
use super::intersections::{Found, Skip, Skipped};
use super::signals::ListedSignal;
use crate::family::names::check_id;

/// Why a row has no intersection although one is within reach.
const OF_ANOTHER_ROW: &str = "its intersection belongs to a nearer row";

/// Why a row has no intersection where the map has nothing.
const NOTHING_NEAR: &str = "no junction of streets within reach";

/// Why an intersection does not have the id of its row.
const NO_NAME: &str = "its id cannot name files or is that of another intersection, so the \
                       intersection keeps that of the map";

/// A place on the sphere, metres from the centre of the earth: nearest along a chord is nearest on
/// the ground.
type Chord<T> = GeomWithData<[f64; 3], T>;

fn chord(place: Place) -> [f64; 3] {
    let (latitude, longitude) = (place.latitude().to_radians(), place.longitude().to_radians());
    let east = [latitude.cos() * longitude.cos(), latitude.cos() * longitude.sin()];
    [east[0], east[1], latitude.sin()].map(|c| c * EARTH_RADIUS_M)
}

/// What became of one row of a signal list.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ListMatch {
    /// Id in the list.
    pub id: String,
    /// Line in the list.
    pub line: u64,
    /// Latitude in the list, degrees.
    pub latitude: f64,
    /// Longitude in the list, degrees.
    pub longitude: f64,
    /// Id of its intersection, if it has one.
    pub intersection: Option<String>,
    /// Distance to it, metres.
    pub distance_m: Option<f64>,
    /// Whether the map has a signal there as well.
    pub on_map: bool,
    /// Why it has none, or why its intersection is not called like it.
    pub reason: Option<&'static str>,
}

/// Returns the junctions that a list names: of each row the nearest junction within reach, unless a
/// signal of the map is as near, such as one at the junction itself or at a stop line. That one
/// decides which junction it controls.
pub fn unmapped(graph: &Graph<'_>, rows: &[ListedSignal], match_m: f64) -> Vec<u32> {
    if rows.is_empty() {
        return Vec::new();
    }
    let extract = graph.extract;
    let none = HashSet::new();
    let on_street = extract.signals.iter().filter(|s| extract.nodes.index(s.id).is_some());
    let signals = RTree::bulk_load(on_street.map(|s| Chord::new(chord(s.place), ())).collect());
    let nodes = 0..extract.nodes.len() as u32;
    let junctions = nodes.filter(|n| graph.is_junction(*n, &none));
    let junctions =
        RTree::bulk_load(junctions.map(|n| Chord::new(chord(graph.place(n)), n)).collect());
    let reach = match_m * match_m;
    let named: BTreeSet<u32> = rows
        .iter()
        .map(|row| chord(row.place))
        .filter_map(|at| {
            let (junction, squared) = nearest(&junctions, at)?;
            let mapped = nearest(&signals, at).is_some_and(|(_, signal)| signal <= squared);
            (squared <= reach && !mapped).then_some(junction)
        })
        .collect();
    named.into_iter().collect()
}

/// Returns what is nearest to a place and the square of its distance.
fn nearest<T: Copy>(tree: &RTree<Chord<T>>, at: [f64; 3]) -> Option<(T, f64)> {
    tree.nearest_neighbor_iter_with_distance_2(&at)
        .next()
        .map(|(near, squared)| (near.data, squared))
}

/// Keeps the intersections that a list names, each under its id in the list, and says what became
/// of every row. A row and an intersection are matched if they are within reach, nearest first, each
/// once. An id that cannot name files, or that another intersection has by the map, is not taken
/// over.
pub fn keep_listed(found: &mut Found, rows: &[ListedSignal], match_m: f64) -> Vec<ListMatch> {
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    let centres = found.intersections.iter().enumerate();
    let tree = RTree::bulk_load(
        centres.flat_map(|(i, x)| x.places().map(move |p| Chord::new(chord(p), i))).collect(),
    );
    for (row, listed) in rows.iter().enumerate() {
        let mut nearest: BTreeMap<usize, f64> = BTreeMap::new();
        for near in tree.locate_within_distance(chord(listed.place), match_m * match_m) {
            let squared: f64 =
                near.geom().iter().zip(chord(listed.place)).map(|(a, b)| (a - b).powi(2)).sum();
            let metres = nearest.entry(near.data).or_insert(f64::INFINITY);
            *metres = metres.min(squared.sqrt());
        }
        pairs.extend(nearest.into_iter().map(|(i, metres)| (metres, row, i)));
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| (a.1, a.2).cmp(&(b.1, b.2))));
    let mut row_of: BTreeMap<usize, (usize, f64)> = BTreeMap::new();
    let mut matched: BTreeMap<usize, usize> = BTreeMap::new();
    for (metres, row, i) in &pairs {
        if !row_of.contains_key(i) && !matched.contains_key(row) {
            row_of.insert(*i, (*row, *metres));
            matched.insert(*row, *i);
        }
    }
    let near_any: HashSet<usize> = pairs.iter().map(|(_, row, _)| *row).collect();
    let skipped = found.skipped.iter().map(|s| Chord::new(chord(s.place), s.reason));
    let skipped = RTree::bulk_load(skipped.collect());
    let mut matches: Vec<ListMatch> = rows
        .iter()
        .enumerate()
        .map(|(row, listed)| {
            let i = matched.get(&row).map(|i| &found.intersections[*i]);
            let distance_m = matched.get(&row).map(|i| row_of[i].1);
            let reason = match i {
                Some(_) => None,
                None if near_any.contains(&row) => Some(OF_ANOTHER_ROW),
                None => nearest(&skipped, chord(listed.place))
                    .filter(|(_, squared)| *squared <= match_m * match_m)
                    .map_or(Some(NOTHING_NEAR), |(skip, _)| Some(skip.reason())),
            };
            ListMatch {
                id: listed.id.clone(),
                line: listed.line,
                latitude: listed.place.latitude(),
                longitude: listed.place.longitude(),
                intersection: None,
                distance_m,
                on_map: i.is_some_and(|i| !i.signals.is_empty()),
                reason,
            }
        })
        .collect();
    let all = std::mem::take(&mut found.intersections);
    let of_map: HashSet<String> = all.iter().map(|i| i.id.clone()).collect();
    for (index, mut intersection) in all.into_iter().enumerate() {
        match row_of.get(&index) {
            Some((row, metres)) => {
                let id = &rows[*row].id;
                if check_id("signal", id).is_ok() && !of_map.contains(id) {
                    intersection.id.clone_from(id);
                } else if *id != intersection.id {
                    matches[*row].reason = Some(NO_NAME);
                }
                intersection.list_distance_m = Some(*metres);
                matches[*row].intersection = Some(intersection.id.clone());
                found.intersections.push(intersection);
            }
            None => found.skipped.push(Skipped {
                signals: intersection.signals,
                place: intersection.centre,
                reason: Skip::NotListed,
            }),
        }
    }
    matches
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;
    use crate::osm::intersections::Intersection;

    /// Places on a grid of about 100 m, so many in a row.
    const COLUMNS: usize = 200;

    fn at(i: usize, north_deg: f64) -> Place {
        let (y, x) = ((i / COLUMNS) as f64, (i % COLUMNS) as f64);
        Place::from_degrees(y.mul_add(1e-3, north_deg), x * 1e-3).unwrap()
    }

    fn row(id: &str, place: Place) -> ListedSignal {
        ListedSignal { id: id.into(), place, line: 2 }
    }

    fn intersection(i: usize) -> Intersection {
        Intersection {
            id: format!("n{i}"),
            centre: at(i, 0.0),
            nodes: vec![i as i64],
            places: vec![at(i, 0.0)],
            list_distance_m: None,
            signals: vec![i as i64],
            arms: vec![],
            turns: vec![],
        }
    }

    /// The ids of intersections of the map in the order of the listed ones, and the reasons.
    fn named(ids: &[&str]) -> (Vec<String>, Vec<bool>) {
        let rows: Vec<_> = ids.iter().enumerate().map(|(i, id)| row(id, at(i, 0.0))).collect();
        let intersections = (0..ids.len()).map(intersection).collect();
        let mut found = Found { intersections, skipped: vec![] };
        let matches = keep_listed(&mut found, &rows, 40.0);
        let ids = found.intersections.iter().map(|i| i.id.clone()).collect();
        (ids, matches.iter().map(|m| m.reason == Some(NO_NAME)).collect())
    }

    #[test]
    fn an_id_of_another_intersection_is_not_taken_over() {
        let (ids, refused) = named(&["n1", "../a", "n2", "1001"]);
        assert_eq!(ids, ["n0", "n1", "n2", "1001"]);
        assert_eq!(refused, [true, true, false, false]);
    }

    #[test]
    fn an_id_that_cannot_name_files_is_said_so() {
        let long = "7".repeat(crate::family::names::MAX_ID + 1);
        for id in ["a/b", "Münster", &long, "", ".a", "INDEX.csv", "index.CSV"] {
            assert_eq!(named(&[id]), (vec!["n0".to_owned()], vec![true]), "{id}");
        }
        let longest = &long[1..];
        for id in [longest, "INDEX", "a-b_c.d"] {
            assert_eq!(named(&[id]), (vec![id.to_owned()], vec![false]), "{id}");
        }
    }

    #[test]
    fn a_long_list_takes_no_time() {
        const MANY: usize = 20_000;
        let skipped = |i| Skipped { signals: vec![], place: at(i, 1.0), reason: Skip::Border };
        let mut found = Found {
            intersections: (0..MANY).map(intersection).collect(),
            skipped: (0..MANY).map(skipped).collect(),
        };
        let near = (0..MANY).map(|i| row(&i.to_string(), at(i, 0.0)));
        let second = (0..MANY).map(|i| row(&format!("b{i}"), at(i, 1e-4)));
        let bad = (0..MANY).map(|i| row(&format!("c{i}"), at(i, 1.0 + 1e-4)));
        let rows: Vec<_> = near.chain(second).chain(bad).collect();
        let start = Instant::now();
        let matches = keep_listed(&mut found, &rows, 40.0);
        let took = start.elapsed();
        assert!(took < Duration::from_secs(5), "{took:?}");
        println!("{} rows in {took:?}", rows.len());
        assert_eq!(found.intersections.len(), MANY);
        assert_eq!(matches[MANY].reason, Some(OF_ANOTHER_ROW));
        assert_eq!(matches[2 * MANY].reason, Some(Skip::Border.reason()));
    }
}

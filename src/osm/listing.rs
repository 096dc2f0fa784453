//! A signal list against the map: which junctions it names, and which intersections are its own.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use rstar::RTree;
use rstar::primitives::GeomWithData;
use serde::Serialize;

use super::extract::Place;
use super::geometry::{EARTH_RADIUS_M, distance_m};
use super::graph::Graph;
use super::intersections::{Found, Skip, Skipped};
use super::signals::ListedSignal;

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
    /// Why it has none.
    pub reason: Option<&'static str>,
}

/// Returns the junctions that a list names where the map has no signal: of each row the nearest
/// junction within reach.
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
        .filter(|at| signals.locate_within_distance(*at, reach).next().is_none())
        .filter_map(|at| {
            let near = junctions.nearest_neighbor_iter_with_distance_2(&at).next();
            near.filter(|(_, squared)| *squared <= reach).map(|(junction, _)| junction.data)
        })
        .collect();
    named.into_iter().collect()
}

/// Keeps the intersections that a list names, each under its id in the list, and says what became
/// of every row. A row and an intersection are matched if they are within reach, nearest first, each
/// once.
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
    let mut matches: Vec<ListMatch> = rows
        .iter()
        .enumerate()
        .map(|(row, listed)| {
            let i = matched.get(&row).map(|i| &found.intersections[*i]);
            let distance_m = matched.get(&row).map(|i| row_of[i].1);
            let near_other = pairs.iter().any(|(_, r, _)| *r == row);
            let reason = match i {
                Some(_) => None,
                None if near_other => Some("its intersection belongs to a nearer row"),
                None => Some(reason(&found.skipped, listed.place, match_m)),
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
    for (index, mut intersection) in all.into_iter().enumerate() {
        match row_of.get(&index) {
            Some((row, metres)) => {
                if is_file_name(&rows[*row].id) {
                    intersection.id.clone_from(&rows[*row].id);
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

/// Returns whether an id may stand in the name of a folder, as an approaches table asks.
fn is_file_name(id: &str) -> bool {
    let safe = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    (1..=100).contains(&id.len()) && id.chars().all(safe) && !id.starts_with('.')
}

/// Returns why nothing near a place is an intersection.
fn reason(skipped: &[Skipped], place: Place, match_m: f64) -> &'static str {
    let near = skipped.iter().map(|s| (distance_m(s.place, place), s.reason));
    let near = near.filter(|(metres, _)| *metres <= match_m);
    let nearest = near.min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map_or("no junction of streets within reach", |(_, reason)| reason.reason())
}

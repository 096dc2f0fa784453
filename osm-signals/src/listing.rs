//! A signal list against the map: which junctions it names, and which intersections are its own.
//!
//! Coordinates of lists are off by some metres, often by half a junction. So a row goes to the nearest intersection that
//! has a signal on the map, each to one row, nearest first, even if a junction without one is nearer. A junction without a
//! signal on the map is taken where no such intersection is within reach, and where a row stands right on it and the signal
//! is clearly farther away; other rows beside an intersection that a nearer row has are duplicates of that row.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::geometry::chord;
use super::graph::Graph;
use super::intersections::{Found, Intersection, Skip, Skipped};
use super::signals::ListedSignal;

/// Distance up to which a row stands right on a junction, metres: half the width of one.
const ON_JUNCTION_M: f64 = 10.0;

/// How much farther a signal of the map has to be than a junction on which a row stands for the row
/// to mean the junction, metres.
const CLEARLY_M: f64 = 20.0;

/// A place on the sphere, metres from the centre of the earth: nearest along a chord is nearest on the ground.
type Chord<T> = GeomWithData<[f64; 3], T>;

/// Why a row has no intersection, or why its intersection is not called like it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RowNote {
    /// Another row, on this line of the list, has the intersection that it would have.
    Duplicate(u64),
    /// Its coordinates are those that programs write for none.
    NoPlace,
    /// The map has nothing there.
    NothingNear,
    /// What the map has there is no intersection.
    Skipped(Skip),
    /// It has an intersection, which cannot be called like it.
    NoName,
    /// Its intersection is called like another row, on this line, which has the same controller.
    SameController(u64),
}

impl RowNote {
    /// Returns the note in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Duplicate(_) => "duplicate of another row",
            Self::SameController(_) => "run by the controller of another row",
            Self::NoPlace => "at latitude 0, longitude 0, which stands for no place",
            Self::NothingNear => "no junction of streets within reach",
            Self::Skipped(skip) => skip.reason(),
            Self::NoName => {
                "its id is that of another intersection or no name, so the intersection keeps that \
                 of the map"
            }
        }
    }
}

/// What became of one row of a signal list.
#[derive(Debug, Clone, PartialEq)]
pub struct ListMatch {
    /// Id in the list.
    pub id: String,
    /// Line in the list, the first line being 1.
    pub line: u64,
    /// Latitude in the list, degrees.
    pub latitude: f64,
    /// Longitude in the list, degrees.
    pub longitude: f64,
    /// Id of its intersection, if it has one.
    pub intersection: Option<String>,
    /// Distance to it, or to that of the row that it repeats, metres.
    pub distance_m: Option<f64>,
    /// Whether the map has a signal there as well.
    pub on_map: bool,
    /// Why it has none, or why its intersection is not called like it.
    pub note: Option<RowNote>,
}

/// The junctions that a list names although the map has no signal there: their nodes, sorted, and the positions of the rows
/// that stand right on one.
pub(crate) type Named = (Vec<u32>, BTreeSet<usize>);

/// Returns the junctions that a list names: of each row without an intersection of the map within reach, and of each that
/// stands right on a junction, the nearest one, unless a signal of the map is as near.
pub(crate) fn unmapped(
    graph: &Graph<'_>,
    mapped: &Found,
    rows: &[ListedSignal],
    match_m: f64,
) -> Named {
    if rows.is_empty() {
        return Named::default();
    }
    let extract = graph.extract;
    let none = HashSet::new();
    let on_street = extract.signals.iter().filter(|s| extract.nodes.index(s.id).is_some());
    let places = mapped.intersections.iter().flat_map(Intersection::places);
    let signals = on_street.map(|s| s.place).chain(places).map(|p| Chord::new(chord(p), ()));
    let signals = RTree::bulk_load(signals.collect());
    let nodes = 0..extract.nodes.ids.len() as u32;
    let junctions = nodes.filter(|n| graph.is_junction(*n, &none));
    let junctions =
        RTree::bulk_load(junctions.map(|n| Chord::new(chord(graph.place(n)), n)).collect());
    // Per row the nearest junction within reach, if no signal is as near, and both distances.
    let own: Vec<Option<(u32, f64, f64)>> = rows
        .iter()
        .map(|row| {
            let (junction, squared) = nearest(&junctions, chord(row.place))?;
            let signal = nearest(&signals, chord(row.place)).map_or(f64::INFINITY, |s| s.1);
            let (metres, signal_m) = (squared.sqrt(), signal.sqrt());
            (metres <= match_m && metres < signal_m).then_some((junction, metres, signal_m))
        })
        .collect();
    let on = |(_, metres, signal_m): &(u32, f64, f64)| {
        *metres <= ON_JUNCTION_M && signal_m - metres >= CLEARLY_M
    };
    let on_junction: BTreeSet<usize> =
        (0..rows.len()).filter(|row| own[*row].as_ref().is_some_and(on)).collect();
    let [_, near] = assign(&mapped.intersections, rows, &on_junction, match_m);
    let left = (0..rows.len()).filter(|row| on_junction.contains(row) || !near.contains_key(row));
    let named: BTreeSet<u32> = left.filter_map(|row| own[row].map(|(node, ..)| node)).collect();
    (named.into_iter().collect(), on_junction)
}

/// Returns the junctions of intersections that a list gives one controller, in groups of at least two intersections.
pub(crate) fn one_controller(
    graph: &Graph<'_>,
    found: &Found,
    rows: &[ListedSignal],
    match_m: f64,
) -> Vec<Vec<u32>> {
    let mut of: BTreeMap<&str, BTreeSet<usize>> = BTreeMap::new();
    let [_, nearest] = assign(&found.intersections, rows, &BTreeSet::new(), match_m);
    for (row, (intersection, _)) in nearest {
        if let Some(controller) = rows[row].controller.as_deref() {
            of.entry(controller).or_default().insert(intersection);
        }
    }
    let nodes = |i: &usize| found.intersections[*i].nodes.iter();
    let index = |id: &i64| graph.extract.nodes.index(*id).map(|n| n as u32);
    let groups = of.into_values().filter(|intersections| intersections.len() > 1);
    groups.map(|group| group.iter().flat_map(nodes).filter_map(index).collect()).collect()
}

fn nearest<T: Copy>(tree: &RTree<Chord<T>>, at: [f64; 3]) -> Option<(T, f64)> {
    tree.nearest_neighbor_iter_with_distance_2(&at)
        .next()
        .map(|(near, squared)| (near.data, squared))
}

/// Row by intersection, each with its distance in metres, and the nearest intersection within reach by row.
type Assigned = [BTreeMap<usize, (usize, f64)>; 2];

/// Gives every row the nearest intersection within reach that no nearer row has; those with a signal
/// on the map come first, except to rows that stand right on another junction.
fn assign(
    intersections: &[Intersection],
    rows: &[ListedSignal],
    on_junction: &BTreeSet<usize>,
    match_m: f64,
) -> Assigned {
    let mut pairs: Vec<(bool, f64, usize, usize)> = Vec::new();
    let mut nearest_of: BTreeMap<usize, (usize, f64)> = BTreeMap::new();
    let places = intersections.iter().enumerate();
    let tree = RTree::bulk_load(
        places.flat_map(|(i, x)| x.places().map(move |p| Chord::new(chord(p), i))).collect(),
    );
    for (row, listed) in rows.iter().enumerate() {
        let at = chord(listed.place);
        let mut within: BTreeMap<usize, f64> = BTreeMap::new();
        for near in tree.locate_within_distance(at, match_m * match_m) {
            let squared: f64 = near.geom().iter().zip(at).map(|(a, b)| (a - b).powi(2)).sum();
            let metres = within.entry(near.data).or_insert(f64::INFINITY);
            *metres = metres.min(squared.sqrt());
        }
        let first = within.iter().min_by(|a, b| a.1.total_cmp(b.1));
        nearest_of.extend(first.map(|(i, metres)| (row, (*i, *metres))));
        pairs.extend(within.into_iter().map(|(i, metres)| {
            let late = intersections[i].signals.is_empty() || on_junction.contains(&row);
            (late, metres, row, i)
        }));
    }
    pairs.sort_by(|a, b| {
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then_with(|| (a.2, a.3).cmp(&(b.2, b.3)))
    });
    let mut row_of: BTreeMap<usize, (usize, f64)> = BTreeMap::new();
    let mut matched: HashSet<usize> = HashSet::new();
    for (_, metres, row, i) in pairs {
        if !row_of.contains_key(&i) && matched.insert(row) {
            row_of.insert(i, (row, metres));
        }
    }
    [row_of, nearest_of]
}

/// Keeps the intersections that a list names, each under its id in the list, and says what became of every row. A row and
/// an intersection are matched if they are within reach, nearest first, each once, with a signal on the map before those
/// without one. An id may be free text, such as the names of the streets; what names files is made from it. One that is
/// nothing but blanks, has control characters or is another intersection's is not taken over.
pub(crate) fn keep_listed(
    found: &mut Found,
    rows: &[ListedSignal],
    (_, on_junction): &Named,
    match_m: f64,
) -> Vec<ListMatch> {
    let [row_of, nearest_of] = assign(&found.intersections, rows, on_junction, match_m);
    let matched: BTreeMap<usize, usize> = row_of.iter().map(|(i, (row, _))| (*row, *i)).collect();
    let skipped = found.skipped.iter().map(|s| Chord::new(chord(s.place), s.reason));
    let skipped = RTree::bulk_load(skipped.collect());
    let mut matches: Vec<ListMatch> = rows
        .iter()
        .enumerate()
        .map(|(row, listed)| {
            let near = matched.get(&row).map(|i| (*i, row_of[i].1));
            let near = near.or_else(|| nearest_of.get(&row).copied());
            let owner = near.and_then(|(i, _)| row_of.get(&i)).map(|(owner, _)| *owner);
            let owner = owner.filter(|owner| *owner != row);
            let place = listed.place;
            let note = match near {
                Some(_) => owner.map(|owner| RowNote::Duplicate(rows[owner].line)),
                None if listed.is_nowhere() => Some(RowNote::NoPlace),
                None => nearest(&skipped, chord(place))
                    .filter(|(_, squared)| *squared <= match_m * match_m)
                    .map_or(Some(RowNote::NothingNear), |(skip, _)| Some(RowNote::Skipped(skip))),
            };
            let i = matched.get(&row).map(|i| &found.intersections[*i]);
            ListMatch {
                id: listed.id.clone(),
                line: listed.line,
                latitude: place.latitude(),
                longitude: place.longitude(),
                intersection: None,
                distance_m: near.map(|(_, metres)| metres),
                on_map: i.is_some_and(|i| !i.signals.is_empty()),
                note,
            }
        })
        .collect();
    let all = std::mem::take(&mut found.intersections);
    let mut taken: HashSet<String> = all.iter().map(|i| i.id.clone()).collect();
    for (index, mut intersection) in all.into_iter().enumerate() {
        match row_of.get(&index) {
            Some((row, metres)) => {
                match sheet::name(&rows[*row].id) {
                    Some(id) if id == intersection.id => {}
                    Some(id) if taken.insert(id.clone()) => intersection.id = id,
                    _ => matches[*row].note = Some(RowNote::NoName),
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
    for row in 0..rows.len() {
        let (Some(RowNote::Duplicate(line)), Some(controller)) =
            (matches[row].note, &rows[row].controller)
        else {
            continue;
        };
        let same = |r: &ListedSignal| r.line == line && r.controller.as_ref() == Some(controller);
        if let Some(owner) = rows.iter().position(same) {
            matches[row].intersection = matches[owner].intersection.clone();
            matches[row].on_map = matches[owner].on_map;
            matches[row].note = Some(RowNote::SameController(line));
        }
    }
    matches
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::extract::Place;
    use crate::intersections::Intersection;

    /// Places on a grid of about 100 m, so many in a row.
    const COLUMNS: usize = 200;

    fn at(i: usize, north_deg: f64) -> Place {
        let (y, x) = ((i / COLUMNS) as f64, (i % COLUMNS) as f64);
        Place::from_degrees(y.mul_add(1e-3, north_deg), x * 1e-3).unwrap()
    }

    fn row(id: &str, place: Place) -> ListedSignal {
        ListedSignal { id: id.into(), place, line: 2, controller: None }
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
            flags: vec![],
        }
    }

    fn named(ids: &[&str]) -> (Vec<String>, Vec<bool>) {
        let rows: Vec<_> = ids.iter().enumerate().map(|(i, id)| row(id, at(i, 0.0))).collect();
        let intersections = (0..ids.len()).map(intersection).collect();
        let mut found = Found { intersections, skipped: vec![] };
        let matches = keep_listed(&mut found, &rows, &Named::default(), 40.0);
        let ids = found.intersections.iter().map(|i| i.id.clone()).collect();
        (ids, matches.iter().map(|m| m.note == Some(RowNote::NoName)).collect())
    }

    #[test]
    fn an_id_of_another_intersection_is_not_taken_over() {
        let (ids, refused) = named(&["n1", "../a", "n2", "1001"]);
        assert_eq!(ids, ["n0", "../a", "n2", "1001"]);
        assert_eq!(refused, [true, false, false, false]);
    }

    #[test]
    fn an_id_may_be_free_text() {
        let long = "7".repeat(300);
        for id in ["a/b", "Main St / 5th", "M\u{fc}nster", &long, ".a", "INDEX.csv", "a-b_c.d"] {
            assert_eq!(named(&[id]), (vec![id.to_owned()], vec![false]), "{id}");
        }
        let (ids, refused) = named(&["Main  St", "Main St", "Main\nSt"]);
        assert_eq!(ids, ["Main St", "n1", "n2"]);
        assert_eq!(refused, [false, true, true]);
        for id in ["", " ", "a\u{7}"] {
            assert_eq!(named(&[id]), (vec!["n0".to_owned()], vec![true]), "{id:?}");
        }
    }
}

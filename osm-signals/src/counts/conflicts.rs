//! Counts of one place: equal ones are one, and of different ones nobody can tell which is meant.
//!
//! Portals give a row per direction, per year or per hour, all at one place. Any choice among them is wrong for
//! one of these: the larger of two directions is half of the street, their sum twice the traffic of two
//! years. So all of them are left out and named. Counts of two directions are different also where their values
//! are equal: each may be half of the street, or all of it.

use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::{Counted, Shape};
use crate::angle::turn_degrees;
use crate::error::brief;
use crate::extract::Place;
use crate::geometry::{along, axis_difference_deg, chord, distance_m, length_m};
use crate::oddities::Oddities;

/// Farthest that two counts of one place may be apart, metres: the sides of a street of two lanes.
const ONE_PLACE_M: f64 = 10.0;

/// Angle between the bearings of two stations from which on they are of two directions of travel, degrees.
const OPPOSED_DEG: f64 = 90.0;

/// What is said of counts that are left out.
const REASON: &str =
    "different counts at one place, all left out; give one per place, of both directions together";

/// Where something was counted: start, middle and end of a line, three times the place of a station.
type Trace = [Place; 3];

/// Keeps the counts of which there is one value at their place; the others are counted in `oddities`.
pub(super) fn settled(
    counted: Vec<Counted>,
    match_deg: f64,
    oddities: &mut Oddities,
) -> Vec<Counted> {
    let traces: Vec<Trace> = counted.iter().map(|count| trace(&count.shape)).collect();
    let middles = traces.iter().enumerate();
    let tree = RTree::bulk_load(
        middles.map(|(i, trace)| GeomWithData::new(chord(trace[1]), i)).collect::<Vec<_>>(),
    );
    let conflict = |i: usize| {
        let near = tree.locate_within_distance(chord(traces[i][1]), ONE_PLACE_M * ONE_PLACE_M);
        near.map(|near| near.data).find(|j| {
            contradict(&counted[i], &counted[*j], match_deg) && one_place(&traces[i], &traces[*j])
        })
    };
    let conflicts: Vec<Option<usize>> = (0..counted.len()).map(conflict).collect();
    let name = |i: usize| {
        let Counted { id, aadt_veh_per_day, direction, .. } = &counted[i];
        let direction = direction.as_ref().map(|d| format!(", {}", brief(d))).unwrap_or_default();
        format!("{} ({aadt_veh_per_day}{direction})", brief(id))
    };
    for (i, j) in conflicts.iter().enumerate().filter_map(|(i, j)| j.map(|j| (i, j))) {
        oddities.add(REASON, || format!("{} and {}", name(i), name(j)));
    }
    let settled = counted.into_iter().zip(conflicts).filter(|(_, conflict)| conflict.is_none());
    settled.map(|(count, _)| count).collect()
}

fn trace(shape: &Shape) -> Trace {
    match shape {
        Shape::Station(place, _) => [*place; 3],
        Shape::Lines(lines) => {
            let places = lines.concat();
            let (start, end) = (places[0], places[places.len() - 1]);
            let middle = along(&places, length_m(&places) / 2.0);
            let middle = middle.and_then(|(lat, lon)| Place::from_degrees(lat, lon));
            [start, middle.unwrap_or(start), end]
        }
    }
}

/// A line and a station say different things, and stations with bearings say which street they are of.
fn contradict(a: &Counted, b: &Counted, match_deg: f64) -> bool {
    let differ = a.aadt_veh_per_day != b.aadt_veh_per_day || a.direction != b.direction;
    match (&a.shape, &b.shape) {
        (Shape::Station(_, Some(a)), Shape::Station(_, Some(b))) => {
            let opposed = turn_degrees(*a, *b).abs() > OPPOSED_DEG;
            (differ || opposed) && axis_difference_deg(*a, *b) <= match_deg
        }
        (Shape::Lines(_), Shape::Lines(_)) | (Shape::Station(..), Shape::Station(..)) => differ,
        _ => false,
    }
}

fn one_place(a: &Trace, b: &Trace) -> bool {
    let near = |b: &[Place; 3]| a.iter().zip(b).all(|(a, b)| distance_m(*a, *b) <= ONE_PLACE_M);
    near(b) || near(&[b[2], b[1], b[0]])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at((latitude, longitude): (f64, f64)) -> Place {
        Place::from_degrees(latitude, longitude).unwrap()
    }

    fn station(id: &str, aadt_veh_per_day: f64, place: (f64, f64), axis: Option<f64>) -> Counted {
        let shape = Shape::Station(at(place), axis);
        Counted { id: id.into(), aadt_veh_per_day, direction: None, shape }
    }

    fn line(id: &str, aadt_veh_per_day: f64, places: &[(f64, f64)]) -> Counted {
        let shape = Shape::Lines(vec![places.iter().copied().map(at).collect()]);
        Counted { id: id.into(), aadt_veh_per_day, direction: None, shape }
    }

    fn settle(counted: Vec<Counted>) -> (String, Option<String>) {
        let mut oddities = Oddities::default();
        let left = settled(counted, 30.0, &mut oddities);
        let ids = left.into_iter().map(|c| c.id).collect::<Vec<_>>().join(" ");
        (ids, oddities.iter().next().map(|(_, o)| format!("{}: {}", o.count, o.example)))
    }

    const HERE: (f64, f64) = (48.7809, 9.18);

    /// 3 m from [`HERE`].
    const BESIDE: (f64, f64) = (48.7809, 9.180_04);

    #[test]
    fn different_counts_at_one_place_are_left_out_and_named() {
        let far = station("far", 5.0, (48.79, 9.18), None);
        for place in [HERE, BESIDE] {
            let two = vec![
                station("N1", 12_300.0, HERE, None),
                far.clone(),
                station("N2", 11_300.0, place, None),
            ];
            let named = "2: N1 (12300) and N2 (11300)".to_owned();
            assert_eq!(settle(two), ("far".to_owned(), Some(named)));
        }
    }

    #[test]
    fn equal_counts_at_one_place_stay() {
        let two = vec![station("b", 9.0, HERE, None), station("a", 9.0, HERE, None)];
        assert_eq!(settle(two), ("b a".to_owned(), None));
        let two = vec![station("b", 9.0, HERE, None), station("a", 9.0, BESIDE, None)];
        assert_eq!(settle(two), ("b a".to_owned(), None));
    }

    #[test]
    fn equal_counts_of_two_directions_are_left_out_and_named() {
        let of = |id: &str, place, direction: &str| Counted {
            direction: Some(direction.into()),
            ..station(id, 9.0, place, None)
        };
        for place in [HERE, BESIDE] {
            let two = vec![of("a", HERE, "EB"), of("b", place, "WB")];
            assert_eq!(settle(two), (String::new(), Some("2: a (9, EB) and b (9, WB)".to_owned())));
        }
        let same = vec![of("b", HERE, "EB"), of("a", HERE, "EB")];
        assert_eq!(settle(same), ("b a".to_owned(), None));
        let bearing = |id: &str, deg| station(id, 9.0, HERE, Some(deg));
        assert_eq!(settle(vec![bearing("a", 90.0), bearing("b", 270.0)]).0, "");
        assert_eq!(settle(vec![bearing("a", 90.0), bearing("b", 91.0)]).0, "a b");
    }

    #[test]
    fn stations_of_two_streets_are_told_by_their_bearings() {
        let two =
            |axis| vec![station("a", 9.0, HERE, Some(0.0)), station("b", 8.0, HERE, Some(axis))];
        assert_eq!(settle(two(90.0)), ("a b".to_owned(), None));
        assert_eq!(settle(two(182.0)).0, "");
    }

    #[test]
    fn lines_of_two_years_are_one_place_whatever_their_direction() {
        let old = line("old", 9000.0, &[(48.78, 9.18), (48.781, 9.18), (48.782, 9.18)]);
        let new = [(48.782, 9.180_05), (48.78, 9.18)];
        let (left, named) = settle(vec![old.clone(), line("new", 15_000.0, &new)]);
        assert_eq!((&*left, named.as_deref()), ("", Some("2: old (9000) and new (15000)")));
        let next = line("next", 8000.0, &[(48.782, 9.18), (48.784, 9.18)]);
        let station = station("s", 7000.0, (48.781, 9.18), None);
        assert_eq!(settle(vec![old, next, station]), ("old next s".to_owned(), None));
    }
}

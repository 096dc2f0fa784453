//! The spatial index of counts and the join to a street.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use geo::line_measures::InterpolateLine;
use geo::{
    BoundingRect, Coord, Distance, Euclidean, Length, Line, LineLocatePoint, LineString, Point,
    Rect, Vector2DOps,
};
use rstar::primitives::GeomWithData;
use rstar::{AABB, RTree};

use super::settings::CountSettings;
use super::{CountMatch, Counted, Shape};
use crate::extract::Place;
use crate::geometry::{Plane, axis_difference_deg};

/// How far beyond the end of a counted line a street may still be beside it, metres. Without this
/// the line of the opposite arm would be near the first places of an arm.
const BEYOND_M: f64 = 10.0;

/// Distance of the first place from the junction, metres; before it the streets overlap.
const FIRST_M: f64 = 5.0;

/// Distance between places, metres.
const STEP_M: f64 = 10.0;

/// Length of the street that is compared, metres: about a block. A longer street may bend away,
/// and its counted line may end at a junction that the street goes through.
const COMPARED_M: f64 = 150.0;

/// Half the length of the chord whose direction is that of the street, metres; single pieces of
/// a street can be short and point anywhere.
const HALF_CHORD_M: f64 = 10.0;

/// A straight piece of a counted line, degrees, and the position of what it belongs to.
type Piece = GeomWithData<Line<f64>, usize>;

/// A station, degrees, the position of what it belongs to and the axis of its road.
type Station = GeomWithData<Point<f64>, (usize, Option<f64>)>;

#[derive(Debug)]
pub(super) struct Index {
    /// Id and vehicles per day.
    counted: Vec<(String, f64)>,
    pieces: RTree<Piece>,
    stations: RTree<Station>,
}

/// How a street lies to a counted line or station at one place: distance in metres and angle in degrees.
type Near = (f64, f64);

/// How well a match fits, from 0 to 1, and the match.
type Scored = (f64, CountMatch);

impl Index {
    pub(super) fn new(all: Vec<Counted>) -> Option<(Self, Rect<f64>)> {
        let mut counted = Vec::with_capacity(all.len());
        let (mut pieces, mut stations) = (Vec::new(), Vec::new());
        for (i, Counted { id, aadt_veh_per_day, shape, .. }) in all.into_iter().enumerate() {
            counted.push((id, aadt_veh_per_day));
            match shape {
                Shape::Lines(lines) => {
                    let pairs = lines.iter().flat_map(|line| line.windows(2));
                    let line = |pair: &[Place]| Line::new(degrees(pair[0]), degrees(pair[1]));
                    pieces.extend(pairs.map(|pair| Piece::new(line(pair), i)));
                }
                Shape::Station(place, axis) => {
                    stations.push(Station::new(degrees(place).into(), (i, axis)));
                }
            }
        }
        let ends = pieces.iter().flat_map(|p| [p.geom().start, p.geom().end]);
        let places = ends.chain(stations.iter().map(|s| Coord::from(*s.geom())));
        let bounds = places.collect::<LineString<_>>().bounding_rect()?;
        let (pieces, stations) = (RTree::bulk_load(pieces), RTree::bulk_load(stations));
        Some((Self { counted, pieces, stations }, bounds))
    }

    pub(super) fn along(
        &self,
        street: &[Place],
        lanes: u32,
        settings: &CountSettings,
    ) -> Option<CountMatch> {
        let plane = Plane::around(*street.first()?);
        let flat = Street::new(&plane, street)?;
        let area = area(street, &plane, settings.match_m)?;
        let most = settings.max_veh_per_day_per_lane * f64::from(lanes.max(1));
        let lines = self.lines(&plane, &flat, &area, settings);
        let stations = self.stations(&plane, &flat, &area, settings);
        let possible = |(_, found): &Scored| found.aadt_veh_per_day <= most;
        let best = lines.into_iter().chain(stations).filter(possible).max_by(worse);
        best.map(|(_, found)| found)
    }

    fn lines(
        &self,
        plane: &Plane,
        street: &Street,
        area: &AABB<Point<f64>>,
        settings: &CountSettings,
    ) -> Vec<Scored> {
        let mut lines: BTreeMap<usize, Vec<Line<f64>>> = BTreeMap::new();
        let near = self.pieces.locate_in_envelope_intersecting(area);
        for piece in near {
            let (start, end) = (plane.flat(piece.geom().start), plane.flat(piece.geom().end));
            lines.entry(piece.data).or_default().push(Line::new(start, end));
        }
        let samples = street.samples();
        let scored = lines.into_iter().filter_map(|(i, pieces)| {
            let nearest = |sample: &Sample| {
                pieces.iter().filter_map(|piece| beside(sample, piece, settings)).min_by(nearer)
            };
            let near: Vec<_> = samples.iter().filter_map(nearest).collect();
            (!near.is_empty() && 2 * near.len() >= samples.len())
                .then(|| self.scored(i, &near, samples.len(), settings))
        });
        scored.collect()
    }

    fn stations(
        &self,
        plane: &Plane,
        street: &Street,
        area: &AABB<Point<f64>>,
        settings: &CountSettings,
    ) -> Vec<Scored> {
        // A station before this is beside a street that this one meets.
        let margin_m = FIRST_M.min(street.length_m / 4.0);
        let near = self.stations.locate_in_envelope_intersecting(area);
        let scored = near.filter_map(|station| {
            let (i, axis) = station.data;
            let at = Point::from(plane.flat((*station.geom()).into()));
            let along_m = street.line.line_locate_point(&at)? * street.length_m;
            let distance_m = Euclidean.distance(&at, &street.line);
            let (_, axis_deg) = street.sample(along_m)?;
            let angle_deg = axis.map_or(0.0, |axis| axis_difference_deg(axis, axis_deg));
            let beside = (margin_m..=street.length_m - margin_m).contains(&along_m)
                && distance_m <= settings.match_m
                && angle_deg <= settings.match_deg;
            beside.then(|| self.scored(i, &[(distance_m, angle_deg)], 1, settings))
        });
        scored.collect()
    }

    fn scored(&self, i: usize, near: &[Near], of: usize, settings: &CountSettings) -> Scored {
        let closeness: f64 = near.iter().map(|(metres, _)| 1.0 - metres / settings.match_m).sum();
        let mean = |f: fn(&Near) -> f64| near.iter().map(f).sum::<f64>() / near.len() as f64;
        let (id, aadt_veh_per_day) = &self.counted[i];
        let found = CountMatch {
            aadt_veh_per_day: *aadt_veh_per_day,
            distance_m: mean(|near| near.0),
            angle_deg: mean(|near| near.1),
            id: id.clone(),
        };
        (closeness / of as f64, found)
    }
}

/// Ties go by distance and angle, then by what does not depend on the order of the file.
fn worse((a_fits, a): &Scored, (b_fits, b): &Scored) -> Ordering {
    a_fits
        .total_cmp(b_fits)
        .then(b.distance_m.total_cmp(&a.distance_m))
        .then(b.angle_deg.total_cmp(&a.angle_deg))
        .then(b.aadt_veh_per_day.total_cmp(&a.aadt_veh_per_day))
        .then_with(|| b.id.cmp(&a.id))
}

/// Orders places by distance; where two pieces meet, the angle decides.
fn nearer(a: &Near, b: &Near) -> Ordering {
    a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
}

fn beside((at, axis): &Sample, piece: &Line<f64>, settings: &CountSettings) -> Option<Near> {
    let step = piece.delta();
    let angle_deg = axis_difference_deg(axis_deg(step), *axis);
    if angle_deg > settings.match_deg {
        return None;
    }
    let length_m = step.magnitude();
    let along_m = step.dot_product(Coord::from(*at) - piece.start) / length_m;
    let beyond_m = (-along_m).max(along_m - length_m);
    let distance_m = Euclidean.distance(at, piece);
    (beyond_m <= BEYOND_M && distance_m <= settings.match_m).then_some((distance_m, angle_deg))
}

fn area(street: &[Place], plane: &Plane, margin_m: f64) -> Option<AABB<Point<f64>>> {
    let places = street.iter().map(|place| degrees(*place));
    let bounds = places.collect::<LineString<_>>().bounding_rect()?;
    let margin = Coord { x: margin_m / plane.east_m_per_deg, y: margin_m / plane.north_m_per_deg };
    let (min, max) = (bounds.min() - margin, bounds.max() + margin);
    Some(AABB::from_corners(min.into(), max.into()))
}

fn degrees(place: Place) -> Coord<f64> {
    Coord { x: place.longitude(), y: place.latitude() }
}

#[derive(Debug, Clone)]
struct Street {
    line: LineString<f64>,
    length_m: f64,
}

/// A place along a street, metres on the plane, and the direction of the street there, degrees clockwise from north.
type Sample = (Point<f64>, f64);

impl Street {
    /// `None` if it has no length.
    fn new(plane: &Plane, places: &[Place]) -> Option<Self> {
        let mut coords: Vec<_> = places.iter().map(|p| plane.flat(degrees(*p))).collect();
        coords.dedup();
        let line = LineString(coords);
        let length_m = Euclidean.length(&line);
        (length_m > 0.0).then_some(Self { line, length_m })
    }

    /// Returns the places to compare: every 10 m from 5 m on, or the middle of a shorter street.
    fn samples(&self) -> Vec<Sample> {
        let end = self.length_m.min(COMPARED_M);
        let first = FIRST_M.min(self.length_m / 2.0);
        let places = (0_u32..).map(|i| first + STEP_M * f64::from(i)).take_while(|m| *m <= end);
        places.filter_map(|metres| self.sample(metres)).collect()
    }

    /// Returns the place some metres from the start; `None` if the street turns back there.
    fn sample(&self, metres: f64) -> Option<Sample> {
        let point = |m: f64| Euclidean.point_at_distance_from_start(&self.line, m);
        let (from, to) = (point(metres - HALF_CHORD_M)?, point(metres + HALF_CHORD_M)?);
        let chord = to - from;
        (chord != Point::new(0.0, 0.0)).then_some((point(metres)?, axis_deg(chord.into())))
    }
}

fn axis_deg(step: Coord<f64>) -> f64 {
    step.x.atan2(step.y).to_degrees()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Metres per degree of latitude; of longitude too, because everything lies at the equator.
    const PER_DEG: f64 = 111_195.083;

    /// A place so many metres east and north of the junction.
    fn at((east, north): (f64, f64)) -> Place {
        Place::from_degrees(north / PER_DEG, east / PER_DEG).unwrap()
    }

    fn street() -> Vec<Place> {
        [(0.0, 0.0), (0.0, 40.0), (0.0, 100.0)].map(at).to_vec()
    }

    fn line(id: &str, aadt_veh_per_day: f64, places: &[(f64, f64)]) -> Counted {
        let places = places.iter().copied().map(at).collect();
        let shape = Shape::Lines(vec![places]);
        Counted { id: id.into(), aadt_veh_per_day, direction: None, shape }
    }

    fn station(id: &str, place: (f64, f64), axis: Option<f64>) -> Counted {
        let shape = Shape::Station(at(place), axis);
        Counted { id: id.into(), aadt_veh_per_day: 900.0, direction: None, shape }
    }

    fn found(counted: Vec<Counted>) -> Option<CountMatch> {
        Index::new(counted).unwrap().0.along(&street(), 2, &CountSettings::default())
    }

    fn id(counted: Vec<Counted>) -> Option<String> {
        found(counted).map(|m| m.id)
    }

    #[test]
    fn a_line_along_the_street_is_its_count() {
        let found = found(vec![line("a", 9000.0, &[(3.0, -10.0), (3.0, 200.0)])]).unwrap();
        assert_eq!((found.aadt_veh_per_day, &*found.id), (9000.0, "a"));
        assert!((found.distance_m - 3.0).abs() < 0.02 && found.angle_deg < 0.1, "{found:?}");
    }

    #[test]
    fn a_road_that_crosses_above_is_not_taken() {
        assert_eq!(id(vec![line("above", 40_000.0, &[(-300.0, 50.0), (300.0, 60.0)])]), None);
        assert_eq!(id(vec![line("at 45", 9000.0, &[(-40.0, 0.0), (60.0, 100.0)])]), None);
    }

    #[test]
    fn a_freeway_beside_the_street_is_not_taken_but_the_next_best() {
        let freeway = line("freeway", 200_403.0, &[(1.0, 0.0), (1.0, 100.0)]);
        let own = line("own", 12_000.0, &[(9.0, 0.0), (9.0, 100.0)]);
        assert_eq!(id(vec![freeway.clone()]), None);
        assert_eq!(id(vec![freeway, own]), Some("own".into()));
    }

    #[test]
    fn a_parallel_road_much_farther_away_does_not_win_by_being_longer() {
        let own = line("own", 9000.0, &[(2.0, 0.0), (2.0, 70.0)]);
        let frontage = line("frontage", 9000.0, &[(25.0, -200.0), (25.0, 200.0)]);
        assert_eq!(id(vec![frontage, own]), Some("own".into()));
    }

    #[test]
    fn a_line_has_to_be_near_half_of_the_street() {
        assert_eq!(id(vec![line("a", 9000.0, &[(2.0, 70.0), (2.0, 300.0)])]), None);
        assert!(id(vec![line("a", 9000.0, &[(2.0, 40.0), (2.0, 300.0)])]).is_some());
        assert_eq!(id(vec![line("a", 9000.0, &[(30.5, 0.0), (30.5, 100.0)])]), None);
        assert!(id(vec![line("a", 9000.0, &[(29.5, 0.0), (29.5, 100.0)])]).is_some());
    }

    #[test]
    fn the_line_of_the_opposite_arm_is_not_taken() {
        let opposite = vec![line("opposite", 9000.0, &[(0.0, -200.0), (0.0, 0.0)])];
        let short = [(0.0, 0.0), (0.0, 35.0)].map(at);
        let index = Index::new(opposite).unwrap().0;
        assert_eq!(index.along(&short, 2, &CountSettings::default()), None);
    }

    #[test]
    fn a_station_counts_for_the_street_that_it_is_beside() {
        assert_eq!(id(vec![station("a", (8.0, 50.0), None)]), Some("a".into()));
        assert_eq!(id(vec![station("along", (8.0, 50.0), Some(185.0))]), Some("along".into()));
        assert_eq!(id(vec![station("across", (8.0, 50.0), Some(90.0))]), None);
        assert_eq!(id(vec![station("crossing street", (20.0, 0.0), None)]), None);
        assert_eq!(id(vec![station("far", (31.0, 50.0), None)]), None);
        let near = vec![station("b", (9.0, 30.0), None), station("c", (-4.0, 60.0), None)];
        assert_eq!(id(near), Some("c".into()));
    }

    fn flat(places: &[(f64, f64)]) -> Option<Street> {
        let places: Vec<_> =
            places.iter().map(|(y, x)| Place::from_degrees(*y, *x).unwrap()).collect();
        Street::new(&Plane::around(places[0]), &places)
    }

    #[test]
    fn a_long_street_is_compared_along_its_first_block() {
        let samples = flat(&[(40.0, -111.0), (40.01, -111.0)]).unwrap().samples();
        assert_eq!(samples.len(), 15);
        assert!((samples[0].0.y() - 5.0).abs() < 1e-6 && samples[0].1.abs() < 1e-6);
        assert!((samples[14].0.y() - 145.0).abs() < 1e-6);
    }

    #[test]
    fn a_short_street_is_compared_in_its_middle() {
        let samples = flat(&[(40.0, -111.0), (40.00004, -111.0)]).unwrap().samples();
        assert_eq!(samples.len(), 1);
        assert!((samples[0].0.y() - 2.224).abs() < 0.001, "{samples:?}");
    }

    #[test]
    fn a_street_without_length_has_no_place() {
        assert!(flat(&[(40.0, -111.0), (40.0, -111.0)]).is_none());
        assert!(flat(&[(40.0, -111.0)]).is_none());
    }

    #[test]
    fn the_direction_is_that_of_a_chord_not_of_a_crooked_piece() {
        let crooked =
            [(40.0, -111.0), (40.00045, -111.0), (40.00045, -110.99999), (40.001, -111.0)];
        let samples = flat(&crooked).unwrap().samples();
        assert!(samples.iter().all(|s| s.1.abs() < 8.0), "{samples:?}");
    }

    prop_compose! {
        fn any_line()(
            aadt in 1_u32..60_000,
            places in prop::collection::vec((-60_i32..60, -60_i32..160), 2..6),
        ) -> Counted {
            let places: Vec<_> = places.iter().map(|(x, y)| (f64::from(*x), f64::from(*y))).collect();
            line(&format!("{aadt}"), f64::from(aadt), &places)
        }
    }

    proptest! {
        #[test]
        fn the_order_of_lines_does_not_matter(
            lines in prop::collection::vec(any_line(), 1..9).prop_shuffle(),
        ) {
            let mut reversed = lines.clone();
            reversed.reverse();
            prop_assert_eq!(found(lines), found(reversed));
        }

        #[test]
        fn any_place_on_earth_is_joined_without_panic(
            lines in prop::collection::vec((-900_000_000..=900_000_000, -1_800_000_000..=1_800_000_000), 2..4),
            offset in -500..500_i32,
        ) {
            let places: Vec<_> = lines
                .into_iter()
                .map(|(latitude_e7, longitude_e7)| Place { latitude_e7, longitude_e7 })
                .collect();
            let street: Vec<_> = places
                .iter()
                .map(|p| Place { longitude_e7: p.longitude_e7 + offset, ..*p })
                .collect();
            let shape = Shape::Lines(vec![places]);
            let counted = Counted { id: "a".into(), aadt_veh_per_day: 1.0, direction: None, shape };
            drop(Index::new(vec![counted]).unwrap().0.along(&street, 1, &CountSettings::default()));
        }
    }
}

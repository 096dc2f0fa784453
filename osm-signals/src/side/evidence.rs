//! What the streets of an extract say of the side that traffic keeps to.
//!
//! - **Roundabouts:** seen from above, right-hand traffic goes round them anticlockwise. A way of one
//!   votes by its bend.
//! - **Carriageways:** the opposite carriageway of a divided street, a one-way street of the same name and
//!   class, is to the left of right-hand traffic. A way votes by where the nearest one is along most of
//!   its length.
//!
//! Streets that are one-way for other reasons, such as couplets a block apart, have no opposite
//! carriageway as near as a median is wide. Single votes may be wrong, such as those of carriageways that change sides at a
//! diverging diamond; many are not.

use std::collections::HashMap;

use serde::Serialize;

use crate::angle::turn_degrees;
use crate::driving_side::DrivingSide;
use crate::extract::{Extract, Place, Way};
use crate::geometry::{LocalMetric, bearing_deg};
use crate::tags::{Direction, Highway};

/// Least bend of a way of a roundabout that says in which sense it goes round, degrees.
const LEAST_BEND_DEG: f64 = 30.0;

/// Distance between opposite carriageways, least and most, metres: less is a mistake of drawing, more
/// is another street (the widest median that is one intersection is 45 m).
const APART_M: (f64, f64) = (3.0, 45.0);

/// Largest deviation of opposite carriageways from opposite directions, degrees.
const OPPOSITE_DEG: f64 = 25.0;

/// Shortest piece of a street that says where its opposite carriageway is, metres.
const LEAST_PIECE_M: f64 = 8.0;

/// Longest piece; longer ones are cut, so that a piece of the opposite carriageway begins near.
const LONGEST_PIECE_M: f64 = 40.0;

/// How far the middles of two pieces may lie apart along the street, metres.
const ALONG_M: f64 = 40.0;

/// Side of the squares in which pieces are looked up, metres: no two that matter are further apart.
const SQUARE_M: f64 = 64.0;

/// Ways that say right or left.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Votes {
    /// Ways that say right.
    pub right: usize,
    /// Ways that say left.
    pub left: usize,
}

impl Votes {
    /// Returns all ways that say something.
    pub fn total(self) -> usize {
        self.right + self.left
    }

    /// Returns the votes for a side.
    pub fn of(self, side: DrivingSide) -> usize {
        match side {
            DrivingSide::Right => self.right,
            DrivingSide::Left => self.left,
        }
    }

    fn add(&mut self, side: DrivingSide) {
        match side {
            DrivingSide::Right => self.right += 1,
            DrivingSide::Left => self.left += 1,
        }
    }
}

/// Says whether a place counts.
pub type Inside<'a> = &'a dyn Fn(Place) -> bool;

/// Returns the ways that begin at a place that counts, with their numbers.
fn ways<'a>(extract: &'a Extract, inside: Inside<'a>) -> impl Iterator<Item = (usize, &'a Way)> {
    extract.ways.iter().enumerate().filter(move |(_, way)| {
        let mut nodes = extract.nodes_of(way).iter().filter_map(|id| extract.nodes.index(*id));
        nodes.find_map(|n| extract.nodes.place(n)).is_some_and(inside)
    })
}

/// Returns what tags `driving_side` of streets say.
pub fn tags(extract: &Extract, inside: Inside<'_>) -> Votes {
    let mut votes = Votes::default();
    ways(extract, inside)
        .filter_map(|(_, w)| w.street.driving_side)
        .for_each(|side| votes.add(side));
    votes
}

/// Returns what the senses of roundabouts say.
pub fn roundabouts(extract: &Extract, inside: Inside<'_>) -> Votes {
    let mut votes = Votes::default();
    for (_, way) in ways(extract, inside).filter(|(_, w)| w.street.roundabout) {
        let places = as_traffic_goes(extract, way);
        let headings: Vec<f64> = places
            .windows(2)
            .filter(|pair| pair[0] != pair[1])
            .map(|pair| bearing_deg(pair[0], pair[1]))
            .collect();
        let closed = places.len() > 2 && places.first() == places.last();
        let ends = closed.then(|| headings.last().copied().zip(headings.first().copied()));
        let bends = headings.windows(2).map(|pair| (pair[0], pair[1])).chain(ends.flatten());
        let bend_deg: f64 = bends.map(|(from, to)| turn_degrees(from, to)).sum();
        if bend_deg.abs() >= LEAST_BEND_DEG {
            votes.add(if bend_deg < 0.0 { DrivingSide::Right } else { DrivingSide::Left });
        }
    }
    votes
}

/// A piece of a carriageway, metres east and north.
struct Piece<'a> {
    way: usize,
    name: &'a str,
    highway: Highway,
    middle: (f64, f64),
    /// Direction of traffic, of length 1.
    ahead: (f64, f64),
    length_m: f64,
}

/// Returns what the places of opposite carriageways say.
pub fn carriageways(extract: &Extract, inside: Inside<'_>) -> Votes {
    let pieces = pieces(extract, inside);
    let square =
        |(x, y): (f64, f64)| ((x / SQUARE_M).floor() as i32, (y / SQUARE_M).floor() as i32);
    let mut squares: HashMap<(i32, i32), Vec<usize>> = HashMap::new();
    for (index, piece) in pieces.iter().enumerate() {
        squares.entry(square(piece.middle)).or_default().push(index);
    }
    // Per way the metres that say right, less those that say left.
    let mut says: HashMap<usize, f64> = HashMap::new();
    for piece in &pieces {
        let (column, row) = square(piece.middle);
        let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| (column + i, row + j)));
        let near = around.filter_map(|place| squares.get(&place)).flatten();
        let opposite = near
            .filter_map(|other| to_the_left_m(piece, &pieces[*other]))
            .min_by(|a, b| a.abs().total_cmp(&b.abs()));
        if let Some(left_m) = opposite {
            *says.entry(piece.way).or_default() += piece.length_m * left_m.signum();
        }
    }
    let mut votes = Votes::default();
    for metres in says.into_values().filter(|metres| *metres != 0.0) {
        votes.add(if metres > 0.0 { DrivingSide::Right } else { DrivingSide::Left });
    }
    votes
}

/// Returns how far to the left of a piece another one lies, metres, if it is of the opposite carriageway.
fn to_the_left_m(piece: &Piece<'_>, other: &Piece<'_>) -> Option<f64> {
    if piece.highway != other.highway || piece.name != other.name {
        return None;
    }
    let dot = piece.ahead.0 * other.ahead.0 + piece.ahead.1 * other.ahead.1;
    let (dx, dy) = (other.middle.0 - piece.middle.0, other.middle.1 - piece.middle.1);
    let along_m = dx * piece.ahead.0 + dy * piece.ahead.1;
    let left_m = dy * piece.ahead.0 - dx * piece.ahead.1;
    let opposite = dot <= -OPPOSITE_DEG.to_radians().cos()
        && along_m.abs() <= ALONG_M
        && (APART_M.0..=APART_M.1).contains(&left_m.abs());
    opposite.then_some(left_m)
}

fn pieces<'a>(extract: &'a Extract, inside: Inside<'a>) -> Vec<Piece<'a>> {
    let mut pieces = Vec::new();
    let mut metric: Option<(Place, LocalMetric)> = None;
    for (index, way) in ways(extract, inside) {
        let street = &way.street;
        let one_way = street.direction != Direction::Both;
        let Some(name) = street.name.as_deref() else { continue };
        if !one_way || street.roundabout || street.highway.is_link() {
            continue;
        }
        for pair in as_traffic_goes(extract, way).windows(2) {
            // Metres about one latitude for all: directions and distances of neighbours nearly hold,
            // and sides do.
            let (origin, metric) =
                *metric.get_or_insert((pair[0], LocalMetric::at(pair[0].latitude())));
            let at = |p: Place| {
                metric.offset_m(
                    (origin.latitude(), origin.longitude()),
                    (p.latitude(), p.longitude()),
                )
            };
            let (a, b) = (at(pair[0]), at(pair[1]));
            let (dx, dy) = (b.0 - a.0, b.1 - a.1);
            let length_m = dx.hypot(dy);
            if length_m < LEAST_PIECE_M {
                continue;
            }
            let parts = (length_m / LONGEST_PIECE_M).ceil();
            pieces.extend((0..parts as u32).map(|part| {
                let share = (f64::from(part) + 0.5) / parts;
                Piece {
                    way: index,
                    name,
                    highway: street.highway,
                    middle: (a.0 + share * dx, a.1 + share * dy),
                    ahead: (dx / length_m, dy / length_m),
                    length_m: length_m / parts,
                }
            }));
        }
    }
    pieces
}

/// Returns the places of a one-way street in the direction of its traffic.
fn as_traffic_goes(extract: &Extract, way: &Way) -> Vec<Place> {
    let nodes = extract.nodes_of(way).iter().filter_map(|id| extract.nodes.index(*id));
    let mut places: Vec<Place> = nodes.filter_map(|n| extract.nodes.place(n)).collect();
    if way.street.direction == Direction::Backward {
        places.reverse();
    }
    places
}

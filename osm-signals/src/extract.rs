//! What is kept of an OpenStreetMap file: drivable ways, the nodes on them, signals and turn
//! restrictions. Its size is that of the streets, not of the file.

use std::ops::Range;

use super::hours::Hours;
use super::oddities::Oddities;
use super::tags::{SignalTags, Street};

/// Units of [`Place`] per degree, as in OpenStreetMap's own files.
const PER_DEGREE: f64 = 1e7;

/// A position, WGS 84, in units of 1e-7 degrees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// Latitude.
    pub latitude_e7: i32,
    /// Longitude.
    pub longitude_e7: i32,
}

impl Place {
    /// Returns a place; `None` outside the world.
    pub fn from_degrees(latitude: f64, longitude: f64) -> Option<Self> {
        let inside = (-90.0..=90.0).contains(&latitude) && (-180.0..=180.0).contains(&longitude);
        inside.then(|| Self {
            latitude_e7: (latitude * PER_DEGREE).round() as i32,
            longitude_e7: (longitude * PER_DEGREE).round() as i32,
        })
    }

    /// Returns the place with east and west exchanged.
    #[must_use]
    pub fn mirrored(self) -> Self {
        Self { longitude_e7: -self.longitude_e7, ..self }
    }

    /// Returns the latitude, degrees.
    pub fn latitude(self) -> f64 {
        f64::from(self.latitude_e7) / PER_DEGREE
    }

    /// Returns the longitude, degrees.
    pub fn longitude(self) -> f64 {
        f64::from(self.longitude_e7) / PER_DEGREE
    }
}

/// A drivable way.
#[derive(Debug, Clone, PartialEq)]
pub struct Way {
    /// OpenStreetMap's id.
    pub id: i64,
    /// Its nodes, as positions in [`Extract::refs`].
    pub refs: Range<usize>,
    /// What its tags say.
    pub street: Street,
}

/// A node with `highway=traffic_signals`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SignalNode {
    /// OpenStreetMap's id.
    pub id: i64,
    /// Where it is.
    pub place: Place,
    /// What its other tags say.
    pub tags: SignalTags,
}

/// Through what a turn restriction leads.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Via {
    /// A node.
    Node(i64),
    /// One or more ways, in order.
    Ways(Vec<i64>),
}

/// A turn restriction; one per pair of ways if the relation names several.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Restriction {
    /// Way that it starts on.
    pub from: i64,
    /// What lies between.
    pub via: Via,
    /// Way that it ends on.
    pub to: i64,
    /// Whether this is the only way on (`only_*`) instead of one that is forbidden (`no_*`).
    pub only: bool,
    /// Times at which it holds; `None` if always.
    pub when: Option<Hours>,
}

impl Restriction {
    /// Returns whether it holds in an hour of a working day that begins at a time, hours after midnight.
    pub fn holds(&self, time_of_day: f64) -> bool {
        self.when.as_ref().is_none_or(|hours| hours.hold(time_of_day))
    }
}

/// The nodes on drivable ways, sorted by id.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Nodes {
    ids: Vec<i64>,
    places: Vec<Option<Place>>,
}

impl Nodes {
    /// Whether any of them has a place.
    pub fn have_places(&self) -> bool {
        self.places.iter().any(Option::is_some)
    }

    /// Returns the nodes to look for; none has a place yet.
    pub fn wanted(mut ids: Vec<i64>) -> Self {
        ids.sort_unstable();
        ids.dedup();
        ids.shrink_to_fit();
        let places = vec![None; ids.len()];
        Self { ids, places }
    }

    /// Returns the position of a node.
    pub fn index(&self, id: i64) -> Option<usize> {
        self.ids.binary_search(&id).ok()
    }

    /// Sets where a node is, unless it is not wanted.
    pub fn set(&mut self, id: i64, place: Place) {
        if let Some(index) = self.index(id) {
            self.places[index] = Some(place);
        }
    }

    /// Returns the id of a node by its position.
    pub fn id(&self, index: usize) -> i64 {
        self.ids[index]
    }

    /// Returns where a node is; `None` if the file does not have it.
    pub fn place(&self, index: usize) -> Option<Place> {
        self.places[index]
    }

    /// Exchanges east and west.
    pub fn mirror(&mut self) {
        for place in self.places.iter_mut().flatten() {
            *place = place.mirrored();
        }
    }

    /// Returns how many there are.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Returns whether there is none.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }
}

/// What is kept of a file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Extract {
    /// Drivable ways, by id.
    pub ways: Vec<Way>,
    /// Node ids of all ways, one after the other.
    pub refs: Vec<i64>,
    /// Nodes on the ways.
    pub nodes: Nodes,
    /// Signals, by id; also those that are on no drivable way.
    pub signals: Vec<SignalNode>,
    /// Nodes on the ways that are crossings of pedestrians with signals, but no signals for vehicles, by id.
    pub crossings: Vec<i64>,
    /// Nodes on the ways with a stop or give-way sign, by id.
    pub signs: Vec<i64>,
    /// Turn restrictions for motor vehicles, between ways that are kept.
    pub restrictions: Vec<Restriction>,
    /// What was skipped and why.
    pub oddities: Oddities,
}

impl Extract {
    /// Returns the node ids of a way.
    pub fn nodes_of(&self, way: &Way) -> &[i64] {
        &self.refs[way.refs.clone()]
    }

    /// Returns how many turn restrictions that hold at certain times only hold in an hour of a working day, and
    /// how many there are.
    ///
    /// # Arguments
    ///
    /// * `time_of_day` — when the hour begins, hours after midnight.
    pub fn timed_restrictions(&self, time_of_day: f64) -> (usize, usize) {
        let timed = || self.restrictions.iter().filter(|r| r.when.is_some());
        (timed().filter(|r| r.holds(time_of_day)).count(), timed().count())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_outside_the_world_is_none() {
        assert!(Place::from_degrees(40.76, -111.83).is_some());
        assert!(Place::from_degrees(-111.83, 40.76).is_none());
        assert!(Place::from_degrees(f64::NAN, 0.0).is_none());
    }

    #[test]
    fn a_node_that_is_not_wanted_is_not_kept() {
        let mut nodes = Nodes::wanted(vec![5, 3, 5]);
        let place = Place { latitude_e7: 1, longitude_e7: 2 };
        nodes.set(4, place);
        nodes.set(5, place);
        assert_eq!(nodes.len(), 2);
        assert_eq!((nodes.place(0), nodes.place(1)), (None, Some(place)));
    }
}

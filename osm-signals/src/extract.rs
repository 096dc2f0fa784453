//! What is kept of an OpenStreetMap file: drivable ways, the nodes on them, signals and turn
//! restrictions. Its size is that of the streets, not of the file.

use std::ops::Range;

use super::oddities::Oddities;
use super::tags::{SignalTags, Street};

/// Units of [`Place`] per degree, as in OpenStreetMap's own files.
const PER_DEGREE: f64 = 1e7;

const DAYS: [&str; 7] = ["Mo", "Tu", "We", "Th", "Fr", "Sa", "Su"];

/// A Tuesday stands for any working day, and its night begins on Monday.
const MONDAY: usize = 0;
const TUESDAY: usize = 1;

const DAY_MIN: u32 = 24 * 60;

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
    /// Their ids.
    pub ids: Vec<i64>,
    /// Where they are; `None` if the file does not have them.
    pub places: Vec<Option<Place>>,
}

impl Nodes {
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
    /// how many there are; `time_of_day` is when the hour begins, hours after midnight.
    pub fn timed_restrictions(&self, time_of_day: f64) -> (usize, usize) {
        let timed = || self.restrictions.iter().filter(|r| r.when.is_some());
        (timed().filter(|r| r.holds(time_of_day)).count(), timed().count())
    }
}

/// Times at which a turn restriction holds: one range of days with ranges of hours, such as
/// `Mo-Fr 07:00-09:00,16:00-18:00; PH off`, and whether they hold in the simulated hour of a working day.
///
/// Source: <https://wiki.openstreetmap.org/wiki/Conditional_restrictions>.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hours {
    /// Whether a range may begin on Monday, and on Tuesday.
    begins: [bool; 2],
    /// Begin and end, minutes after midnight; one that ends before it begins lasts into the next day.
    ranges: Vec<(u32, u32)>,
}

impl Hours {
    /// Returns the times that a text says; `None` if it says something else, such as a weight.
    pub fn parse(text: &str) -> Option<Self> {
        let mut rules = text.split(';').map(str::trim).filter(|r| !matches!(*r, "" | "PH off"));
        let (rule, None) = (rules.next()?, rules.next()) else { return None };
        let rule = if rule == "24/7" { "00:00-24:00" } else { rule };
        let (days, hours) = rule.split_at(rule.find(|c: char| c.is_ascii_digit())?);
        let mut begins = [days.trim().is_empty(); 2];
        for range in days.split(',').map(str::trim).filter(|range| !range.is_empty()) {
            let (first, last) = range.split_once('-').unwrap_or((range, range));
            let is = |day: &str, of| day.get(..2).is_some_and(|d| d.eq_ignore_ascii_case(of));
            let at = |day: &str| DAYS.iter().position(|known| is(day.trim(), known));
            let (first, last) = (at(first)?, at(last)?);
            let after = |day: usize| (day + DAYS.len() - first) % DAYS.len();
            for (begins, day) in begins.iter_mut().zip([MONDAY, TUESDAY]) {
                *begins |= after(day) <= after(last);
            }
        }
        let ranges = hours.split(',').map(|range| {
            let (begin, end) = range.trim().split_once('-')?;
            Some((minute(begin)?, minute(end)?))
        });
        Some(Self { begins, ranges: ranges.collect::<Option<_>>()? })
    }

    /// Whether they hold in the middle of the hour of a working day that begins at a time, hours after midnight.
    fn hold(&self, time_of_day: f64) -> bool {
        let now = (time_of_day.rem_euclid(24.0) * 60.0 + 30.0) as u32 % DAY_MIN;
        let [monday, tuesday] = self.begins;
        self.ranges.iter().any(|(begin, end)| match begin < end {
            true => tuesday && (*begin..*end).contains(&now),
            false => (tuesday && now >= *begin) || (monday && now < *end),
        })
    }
}

fn minute(time: &str) -> Option<u32> {
    let (hour, minute) = time.trim().split_once(':')?;
    let minute = 60 * hour.parse::<u32>().ok()? + minute.parse::<u32>().ok().filter(|m| *m < 60)?;
    (minute <= DAY_MIN).then_some(minute)
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
        assert_eq!(nodes.places, [None, Some(place)]);
    }

    #[test]
    fn times_hold_on_a_working_day() {
        for (text, hours) in [
            ("Mo-Fr 07:00-09:00,16:00-18:00", &[7.0, 8.0, 16.5][..]),
            ("07:00-23:00", &[7.0, 8.0, 10.0, 16.5, 18.0]),
            ("Sa,Su 07:00-23:00", &[]),
            ("24/7", &[3.0, 7.0, 8.0, 10.0, 16.5, 18.0]),
            ("22:00-06:00", &[3.0]),
            ("Su-Mo 22:00-06:00", &[3.0]),
            ("Fr-Tu 06:00-10:00; PH off", &[7.0, 8.0]),
        ] {
            let parsed = Hours::parse(text).unwrap();
            let held = [3.0, 7.0, 8.0, 10.0, 16.5, 18.0].into_iter().filter(|t| parsed.hold(*t));
            assert_eq!(held.collect::<Vec<_>>(), hours, "{text}");
        }
    }

    #[test]
    fn what_is_no_time_is_none() {
        let weight = "Mo-Fr 07:00-09:00 AND weight>3.5";
        for text in ["weight>3.5", weight, "", "sometimes", "Mo-Fr 07:00-09:00; Sa 08:00-09:00"] {
            assert_eq!(Hours::parse(text), None, "{text}");
        }
    }
}

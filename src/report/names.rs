//! What point MDPs and intersections are called: by their streets, where a map knows them.

use super::data::ReportData;
use crate::store::places::Place;

/// Intersections of a point MDP that are named; more are counted.
const NAMED: usize = 3;

impl ReportData {
    /// Returns the intersections of a point MDP.
    pub(super) fn places_of<'a>(&'a self, point: &'a str) -> impl Iterator<Item = &'a Place> {
        self.places.intersections.iter().filter(move |place| place.point == point)
    }

    /// Returns the streets of the intersections of a point MDP, those of the first few by name; `None`
    /// when none has a name.
    pub(super) fn streets_of(&self, point: &str) -> Option<String> {
        let places: Vec<&Place> = self.places_of(point).collect();
        let mut named: Vec<String> = places.iter().filter_map(|p| streets(p)).take(NAMED).collect();
        if named.is_empty() {
            return None;
        }
        if places.len() > named.len() {
            named.push(format!("and {} more", places.len() - named.len()));
        }
        Some(named.join("; "))
    }

    /// Returns what a point MDP is called: by its streets where it is one intersection, else as its table
    /// does.
    pub(super) fn title_of(&self, point: &str) -> String {
        let mut places = self.places_of(point);
        if let (Some(streets), None) = (places.next().and_then(streets), places.next()) {
            return streets;
        }
        let row = self.points.iter().find(|p| p.row.point == point);
        row.map_or(point, |p| p.row.name()).to_owned()
    }

    /// Returns what every point MDP is called, in the order of [`ReportData::points`]; `None` where all
    /// are called by their ids, so that tables need no column for it.
    pub(super) fn titles(&self) -> Option<Vec<String>> {
        let titles: Vec<String> = self.points.iter().map(|p| self.title_of(&p.row.point)).collect();
        let differ = self.points.iter().zip(&titles).any(|(p, title)| p.row.point != *title);
        differ.then_some(titles)
    }

    /// Returns what a point MDP is called with its id behind it, for those who have to type that.
    pub(super) fn called(&self, point: &str) -> String {
        match self.title_of(point) {
            title if title == point => title,
            title => format!("{title} ({point})"),
        }
    }
}

/// Returns the streets of an intersection; `None` when the map names none.
pub(super) fn streets(place: &Place) -> Option<String> {
    (!place.streets.is_empty()).then(|| place.streets.join(" / "))
}

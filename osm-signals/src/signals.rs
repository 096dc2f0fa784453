//! Signal lists: a table of the signals that a city or state operates.
//!
//! An extract tells where OpenStreetMap's contributors have seen a signal; such a list tells
//! where one is by its operator. One row is one signal, with its place and, if it has one, its id.

use std::collections::BTreeMap;
use std::path::Path;

use geo::{BoundingRect, Coord, LineString, Rect};
use serde::{Deserialize, Serialize};

use super::error::{OsmError, brief};
use super::extract::Place;
use super::file;
use super::table::{Column, Table};

/// Usual names of the column with the id.
const ID: [&str; 5] = ["id", "signal", "signal_id", "signalid", "name"];

/// Names of a signal list's columns, where they are not among the usual ones.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SignalColumns {
    /// Column with the id; usual are id, signal, signal_id, signalid, name. Without one, rows are
    /// numbered.
    pub id: Option<String>,
    /// Column with the latitude, degrees, WGS 84; usual are latitude, lat, y.
    pub latitude: Option<String>,
    /// Column with the longitude, degrees, WGS 84; usual are longitude, lon, lng, long, x.
    pub longitude: Option<String>,
}

/// A signal of a list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ListedSignal {
    /// Its id, or else the number of its row, from 1.
    pub id: String,
    /// Where it is.
    pub place: Place,
    /// Line of the file.
    pub line: u64,
}

/// The signals of a list, in the order of the file; at least one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SignalList {
    /// The signals.
    pub signals: Vec<ListedSignal>,
}

impl SignalList {
    /// Reads a list.
    ///
    /// # Errors
    ///
    /// [`OsmError`] naming the file and the line: a column that is missing, a place outside the
    /// world, an id that comes twice, no signal at all.
    pub fn read(path: &Path, columns: &SignalColumns) -> Result<Self, OsmError> {
        Self::from_bytes(&file::bytes(path)?, path, columns)
    }

    /// Reads a list from the bytes of a file; `path` is for messages only.
    ///
    /// # Errors
    ///
    /// As [`SignalList::read`].
    pub fn from_bytes(
        bytes: &[u8],
        path: &Path,
        columns: &SignalColumns,
    ) -> Result<Self, OsmError> {
        let mut table = Table::open(bytes, path)?;
        let id = Column { what: "id", given: columns.id.as_deref(), usual: &ID };
        let id = table.find(&id)?;
        let at = (
            table.need(&Column::latitude(columns.latitude.as_deref()))?,
            table.need(&Column::longitude(columns.longitude.as_deref()))?,
        );
        let mut signals: Vec<ListedSignal> = Vec::new();
        let mut lines: BTreeMap<String, u64> = BTreeMap::new();
        while let Some(row) = table.next_row()? {
            let line = row.line;
            let id = match id.map(|column| row.text(column)) {
                None => (signals.len() + 1).to_string(),
                Some("") => {
                    let reason = "no id; give every signal one, or remove the column to number \
                                  the rows";
                    return Err(table.error(line, reason.to_owned()));
                }
                Some(id) => id.to_owned(),
            };
            if let Some(first) = lines.insert(id.clone(), line) {
                let id = brief(&id);
                let reason = format!(
                    "signal {id} is on line {first} already; if these are two signals, name a column that \
                     tells them apart (`id` in [signals] of the settings), else remove one of them"
                );
                return Err(table.error(line, reason));
            }
            signals.push(ListedSignal { id, place: table.place(&row, at)?, line });
        }
        if signals.is_empty() {
            return Err(table.nothing("no signal below the first line; give one row per signal"));
        }
        Ok(Self { signals })
    }

    /// Returns the smallest box around all signals but those at (0, 0), where programs put what has
    /// no place: x is the longitude and y the latitude, degrees.
    pub fn bounds(&self) -> Rect<f64> {
        let at = |p: Place| Coord { x: p.longitude(), y: p.latitude() };
        let somewhere = |p: &Coord<f64>| *p != Coord::zero();
        let places = self.signals.iter().map(|s| at(s.place)).filter(somewhere);
        let bounds = places.collect::<LineString<_>>().bounding_rect();
        bounds.unwrap_or_else(|| Rect::new(Coord::zero(), Coord::zero()))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn read(text: &str) -> Result<Vec<ListedSignal>, String> {
        SignalList::from_bytes(text.as_bytes(), Path::new("s.csv"), &SignalColumns::default())
            .map(|list| list.signals)
            .map_err(|e| e.to_string())
    }

    #[test]
    fn a_list_keeps_ids_places_and_lines() {
        let signals = read("SIGNAL,TYPE,LAT,LNG\n1001,Signal,40.78,-111.92\n").unwrap();
        let place = Place::from_degrees(40.78, -111.92).unwrap();
        assert_eq!(signals, [ListedSignal { id: "1001".into(), place, line: 2 }]);
    }

    #[test]
    fn rows_without_an_id_column_are_numbered() {
        let signals = read("y,x\n40,-111\n41,-111\n").unwrap();
        assert_eq!(signals.iter().map(|s| &*s.id).collect::<Vec<_>>(), ["1", "2"]);
    }

    #[test]
    fn an_id_that_comes_twice_names_both_lines() {
        let reason = read("id,y,x\n7,40,-111\n8,41,-111\n7,40,-111\n").unwrap_err();
        assert_eq!(
            reason,
            "s.csv, line 4: signal 7 is on line 2 already; if these are two signals, name a column that \
             tells them apart (`id` in [signals] of the settings), else remove one of them"
        );
        let long = "7".repeat(100_000);
        let reason = read(&format!("id,y,x\n{long},40,-111\n{long},40,-111\n")).unwrap_err();
        assert!(reason.len() < 300, "{reason}");
    }

    #[test]
    fn bounds_are_those_of_all_signals() {
        let text = "y,x\n40,-111\n41.5,-112\n40.5,-110\n";
        let list =
            SignalList::from_bytes(text.as_bytes(), Path::new("s"), &SignalColumns::default());
        let bounds = list.unwrap().bounds();
        assert_eq!(bounds.min(), Coord { x: -112.0, y: 40.0 });
        assert_eq!(bounds.max(), Coord { x: -110.0, y: 41.5 });
    }

    #[test]
    fn a_missing_id_and_a_list_without_rows_are_refused() {
        assert!(read("id,y,x\n,40,-111\n").unwrap_err().contains("line 2: no id"));
        assert!(read("id,y,x\n").unwrap_err().contains("no signal below the first line"));
    }

    #[test]
    fn columns_with_other_names_can_be_given() {
        let columns: SignalColumns =
            toml::from_str("latitude = \"Breite\"\nlongitude = \"Länge\"").unwrap();
        let text = "Breite,LÄNGE\n40,-111\n";
        let list = SignalList::from_bytes(text.as_bytes(), Path::new("s.csv"), &columns).unwrap();
        assert_eq!(list.signals.len(), 1);
        assert!(toml::from_str::<SignalColumns>("lat = \"y\"").is_err());
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let columns = SignalColumns::default();
            drop(SignalList::from_bytes(&bytes, Path::new("s.csv"), &columns));
        }

        #[test]
        fn any_rows_are_read_or_refused(rows in "[0-9;,.\"\\-\r\n a]{0,80}") {
            drop(read(&format!("id,lat,lon\n{rows}")));
        }
    }
}

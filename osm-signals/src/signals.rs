//! Signal lists: a table of the signals that a city or state operates.
//!
//! An extract tells where OpenStreetMap's contributors have seen a signal; such a list tells
//! where one is by its operator. One row is one signal, with its place and, if it has one, its id.
//!
//! A place is a latitude and a longitude, a text `POINT (longitude latitude)`, or the point of a feature. Lists mix
//! signals with beacons, flashers and planned ones; [`SignalColumns::keep`] says which rows count.

mod choice;

use std::collections::BTreeMap;
use std::path::Path;

use geo::{BoundingRect, Coord, LineString, Rect};
use serde::{Deserialize, Serialize};

use choice::{conditions, doubt, kinds, named};

use super::error::{OsmError, brief};
use super::extract::Place;
use super::file;
use super::geometry::{checked_place, distance_m};
use super::sources::Source;
use super::table::{Column, Table};
use super::wkt;

/// Usual names of the column with the id, the best one first: counts and plans refer to the number of a signal or
/// intersection, and `id` may be that of a row in a database.
const ID: [&str; 38] = [
    "signal_id", "signalid", "signal_number", "signalnumber", "signal_num", "signalnum",
    "signal_no", "signalno", "signal_no.", "signal_#", "sig_id", "sigid", "sig_number", "sig_num",
    "sig_no", "traffic_signal_id", "intersection_id", "intersectionid", "intersection_number",
    "intersection_no", "int_id", "intid", "int_num", "int_no", "int", "node_id", "nodeid", "node",
    "site_id", "location_id", "asset_id", "assetid", "facilityid", "id", "signal", "name",
    "objectid", "object_id",
];

/// Those of them that number the rows of a database, and may be others in its next export.
const OF_ROWS: [&str; 2] = ["objectid", "object_id"];

/// Those of them that are no number of a signal where a list has another column with an id.
const NO_NUMBERS: [&str; 3] = ["name", OF_ROWS[0], OF_ROWS[1]];

/// Usual names of the column with a text `POINT (...)`.
const POINT: [&str; 10] = [
    "shape", "the_geom", "geom", "geometry", "wkt", "wkt_geom", "point", "location",
    "georeference", "geo_point",
];

/// Usual names of the column with the controller; a column `controller` mostly has its type.
const CONTROLLER: [&str; 2] = ["controller_id", "controllerid"];

/// Farthest that a signal may be from the next one of its controller to be at the same intersection, metres: more than the
/// ramps of an interchange with one controller are apart, less than a block of most cities. This project's choice.
const ONE_CONTROLLER_M: f64 = 250.0;

/// Names of a signal list's columns, where they are not among the usual ones, and which of its rows count.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SignalColumns {
    /// Column with the id; usual are signal_id, intersection_id, node, id, signal, name and the like. Without one, rows
    /// are numbered.
    pub id: Option<String>,
    /// Column with the latitude, degrees, WGS 84; usual are latitude, lat, y and the like.
    pub latitude: Option<String>,
    /// Column with the longitude, degrees, WGS 84; usual are longitude, lon, lng, long, x and the like.
    pub longitude: Option<String>,
    /// Column with a text `POINT (longitude latitude)`, WGS 84; usual are shape, the_geom, geom, wkt and the like.
    pub point: Option<String>,
    /// Column with the controller: signals with one value are one intersection. Usual is controller_id.
    pub controller: Option<String>,
    /// Which rows count, each `COLUMN=VALUE` or `COLUMN!=VALUE`, whatever the case of letters: of one column
    /// any of the values, and what all columns say.
    #[serde(rename = "where")]
    pub keep: Vec<String>,
}

/// A signal of a list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ListedSignal {
    /// Its id, or else the number of its row, from 1.
    pub id: String,
    /// Where it is; latitude 0, longitude 0 if its row has no place.
    pub place: Place,
    /// Line of the file; of features and workbooks the number of the feature or row.
    pub line: u64,
    /// Its controller, if the list has a column for it.
    pub controller: Option<String>,
}

/// The signals of a list, in the order of the file; at least one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SignalList {
    /// The signals.
    pub signals: Vec<ListedSignal>,
    /// How many rows were left out by [`SignalColumns::keep`].
    pub left_out: usize,
    /// What may be no signal or not its id, and the way out.
    pub doubts: Vec<String>,
}

/// Where the place of a row stands.
enum At {
    /// In two columns.
    Degrees(usize, usize),
    /// In a text.
    Text(usize),
}

impl SignalList {
    /// Reads a list: CSV, a workbook, GeoJSON points, a shapefile, or an archive with one of these.
    ///
    /// # Errors
    ///
    /// [`OsmError`] naming the file and the line: a column that is missing, a place outside the
    /// world, an id that comes twice, no signal at all.
    pub fn read(path: &Path, columns: &SignalColumns) -> Result<Self, OsmError> {
        Self::from_bytes(&file::bytes(path)?, path, columns)
    }

    /// Reads a list from the bytes of a file; `path` is for messages, and for the other files of a shapefile.
    ///
    /// # Errors
    ///
    /// As [`SignalList::read`].
    pub fn from_bytes(
        bytes: &[u8],
        path: &Path,
        columns: &SignalColumns,
    ) -> Result<Self, OsmError> {
        let source = Source::of(bytes, path)?;
        let mut table = Table::with_rows(&source.bytes, path, source.rows)?;
        let id = Column { what: "id", given: columns.id.as_deref(), usual: &ID };
        let id = table.find(&id)?;
        let id_doubt = columns.id.is_none().then(|| id_doubt(&table, id)).flatten();
        let controller =
            Column { what: "controller", given: columns.controller.as_deref(), usual: &CONTROLLER };
        let controller = table.find(&controller)?;
        let at = places(&table, columns)?;
        let conditions = conditions(&table, &columns.keep)?;
        let kinds = kinds(&table, &conditions);
        let mut found: BTreeMap<usize, BTreeMap<String, usize>> = BTreeMap::new();
        let mut left: BTreeMap<usize, BTreeMap<String, usize>> = BTreeMap::new();
        let mut list = Self { signals: Vec::new(), left_out: 0, doubts: Vec::new() };
        let mut lines: BTreeMap<String, u64> = BTreeMap::new();
        let mut number = 0;
        while let Some(row) = table.next_row()? {
            let line = row.line;
            number += 1;
            let value = |column: usize| row.text(column).to_lowercase();
            if let Some(condition) = conditions.iter().find(|c| !c.holds(&value(c.column))) {
                let values = left.entry(condition.column).or_default();
                *values.entry(row.text(condition.column).to_owned()).or_default() += 1;
                list.left_out += 1;
                continue;
            }
            let id = match id.map(|column| row.text(column)) {
                None => number.to_string(),
                Some("") => {
                    let reason = "no id; give every signal one, or remove the column to number \
                                  the rows";
                    return Err(table.error(line, reason.to_owned()));
                }
                Some(id) => id.to_owned(),
            };
            if let Some(first) = lines.insert(id.clone(), line) {
                let id = brief(&id);
                let first = table.number_of(first);
                let reason = format!(
                    "signal {id} is on line {first} already; if these are two signals, name a column that \
                     tells them apart (`id` in [signals] of the settings), else remove one of them"
                );
                return Err(table.error(line, reason));
            }
            for kind in &kinds {
                *found.entry(*kind).or_default().entry(row.text(*kind).to_owned()).or_default() +=
                    1;
            }
            let controller = controller.map(|column| row.text(column)).filter(|c| !c.is_empty());
            list.signals.push(ListedSignal {
                id,
                place: at.place(&table, &row)?,
                line: table.number_of(line),
                controller: controller.map(str::to_owned),
            });
        }
        if list.signals.is_empty() {
            let reason = match left.iter().next() {
                Some((column, values)) => format!(
                    "no row is as asked for; column {} has {}",
                    brief(table.name(*column)),
                    named(values)
                ),
                None => "no signal below the first line; give one row per signal".to_owned(),
            };
            return Err(table.nothing(&reason));
        }
        if list
            .signals
            .iter()
            .all(|signal| (signal.place.latitude_e7, signal.place.longitude_e7) == (0, 0))
        {
            return Err(table.nothing(&at.without_places(&table)));
        }
        let kinds = found.into_iter().filter_map(|(c, values)| doubt(table.name(c), &values));
        list.doubts = id_doubt.into_iter().chain(kinds).collect();
        list.doubts.extend(part_controllers(&mut list.signals));
        Ok(list)
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

impl At {
    /// Returns the place of a row; latitude 0, longitude 0 for one without any.
    fn place(&self, table: &Table<'_>, row: &sheet::Row) -> Result<Place, OsmError> {
        let nowhere = Place { latitude_e7: 0, longitude_e7: 0 };
        match *self {
            Self::Degrees(latitude, longitude) => {
                let empty = row.text(latitude).is_empty() && row.text(longitude).is_empty();
                if empty { Ok(nowhere) } else { table.place(row, (latitude, longitude)) }
            }
            Self::Text(column) => match row.text(column) {
                "" => Ok(nowhere),
                text => wkt::point(text)
                    .and_then(|(latitude, longitude)| checked_place(latitude, longitude))
                    .map_err(|reason| table.error(row.line, reason)),
            },
        }
    }

    /// Returns what is wrong with a list of which no row has a place.
    fn without_places(&self, table: &Table<'_>) -> String {
        let name = |column: usize| brief(table.name(column));
        let (read, settings) = match *self {
            Self::Degrees(latitude, longitude) => (
                format!("columns {} and {}", name(latitude), name(longitude)),
                "`latitude` and `longitude`",
            ),
            Self::Text(column) => (format!("column {}", name(column)), "`point`"),
        };
        format!(
            "no row has a place in the {read}; fill them in, or name other columns ({settings} in [signals] of the \
             settings)"
        )
    }
}

/// Says which column has the id where others could have it, and where ids may change from one export to the next.
fn id_doubt(table: &Table<'_>, id: Option<usize>) -> Option<String> {
    let Some(id) = id else {
        let doubt = "no column has an id, so that the rows are numbered, and change their numbers with their order; name a \
                     column as `id` in [signals] of the settings";
        return Some(doubt.to_owned());
    };
    let of_rows = Column { what: "id", given: None, usual: &OF_ROWS };
    if table.find(&of_rows).ok().flatten() == Some(id) {
        return Some(format!(
            "the id is {}, which numbers the rows of a database and may change with each export; name a column with the \
             number of the signal as `id` in [signals] of the settings",
            brief(table.name(id))
        ));
    }
    let could = ID.iter().filter(|name| !NO_NUMBERS.contains(name)).filter_map(|name| {
        let column = Column { what: "id", given: None, usual: std::slice::from_ref(name) };
        table.find(&column).ok().flatten()
    });
    let could: Vec<String> = could.map(|column| brief(table.name(column))).collect();
    (could.len() > 1).then(|| {
        format!(
            "several columns could be the id ({}), and {} is used; name another one as `id` in [signals] of the \
             settings",
            could.join(", "),
            brief(table.name(id))
        )
    })
}

/// Returns where the places of a list stand.
fn places(table: &Table<'_>, columns: &SignalColumns) -> Result<At, OsmError> {
    let text = Column { what: "point", given: columns.point.as_deref(), usual: &POINT };
    let degrees = [
        Column::latitude(columns.latitude.as_deref()),
        Column::longitude(columns.longitude.as_deref()),
    ];
    if columns.point.is_none() {
        let found = [table.find(&degrees[0])?, table.find(&degrees[1])?];
        if let [Some(latitude), Some(longitude)] = found {
            return Ok(At::Degrees(latitude, longitude));
        }
        let named = columns.latitude.is_some() || columns.longitude.is_some();
        if let Some(column) = table.find(&text)?.filter(|_| !named) {
            return Ok(At::Text(column));
        }
        return Ok(At::Degrees(table.need(&degrees[0])?, table.need(&degrees[1])?));
    }
    Ok(At::Text(table.need(&text)?))
}

/// Gives signals of one controller that are not near each other controllers of their own, and says so: one intersection
/// cannot have them all, and a column may hold another thing, such as the type of the controller.
fn part_controllers(signals: &mut [ListedSignal]) -> Option<String> {
    let mut of: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (row, signal) in signals.iter().enumerate() {
        if let Some(controller) = &signal.controller {
            of.entry(controller.clone()).or_default().push(row);
        }
    }
    let mut apart: Vec<(String, usize)> = Vec::new();
    for (controller, mut rows) in of {
        let mut parts = 0;
        while let Some(first) = rows.pop() {
            let mut part = vec![first];
            let mut next = 0;
            while let Some(from) = part.get(next).map(|row| signals[*row].place) {
                let near = |row: &usize| distance_m(from, signals[*row].place) <= ONE_CONTROLLER_M;
                part.extend(rows.extract_if(.., |row| near(row)));
                next += 1;
            }
            parts += 1;
            if parts > 1 {
                part.iter().for_each(|row| {
                    signals[*row].controller = Some(format!("{controller} {parts}"))
                });
            }
        }
        if parts > 1 {
            apart.push((controller, parts));
        }
    }
    let (controller, parts) = apart.first()?;
    Some(format!(
        "{} controllers have signals more than {ONE_CONTROLLER_M} m from their others, which stay intersections of their \
         own: {} has {parts} places",
        apart.len(),
        brief(controller)
    ))
}

#[cfg(test)]
mod tests;

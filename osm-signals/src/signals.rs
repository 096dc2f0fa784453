//! Signal lists: a table of the signals that a city or state operates.
//!
//! An extract tells where OpenStreetMap's contributors have seen a signal; such a list tells
//! where one is by its operator. One row is one signal, with its place and, if it has one, its id.
//!
//! A place is a latitude and a longitude, a text `POINT (longitude latitude)`, or the point of a feature. Lists mix
//! signals with beacons, flashers and planned ones; [`SignalColumns::keep`] says which rows count.

use std::collections::BTreeMap;
use std::path::Path;

use geo::{BoundingRect, Coord, LineString, Rect};
use serde::{Deserialize, Serialize};

use super::error::{OsmError, brief};
use super::extract::Place;
use super::file;
use super::geometry::{checked_place, distance_m};
use super::sources::Source;
use super::table::{Column, Table};

/// Usual names of the column with the id, the best one first: counts and plans refer to the number of a signal or
/// intersection, and `id` may be that of a row in a database, as `object_id` always is.
const ID: [&str; 20] = [
    "signal_id", "signal_number", "signal_num", "signal_no", "sig_id", "sig_num", "sig_no",
    "traffic_signal_id", "intersection_id", "intersection_no", "int_id", "int_no", "int",
    "node_id", "node", "location_id", "asset_id", "id", "signal", "name",
];

/// Usual names of the column with a text `POINT (...)`.
const POINT: [&str; 7] = ["shape", "the_geom", "geom", "geometry", "wkt", "point", "location"];

/// Usual name of the column with the controller; a column `controller` mostly has its type.
const CONTROLLER: [&str; 1] = ["controller_id"];

/// Farthest that a signal may be from the first one of its controller to be at the same intersection, metres: more than the
/// ramps of an interchange with one controller are apart, less than a block of most cities. This project's choice.
const ONE_CONTROLLER_M: f64 = 250.0;

/// Values with how often they occur.
type Values = BTreeMap<String, usize>;

/// Usual names of columns that tell signals from what else a list has.
const KINDS: [&str; 11] = [
    "type", "kind", "signal_type", "sig_type", "asset_type", "device_type", "site_type",
    "category", "status", "state", "signal_status",
];

/// Parts of words for what stands in such lists and stops nobody, or not yet, or no longer.
const NO_SIGNALS: [&str; 29] = [
    "beacon", "flash", "planned", "pending", "proposed", "future", "design", "removed", "retired",
    "inactive", "abandoned", "school", "rrfb", "rapid", "hawk", "hybrid", "decommission",
    "construction", "crossing", "pelican", "puffin", "toucan", "meter", "camera", "pedestrian",
    "mid-block", "midblock", "mid block", "emergency",
];

/// Whole words for the same: as a part, `sign` is in every signal. Half signals and pedestrian
/// hybrid beacons (PHB) stop one of two streets, and signals of fire stations only for fire engines.
const NO_SIGNALS_ALONE: [&str; 5] = ["sign", "signs", "half", "fire", "phb"];

/// Most different values that a message names.
const NAMED: usize = 8;

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

impl SignalList {
    /// Reads a list: CSV, a workbook or GeoJSON points.
    ///
    /// [`OsmError`] naming the file and the line: a column that is missing, a place outside the
    /// world, an id that comes twice, no signal at all.
    pub fn read(path: &Path, columns: &SignalColumns) -> Result<Self, OsmError> {
        Self::from_bytes(&file::bytes(path)?, path, columns)
    }

    /// Reads a list from the bytes of a file; of a workbook the first sheet that holds anything. `path` is for messages.
    pub fn from_bytes(
        bytes: &[u8],
        path: &Path,
        columns: &SignalColumns,
    ) -> Result<Self, OsmError> {
        let source = Source::sheets(bytes, path)?.swap_remove(0);
        let mut table = Table::open(&source.bytes, path, source.rows)?;
        let id = table.find(&Column { what: "id", given: columns.id.as_deref(), usual: &ID })?;
        let controller = columns.controller.as_deref();
        let controller = Column { what: "controller", given: controller, usual: &CONTROLLER };
        let controller = table.find(&controller)?;
        let at = places(&table, columns)?;
        let conditions = conditions(&table, &columns.keep)?;
        let kinds = kinds(&table, &conditions);
        let mut found: BTreeMap<usize, Values> = BTreeMap::new();
        let mut left: BTreeMap<usize, Values> = BTreeMap::new();
        let mut list = Self { signals: Vec::new(), left_out: 0, doubts: Vec::new() };
        if id.is_none() {
            let doubt = "no column has an id, so that the rows are numbered, and another export may number them otherwise; name \
                         a column as `id` in [signals] of the settings";
            list.doubts.push(doubt.to_owned());
        }
        let mut lines: BTreeMap<String, u64> = BTreeMap::new();
        let mut number = 0;
        while let Some(row) = table.next_row()? {
            number += 1;
            let count = |of: &mut BTreeMap<usize, Values>, column: usize| {
                let values = of.entry(column).or_default();
                *values.entry(row.text(column).to_owned()).or_default() += 1;
            };
            let is_left = |(column, (any, none)): &(&usize, &(Vec<String>, Vec<String>))| {
                let value = row.text(**column).to_lowercase();
                !any.is_empty() && !any.contains(&value) || none.contains(&value)
            };
            if let Some((column, _)) = conditions.iter().find(is_left) {
                count(&mut left, *column);
                list.left_out += 1;
                continue;
            }
            let id = id.map_or_else(|| number.to_string(), |column| row.text(column).to_owned());
            if id.is_empty() {
                return Err(table.error(row.line, "no id; give every signal one".to_owned()));
            }
            if let Some(first) = lines.insert(id.clone(), row.line) {
                let (id, first) = (brief(&id), table.number_of(first));
                let reason = format!(
                    "signal {id} is on line {first} already; remove one of them, or name another column as `id` in \
                     [signals] of the settings"
                );
                return Err(table.error(row.line, reason));
            }
            kinds.iter().for_each(|kind| count(&mut found, *kind));
            let controller = controller.map(|column| row.text(column)).filter(|c| !c.is_empty());
            list.signals.push(ListedSignal {
                id,
                place: place(&table, &row, &at)?,
                line: table.number_of(row.line),
                controller: controller.map(str::to_owned),
            });
        }
        if let Some((column, values)) = left.iter().next().filter(|_| list.signals.is_empty()) {
            let (column, values) = (table.name(*column), named(values));
            return Err(
                table.nothing(&format!("no row is as asked for; column {column} has {values}"))
            );
        }
        if list.signals.iter().all(|signal| signal.is_nowhere()) {
            return Err(
                table.nothing("no row with a place; name the columns in [signals] of the settings")
            );
        }
        let kinds = found.into_iter().filter_map(|(c, values)| doubt(&table.name(c), &values));
        list.doubts.extend(kinds);
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

impl ListedSignal {
    /// Returns whether it is where programs put what has no place.
    pub fn is_nowhere(&self) -> bool {
        (self.place.latitude_e7, self.place.longitude_e7) == (0, 0)
    }
}

/// Latitude 0, longitude 0 for a row without any place.
fn place(table: &Table<'_>, row: &sheet::Row, at: &[usize]) -> Result<Place, OsmError> {
    match *at {
        _ if at.iter().all(|column| row.text(*column).is_empty()) => {
            Ok(Place { latitude_e7: 0, longitude_e7: 0 })
        }
        [latitude, longitude] => table.place(row, [latitude, longitude]),
        _ => point(row.text(at[0]))
            .and_then(|(latitude, longitude)| checked_place(latitude, longitude))
            .map_err(|reason| table.error(row.line, reason)),
    }
}

/// Columns of latitude and longitude, or one with a text.
fn places(table: &Table<'_>, columns: &SignalColumns) -> Result<Vec<usize>, OsmError> {
    let text = Column { what: "point", given: columns.point.as_deref(), usual: &POINT };
    if columns.point.is_some() {
        return Ok(vec![table.need(&text)?]);
    }
    let given = [columns.latitude.as_deref(), columns.longitude.as_deref()];
    let degrees = Column::place(given);
    let found = [table.find(&degrees[0])?, table.find(&degrees[1])?];
    match (found, table.find(&text)?) {
        ([Some(latitude), Some(longitude)], _) => Ok(vec![latitude, longitude]),
        (_, Some(column)) if given == [None, None] => Ok(vec![column]),
        _ => Ok(vec![table.need(&degrees[0])?, table.need(&degrees[1])?]),
    }
}

/// One intersection cannot have signals far apart, and a column may hold another thing, such as the type of the controller.
fn part_controllers(signals: &mut [ListedSignal]) -> Option<String> {
    let mut first: BTreeMap<String, Place> = BTreeMap::new();
    let mut apart = 0;
    for signal in signals {
        let Some(controller) = &signal.controller else { continue };
        let first = *first.entry(controller.clone()).or_insert(signal.place);
        if distance_m(first, signal.place) > ONE_CONTROLLER_M {
            signal.controller = None;
            apart += 1;
        }
    }
    (apart > 0).then(|| {
        format!(
            "{apart} signals are more than {ONE_CONTROLLER_M} m from the first one of their controller and stay \
             intersections of their own"
        )
    })
}

/// By column the values, lower case, of which a row has one, if there are any, and those of which it has none.
type Conditions = BTreeMap<usize, (Vec<String>, Vec<String>)>;

fn conditions(table: &Table<'_>, keep: &[String]) -> Result<Conditions, OsmError> {
    let mut of = Conditions::new();
    for text in keep {
        let Some((name, value)) = text.split_once('=') else {
            let reason = format!("{:?}: expected COLUMN=VALUE or COLUMN!=VALUE", brief(text));
            return Err(table.nothing(&reason));
        };
        let wanted = name.strip_suffix('!').unwrap_or(name);
        let column = Column { what: "rows to keep", given: Some(wanted.trim()), usual: &[] };
        let (any, none) = of.entry(table.need(&column)?).or_default();
        let values = if wanted == name { any } else { none };
        values.push(value.trim().to_lowercase());
    }
    Ok(of)
}

/// Returns the columns that may tell signals from what else there is and that nobody asked for.
fn kinds(table: &Table<'_>, conditions: &Conditions) -> Vec<usize> {
    let usual = KINDS.iter().filter_map(|name| {
        let column = Column { what: "kind", given: None, usual: std::slice::from_ref(name) };
        table.find(&column).ok().flatten()
    });
    usual.filter(|column| !conditions.contains_key(column)).collect()
}

fn doubt(column: &str, values: &Values) -> Option<String> {
    let others = |value: &&String| {
        let value = value.to_lowercase();
        let mut words = value.split(|c: char| !c.is_alphanumeric());
        NO_SIGNALS.iter().any(|part| value.contains(part))
            || words.any(|word| NO_SIGNALS_ALONE.contains(&word))
    };
    let doubtful: Values =
        values.iter().filter(|(v, _)| others(v)).map(|(v, n)| (v.clone(), *n)).collect();
    let rows: usize = doubtful.values().sum();
    let first = doubtful.keys().next()?;
    Some(format!(
        "{rows} rows may be no signals: column {} has {}; leave them out with --signals-where, such as '{}!={}'",
        column,
        named(&doubtful),
        column,
        brief(first)
    ))
}

fn named(values: &Values) -> String {
    let mut sorted: Vec<(&String, &usize)> = values.iter().collect();
    sorted.sort_by(|a, b| b.1.cmp(a.1).then(a.0.cmp(b.0)));
    let more = if sorted.len() > NAMED { ", ..." } else { "" };
    let named = sorted.iter().take(NAMED).map(|(value, n)| format!("{} ({n})", brief(value)));
    format!("{}{more}", named.collect::<Vec<_>>().join(", "))
}

/// Returns latitude and longitude, degrees, of a text such as `POINT (-111.9 40.7)`, `SRID=4326;POINT Z(-111.9 40.7 3)`,
/// `(40.7, -111.9)`, which portals of Socrata write, or `{"type": "Point", "coordinates": [-111.9, 40.7]}`.
fn point(text: &str) -> Result<(f64, f64), String> {
    let found = || {
        let (kind, rest) = text.split_once(['(', '['])?;
        let (inner, _) = rest.rsplit_once([')', ']'])?;
        let numbers = inner.split([' ', ',', '(', ')', '[', ']']).filter(|n| !n.is_empty());
        let numbers: Vec<f64> = numbers.map(|n| n.parse().ok()).collect::<Option<_>>()?;
        match (kind.trim(), &numbers[..]) {
            ("", [latitude, longitude]) => Some((*latitude, *longitude)),
            ("", _) => None,
            (_, [longitude, latitude] | [longitude, latitude, _]) => {
                text.to_uppercase().contains("POINT").then_some((*latitude, *longitude))
            }
            _ => None,
        }
    };
    found().ok_or_else(|| {
        let text = brief(text);
        format!("{text:?}: expected POINT (longitude latitude), such as POINT (-111.89 40.76)")
    })
}

#[cfg(test)]
mod tests;

//! Counts at stations, as CSV.

use std::path::Path;

use super::{Counted, DIRECTION, Found, Shape, YEAR, choose, direction, is_separated, usable};
use crate::error::{OsmError, brief};
use crate::oddities::Oddities;
use crate::table::{Column, Table};

/// Usual names of the column with the axis of the street.
const BEARING: [&str; 2] = ["bearing_deg", "bearing"];

/// Usual names of the column with the id.
const ID: [&str; 4] = ["id", "station", "station_id", "name"];

pub(super) fn read(bytes: &[u8], path: &Path, field: Option<&str>) -> Result<Found, OsmError> {
    let mut table = Table::open(bytes, path, ("line", 0))?;
    let [latitude, longitude] = Column::place([None; 2]);
    let at = [table.need(&latitude)?, table.need(&longitude)?];
    let bearing = table.find(&Column { what: "bearing", given: None, usual: &BEARING })?;
    let id = table.find(&Column { what: "id", given: None, usual: &ID })?;
    let way = table.find(&Column { what: "direction", given: None, usual: &DIRECTION })?;
    let year = table.find(&Column { what: "year", given: None, usual: &YEAR })?;
    let names: Vec<_> = table.headers().collect();
    let field = choose(&names, field).map_err(|reason| table.error(table.header_line(), reason))?;
    let aadt = table.need(&Column { what: "count", given: Some(&field), usual: &[] })?;
    let mut oddities = Oddities::default();
    let mut counted = Vec::new();
    while let Some(row) = table.next_row()? {
        let line = format!("line {}", row.line);
        let id = id.map(|column| row.text(column)).filter(|id| !id.is_empty());
        let id = id.map_or_else(|| line.clone(), str::to_owned);
        let text = row.text(aadt);
        let number = match is_separated(text) {
            // Of a number with a separator the table knows what it means.
            true => Some(table.count(&row, aadt)?),
            false if text.is_empty() => None,
            false => Some(text.parse().unwrap_or(f64::NAN)),
        };
        match usable(number, year.map(|column| row.text(column))) {
            Err(reason) => {
                oddities.add(reason, || {
                    if id == line { id } else { format!("{line}, id {}", brief(&id)) }
                });
            }
            Ok(aadt_veh_per_day) => {
                let place = table.place(&row, at)?;
                let bearing = bearing.map(|column| table.optional_number(&row, column));
                let bearing = bearing.transpose()?.flatten();
                let shape = Shape::Station(place, bearing);
                let direction = way.and_then(|column| direction(row.text(column)));
                counted.push(Counted { id, aadt_veh_per_day, direction, shape });
            }
        }
    }
    Ok((counted, field, oddities))
}

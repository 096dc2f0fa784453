//! Counts along lines, as GeoJSON.

use std::collections::BTreeSet;
use std::path::Path;

use geojson::feature::Id;
use geojson::{Feature, FeatureCollection, GeometryValue, JsonValue, LineStringType};

use super::{Counted, DIRECTION, Found, Shape, YEAR, choose, direction, is_separated, usable};
use crate::error::malformed;
use crate::error::{OsmError, brief};
use crate::extract::Place;
use crate::features;
use crate::oddities::Oddities;

/// Usual names of a property with the id, where a feature has none of its own.
const ID: [&str; 5] = ["segid", "segment_id", "id", "objectid", "fid"];

/// What ArcGIS services write into a page that is not the last one.
const MORE: &str = "exceededTransferLimit";

pub(super) fn read(bytes: &[u8], path: &Path, field: Option<&str>) -> Result<Found, OsmError> {
    let collection: FeatureCollection =
        features::read(bytes, path, "GeoJSON with a FeatureCollection of lines")?;
    let names = collection.features.iter().flat_map(|f| f.properties.iter().flatten());
    let names: BTreeSet<&str> = names.map(|(name, _)| &**name).collect();
    let names: Vec<&str> = names.into_iter().collect();
    let field = choose(&names, field).map_err(|reason| malformed(path, "properties", reason))?;
    let mut oddities = Oddities::default();
    let more = collection
        .foreign_members
        .as_ref()
        .and_then(|m| m.get(MORE).or_else(|| m.get("properties")?.get(MORE)));
    if more == Some(&JsonValue::Bool(true)) {
        oddities.add("file that is one page of several", || format!("{MORE} is true"));
    }
    let mut counted = Vec::new();
    for (i, feature) in collection.features.iter().enumerate() {
        let place = format!("feature {}", i + 1);
        let id = id(feature).unwrap_or_else(|| place.clone());
        let refuse = |reason| malformed(path, &*place, reason);
        let lines = lines(feature).map_err(refuse)?;
        let number = number(feature.property(&field))
            .map_err(|way_out| refuse(format!("{}: {way_out}", brief(&field))))?;
        let year = text_of(feature, &YEAR);
        match lines.and_then(|lines| Ok((lines, usable(number, year.as_deref())?))) {
            Ok((lines, aadt_veh_per_day)) => {
                let direction = text_of(feature, &DIRECTION).and_then(|text| direction(&text));
                let shape = Shape::Lines(lines);
                counted.push(Counted { id, aadt_veh_per_day, direction, shape });
            }
            Err(skipped) => {
                let of = if id == place { id } else { format!("{place}, id {}", brief(&id)) };
                oddities.add(skipped, || of);
            }
        }
    }
    Ok((counted, field, oddities))
}

/// Not a number for what is none; an error for a text that may be two numbers.
fn number(value: Option<&JsonValue>) -> Result<Option<f64>, String> {
    match value {
        None | Some(JsonValue::Null) => Ok(None),
        Some(JsonValue::Number(number)) => Ok(number.as_f64()),
        Some(JsonValue::String(text)) => match text.trim() {
            "" => Ok(None),
            text if is_separated(text) => sheet::count(text).map(Some),
            text => Ok(Some(text.parse().unwrap_or(f64::NAN))),
        },
        Some(_) => Ok(Some(f64::NAN)),
    }
}

fn id(feature: &Feature) -> Option<String> {
    match &feature.id {
        Some(Id::String(text)) => Some(text.clone()),
        Some(Id::Number(number)) => Some(number.to_string()),
        None => text_of(feature, &ID),
    }
}

fn text_of(feature: &Feature, usual: &[&str]) -> Option<String> {
    let properties = feature.properties.as_ref()?;
    let find = |usual: &&str| properties.iter().find(|(name, _)| name.eq_ignore_ascii_case(usual));
    match usual.iter().find_map(find)?.1 {
        JsonValue::String(text) if !text.trim().is_empty() => Some(text.clone()),
        JsonValue::Number(number) => Some(number.to_string()),
        _ => None,
    }
}

/// The inner error is why there is none, the outer what is wrong with the coordinates.
fn lines(feature: &Feature) -> Result<Result<Vec<Vec<Place>>, &'static str>, String> {
    let lines: &[LineStringType] = match feature.geometry.as_ref().map(|g| &g.value) {
        Some(GeometryValue::LineString { coordinates }) => std::slice::from_ref(coordinates),
        Some(GeometryValue::MultiLineString { coordinates }) => coordinates,
        Some(_) => return Ok(Err("geometry other than lines")),
        None => return Ok(Err("missing geometry")),
    };
    let mut kept = Vec::new();
    for line in lines {
        let mut places = line.iter().map(features::place).collect::<Result<Vec<_>, _>>()?;
        places.dedup();
        if places.len() > 1 {
            kept.push(places);
        }
    }
    Ok(if kept.is_empty() { Err("line without length") } else { Ok(kept) })
}

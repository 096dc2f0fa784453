//! Counts along lines, as GeoJSON.

use std::collections::BTreeMap;
use std::path::Path;

use geojson::feature::Id;
use geojson::{Feature, FeatureCollection, GeometryValue, JsonValue, LineStringType};

use super::counted::{Counted, DIRECTION, Found, Shape, direction};
use super::field::{Name, NoCount, YEAR, choose, count};
use crate::error::{OsmError, brief};
use crate::extract::Place;
use crate::features::{self, check_crs, malformed};
use crate::oddities::Oddities;

/// Usual names of a property with the id, where a feature has none of its own.
const ID: [&str; 5] = ["segid", "segment_id", "id", "objectid", "fid"];

/// What ArcGIS services write into a page that is not the last one.
const MORE: &str = "exceededTransferLimit";

/// Largest step between two positions of a line, degrees of longitude; a larger one goes round
/// the world.
const HALF_WORLD_DEG: f64 = 180.0;

/// Reads counted lines; `field` is the property with the count if it is given.
///
/// # Errors
///
/// [`OsmError`] for other content, projected or swapped coordinates, and if no property is the
/// count.
pub(super) fn read(bytes: &[u8], path: &Path, field: Option<&str>) -> Result<Found, OsmError> {
    let collection: FeatureCollection =
        features::read(bytes, path, "GeoJSON with a FeatureCollection of lines")?;
    let members = collection.foreign_members.as_ref();
    check_crs(members, path)?;
    let field = choose(&names(&collection.features), field)
        .map_err(|reason| malformed(path, "properties", reason))?;
    let mut oddities = Oddities::default();
    let more = members.and_then(|m| m.get(MORE).or_else(|| m.get("properties")?.get(MORE)));
    if more == Some(&JsonValue::Bool(true)) {
        oddities.add("file that is one page of several", || format!("{MORE} is true"));
    }
    let values = collection.features.iter().filter_map(|f| f.property(&field)?.as_str());
    let have_decimals = values.map(str::trim).any(sheet::has_decimals);
    let mut counted = Vec::new();
    for (i, feature) in collection.features.iter().enumerate() {
        let place = format!("feature {}", i + 1);
        let id = id(feature).unwrap_or_else(|| place.clone());
        let lines = lines(feature).map_err(|reason| malformed(path, &*place, reason))?;
        let value = feature.property(&field);
        let year = text_of(feature, &YEAR);
        let skipped = match (lines, count(value, have_decimals, year.as_deref())) {
            (Err(reason), _) | (Ok(_), Err(NoCount::Skipped(reason))) => reason,
            (Ok(_), Err(NoCount::Refused(way_out))) => {
                let text = value.map_or_else(String::new, |value| brief(&value.to_string()));
                let reason = format!("{} = {text}: {way_out}", brief(&field));
                return Err(malformed(path, &*place, reason));
            }
            (Ok(lines), Ok(aadt_veh_per_day)) => {
                let direction = text_of(feature, &DIRECTION).and_then(|text| direction(&text));
                let shape = Shape::Lines(lines);
                counted.push(Counted { id, aadt_veh_per_day, direction, shape });
                continue;
            }
        };
        oddities
            .add(skipped, || if id == place { id } else { format!("{place}, id {}", brief(&id)) });
    }
    Ok(Found { counted, field, oddities })
}

/// Returns the names of all properties, with a value if no feature has a count of that name: one that is
/// refused for how it is written is one.
fn names(features: &[Feature]) -> Vec<Name<'_>> {
    let mut names: BTreeMap<&str, Option<&JsonValue>> = BTreeMap::new();
    for (name, value) in features.iter().flat_map(|f| f.properties.iter().flatten()) {
        let unusable = names.entry(name).or_insert(Some(value));
        if !matches!(count(Some(value), false, None), Err(NoCount::Skipped(_))) {
            *unusable = None;
        }
    }
    names.into_iter().map(|(name, value)| (name, value.map(JsonValue::to_string))).collect()
}

fn id(feature: &Feature) -> Option<String> {
    match &feature.id {
        Some(Id::String(text)) => Some(text.clone()),
        Some(Id::Number(number)) => Some(number.to_string()),
        None => text_of(feature, &ID),
    }
}

/// Returns the text or number of the first of some usual properties that a feature has.
fn text_of(feature: &Feature, usual: &[&str]) -> Option<String> {
    let properties = feature.properties.as_ref()?;
    let find = |usual: &&str| properties.iter().find(|(name, _)| name.eq_ignore_ascii_case(usual));
    match usual.iter().find_map(find)?.1 {
        JsonValue::String(text) if !text.trim().is_empty() => Some(text.clone()),
        JsonValue::Number(number) => Some(number.to_string()),
        _ => None,
    }
}

/// Returns the lines of a feature, or why it has none.
///
/// # Errors
///
/// What is wrong with its coordinates, and the way out.
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
        let far =
            |pair: &[Place]| (pair[0].longitude() - pair[1].longitude()).abs() > HALF_WORLD_DEG;
        if places.windows(2).any(far) {
            return Ok(Err("line across the 180th meridian"));
        }
        if places.len() > 1 {
            kept.push(places);
        }
    }
    Ok(if kept.is_empty() { Err("line without length") } else { Ok(kept) })
}

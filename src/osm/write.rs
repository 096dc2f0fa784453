//! The files of a city beside its networks: tables, settings and GeoJSON.

use std::collections::BTreeMap;
use std::path::Path;

use geojson::{Feature, FeatureCollection, GeometryValue, JsonObject, JsonValue};
use toml::{Table, Value};

use super::OsmError;
use super::city::City;
use super::config::OsmConfig;
use super::extract::Place;
use super::listing::ListMatch;
use super::quality::{Demand, Distribution, FamilyFacts, Quality};
use super::side::SideDecision;
use super::spots::Spot;
use super::surroundings::INTERSECTIONS_FILE;
use super::traffic::InflowSource;
use crate::family::MdpFamily;
use crate::family::error::FamilyError;
use crate::files::write_atomically;
use crate::settings::overrides::Override;
use crate::settings::wording::explain;
use crate::traffic::family::features::six_features;
use crate::traffic::family::load::LoadedScenario;
use crate::traffic::settings::check::check;
use crate::traffic::settings::inflow::InflowSources;
use crate::traffic::settings::{Detail, Scenario, SixFeatures};
use crate::traffic::side::DrivingSide;

/// Name of the scenario file within a city's folder.
pub const SCENARIO_FILE: &str = "scenario.toml";

/// Name of the table of approaches within a city's folder.
pub const APPROACHES_FILE: &str = "approaches.csv";

/// Name of the table of the rows of a signal list within a city's folder.
pub const MATCHES_FILE: &str = "signal-list.csv";

/// What a scenario file says of its demand.
const DEMAND_NOTE: &str = "\
# Demand is a design hour: hourly_share is the share of the day's traffic in it (1/24 is the mean hour),
# directional_split the share of a two-way street's hour in its peak direction, which is the one within
# 90 degrees of peak_heading_deg (45: north- and eastbound). [family.inflows] says what the inflows of
# approaches.csv rest on, shares of the approaches; pages of results quote it, and it decides nothing.
";

/// Digits after the point of a share.
const SHARE_DIGITS: i32 = 4;

/// What decides the scenario of a city.
#[derive(Debug, Clone, Copy)]
pub struct ScenarioInputs<'a> {
    /// Its name.
    pub name: &'a str,
    /// Name of the extract.
    pub extract: &'a str,
    /// Six features or real arms.
    pub detail: Detail,
    /// Settings of the derivation, which may hold some for the scenario.
    pub config: &'a OsmConfig,
    /// Settings from the command line.
    pub overrides: &'a [Override],
    /// Side of the street that traffic keeps to; `None` as long as it is not known.
    pub side: Option<&'a SideDecision>,
    /// What errors call the settings: a file, or the command line.
    pub source: &'a str,
    /// What the inflows of the table rest on, once that is known.
    pub inflows: Option<InflowSources>,
}

/// Returns the text of a scenario file for a table of approaches beside it.
///
/// # Errors
///
/// [`OsmError::Family`] for a setting that does not exist, is out of range, or is decided by the
/// command.
pub fn scenario_text(inputs: &ScenarioInputs<'_>) -> Result<String, OsmError> {
    let ScenarioInputs { name, extract, detail, config, overrides, source, side, inflows } =
        *inputs;
    let mut table = Table::new();
    table.insert("name".to_owned(), name.into());
    let title = format!("Signalised intersections of {extract} ((c) OpenStreetMap contributors)");
    table.insert("title".to_owned(), title.into());
    let mut family = Table::new();
    family.insert("approaches".to_owned(), APPROACHES_FILE.into());
    let word = Value::try_from(detail).expect("a detail is a word");
    family.insert("detail".to_owned(), word);
    family.insert("hourly_share".to_owned(), config.traffic.hourly_share.into());
    if config.traffic.both_directions {
        let (split, heading) = (config.traffic.directional_split, config.traffic.peak_heading_deg);
        family.insert("directional_split".to_owned(), split.into());
        family.insert("peak_heading_deg".to_owned(), heading.into());
    }
    if let Some(inflows) = inflows {
        let shares = Value::try_from(inflows).expect("shares are numbers");
        family.insert("inflows".to_owned(), shares);
    }
    table.insert("family".to_owned(), family.into());
    for (key, value) in &config.scenario {
        match (table.get_mut(key), value) {
            (Some(Value::Table(own)), Value::Table(more)) => own.extend(more.clone()),
            _ => {
                table.insert(key.clone(), value.clone());
            }
        }
    }
    let driving_side = side.map_or(DrivingSide::Right, |side| side.driving_side);
    if let Some(side) = side.filter(|side| !side.driving_side.is_right()) {
        side.put_into(&mut table);
    }
    let wrong = |field: &str, value: String, expected: String| FamilyError::Setting {
        file: source.to_owned(),
        field: field.to_owned(),
        value,
        expected,
    };
    let own = table.clone().try_into::<Scenario>();
    let mut scenario = own.map_err(|e: toml::de::Error| FamilyError::Toml {
        file: format!("{source}, [scenario]"),
        message: explain(e.message(), ""),
    })?;
    for setting in overrides {
        scenario = setting.apply(&scenario)?;
        setting.put_into(&mut table)?;
    }
    check(&scenario, source)?;
    let decided = [
        ("name", scenario.name == name, "--out"),
        ("family.detail", scenario.family.detail == detail, "--detail"),
        ("network.driving_side", scenario.network.driving_side == driving_side, "--driving-side"),
        ("family.points", scenario.family.points.is_none(), "the map"),
        (
            "family.approaches",
            scenario.family.approaches.as_deref() == Some(APPROACHES_FILE),
            "the map",
        ),
    ];
    if let Some((field, _, by)) = decided.into_iter().find(|(_, same, _)| !same) {
        let expected = format!("with --osm {by} decides it; leave it out");
        return Err(wrong(field, "another value".to_owned(), expected).into());
    }
    let settings = toml::to_string(&table).expect("settings are plain data");
    let side = side.map(|side| format!("# {}.\n", side.text())).unwrap_or_default();
    Ok(format!(
        "# Made from {extract} by `tsc-family build-networks --osm`; what is not here has its \
         default.\n{side}{DEMAND_NOTE}{settings}"
    ))
}

/// Writes the point MDPs as a table: id, importance, intersections and features.
///
/// # Errors
///
/// [`OsmError::Io`].
pub fn write_family(folder: &Path, family: &MdpFamily) -> Result<(), OsmError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let names = family.features.iter().map(|f| f.name.clone());
    let head = ["point", "importance", "intersections"].map(str::to_owned);
    writer.write_record(head.into_iter().chain(names)).expect("memory takes every row");
    for p in &family.points {
        let fixed = [p.id.clone(), p.importance.to_string(), p.instances.to_string()];
        let features = p.features.iter().map(f64::to_string);
        writer.write_record(fixed.into_iter().chain(features)).expect("memory takes every row");
    }
    let table = writer.into_inner().expect("memory takes every row");
    Ok(write_atomically(&folder.join("family.csv"), &table)?)
}

/// Writes what became of every row of the signal list: its intersection, the distance, the reason.
///
/// # Errors
///
/// [`OsmError::Io`].
pub fn write_matches(folder: &Path, listed: &[ListMatch]) -> Result<(), OsmError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let head = [
        "id",
        "row",
        "latitude",
        "longitude",
        "intersection",
        "distance_m",
        "signal_on_map",
        "duplicate_of_row",
        "reason",
    ];
    writer.write_record(head).expect("memory takes every row");
    for m in listed {
        let metres = m.distance_m.map(|metres| format!("{metres:.1}"));
        let row = [
            m.id.clone(),
            m.line.to_string(),
            m.latitude.to_string(),
            m.longitude.to_string(),
            m.intersection.clone().unwrap_or_default(),
            metres.unwrap_or_default(),
            m.on_map.to_string(),
            m.duplicate_of.map(|line| line.to_string()).unwrap_or_default(),
            m.why().unwrap_or_default(),
        ];
        writer.write_record(row).expect("memory takes every row");
    }
    let table = writer.into_inner().expect("memory takes every row");
    Ok(write_atomically(&folder.join(MATCHES_FILE), &table)?)
}

/// Returns what the family of a city adds to what is known of it.
pub fn family_facts(loaded: &LoadedScenario) -> FamilyFacts {
    let settings = &loaded.scenario.family;
    FamilyFacts {
        name: loaded.scenario.name.clone(),
        demand: Demand {
            hourly_share: settings.hourly_share,
            directional_split: settings.directional_split,
            peak_heading_deg: settings.peak_heading_deg,
        },
        features: distributions(loaded),
        point_mdps: loaded.family.points.len(),
    }
}

/// Returns the six features of the intersections of a scenario, before quantising.
fn distributions(loaded: &LoadedScenario) -> Vec<Distribution> {
    let settings = &loaded.scenario.family;
    let rows: Vec<[f64; 6]> =
        loaded.intersections.iter().map(|i| six_features(i, settings).to_array()).collect();
    let bins = settings.bins.to_array();
    let columns = SixFeatures::COLUMNS.iter().enumerate();
    columns
        .map(|(f, (name, unit))| {
            let values: Vec<f64> = rows.iter().map(|row| row[f]).collect();
            let count = values.len().max(1) as f64;
            let mean = values.iter().sum::<f64>() / count;
            let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count;
            Distribution {
                name: (*name).to_owned(),
                unit: (*unit).to_owned(),
                mean,
                sd: variance.sqrt(),
                bin: bins[f],
                values,
            }
        })
        .collect()
}

/// Writes `intersections.geojson`: intersections with their point MDP, its importance and features,
/// and how well they are known; and the signals that are none, with the reason.
///
/// # Errors
///
/// [`OsmError::Io`].
pub fn write_geojson(
    folder: &Path,
    city: &City,
    quality: &Quality,
    loaded: &LoadedScenario,
) -> Result<(), OsmError> {
    let mut point_of: BTreeMap<&str, usize> = BTreeMap::new();
    for (point, members) in loaded.members.iter().enumerate() {
        point_of.extend(members.iter().map(|i| (loaded.intersections[*i].id.as_str(), point)));
    }
    let rows = quality.spots.iter().enumerate().map(|(index, spot)| {
        let point = point_of.get(spot.id.as_str()).map(|p| &loaded.family.points[*p]);
        let mut properties = spot_properties(spot);
        properties.insert("point".to_owned(), point.map(|p| p.id.clone()).into());
        properties.insert("importance".to_owned(), point.map(|p| p.importance).into());
        for d in &quality.features {
            properties.insert(d.name.clone(), number(d.values[index], 2));
        }
        feature(spot.latitude, spot.longitude, properties)
    });
    let skipped = city.found.skipped.iter().map(|s| {
        let mut properties = JsonObject::new();
        properties.insert("status".to_owned(), "skipped".into());
        properties.insert("reason".to_owned(), s.reason.reason().into());
        let id = s.signals.first().map(|id| format!("n{id}"));
        properties.insert("id".to_owned(), id.into());
        feature(Place::latitude(s.place), s.place.longitude(), properties)
    });
    let features = rows.chain(skipped).collect();
    let collection = FeatureCollection { bbox: None, features, foreign_members: None };
    let text = serde_json::to_vec(&collection).expect("features are plain data");
    Ok(write_atomically(&folder.join(INTERSECTIONS_FILE), &text)?)
}

fn spot_properties(spot: &Spot) -> JsonObject {
    let known = number(spot.known, SHARE_DIGITS);
    let metres = |value: Option<f64>| value.map_or(JsonValue::Null, |v| number(v, 1));
    let pairs = [
        ("status", "intersection".into()),
        ("id", spot.id.clone().into()),
        ("streets", spot.streets.join(" / ").into()),
        ("arms", spot.arms.len().into()),
        ("signal_nodes", spot.signals.into()),
        ("known_share", known),
        ("inflow_sources", inflow_sources(spot).into()),
        ("flags", spot.flags.iter().map(|f| f.words()).collect::<Vec<_>>().join("; ").into()),
        ("list_distance_m", metres(spot.list_distance_m)),
        ("count_distance_m", metres(spot.count_distance_m)),
    ];
    pairs.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

/// Returns what the inflows of an intersection rest on, in the order of its approaches.
fn inflow_sources(spot: &Spot) -> String {
    let sources = spot.arms.iter().filter_map(|a| a.inflow_source);
    let word = |source: InflowSource| match source {
        InflowSource::Counted => "counted",
        InflowSource::Spread => "spread",
        InflowSource::Imputed => "imputed",
        InflowSource::Default => "default",
    };
    sources.map(word).collect::<Vec<_>>().join(", ")
}

fn feature(latitude: f64, longitude: f64, properties: JsonObject) -> Feature {
    Feature {
        geometry: Some(GeometryValue::new_point([longitude, latitude]).into()),
        properties: Some(properties),
        ..Feature::default()
    }
}

/// Returns a number with so many digits after the point.
fn number(value: f64, digits: i32) -> JsonValue {
    let scale = 10f64.powi(digits);
    ((value * scale).round() / scale).into()
}

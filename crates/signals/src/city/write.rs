//! The files of a city beside its networks.

use std::collections::BTreeMap;
use std::path::Path;

use geojson::{JsonObject, JsonValue};
use osm_signals::DrivingSide;
use osm_signals::listing::RowNote;
use toml::{Table, Value};

use super::config::CityConfig;
use super::counted::hours;
use super::derive::Request;
use super::folder::{self, APPROACHES_FILE};
use super::quality::{Quality, Spot};
use super::sites::{City, Reason};
use super::surroundings::write_places;
use crate::family::features::six_features;
use crate::family::load::LoadedScenario;
use crate::settings::InflowSources;
use crate::settings::check::check;
use crate::settings::{Detail, Scenario, SixFeatures};
use basics::files::{FileError, lines, write_atomically};
use evaluation::family::MdpFamily;
use evaluation::family::error::FamilyError;
use evaluation::settings::wording::explain;

/// What a scenario file says of its demand.
const DEMAND_NOTE: &str = "\
# Demand is a design hour: hourly_share is the share of the day's traffic in it (1/24 is the mean hour),
# directional_split the share of a two-way street's hour in its peak direction, which is the one within
# 90 degrees of peak_heading_deg (45: north- and eastbound). [family.inflows] says what the inflows of
# approaches.csv rest on, shares of the approaches; pages of results quote it, and it decides nothing.
";

/// Returns the text of the scenario file of a city, for a table of approaches beside it.
pub(super) fn scenario_text(
    request: &Request,
    config: &CityConfig,
    (inflows, side): (Option<InflowSources>, Option<DrivingSide>),
) -> Result<String, FamilyError> {
    let detail = request.detail.unwrap_or(Detail::PerApproach);
    let (name, extract) = (folder::scenario_name(&request.out), folder::stem(&request.extract));
    let mut source =
        request.config.as_ref().map_or("settings".to_owned(), |c| c.display().to_string());
    source.extend(request.overrides.iter().map(|o| format!(" {}", o.flag())));
    let mut family = Table::new();
    family.insert("approaches".to_owned(), APPROACHES_FILE.into());
    family.insert("detail".to_owned(), Value::try_from(detail).expect("a detail is a word"));
    family.insert("hourly_share".to_owned(), config.hour.hourly_share.into());
    if config.settings.traffic.both_directions {
        family.insert("directional_split".to_owned(), config.hour.directional_split.into());
        family.insert("peak_heading_deg".to_owned(), config.hour.peak_heading_deg.into());
    }
    if let Some(inflows) = inflows {
        family.insert("inflows".to_owned(), Value::try_from(inflows).expect("shares are numbers"));
    }
    family.extend(hours(&request.periods).map(|hours| ("periods".to_owned(), hours)));
    let title = format!("Signalised intersections of {extract} ((c) OpenStreetMap contributors)");
    let mut table = Table::from_iter([
        ("name".to_owned(), name.as_str().into()),
        ("title".to_owned(), title.into()),
        ("family".to_owned(), family.into()),
    ]);
    for (key, value) in &config.scenario {
        match (table.get_mut(key), value) {
            (Some(Value::Table(own)), Value::Table(more)) => own.extend(more.clone()),
            _ => drop(table.insert(key.clone(), value.clone())),
        }
    }
    let side = side.unwrap_or_default();
    if side == DrivingSide::Left
        && let Value::Table(network) = table.entry("network").or_insert_with(|| Table::new().into())
    {
        network.entry("driving_side").or_insert_with(|| side.name().into());
    }
    let own = table.clone().try_into::<Scenario>();
    let mut scenario = own.map_err(|e: toml::de::Error| FamilyError::Toml {
        file: format!("{source}, [scenario]"),
        message: explain::<Scenario>(e.message(), ""),
    })?;
    for setting in &request.overrides {
        scenario = setting.apply(&scenario)?;
        setting.put_into(&mut table)?;
    }
    check(&scenario, &source)?;
    let of = &scenario.family;
    let decided = [
        ("name", scenario.name == name, "--out"),
        ("family.detail", of.detail == detail, "--detail"),
        ("network.driving_side", scenario.network.driving_side == side, "--driving-side"),
        ("family.points", of.points.is_none(), "the map"),
        ("family.approaches", of.approaches.as_deref() == Some(APPROACHES_FILE), "the map"),
    ];
    if let Some((field, _, by)) = decided.into_iter().find(|(_, same, _)| !same) {
        return Err(FamilyError::Setting {
            file: source,
            field: field.to_owned(),
            value: "another value".to_owned(),
            expected: format!("with --osm {by} decides it; leave it out"),
        });
    }
    let settings = toml::to_string(&table).expect("settings are plain data");
    Ok(format!(
        "# Made from {extract} by `tsc-family build-networks --osm`; what is not here has its \
         default.\n{DEMAND_NOTE}{settings}"
    ))
}

/// Writes the point MDPs as a table: id, importance, intersections and features.
pub(super) fn write_family(folder: &Path, family: &MdpFamily) -> Result<(), FileError> {
    let names = family.features.iter().map(|f| f.name.clone());
    let head = ["point", "importance", "intersections"].map(str::to_owned);
    let mut rows: Vec<Vec<String>> = vec![head.into_iter().chain(names).collect()];
    rows.extend(family.points.iter().map(|p| {
        let fixed = [p.id.clone(), p.importance.to_string(), p.instances.to_string()];
        fixed.into_iter().chain(p.features.iter().map(f64::to_string)).collect::<Vec<String>>()
    }));
    write_atomically(&folder.join("family.csv"), &lines(&rows))
}

/// Writes what became of every row of the signal list: its intersection, the distance, the reason.
pub(super) fn write_matches(folder: &Path, city: &City) -> Result<(), FileError> {
    let head = [
        "id", "row", "latitude", "longitude", "intersection", "distance_m", "signal_on_map",
        "duplicate_of_row", "reason",
    ];
    let mut rows = vec![head.map(str::to_owned)];
    rows.extend(city.listed().map(|(row, left_out)| {
        let duplicate_of = match row.note {
            Some(RowNote::Duplicate(line)) => Some(line.to_string()),
            _ => None,
        };
        let why = left_out.map(Reason::words).or(row.note.map(RowNote::words)).unwrap_or_default();
        [
            row.id.clone(),
            row.line.to_string(),
            row.latitude.to_string(),
            row.longitude.to_string(),
            row.intersection.clone().filter(|_| left_out.is_none()).unwrap_or_default(),
            row.distance_m.map(|metres| format!("{metres:.1}")).unwrap_or_default(),
            row.on_map.to_string(),
            duplicate_of.clone().unwrap_or_default(),
            duplicate_of.map_or(why.to_owned(), |line| format!("duplicate of row {line}")),
        ]
    }));
    write_atomically(&folder.join("signal-list.csv"), &lines(&rows))
}

/// Writes `intersections.geojson`: intersections with their point MDP, its importance and features,
/// and how well they are known; and the signals that are none, with the reason.
pub(super) fn write_geojson(
    folder: &Path,
    city: &City,
    quality: &Quality,
    loaded: &LoadedScenario,
) -> Result<(), FileError> {
    // Of several periods the first.
    let mut first: BTreeMap<&str, usize> = BTreeMap::new();
    let mut point_of: BTreeMap<usize, usize> = BTreeMap::new();
    for (i, intersection) in loaded.intersections.iter().enumerate() {
        first.entry(&intersection.id).or_insert(i);
    }
    for (point, members) in loaded.members.iter().enumerate() {
        point_of.extend(members.iter().map(|i| (*i, point)));
    }
    let intersections = quality.spots.iter().map(|spot| {
        let i = first.get(spot.id.as_str());
        let point = i.and_then(|i| Some(&loaded.family.points[*point_of.get(i)?]));
        let mut properties = spot_properties(spot);
        properties.insert("point".to_owned(), point.map(|p| p.id.clone()).into());
        properties.insert("importance".to_owned(), point.map(|p| p.importance).into());
        if let Some(i) = i {
            let features = six_features(&loaded.intersections[*i], &loaded.scenario.family);
            for ((name, _), value) in SixFeatures::COLUMNS.iter().zip(features.to_array()) {
                properties.insert((*name).to_owned(), number(value, 2));
            }
        }
        (spot.latitude, spot.longitude, properties)
    });
    let skipped = city.skipped().map(|s| {
        let id = s.signals.first().map(|id| format!("n{id}"));
        let properties =
            [("status", "skipped".into()), ("reason", s.reason.words().into()), ("id", id.into())];
        (s.place.latitude(), s.place.longitude(), object(properties))
    });
    write_places(folder, intersections.chain(skipped))
}

fn spot_properties(spot: &Spot) -> JsonObject {
    let metres = |value: Option<f64>| value.map_or(JsonValue::Null, |v| number(v, 1));
    let sources = spot.inflow_sources.iter().map(|source| serde_json::json!(source));
    let sources: Vec<String> = sources.filter_map(|s| Some(s.as_str()?.to_owned())).collect();
    object([
        ("status", "intersection".into()),
        ("id", spot.id.clone().into()),
        ("streets", spot.streets.clone().into()),
        ("arms", spot.arms.into()),
        ("signal_nodes", spot.signals.into()),
        ("known_share", number(spot.known, 4)),
        ("inflow_sources", sources.join(", ").into()),
        ("flags", spot.flags.join("; ").into()),
        ("list_distance_m", metres(spot.list_distance_m)),
        ("count_distance_m", metres(spot.count_distance_m)),
    ])
}

fn object<const N: usize>(pairs: [(&str, JsonValue); N]) -> JsonObject {
    pairs.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

/// Returns a number with so many digits after the point.
fn number(value: f64, digits: i32) -> JsonValue {
    let scale = 10f64.powi(digits);
    ((value * scale).round() / scale).into()
}

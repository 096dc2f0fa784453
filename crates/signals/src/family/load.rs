//! Reads a scenario, embedded or from a file, and derives its family.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use sheet::{Fault, Sheet};
use toml::Table;

use super::approaches::{self, Approach, Intersection, check_arms};
use super::doubts::{self, Doubt};
use super::features::{describing, group, per_approach_features, point_id};
use super::points;
use crate::existing::{self, Plans};
use crate::settings::InflowSources;
use crate::settings::check::check;
use crate::settings::{Detail, Preset, Scenario, SixFeatures};
use crate::vocabulary::Heading;
use basics::suggest::did_you_mean;
use evaluation::family::columns::at;
use evaluation::family::error::FamilyError;
use evaluation::family::names::{check_id, safe_id};
use evaluation::family::{Feature, MdpFamily, PointMdp};
use evaluation::settings::default_name::name_of;
use evaluation::settings::overrides::{Override, overlay};
use evaluation::settings::source::{file_of, read_scenario, read_text, unreadable};
use evaluation::settings::wording;

/// Scenarios that the binary carries, so that it works from any directory.
pub const EMBEDDED: [(&str, &str); 3] = [
    ("salt-lake-city", include_str!("../../../../scenarios/salt-lake-city.toml")),
    ("salt-lake-city-peak", include_str!("../../../../scenarios/salt-lake-city-peak.toml")),
    ("smoke", include_str!("../../../../scenarios/smoke.toml")),
];

/// Tables that embedded scenarios name, by the path in the scenario.
const EMBEDDED_TABLES: [(&str, &str); 2] = [
    (
        "../data/salt-lake-city/approaches.csv",
        include_str!("../../../../data/salt-lake-city/approaches.csv"),
    ),
    ("smoke.csv", include_str!("../../../../scenarios/smoke.csv")),
];

/// A scenario with its family and what the family was derived from.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedScenario {
    /// The settings.
    pub scenario: Scenario,
    /// The scenario file's text, of which the manifest keeps the hash.
    pub text: String,
    /// The table's text.
    pub table: String,
    /// The point MDPs.
    pub family: MdpFamily,
    /// Real intersections; empty for a table of point MDPs.
    pub intersections: Vec<Intersection>,
    /// Per point MDP the indices of its intersections.
    pub members: Vec<Vec<usize>>,
    /// What is doubtful in the table, and what of it is changed; nothing for a table that the program carries.
    pub doubts: Vec<Doubt>,
    /// Plans that its signals have today.
    pub plans: Option<Plans>,
}

/// Loads a scenario by path or embedded name.
///
/// # Errors
///
/// [`FamilyError`] naming the file and the place.
pub fn load(name: &str) -> Result<LoadedScenario, FamilyError> {
    load_with(name, &[])
}

/// Loads a scenario by path or embedded name, with some settings replaced; the last of several
/// values of one setting counts.
///
/// # Errors
///
/// [`FamilyError`] naming the file and the place, or what replaces a setting.
pub fn load_with(name: &str, overrides: &[Override]) -> Result<LoadedScenario, FamilyError> {
    let (text, file, folder) = open(name)?;
    let detail = if folder.is_none() { Detail::SixFeatures } else { Detail::PerApproach };
    let table = |path: &str| table_of(folder.as_deref(), path);
    let mut loaded = with_detail(&text, &file, overrides, &table, detail)?;
    if folder.is_none() && EMBEDDED_TABLES.iter().any(|(_, text)| *text == loaded.table) {
        loaded.doubts.clear();
    }
    Ok(loaded)
}

/// Returns the text of a table that a scenario names, whose paths are relative to a folder if it is not embedded. Of an
/// embedded scenario only a table from the command line is not embedded.
fn table_of(folder: Option<&Path>, path: &str) -> Result<String, FamilyError> {
    match EMBEDDED_TABLES.iter().find(|(table, _)| folder.is_none() && *table == path) {
        Some((_, text)) => Ok((*text).to_owned()),
        None => read_text(&folder.unwrap_or(Path::new("")).join(path)),
    }
}

/// Opens a scenario by path or embedded name. A table of approaches or of point MDPs is a scenario with the
/// settings of a file that names it and nothing else. Returns its text, what messages call it, and its folder if it is not embedded.
fn open(name: &str) -> Result<(String, String, Option<PathBuf>), FamilyError> {
    if let Some((_, text)) = EMBEDDED.iter().find(|(n, _)| *n == name) {
        return Ok(((*text).to_owned(), format!("{name}.toml (embedded)"), None));
    }
    if !Path::new(name).exists() {
        let embedded = EMBEDDED.map(|(name, _)| name);
        return Err(FamilyError::UnknownScenario {
            name: name.to_owned(),
            embedded: embedded.join(", "),
            meant: did_you_mean(name, embedded),
        });
    }
    let path = file_of(name);
    let text = match is_table(&path) {
        true => scenario_of(&path)?,
        false => read_scenario(&path)?,
    };
    let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    Ok((text, path.display().to_string(), Some(folder)))
}

/// Returns whether a file is a table by its name.
fn is_table(path: &Path) -> bool {
    path.extension().is_some_and(|end| {
        ["csv", "tsv", "txt", "xlsx", "xls"].iter().any(|table| end.eq_ignore_ascii_case(table))
    })
}

/// Returns the text of a scenario with one table.
fn scenario_of(table: &Path) -> Result<String, FamilyError> {
    let file = table.display().to_string();
    let text = read_text(table)?;
    let sheet = Sheet::of(&text).map_err(|fault| at(&file, fault))?;
    let has = |name: &str| sheet.headers.iter().any(|h| h.eq_ignore_ascii_case(name));
    let kind = match () {
        () if has("arm") && has("bearing_deg") => "approaches",
        () if has("importance") || has("intersections") => "points",
        () => {
            let message = "a table without the columns of a scenario: approaches have arm and bearing_deg, point MDPs \
                           have importance or intersections; give turning counts, UTDF and signal lists to \
                           build-networks (--turning-counts, --utdf, --signals)";
            return Err(at(&file, Fault::new(sheet.header_line, message)));
        }
    };
    let called = table.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let family = Table::from_iter([(kind.to_owned(), called.into())]);
    Ok(Table::from_iter([("family".to_owned(), family.into())]).to_string())
}

/// A scenario whose intersections are to be counted.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncounted {
    /// The file that it was read from, for messages.
    pub file: String,
    /// The settings.
    pub scenario: Scenario,
    /// The scenario file's text.
    pub text: String,
    /// Its intersections; what follows from daily counts may be missing.
    pub intersections: Vec<Intersection>,
    /// Plans that its signals have today.
    pub plans: Option<Plans>,
}

/// Loads a scenario to which turning counts are given: its approaches need no count.
///
/// # Errors
///
/// As [`load_with`], and [`FamilyError::Setting`] for a scenario without approaches.
pub fn load_uncounted(name: &str, overrides: &[Override]) -> Result<Uncounted, FamilyError> {
    let (text, file, folder) = open(name)?;
    let (scenario, _) = settings_of(&text, &file, overrides, Detail::PerApproach)?;
    let Some(path) = scenario.family.approaches.clone() else {
        let expected =
            "turning counts need the arms of intersections; give a scenario with approaches";
        let points = scenario.family.points.unwrap_or_default();
        return Err(FamilyError::setting(&file, "family.points", points, expected));
    };
    let table = |path: &str| table_of(folder.as_deref(), path);
    let own = table(&path).map_err(|e| unreadable(e, &file, "family.approaches", &path))?;
    let intersections = approaches::read(&own, &path, Some(f64::NAN))?;
    let plans = plans_of(&scenario, &file, &table)?;
    Ok(Uncounted { file, scenario, text, intersections, plans })
}

/// Returns a scenario whose text stands on a preset's, with settings replaced.
fn with_preset(
    written: &Table,
    preset: Preset,
    overrides: &[Override],
    file: &str,
) -> Result<Scenario, FamilyError> {
    let mut settings: Table = preset.text().parse().expect("a preset is a table");
    overlay(&mut settings, written.clone());
    settings.entry("name").or_insert_with(|| name_of(file).into());
    let mut scenario: Scenario = settings.try_into().map_err(|e: toml::de::Error| {
        let reason = wording::explain::<Scenario>(e.message(), "");
        let message = format!("with the preset {}: {reason}", preset.name());
        FamilyError::Toml { file: file.to_owned(), message }
    })?;
    for setting in overrides {
        scenario = setting.apply(&scenario)?;
    }
    Ok(scenario)
}

/// Parses a scenario, replaces settings and derives the family; `table` resolves a table's path to
/// its text.
///
/// # Errors
///
/// [`FamilyError`] naming the file and the place.
pub fn from_text(
    text: &str,
    file: &str,
    overrides: &[Override],
    table: &dyn Fn(&str) -> Result<String, FamilyError>,
) -> Result<LoadedScenario, FamilyError> {
    with_detail(text, file, overrides, table, Detail::PerApproach)
}

/// Does what [`from_text`] does, with the detail of approaches where neither the scenario nor what replaces its
/// settings says one.
fn with_detail(
    text: &str,
    file: &str,
    overrides: &[Override],
    table: &dyn Fn(&str) -> Result<String, FamilyError>,
    detail: Detail,
) -> Result<LoadedScenario, FamilyError> {
    let (mut scenario, bins_without_effect) = settings_of(text, file, overrides, detail)?;
    let flags: String = overrides.iter().map(|o| format!(" {}", o.flag())).collect();
    let file = &if flags.is_empty() { file.to_owned() } else { format!("{file} with{flags}") };
    check(&scenario, file)?;
    let (field, path, of_approaches) = match (&scenario.family.approaches, &scenario.family.points)
    {
        (Some(path), None) => ("family.approaches", path, true),
        (None, Some(path)) => ("family.points", path, false),
        (approaches, _) => {
            let value = if approaches.is_some() { "approaches and points" } else { "no table" };
            let expected = "give exactly one of the two tables, such as points = \"points.csv\" or approaches = \
                            \"approaches.csv\" in [family]";
            return Err(FamilyError::setting(file, "family", value, expected));
        }
    };
    let text_of = |path: &str| table(path).map_err(|e| unreadable(e, file, field, path));
    let own = text_of(path)?;
    let (family, members, intersections, mut doubts);
    if of_approaches {
        intersections = approaches::read(&own, path, None)?;
        (family, members) = derive(&scenario, &intersections, path)?;
        doubts = doubts::of_approaches(&intersections, &scenario.family);
        doubts.extend(bins_without_effect);
        scenario.family.inflows = counted_by_turn(&intersections, scenario.family.inflows);
    } else {
        family = points::read(&scenario.name, &own, path)?;
        members = vec![Vec::new(); family.points.len()];
        (intersections, doubts) = (vec![], doubts::of_points(&family));
    }
    let plans = plans_of(&scenario, file, table)?;
    let text = text.to_owned();
    Ok(LoadedScenario { scenario, text, table: own, family, intersections, members, doubts, plans })
}

/// Returns the plans that a scenario names.
fn plans_of(
    scenario: &Scenario,
    file: &str,
    table: &dyn Fn(&str) -> Result<String, FamilyError>,
) -> Result<Option<Plans>, FamilyError> {
    let Some(path) = &scenario.family.existing else { return Ok(None) };
    let text = table(path).map_err(|e| unreadable(e, file, "family.existing", path))?;
    existing::read(&text, path).map(Some)
}

/// Returns the settings of a scenario, and what of them has no effect.
fn settings_of(
    text: &str,
    file: &str,
    overrides: &[Override],
    detail: Detail,
) -> Result<(Scenario, Option<Doubt>), FamilyError> {
    let mut scenario: Scenario =
        toml::from_str(text).map_err(|e| wording::file_error::<Scenario>(file, text, &e))?;
    let written: Table = text.parse().expect("it has just been read");
    // A name that is written and empty is the user's mistake, one that is not written is the file's.
    if !written.contains_key("name") {
        scenario.name = name_of(file);
    }
    // Which preset counts is the last word of the scenario and of what replaces its settings.
    let mut preset = scenario.preset;
    for setting in overrides {
        scenario = setting.apply(&scenario)?;
        preset = scenario.preset;
    }
    if preset != Preset::default() {
        scenario = with_preset(&written, preset, overrides, file)?;
    }
    let says = |key: &str| {
        written.get("family").is_some_and(|family| family.get(key).is_some())
            || overrides.iter().flat_map(Override::keys).any(|k| k == format!("family.{key}"))
    };
    // Real approaches stay what they are, unless somebody asks for the paper's six features.
    let real = scenario.family.approaches.is_some() && scenario.family.points.is_none();
    if real && !says("detail") {
        scenario.family.detail = detail;
    }
    let without_effect = scenario.family.detail == Detail::PerApproach && says("bins");
    let bins_without_effect = without_effect.then(|| {
        let about = "family.bins has no effect on intersections that keep their own approaches; say detail = \
                     \"six-features\" in [family] for means over them";
        Doubt { about: about.to_owned(), rows: Vec::new() }
    });
    Ok((scenario, bins_without_effect))
}

/// Returns what inflows rest on, with the share of the approaches that were counted by turn; as it was where none was.
fn counted_by_turn(
    intersections: &[Intersection],
    said: Option<InflowSources>,
) -> Option<InflowSources> {
    let approaches = || intersections.iter().flat_map(|i| &i.arms).filter(|a| a.lanes_in > 0);
    let all = approaches().count() as f64;
    let share = |is: &dyn Fn(&&Approach) -> bool| approaches().filter(is).count() as f64 / all;
    let by_turn = share(&|a| a.counted.is_some());
    if by_turn == 0.0 {
        return said;
    }
    let imputed = share(&|a| a.imputed);
    let of_table =
        InflowSources { counted: 1.0 - imputed, spread: 0.0, imputed, default: 0.0, by_turn };
    Some(said.map_or(of_table, |said| InflowSources { by_turn, ..said }))
}

/// Derives the point MDPs of intersections, and per point MDP the intersections it stands for.
fn derive(
    scenario: &Scenario,
    intersections: &[Intersection],
    file: &str,
) -> Result<(MdpFamily, Vec<Vec<usize>>), FamilyError> {
    let weights = period_weights(intersections, scenario.family.periods.as_ref(), file)?;
    let total: f64 = weights.iter().sum();
    let per_approach = scenario.family.detail == Detail::PerApproach;
    if per_approach {
        for intersection in intersections {
            check_arms(intersection)
                .map_err(|message| at(file, Fault { line: intersection.line, message }))?;
        }
    }
    let groups: Vec<(String, SixFeatures, Vec<usize>)> = match per_approach {
        false => group(intersections, &scenario.family)
            .into_iter()
            .map(|(features, members)| (point_id(&features), features, members))
            .collect(),
        true => (intersections.iter().enumerate())
            .map(|(i, intersection)| {
                let features = per_approach_features(intersection, &scenario.family);
                (id_of_point(intersection), features, vec![i])
            })
            .collect(),
    };
    let mut of_id: BTreeMap<&str, &[usize]> = BTreeMap::new();
    for (id, _, members) in &groups {
        if let Some(earlier) = of_id.insert(id, members) {
            let name = |members: &[usize]| named(&intersections[members[0]]);
            let earlier = name(earlier);
            let expected = format!(
                "the point MDP would be called {id}, as that of intersection {earlier}; rename one of the two"
            );
            return Err(FamilyError::setting(file, "intersection", name(members), expected));
        }
    }
    let columns = SixFeatures::COLUMNS
        .map(|(name, unit)| Feature { name: name.to_owned(), unit: unit.to_owned() })
        .to_vec();
    let points = groups
        .iter()
        .map(|(id, features, members)| PointMdp {
            id: id.clone(),
            title: match per_approach {
                false => id.clone(),
                true => called(id, &intersections[members[0]]),
            },
            features: features.to_array().to_vec(),
            importance: members.iter().map(|i| weights[*i]).sum::<f64>() / total,
            instances: members.len() as u32,
        })
        .collect();
    let mut family = MdpFamily::new(&scenario.name, columns, points, file)?;
    let members: Vec<Vec<usize>> = family
        .points
        .iter()
        .map(|p| of_id.get(&*p.id).expect("points are made from groups").to_vec())
        .collect();
    if per_approach {
        let row = |members: &Vec<usize>| describing(&intersections[members[0]], &scenario.family);
        family.describing = members.iter().map(row).collect();
    }
    Ok((family, members))
}

/// Returns the weight of each intersection: the hours of its period, or 1 where the settings say none.
fn period_weights(
    intersections: &[Intersection],
    hours: Option<&BTreeMap<String, f64>>,
    file: &str,
) -> Result<Vec<f64>, FamilyError> {
    let Some(hours) = hours else { return Ok(vec![1.0; intersections.len()]) };
    let rows = |period: &str| intersections.iter().any(|i| i.period == period);
    let unfit =
        hours.iter().find(|(period, hours)| !(hours.is_normal() && **hours > 0.0 && rows(period)));
    if let Some((period, hours)) = unfit {
        let expected = "expected hours per year above 0, of a period that rows of the table have";
        let value = format!("{period} = {hours}");
        return Err(FamilyError::setting(file, "family.periods", value, expected));
    }
    let weight = |i: &Intersection| {
        hours.get(&i.period).copied().ok_or_else(|| {
            let (id, period) = (&i.id, &i.period);
            let message =
                format!("intersection {id}: family.periods has no hours for its period {period:?}");
            at(file, Fault { line: i.line, message })
        })
    };
    intersections.iter().map(weight).collect()
}

/// Returns the number of an intersection, as UTDF numbers nodes. `007` is no number but a name, as `7` is another one.
pub fn number_of_intersection(id: &str) -> Option<u32> {
    id.parse().ok().filter(|number: &u32| number.to_string() == id)
}

/// Returns the id of an intersection as files are called: a number gets a letter and leading zeros, so that names sort as
/// numbers do.
pub fn id_of_intersection(id: &str) -> String {
    number_of_intersection(id).map_or_else(|| safe_id(id), |number| format!("i{number:04}"))
}

/// Returns the id of the point MDP of an intersection: the period, if any, comes last.
fn id_of_point(intersection: &Intersection) -> String {
    let own = id_of_intersection(&intersection.id);
    match intersection.period.as_str() {
        "" => own,
        period => safe_id(&format!("{own}-{period}")),
    }
}

/// Returns an intersection as errors call it.
fn named(intersection: &Intersection) -> String {
    match intersection.period.as_str() {
        "" => intersection.id.clone(),
        period => format!("{} in the period {period}", intersection.id),
    }
}

/// Returns what people call a point MDP: the streets where the names of the arms say them, else the name of its
/// intersection where the id is made from it, else the id.
fn called(id: &str, intersection: &Intersection) -> String {
    let Intersection { id: name, period, .. } = intersection;
    let streets = streets(intersection);
    let is_plain = |text: &str| check_id("", text).is_ok();
    if streets.is_none() && is_plain(name) && (period.is_empty() || is_plain(period)) {
        return id.to_owned();
    }
    let name = streets.as_ref().unwrap_or(name);
    if period.is_empty() { name.clone() } else { format!("{name}, {period}") }
}

/// Returns the streets of an intersection whose arms are called like `NB Main St`, the direction of travel and the
/// street; `None` where one is not.
fn streets(intersection: &Intersection) -> Option<String> {
    let mut streets: Vec<&str> = Vec::new();
    for arm in &intersection.arms {
        let (direction, street) = arm.arm.split_once(' ')?;
        Heading::ALL.iter().any(|h| h.name() == direction).then_some(())?;
        if !streets.contains(&street) {
            streets.push(street);
        }
    }
    Some(streets.join(" / "))
}

#[cfg(test)]
mod tests;

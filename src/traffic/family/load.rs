//! Reads a scenario, embedded or from a file, and derives its family.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use sheet::Fault;
use toml::Table;

use super::approaches::{self, Intersection, check_arms};
use super::describing::describing;
use super::features::{group, per_approach_features, point_id};
use super::points;
use crate::family::columns::at;
use crate::family::error::FamilyError;
use crate::family::names::{check_id, safe_id};
use crate::family::{Feature, MdpFamily, PointMdp};
use crate::settings::default_name::name_of;
use crate::settings::overrides::{Override, overlay};
use crate::settings::source::{file_of, read_scenario, read_text, unreadable};
use crate::settings::wording;
use crate::suggest::did_you_mean;
use crate::traffic::settings::check::check;
use crate::traffic::settings::{Detail, Preset, Scenario, SixFeatures};

/// Scenarios that the binary carries, so that it works from any directory.
pub const EMBEDDED: [(&str, &str); 3] = [
    ("salt-lake-city", include_str!("../../../scenarios/salt-lake-city.toml")),
    ("salt-lake-city-peak", include_str!("../../../scenarios/salt-lake-city-peak.toml")),
    ("smoke", include_str!("../../../scenarios/smoke.toml")),
];

/// Tables that embedded scenarios name, by the path in the scenario.
const EMBEDDED_TABLES: [(&str, &str); 2] = [
    (
        "../data/salt-lake-city/approaches.csv",
        include_str!("../../../data/salt-lake-city/approaches.csv"),
    ),
    ("smoke.csv", include_str!("../../../scenarios/smoke.csv")),
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
    if let Some((_, text)) = EMBEDDED.iter().find(|(n, _)| *n == name) {
        let file = format!("{name}.toml (embedded)");
        let table = |table: &str| match EMBEDDED_TABLES.iter().find(|(path, _)| *path == table) {
            Some((_, text)) => Ok((*text).to_owned()),
            // Only a table from the command line is not embedded.
            None => read_text(Path::new(table)),
        };
        return from_text(text, &file, overrides, &table);
    }
    let path = Path::new(name);
    if !path.exists() {
        let embedded: Vec<_> = EMBEDDED.iter().map(|(n, _)| *n).collect();
        let mut known: Vec<String> = embedded.iter().map(|n| (*n).to_owned()).collect();
        known.extend(beside(path));
        return Err(FamilyError::UnknownScenario {
            name: name.to_owned(),
            embedded: embedded.join(", "),
            meant: did_you_mean(name, known.iter().map(String::as_str)),
        });
    }
    let path = file_of(name);
    let text = read_scenario(&path)?;
    let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    let table = |table: &str| read_text(&folder.join(table));
    from_text(&text, &path.display().to_string(), overrides, &table)
}

/// Returns the scenarios in the folder of a path.
fn beside(path: &Path) -> Vec<String> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let read = std::fs::read_dir(if folder == Path::new("") { Path::new(".") } else { folder });
    let paths = read.into_iter().flatten().flatten().map(|e| folder.join(e.file_name()));
    let scenario = |p: &PathBuf| {
        p.extension().is_some_and(|e| e == "toml") || p.join("scenario.toml").is_file()
    };
    paths.filter(scenario).map(|p| p.display().to_string()).collect()
}

/// Returns a scenario whose text stands on a preset's, with settings replaced.
fn with_preset(
    text: &str,
    preset: Preset,
    overrides: &[Override],
    file: &str,
) -> Result<Scenario, FamilyError> {
    let table = |text: &str| -> Table { text.parse().expect("it has been read before") };
    let mut settings = table(preset.text());
    overlay(&mut settings, table(text));
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
    let mut scenario: Scenario =
        toml::from_str(text).map_err(|e| wording::file_error::<Scenario>(file, text, &e))?;
    // A name that is written and empty is the user's mistake, one that is not written is the file's.
    if !text.parse::<Table>().is_ok_and(|table| table.contains_key("name")) {
        scenario.name = name_of(file);
    }
    // Which preset counts is the last word of the scenario and of what replaces its settings.
    let mut preset = scenario.preset;
    for setting in overrides {
        scenario = setting.apply(&scenario)?;
        preset = scenario.preset;
    }
    if preset != Preset::default() {
        scenario = with_preset(text, preset, overrides, file)?;
    }
    let flags: String = overrides.iter().map(|o| format!(" {}", o.flag())).collect();
    let file = &if flags.is_empty() { file.to_owned() } else { format!("{file} with{flags}") };
    check(&scenario, file)?;
    let text = text.to_owned();
    match (&scenario.family.approaches, &scenario.family.points) {
        (Some(path), None) => {
            let table = table(path).map_err(|e| unreadable(e, file, "family.approaches", path))?;
            let intersections = approaches::read(&table, path)?;
            let (family, members) = derive(&scenario, &intersections, path)?;
            Ok(LoadedScenario { scenario, text, table, family, intersections, members })
        }
        (None, Some(path)) => {
            let table = table(path).map_err(|e| unreadable(e, file, "family.points", path))?;
            let family = points::read(&scenario.name, &table, path)?;
            let members = vec![Vec::new(); family.points.len()];
            Ok(LoadedScenario { scenario, text, table, family, intersections: vec![], members })
        }
        (approaches, _) => Err(FamilyError::Setting {
            file: file.to_owned(),
            field: "family".into(),
            value: if approaches.is_some() { "approaches and points" } else { "no table" }.into(),
            expected: "give exactly one of the two tables, such as points = \"points.csv\" or \
                       approaches = \"approaches.csv\" in [family]"
                .into(),
        }),
    }
}

/// Derives the point MDPs of intersections, and per point MDP the intersections it stands for.
fn derive(
    scenario: &Scenario,
    intersections: &[Intersection],
    file: &str,
) -> Result<(MdpFamily, Vec<Vec<usize>>), FamilyError> {
    let total = intersections.len() as f64;
    if scenario.family.detail == Detail::PerApproach {
        for intersection in intersections {
            check_arms(intersection)
                .map_err(|message| at(file, Fault { line: intersection.line, message }))?;
        }
    }
    let groups: Vec<(String, SixFeatures, Vec<usize>)> = match scenario.family.detail {
        Detail::SixFeatures => group(intersections, &scenario.family)
            .into_iter()
            .map(|(features, members)| (point_id(&features), features, members))
            .collect(),
        Detail::PerApproach => intersections
            .iter()
            .enumerate()
            .map(|(i, intersection)| {
                let features = per_approach_features(intersection, &scenario.family);
                (id_of_point(&intersection.id), features, vec![i])
            })
            .collect(),
    };
    let mut of_id: BTreeMap<&str, &[usize]> = BTreeMap::new();
    for (id, _, members) in &groups {
        if let Some(earlier) = of_id.insert(id, members) {
            let name = |members: &[usize]| &intersections[members[0]].id;
            return Err(FamilyError::Setting {
                file: file.to_owned(),
                field: "intersection".into(),
                value: name(members).clone(),
                expected: format!(
                    "the point MDP would be called {id}, as that of intersection {}; rename one \
                     of the two",
                    name(earlier)
                ),
            });
        }
    }
    let columns = SixFeatures::COLUMNS
        .map(|(name, unit)| Feature { name: name.to_owned(), unit: unit.to_owned() })
        .to_vec();
    let points = groups
        .iter()
        .map(|(id, features, members)| PointMdp {
            id: id.clone(),
            title: match scenario.family.detail {
                Detail::SixFeatures => id.clone(),
                Detail::PerApproach => called(id, &intersections[members[0]].id),
            },
            features: features.to_array().to_vec(),
            importance: members.len() as f64 / total,
            instances: members.len() as u32,
        })
        .collect();
    let mut family = MdpFamily::new(&scenario.name, columns, points, file)?;
    let members: Vec<Vec<usize>> = family
        .points
        .iter()
        .map(|p| of_id.get(&*p.id).expect("points are made from groups").to_vec())
        .collect();
    if scenario.family.detail == Detail::PerApproach {
        let row = |members: &Vec<usize>| describing(&intersections[members[0]], &scenario.family);
        family.describing = members.iter().map(row).collect();
    }
    Ok((family, members))
}

/// Returns the id of the point MDP of an intersection: a number gets a letter and leading zeros, so
/// that names sort as numbers do. `007` is no number but a name, as `7` is another one.
fn id_of_point(intersection: &str) -> String {
    match intersection.parse::<u32>() {
        Ok(number) if number.to_string() == intersection => format!("i{number:04}"),
        _ => safe_id(intersection),
    }
}

/// Returns what people call a point MDP: the name of its intersection where the id is made from it,
/// else the id.
fn called(id: &str, intersection: &str) -> String {
    if check_id("", intersection).is_ok() { id.to_owned() } else { intersection.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn salt_lake_city_has_164_point_mdps_of_282_intersections() {
        let loaded = load("salt-lake-city").unwrap();
        assert_eq!(loaded.intersections.len(), 282);
        assert_eq!(loaded.family.points.len(), 164);
        assert_eq!(loaded.family.points[0].instances, 19);
        let single = loaded.family.points.iter().filter(|p| p.instances == 1).count();
        assert_eq!(single, 117);
    }

    #[test]
    fn the_design_hour_has_other_point_mdps_of_the_same_table() {
        let (mean, peak) = (load("salt-lake-city").unwrap(), load("salt-lake-city-peak").unwrap());
        assert_eq!((peak.intersections, peak.table), (mean.intersections, mean.table));
        assert_eq!(peak.family.points.len(), 187);
        let mut settings = peak.scenario;
        (settings.name, settings.title) = (mean.scenario.name.clone(), mean.scenario.title.clone());
        settings.version = mean.scenario.version;
        settings.family.hourly_share = mean.scenario.family.hourly_share;
        assert_eq!(settings, mean.scenario);
    }

    #[test]
    fn a_scenario_without_a_version_has_the_first() {
        assert_eq!(load("smoke").unwrap().scenario.version, 1);
        assert_eq!(load("salt-lake-city").unwrap().scenario.version, 2);
    }

    #[test]
    fn salt_lake_city_has_36_approaches_without_a_count_at_30_intersections() {
        let loaded = load("salt-lake-city").unwrap();
        let imputed: Vec<u32> =
            loaded.intersections.iter().map(|i| i.imputed).filter(|n| *n > 0).collect();
        assert_eq!((imputed.len(), imputed.iter().sum::<u32>()), (30, 36));
    }

    #[test]
    fn four_intersections_are_raised_to_the_minimal_inflow() {
        let loaded = load("salt-lake-city").unwrap();
        let raised: u32 = loaded
            .family
            .points
            .iter()
            .filter(|p| p.features[3] == 60.0)
            .map(|p| p.instances)
            .sum();
        assert_eq!(raised, 4);
    }

    #[test]
    fn per_approach_detail_keeps_every_intersection() {
        let text = EMBEDDED[0].1.replace("six-features", "per-approach");
        let loaded =
            from_text(&text, "t.toml", &[], &|_| Ok(EMBEDDED_TABLES[0].1.to_owned())).unwrap();
        assert_eq!(loaded.family.points.len(), 282);
    }

    /// The ids of a family of intersections with these ids, each with one arm.
    fn per_approach(ids: &[&str]) -> Result<Vec<String>, String> {
        let mut table = "intersection,arm,latitude,longitude,bearing_deg,lanes_in,lanes_out,\
            left_turn_lanes,right_turn_lanes,speed_mph,length_m,aadt_veh_per_day_per_lane,\
            movements\n"
            .to_owned();
        for id in ids {
            table += &format!("{id},A,40,-111,0,2,1,1,0,30,200,9000,\n");
            table += &format!("{id},B,40,-111,90,2,1,1,0,30,200,9000,\n");
        }
        let text = "name = \"x\"\n[family]\napproaches = \"a.csv\"\ndetail = \"per-approach\"\n";
        let loaded = from_text(text, "t.toml", &[], &|_| Ok(table.clone()));
        let loaded = loaded.map_err(|e| e.to_string())?;
        Ok(loaded.family.points.into_iter().map(|p| p.id).collect())
    }

    #[test]
    fn only_plain_numbers_are_renamed_so_that_two_ids_stay_two() {
        let ids = per_approach(&["7", "007", "12345", "99999999999", "n7"]).unwrap();
        assert_eq!(ids, ["007", "99999999999", "i0007", "i12345", "n7"]);
    }

    #[test]
    fn two_intersections_of_one_point_id_are_refused_by_name() {
        assert_eq!(
            per_approach(&["7", "i0007"]).unwrap_err(),
            "a.csv: intersection = i0007: the point MDP would be called i0007, as that of \
             intersection 7; rename one of the two"
        );
    }

    #[test]
    fn arms_that_cannot_be_built_are_refused_with_their_line() {
        let table = EMBEDDED_TABLES[0].1;
        let row = table.lines().rfind(|line| !line.is_empty()).unwrap();
        let twin = row.replacen(row.split(',').nth(1).unwrap(), "twin", 1);
        let table = format!("{}\n{twin}\n", table.trim_end());
        let read = |detail: &str| {
            let text = EMBEDDED[0].1.replace("six-features", detail);
            from_text(&text, "t.toml", &[], &|_| Ok(table.clone()))
        };
        read("six-features").unwrap();
        let error = read("per-approach").unwrap_err().to_string();
        assert!(error.contains(", line ") && error.contains("both have bearing_deg"), "{error}");
    }

    #[test]
    fn an_unknown_field_is_refused_with_its_name() {
        let text = "name = \"x\"\n[family]\npoints = \"p.csv\"\nspeeed = 3\n";
        let e = from_text(text, "t.toml", &[], &|_| unreachable!()).unwrap_err().to_string();
        assert!(e.contains("t.toml") && e.contains("speeed"), "{e}");
    }

    #[test]
    fn both_tables_at_once_are_refused() {
        let text = "name = \"x\"\n[family]\npoints = \"p.csv\"\napproaches = \"a.csv\"\n";
        let e = from_text(text, "t.toml", &[], &|_| unreachable!()).unwrap_err().to_string();
        assert!(e.contains("exactly one"), "{e}");
    }
}

//! What a point MDP is, as a hash: its seeds follow from that.
//!
//! Neither the name nor the path of a point MDP counts, so that whoever renames or moves a SUMO
//! scenario meets the same vehicles in it, and equal point MDPs meet equal vehicles. What the scenario
//! file sets does not count either: two runs that differ in the demand or the signals share their
//! random numbers.
//!
//! - **Six features:** their names and values.
//! - **Own arms:** the rows of the table, without the names of intersection, arms and period.
//! - **Imported:** the bytes of network, routes and additional files and of what they name, begin and end.

use serde_json::{Value, json};

use super::error::TrafficError;
use crate::family::load::LoadedScenario;
use crate::settings::Detail;
use crate::sim::intake::Intake;
use basics::hash::{sha256, sha256_file};

/// Returns the hash of the `index`-th point MDP of a scenario's family.
pub fn of_point(loaded: &LoadedScenario, index: usize) -> String {
    let content = match loaded.scenario.family.detail {
        Detail::SixFeatures => {
            let (family, point) = (&loaded.family, &loaded.family.points[index]);
            let named = family.features.iter().map(|f| &f.name).zip(&point.features);
            json!(named.collect::<Vec<_>>())
        }
        Detail::PerApproach => {
            let arms = loaded.members[index].iter().flat_map(|i| &loaded.intersections[*i].arms);
            let nameless = arms.map(|arm| {
                let mut row = serde_json::to_value(arm).expect("an approach is plain data");
                row["intersection"] = Value::Null;
                row["arm"] = Value::Null;
                row.as_object_mut().map(|row| row.remove("period"));
                row
            });
            json!(nameless.collect::<Vec<_>>())
        }
    };
    hash(&content)
}

/// Returns the hash of an imported scenario.
///
/// # Errors
///
/// [`TrafficError`] when a file that is read with it cannot be read.
pub fn of_imported(intake: &Intake) -> Result<String, TrafficError> {
    let files: Result<Vec<String>, _> =
        intake.sources.named().map(|(_, file)| sha256_file(file)).collect();
    Ok(hash(&json!([intake.begin_s, intake.end_s, files?])))
}

fn hash(content: &Value) -> String {
    sha256(content.to_string().as_bytes())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::fs;

    use super::*;
    use crate::family::load::{load, load_with};

    fn all(loaded: &LoadedScenario) -> Vec<String> {
        (0..loaded.family.points.len()).map(|i| of_point(loaded, i)).collect()
    }

    #[test]
    fn every_point_mdp_of_salt_lake_city_differs_with_and_without_its_own_arms() {
        for detail in ["six-features", "per-approach"] {
            let detail = format!("family.detail={detail}").parse().unwrap();
            let hashes = all(&load_with("salt-lake-city", &[detail]).unwrap());
            assert_eq!(hashes.iter().collect::<BTreeSet<_>>().len(), hashes.len());
        }
    }

    #[test]
    fn neither_names_nor_settings_count() {
        let loaded = load("smoke").unwrap();
        let mut other = loaded.clone();
        other.family.points[0].id = "renamed".into();
        other.scenario.demand.peak_hour_factor = 0.9;
        assert_eq!(all(&loaded), all(&other));
        other.family.points[0].features[0] += 1.0;
        assert_ne!(all(&loaded), all(&other));
        let own = "family.detail=per-approach".parse().unwrap();
        let mut arms = load_with("salt-lake-city", &[own]).unwrap();
        let before = of_point(&arms, 0);
        let first = arms.members[0][0];
        arms.intersections[first].arms.iter_mut().for_each(|a| a.intersection = "x".into());
        assert_eq!(before, of_point(&arms, 0));
    }

    #[test]
    fn a_copy_of_a_sumo_scenario_under_other_names_is_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, routes: &str, end: u32| {
            let path = |ending: &str| folder.path().join(format!("{name}.{ending}"));
            fs::write(path("net"), "<net/>").unwrap();
            fs::write(path("rou"), routes).unwrap();
            let text = format!(
                "<configuration><net-file value=\"{name}.net\"/>\
                 <route-files value=\"{name}.rou\"/><end value=\"{end}\"/></configuration>"
            );
            fs::write(path("sumocfg"), text).unwrap();
            let given = crate::sim::obstacle::Given::default();
            of_imported(&Intake::read(&path("sumocfg"), &given).unwrap()).unwrap()
        };
        let a = write("a", "<routes/>", 60);
        assert_eq!(a, write("b", "<routes/>", 60));
        assert_ne!(a, write("c", "<routes></routes>", 60));
        assert_ne!(a, write("d", "<routes/>", 61));
    }
}

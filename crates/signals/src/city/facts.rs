//! What the family of a city adds to what is known of its map.

use super::config::DesignHour;
use super::quality::{Distribution, FamilyFacts};
use crate::family::features::six_features;
use crate::family::load::LoadedScenario;
use crate::settings::SixFeatures;

/// Returns what the family of a city adds to what is known of it.
pub(super) fn family_facts(loaded: &LoadedScenario) -> FamilyFacts {
    let settings = &loaded.scenario.family;
    FamilyFacts {
        name: loaded.scenario.name.clone(),
        demand: DesignHour {
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

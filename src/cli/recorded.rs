//! Results on a whole family, read for estimators.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use super::output::note;
use crate::analysis::Analysis;
use crate::domains;
use crate::family::MdpFamily;
use crate::sample::{Design, Sampling};
use crate::store::Layout;
use crate::store::difference::flat;
use crate::store::results::Results;
use crate::study::Recorded;

/// Reads results on a whole family.
pub(super) fn read(dir: &Path) -> anyhow::Result<(Recorded, Analysis)> {
    let layout = Layout::new(dir);
    let results = Results::load(&layout)?;
    let analysis = domains::analysis(&layout, &results)?;
    Ok((Recorded::of(&analysis, &dir.display().to_string())?, analysis))
}

/// Returns what a sample is spread over: features, and scores where results in a folder assist.
pub(super) fn design(
    family: &MdpFamily,
    sampling: Sampling,
    known: Option<(&Recorded, &Path)>,
) -> anyhow::Result<Design> {
    let mut design = Design::of(family);
    if let Some((known, dir)) = known {
        known.add_to(&mut design, &dir.display().to_string())?;
    }
    Ok(design.for_sampling(sampling))
}

/// Most settings that a warning names.
const MOST_NAMED: usize = 3;

/// Warns where results that assist were computed with other settings than what they assist. Estimates stay right, since
/// what assists is only what point MDPs are told apart by, but it tells less of them.
pub(super) fn warn_of_settings(dir: &Path, known: &Analysis, settings: &Value) {
    let identity = &known.manifest.identity;
    let (there, here) = (flat(&identity.settings), flat(settings));
    let keys = there.keys().chain(here.keys().filter(|key| !there.contains_key(*key)));
    let domains = domains::domains();
    let names: Vec<&str> = domains.iter().flat_map(|d| d.methods()).map(|m| m.name).collect();
    // Sections of methods without results say nothing.
    let absent = |key: &str| {
        let section = key.split('.').next().unwrap_or_default().replace('_', "-");
        !identity.methods.contains(&section) && names.contains(&section.as_str())
    };
    let differing: Vec<String> = keys
        .filter(|key| there.get(*key) != here.get(*key) && !absent(key))
        .map(|key| {
            let of = |values: &BTreeMap<String, Value>| {
                values.get(key).map_or_else(|| "nothing".to_owned(), Value::to_string)
            };
            format!("{key} = {} there, {} here", of(&there), of(&here))
        })
        .collect();
    if differing.is_empty() {
        return;
    }
    let more = differing.len().saturating_sub(MOST_NAMED);
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    let named = differing.iter().take(MOST_NAMED).cloned().collect::<Vec<_>>().join("; ");
    note(format!(
        "warning: {} was computed with other settings ({named}{more}): it helps less than results with the same \
         settings would",
        dir.display()
    ));
}

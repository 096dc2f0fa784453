//! Results on a whole family, read for estimators.

use std::path::Path;

use serde_json::Value;

use super::output::note;
use crate::analysis::Analysis;
use crate::domains;
use crate::family::MdpFamily;
use crate::sample::{Design, Sampling};
use crate::store::results::Results;
use crate::store::{Layout, assisting};
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

/// Returns what is kept of the settings of results that assist.
pub(super) fn settings_of(known: &Recorded, analysis: &Analysis) -> Value {
    let domains = domains::domains();
    let names: Vec<&str> = domains.iter().flat_map(|d| d.methods()).map(|m| m.name).collect();
    let inputs: Vec<&str> = known.inputs.iter().map(|(input, _)| input.method.as_str()).collect();
    assisting::kept(&analysis.manifest.identity.settings, &names, &inputs)
}

/// Warns where results that assist were computed with other settings than what they assist. Estimates stay right, since
/// what assists is only what point MDPs are told apart by, but it tells less of them.
///
/// # Arguments
///
/// * `subject` — what was computed, in words.
/// * `there` — from [`settings_of`].
pub(super) fn warn_of_settings(subject: &str, there: &Value, here: &Value) {
    if let Some(named) = assisting::differences(there, here) {
        note(format!(
            "warning: {subject} was computed with other settings ({named}): it helps less than results with the same \
             settings would"
        ));
    }
}

//! What a report says beside published results.

use serde_json::Value;

use super::format;
use super::whole::Report;
use crate::published;
use crate::store::assisting;

/// Compares the methods of a report with their published rows: a sentence on those that agree, and one on those that do not.
/// Methods with other settings, results of another version or simulator, and joined runs are not compared.
pub(super) fn compared(data: &Report) -> Vec<String> {
    let identity = &data.manifest.identity;
    let run = [&identity.scenario, &identity.tsc_family, &identity.simulator].map(String::clone);
    let Ok(file) = published::comparable(&run, &identity.settings) else { return Vec::new() };
    if !data.reference.is_baseline || data.runs.is_some() {
        return Vec::new();
    }
    let fits = |there: &Value| assisting::differing(there, &identity.settings).is_empty();
    let (mut agree, mut differ) = (Vec::new(), Vec::new());
    let rows = || file["methods"].as_array().into_iter().flatten();
    let ranked = data.methods.iter().filter(|m| m.rank.is_some() && !m.is_reference);
    for (m, row) in ranked.filter_map(|m| Some((m, rows().find(|row| row["method"] == *m.method)?)))
    {
        let Some((score, interval)) = m.overall.zip(m.interval) else { continue };
        let number = |key: &str| row[key].as_f64().unwrap_or(f64::NAN);
        let there = (number("score"), (number("low"), number("high")));
        // Of learners the row has their own settings.
        if identity.controller(&m.method).is_some() || !row.get("settings").is_none_or(fits) {
            continue;
        }
        let said = |(score, interval)| format::score_within(score, Some(interval));
        let both = format!("{} {} here, {} there", m.method, said((score, interval)), said(there));
        if apart((score, interval), there) { &mut differ } else { &mut agree }.push(both);
    }
    let of = format!("the published results of version {}", identity.tsc_family);
    let sentence = |what: &str, all: Vec<String>| {
        (!all.is_empty()).then(|| format!("{what} {of}: {}.", all.join("; ")))
    };
    let differ = sentence("Differs by more than chance from", differ);
    differ.into_iter().chain(sentence("Agrees with", agree)).collect()
}

/// Whether two scores differ by more than their intervals explain, which are of the same kind and taken as independent.
fn apart(a: (f64, (f64, f64)), b: (f64, (f64, f64))) -> bool {
    let (low, high) = if a.0 < b.0 { (a, b) } else { (b, a) };
    let reach = (low.1.1 - low.0).hypot(high.0 - high.1.0);
    high.0 - low.0 > reach
}

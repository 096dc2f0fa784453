//! What a report says beside published results.

use serde_json::Value;

use super::format;
use super::whole::Report;
use crate::published;
use crate::store::assisting;

/// Fewest point MDPs of a sample that give a method a place among the published ones.
const FEWEST: usize = 10;

/// Compares the methods of a report with their published rows: a sentence on those that agree, one on those that do not, and
/// the place of each other method.
/// Methods with other settings, results of another version or simulator, and joined runs are not compared.
pub(super) fn compared(data: &Report) -> Vec<String> {
    let identity = &data.manifest.identity;
    let run = [&identity.scenario, &identity.tsc_family, &identity.simulator].map(String::clone);
    let Ok(file) = published::comparable(&run, &identity.settings) else { return Vec::new() };
    if !data.reference.is_baseline || data.runs.is_some() {
        return Vec::new();
    }
    let fits = |there: &Value| assisting::differing(there, &identity.settings).is_empty();
    let of = format!("the published results of version {}", identity.tsc_family);
    let (mut agree, mut differ, mut places) = (Vec::new(), Vec::new(), Vec::new());
    let rows: Vec<&Value> = file["methods"].as_array().into_iter().flatten().collect();
    let ranked = data.methods.iter().filter(|m| m.rank.is_some() && !m.is_reference);
    for m in ranked {
        let Some((score, interval)) = m.overall.zip(m.interval) else { continue };
        let Some(row) = rows.iter().find(|row| row["method"] == *m.method) else {
            if m.points >= FEWEST.min(identity.sample.family_size) {
                let place = place((score, interval), &rows);
                places.push(format!("{} beside {of}: {place}.", m.method));
            }
            continue;
        };
        let there = published_score(row);
        // Of learners the row has their own settings.
        if identity.controller(&m.method).is_some() || !row.get("settings").is_none_or(fits) {
            continue;
        }
        let said = |(score, interval)| format::score_within(score, Some(interval));
        let both = format!("{} {} here, {} there", m.method, said((score, interval)), said(there));
        if apart((score, interval), there) { &mut differ } else { &mut agree }.push(both);
    }
    let sentence = |what: &str, all: Vec<String>| {
        (!all.is_empty()).then(|| format!("{what} {of}: {}.", all.join("; ")))
    };
    let differ = sentence("Differs by more than chance from", differ);
    differ.into_iter().chain(sentence("Agrees with", agree)).chain(places).collect()
}

/// A score with its interval.
type Scored = (f64, (f64, f64));

fn published_score(row: &Value) -> Scored {
    let number = |key: &str| row[key].as_f64().unwrap_or(f64::NAN);
    (number("score"), (number("low"), number("high")))
}

/// Says which places a method may have among published ones, and against which ones that is decided.
fn place(own: Scored, rows: &[&Value]) -> String {
    let (mut ahead, mut behind, mut open) = (Vec::new(), Vec::new(), Vec::new());
    for row in rows {
        let there = published_score(row);
        let side = match (apart(own, there), own.0 < there.0) {
            (false, _) => &mut open,
            (true, true) => &mut ahead,
            (true, false) => &mut behind,
        };
        side.extend(row["method"].as_str());
    }
    let (first, last) = (behind.len() + 1, behind.len() + open.len() + 1);
    let to = if first == last { String::new() } else { format!(" to {last}") };
    let sides =
        [("ahead of", ahead), ("behind", behind), ("open, it may be chance, against", open)];
    let sides = sides.into_iter().filter(|(_, methods)| !methods.is_empty());
    let sides: Vec<String> =
        sides.map(|(side, methods)| format!("{side} {}", methods.join(", "))).collect();
    format!("place {first}{to} of {}, {}", rows.len() + 1, sides.join("; "))
}

/// Whether two scores differ by more than their intervals explain, which are of the same kind and taken as independent.
fn apart(a: Scored, b: Scored) -> bool {
    let (low, high) = if a.0 < b.0 { (a, b) } else { (b, a) };
    let reach = (low.1.1 - low.0).hypot(high.0 - high.1.0);
    high.0 - low.0 > reach
}

//! What differs between the runs that a report compares, and how much that matters.

use super::format;
use super::whole::Report;
use crate::analysis::joined::Joined;
use crate::analysis::{Decided, Pair};

/// Says what differs between runs, and what their common methods show of it.
pub(super) fn differences(data: &Report, joined: &Joined) -> Vec<String> {
    let mut said = joined.differences.clone();
    said.extend(simulators(joined));
    said.extend(joined.apart.iter().flat_map(|(method, names)| measured(data, method, names)));
    said
}

/// Warns of several versions of the simulator; `None` where there is one.
fn simulators(joined: &Joined) -> Option<String> {
    if joined.simulators.is_empty() {
        return None;
    }
    let versions = joined.simulators.join(" and ");
    let measured = match joined.apart.is_empty() {
        true if joined.results.manifest.identity.baseline.is_empty() => {
            "no method was run under both"
        }
        true => {
            "methods that were run under both have the same records, so the versions make no difference to them"
        }
        false => "below is what they make of methods that were run under both",
    };
    Some(format!(
        "Warning: {versions} simulate traffic otherwise, so differences between methods of different runs contain the effect \
         of the version; {measured}."
    ))
}

/// Says by how much the records of one method differ between runs.
fn measured(data: &Report, method: &str, names: &[String]) -> Vec<String> {
    let place = |name: &String| data.methods.iter().position(|m| m.method == *name);
    let Some(first) = names.first().and_then(place) else { return Vec::new() };
    let of = |other: usize| {
        let with = |p: &&Pair| {
            [p.first, p.second] == [first, other] || [p.second, p.first] == [first, other]
        };
        let pair = data.comparison.pairs.iter().find(with)?;
        let (better, worse) = (&data.methods[pair.first].method, &data.methods[pair.second].method);
        let (ahead, interval) = format::lead(pair.ahead.value, pair.ahead.interval);
        let interval = interval.map(|interval| format!(", 95% interval {interval}"));
        let verdict = match pair.decided() {
            Decided::Open => "; this may be chance",
            Decided::Unknown => "; whether this is chance is not known",
            _ => "",
        };
        Some(format!(
            "Method {method} is in several runs with other records: {better} is ahead of {worse} by {ahead} in score ({}{}{verdict}).",
            format::count(pair.points, "point MDP"),
            interval.unwrap_or_default(),
        ))
    };
    names[1..].iter().filter_map(place).filter_map(of).collect()
}

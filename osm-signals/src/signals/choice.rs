//! Which rows of a list are signals: what somebody asks for, and what looks like something else.

use std::collections::BTreeMap;

use crate::error::{OsmError, brief};
use crate::table::{Column, Table};

/// Values with how often they occur.
pub(super) type Values = BTreeMap<String, usize>;

/// Usual names of columns that tell signals from what else a list has.
const KINDS: [&str; 11] = [
    "type", "kind", "signal_type", "sig_type", "asset_type", "device_type", "site_type",
    "category", "status", "state", "signal_status",
];

/// Parts of words for what stands in such lists and stops nobody, or not yet, or no longer.
const NO_SIGNALS: [&str; 29] = [
    "beacon", "flash", "planned", "pending", "proposed", "future", "design", "removed", "retired",
    "inactive", "abandoned", "school", "rrfb", "rapid", "hawk", "hybrid", "decommission",
    "construction", "crossing", "pelican", "puffin", "toucan", "meter", "camera", "pedestrian",
    "mid-block", "midblock", "mid block", "emergency",
];

/// Whole words for the same: as a part, `sign` is in every signal. Half signals and pedestrian
/// hybrid beacons (PHB) stop one of two streets, and signals of fire stations only for fire engines.
const NO_SIGNALS_ALONE: [&str; 5] = ["sign", "signs", "half", "fire", "phb"];

/// Most different values that a message names.
const NAMED: usize = 8;

/// What a column has to have, or not.
pub(super) struct Condition {
    /// Where the column is.
    pub(super) column: usize,
    /// Values of which it has one, lower case; if there are any.
    any: Vec<String>,
    /// Values that it has not, lower case.
    none: Vec<String>,
}

impl Condition {
    /// Returns whether a value, in lower case, is as asked for.
    pub(super) fn holds(&self, value: &String) -> bool {
        (self.any.is_empty() || self.any.contains(value)) && !self.none.contains(value)
    }
}

/// Returns what rows have to have.
pub(super) fn conditions(table: &Table<'_>, keep: &[String]) -> Result<Vec<Condition>, OsmError> {
    let mut of: BTreeMap<usize, Condition> = BTreeMap::new();
    for text in keep {
        let Some((name, value)) = text.split_once('=') else {
            let reason = format!("{:?}: expected COLUMN=VALUE or COLUMN!=VALUE", brief(text));
            return Err(table.nothing(&reason));
        };
        let (name, is_not) = match name.strip_suffix('!') {
            Some(name) => (name, true),
            None => (name, false),
        };
        let column = Column { what: "rows to keep", given: Some(name.trim()), usual: &[] };
        let column = table.need(&column)?;
        let new = || Condition { column, any: Vec::new(), none: Vec::new() };
        let condition = of.entry(column).or_insert_with(new);
        let values = if is_not { &mut condition.none } else { &mut condition.any };
        values.push(value.trim().to_lowercase());
    }
    Ok(of.into_values().collect())
}

/// Returns the columns that may tell signals from what else there is and that nobody asked for.
pub(super) fn kinds(table: &Table<'_>, conditions: &[Condition]) -> Vec<usize> {
    let usual = KINDS.iter().filter_map(|name| {
        let column = Column { what: "kind", given: None, usual: std::slice::from_ref(name) };
        table.find(&column).ok().flatten()
    });
    usual.filter(|column| conditions.iter().all(|c| c.column != *column)).collect()
}

/// Says which rows may be no signals.
pub(super) fn doubt(column: &str, values: &Values) -> Option<String> {
    let others = |value: &&String| {
        let value = value.to_lowercase();
        let mut words = value.split(|c: char| !c.is_alphanumeric());
        NO_SIGNALS.iter().any(|part| value.contains(part))
            || words.any(|word| NO_SIGNALS_ALONE.contains(&word))
    };
    let doubtful: Values =
        values.iter().filter(|(v, _)| others(v)).map(|(v, n)| (v.clone(), *n)).collect();
    let rows: usize = doubtful.values().sum();
    let first = doubtful.keys().next()?;
    Some(format!(
        "{rows} rows may be no signals: column {} has {}; leave them out with --signals-where, such as '{}!={}'",
        column,
        named(&doubtful),
        column,
        brief(first)
    ))
}

/// Returns values with how often they occur, the most frequent first.
pub(super) fn named(values: &Values) -> String {
    let mut sorted: Vec<(&String, &usize)> = values.iter().collect();
    sorted.sort_by(|a, b| b.1.cmp(a.1).then(a.0.cmp(b.0)));
    let more = if sorted.len() > NAMED { ", ..." } else { "" };
    let named = sorted.iter().take(NAMED).map(|(value, n)| format!("{} ({n})", brief(value)));
    format!("{}{more}", named.collect::<Vec<_>>().join(", "))
}

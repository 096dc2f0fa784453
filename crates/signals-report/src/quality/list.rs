//! What became of a signal list, on the page on quality.

use std::collections::BTreeMap;

use minijinja::{Value, context};

use super::text::{matched, percent, share};
use signals::city::quality::Quality;

/// Returns what became of the signal list; undefined without one.
pub(super) fn list(q: &Quality) -> Option<Value> {
    let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
    for row in q.listed.iter().filter(|row| row.intersection.is_none()) {
        *reasons.entry(row.reason.unwrap_or("unknown")).or_default() += 1;
    }
    let mut reasons: Vec<_> = reasons.into_iter().collect();
    reasons.sort_by_key(|(_, n)| std::cmp::Reverse(*n));
    let (rows, matched) = (q.listed.len(), matched(q));
    let on_map = q.listed.iter().filter(|r| r.intersection.is_some() && r.on_map).count();
    let line = |(name, n): (String, usize)| {
        context! { name, n, share => percent(share(n, rows)) }
    };
    let mut lines = vec![
        ("matched, and a signal on the map".to_owned(), on_map),
        ("matched, at a junction without a signal on the map".to_owned(), matched - on_map),
    ];
    lines.extend(reasons.into_iter().map(|(reason, n)| (format!("unmatched: {reason}"), n)));
    let lines = lines.into_iter().map(line).collect::<Vec<_>>();
    (rows > 0).then(|| context! { rows, lines })
}

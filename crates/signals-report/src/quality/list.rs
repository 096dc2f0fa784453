//! What became of a signal list, on the page on quality: outcomes, distances, and every row.

use std::collections::BTreeMap;

use minijinja::{Value, context};

use super::figures;
use super::link::map_link;
use super::text::{matched, percent, share};
use evaluation::report::format;
use evaluation::stats::quantile::quantile;
use signals::city::quality::{ListedRow, Quality};

/// Rows of the list that are shown; the others are in the file beside the page.
const ROWS: usize = 1000;

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
    let mut distances = figures::matched_m(q);
    distances.sort_by(f64::total_cmp);
    let quartiles = (!distances.is_empty()).then(|| {
        let at = |share| format::amount(quantile(&distances, share));
        [at(0.25), at(0.5), at(0.75), at(1.0)].to_vec()
    });
    let line = |(name, n): (String, usize)| {
        context! { name, n, share => percent(share(n, rows)) }
    };
    let mut lines = vec![
        ("matched, and a signal on the map".to_owned(), on_map),
        ("matched, at a junction without a signal on the map".to_owned(), matched - on_map),
    ];
    lines.extend(reasons.into_iter().map(|(reason, n)| (format!("unmatched: {reason}"), n)));
    (rows > 0).then(|| {
        context! {
            rows,
            lines => lines.into_iter().map(line).collect::<Vec<_>>(),
            quartiles,
            figure => figures::distances(q),
            shown => doubtful_first(q).into_iter().take(ROWS).map(row).collect::<Vec<_>>(),
            more => rows.saturating_sub(ROWS),
        }
    })
}

/// Returns the rows without an intersection in the order of the list, then the others, farthest
/// first.
fn doubtful_first(q: &Quality) -> Vec<&ListedRow> {
    let mut rows: Vec<&ListedRow> = q.listed.iter().collect();
    let metres = |r: &ListedRow| r.intersection.as_ref().map_or(f64::INFINITY, |_| distance_m(r));
    rows.sort_by(|a, b| metres(b).total_cmp(&metres(a)));
    rows
}

fn distance_m(row: &ListedRow) -> f64 {
    row.distance_m.unwrap_or_default()
}

fn row(row: &ListedRow) -> Value {
    let outcome = match (&row.intersection, row.on_map) {
        (Some(_), true) => "matched".to_owned(),
        (Some(_), false) => "matched; no signal on the map".to_owned(),
        (None, _) => row.why().unwrap_or_else(|| "unknown".to_owned()),
    };
    let note = row.intersection.as_ref().and_then(|_| row.why());
    context! {
        id => row.id.as_str(),
        line => row.line,
        place => format!("{:.5}, {:.5}", row.latitude, row.longitude),
        link => map_link(row.latitude, row.longitude),
        intersection => row.intersection.as_deref().unwrap_or("\u{2013}"),
        distance => row.distance_m.map_or("\u{2013}".to_owned(), format::amount),
        outcome => note.map_or(outcome.clone(), |note| format!("{outcome}; {note}")),
    }
}

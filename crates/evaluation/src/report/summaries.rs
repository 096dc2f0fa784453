//! The second table for terminals, summaries beside the score, and sentences on where they disagree.

use super::format;
use super::table::{Cell, Columns, Table};
use super::whole::Report;
use crate::analysis::{Estimated, MethodSummary};
use crate::stats::Direction;

/// Distance from 1 below which two decimals show no difference from the reference.
const EQUAL: f64 = 0.005;

/// Returns the further summaries of the methods that have an estimate, in the order of the ranking.
pub(super) fn table(data: &Report) -> Table {
    let value = |e: Option<Estimated>| Cell::number(e.map(|e| e.value), format::score);
    let absolute = data.reference.is_none();
    let mut columns = Columns::new().text("", "method", |m: &&MethodSummary| m.method.clone());
    if !absolute {
        columns = columns.shown("ratio", move |m| value(m.summaries.ratio_of_means));
    }
    columns = columns.shown("median", move |m| value(m.summaries.median));
    if !absolute {
        columns = columns.shown("geometric", move |m| value(m.summaries.geometric_mean));
    }
    for (i, regime) in data.regimes.iter().enumerate() {
        let of = move |m: &&MethodSummary| value(m.summaries.by_regime.get(i).copied().flatten());
        columns = columns.shown(regime.short, of);
    }
    for (i, share) in data.shares.iter().enumerate() {
        let of = move |m: &&MethodSummary| Cell::number(m.episodes.shares[i], format::percent);
        columns = columns.shown(share.short, of);
    }
    columns = columns.shown("worst", move |m| {
        let e = &m.episodes;
        Cell::number(if absolute { e.worst } else { e.worst_relative }, format::score)
    });
    columns.table(data.methods.iter().filter(|m| m.overall.is_some()))
}

/// Returns what the columns of the table mean, a line or two.
pub(super) fn legend(data: &Report) -> String {
    let (of, words) = (data.reference.in_short(), &data.words);
    let mut lines = vec![match data.reference.is_none() {
        true => "median of the scores".to_owned(),
        false => format!(
            "ratio of mean {}, median and geometric mean of the scores, all relative to {of}",
            words.nouns
        ),
    }];
    lines.extend(data.sections.legend(data));
    lines.push(match (data.reference.is_none(), data.direction()) {
        (true, _) => format!("worst: worst {} in an evaluation episode", words.noun),
        (false, Direction::Higher) => format!(
            "worst: worst {} in an evaluation episode relative to that on the same {}",
            words.noun, words.met
        ),
        (false, Direction::Lower) => format!(
            "worst: {} {} in an evaluation episode relative to that of the same {}",
            words.sizes[2], words.noun, words.met
        ),
    });
    lines.join(";\n")
}

/// Returns a sentence per method that some summaries call better and others worse than the
/// reference, and one on the order if the ratio of means turns it round.
pub(super) fn disagreements(data: &Report) -> Vec<String> {
    let ranked = || data.methods.iter().filter(|m| m.overall.is_some());
    let mut sentences: Vec<String> = ranked().filter_map(|m| two_sides(data, m)).collect();
    sentences.extend(other_order(data));
    sentences
}

/// Returns the summaries of the whole family, each with its name in a sentence; those of ratios only where there
/// are some.
fn summaries(data: &Report, m: &MethodSummary) -> Vec<(String, Option<Estimated>)> {
    let s = &m.summaries;
    let median = ("median score".to_owned(), s.median);
    match data.reference.is_none() {
        true => vec![median],
        false => vec![
            (format!("ratio of mean {}", data.words.nouns), s.ratio_of_means),
            median,
            ("geometric mean".to_owned(), s.geometric_mean),
        ],
    }
}

/// Says that a method is better by one summary and worse by another.
fn two_sides(data: &Report, m: &MethodSummary) -> Option<String> {
    if data.reference.is_none() {
        return None;
    }
    let mut all = vec![("score".to_owned(), m.overall?, m.interval)];
    let further = summaries(data, m).into_iter();
    all.extend(further.filter_map(|(name, e)| e.map(|e| (name, e.value, e.interval))));
    let side = |below: bool| -> Vec<String> {
        let here = all.iter().filter(|(_, value, _)| match below {
            true => *value < 1.0 - EQUAL,
            false => *value > 1.0 + EQUAL,
        });
        here.map(|(name, value, within)| {
            format!("{name} {}", format::score_within(*value, *within))
        })
        .collect()
    };
    let lower = data.direction().is_lower();
    let (better, worse) = (side(lower), side(!lower));
    if better.is_empty() || worse.is_empty() {
        return None;
    }
    Some(format!(
        "Summaries of {} disagree: better than {} by {}, worse by {}.",
        m.method,
        data.reference.in_short(),
        better.join(", "),
        worse.join(", "),
    ))
}

/// Says the order by the ratio of means where it is another one than that by score.
fn other_order(data: &Report) -> Option<String> {
    let ranked: Vec<(&MethodSummary, f64)> = (data.methods.iter())
        .filter(|m| m.rank.is_some())
        .filter_map(|m| Some((m, m.summaries.ratio_of_means?.value)))
        .collect();
    let direction = data.direction();
    let mut by_ratio = ranked.clone();
    by_ratio.sort_by(|a, b| direction.compare(a.1, b.1));
    // What two decimals do not show is no other order.
    let turned = ranked.iter().enumerate().any(|(i, (a, ratio))| {
        ranked[i + 1..].iter().any(|(b, other)| {
            let scores = a.overall.zip(b.overall);
            let apart = scores.is_some_and(|(a, b)| direction.ahead(a, b) > EQUAL);
            apart && direction.ahead(*other, *ratio) > EQUAL
        })
    });
    if !turned {
        return None;
    }
    let order: Vec<String> =
        by_ratio.iter().map(|(m, r)| format!("{} {}", m.method, format::score(*r))).collect();
    Some(format!(
        "The order by ratio of mean {} differs from the order by score: {}.",
        data.words.nouns,
        order.join(", ")
    ))
}

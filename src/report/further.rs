//! The second table for terminals, summaries beside the score, and sentences on where they disagree.

use super::data::ReportData;
use super::format;
use super::plain_table::plain_table;
use crate::analysis::Estimated;
use crate::analysis::MethodSummary;
use crate::traffic::report::UNFINISHED;

/// Distance from 1 below which two decimals show no difference from the reference.
const EQUAL: f64 = 0.005;

/// Returns the further summaries of the methods that have an estimate, in the order of the ranking.
pub(super) fn table(data: &ReportData) -> String {
    let rows = data.methods.iter().filter(|m| m.overall.is_some()).map(row);
    let header: Vec<&str> = ["method", "ratio", "median", "geometric"]
        .into_iter()
        .chain(data.regimes.iter().map(|regime| regime.short))
        .chain(data.shares.iter().map(|share| share.short))
        .chain(["worst"])
        .collect();
    let right: Vec<usize> = (1..header.len()).collect();
    plain_table(&header, &right, rows.collect())
}

/// Returns what the columns of the table mean, a line or two.
pub(super) fn legend(data: &ReportData) -> String {
    let of = data.reference.in_short();
    let f = data.overloaded.map_or_else(String::new, |o| format!("\n({})", o.in_words()));
    format!(
        "ratio of mean delays, median and geometric mean of the scores, all relative to {of};\n\
         to E and at F: mean score where the baseline is at level of service A to E and at F{f};\n\
         unfinished: share of the vehicles; gridlock: share of the evaluation episodes;\n\
         worst: longest delay in an evaluation episode relative to that of the same vehicles"
    )
}

fn row(m: &MethodSummary) -> Vec<String> {
    let dash = || "-".to_owned();
    let value = |e: Option<Estimated>| e.map_or_else(dash, |e| format::score(e.value));
    let share = |s: Option<f64>| s.map_or_else(dash, format::percent);
    let (s, e) = (&m.summaries, &m.episodes);
    let mut cells = vec![m.method.clone()];
    cells.extend([s.ratio_of_means, s.median, s.geometric_mean].map(value));
    cells.extend(s.by_regime.iter().copied().map(value));
    cells.extend(e.shares.iter().copied().map(share));
    cells.push(e.worst_relative.map_or_else(dash, format::score));
    cells
}

/// Returns a sentence per method that some summaries call better and others worse than the
/// reference, and one on the order if the ratio of mean delays turns it round.
pub(super) fn disagreements(data: &ReportData) -> Vec<String> {
    let ranked = || data.methods.iter().filter(|m| m.overall.is_some());
    let mut sentences: Vec<String> = ranked().filter_map(|m| two_sides(data, m)).collect();
    sentences.extend(other_order(data));
    sentences
}

/// Says that a method is better by one summary and worse by another.
fn two_sides(data: &ReportData, m: &MethodSummary) -> Option<String> {
    let mut all = vec![("score", m.overall?, m.interval)];
    let s = &m.summaries;
    let further = [
        ("ratio of mean delays", s.ratio_of_means),
        ("median score", s.median),
        ("geometric mean", s.geometric_mean),
    ];
    all.extend(further.into_iter().filter_map(|(name, e)| e.map(|e| (name, e.value, e.interval))));
    let side = |better: bool| -> Vec<String> {
        let here = all.iter().filter(|(_, value, _)| match better {
            true => *value < 1.0 - EQUAL,
            false => *value > 1.0 + EQUAL,
        });
        here.map(|(name, value, within)| {
            format!("{name} {}", format::score_within(*value, *within))
        })
        .collect()
    };
    let (better, worse) = (side(true), side(false));
    if better.is_empty() || worse.is_empty() {
        return None;
    }
    let ratio = m.summaries.ratio_of_means.map(|r| r.value);
    let more = match (m.overall, ratio) {
        (Some(score), Some(ratio)) if score < 1.0 && ratio > 1.0 => format!(
            ", that is {} more mean delay: it saves where delay is short and loses where it is long",
            format::percent(ratio - 1.0)
        ),
        (Some(score), Some(ratio)) if score > 1.0 && ratio < 1.0 => format!(
            ", that is {} less mean delay: it loses where delay is short and saves where it is long",
            format::percent(1.0 - ratio)
        ),
        _ => ": few point MDPs decide".to_owned(),
    };
    Some(format!(
        "Summaries of {} disagree: better than {} by {}, worse by {}{more}.",
        m.method,
        data.reference.in_short(),
        better.join(", "),
        worse.join(", "),
    ))
}

/// Says the order by the ratio of mean delays where it is another one than that by score.
fn other_order(data: &ReportData) -> Option<String> {
    let ranked: Vec<(&MethodSummary, f64)> = (data.methods.iter())
        .filter(|m| m.rank.is_some())
        .filter_map(|m| Some((m, m.summaries.ratio_of_means?.value)))
        .collect();
    let mut by_ratio = ranked.clone();
    by_ratio.sort_by(|a, b| a.1.total_cmp(&b.1));
    // What two decimals do not show is no other order.
    let turned = ranked.iter().enumerate().any(|(i, (a, ratio))| {
        ranked[i + 1..].iter().any(|(b, other)| {
            let apart = b.overall.zip(a.overall).is_some_and(|(b, a)| b - a > EQUAL);
            apart && ratio - other > EQUAL
        })
    });
    if !turned {
        return None;
    }
    let order: Vec<String> =
        by_ratio.iter().map(|(m, r)| format!("{} {}", m.method, format::score(*r))).collect();
    Some(format!(
        "The order by ratio of mean delays is another than that by score: {}.",
        order.join(", ")
    ))
}

/// Returns how long an episode lasts and how many vehicles of each method are left at its end; `None`
/// when no record says.
pub(super) fn unfinished(data: &ReportData) -> Option<String> {
    let shares: Vec<String> = (data.methods.iter())
        .filter_map(|m| Some(format!("{} {}", m.method, share(m.episodes.shares[UNFINISHED]?))))
        .collect();
    if shares.is_empty() {
        return None;
    }
    let horizon = match horizon_s(data) {
        Some(seconds) => format!("after {seconds} s"),
        None => "when its scenario ends".to_owned(),
    };
    Some(format!(
        "An episode ends {horizon}. Vehicles that have then not arrived or never entered count with \
         their delay up to that moment, so that delays where there are many depend on the length of \
         an episode, and a longer one would put them further apart. Their share, weighted by \
         importance: {}.",
        shares.join(", ")
    ))
}

fn share(share: f64) -> String {
    format!("{:.1}%", 100.0 * share)
}

/// Returns the length of the episodes on generated networks; `None` for imported scenarios, each of
/// which has its own.
fn horizon_s(data: &ReportData) -> Option<f64> {
    let identity = &data.manifest.identity;
    if identity.scenario == "imported" {
        return None;
    }
    identity.settings.pointer("/demand/horizon_s")?.as_f64()
}

//! The headline of a report: who won, and by how much.

use super::first::change;
use super::format;
use super::sections::About;
use super::whole::Report;
use super::words::Words;
use crate::analysis::MethodSummary;

/// Returns the headline: the best method and its score, and what the domain adds.
pub(super) fn headline(data: &Report) -> String {
    verdict(data) + data.sections.says(About::Headline, data).unwrap_or_default().as_str()
}

/// Returns the best method and its score.
fn verdict(data: &Report) -> String {
    let reference = data.reference.in_full();
    let others = data.methods.iter().filter(|m| !m.is_reference && m.overall.is_some()).count();
    match data.best() {
        None => "No method can be scored yet".to_owned(),
        Some(best) if data.reference.is_none() => {
            let Words { noun, unit, .. } = &data.words;
            let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
            format!("{}: mean {noun} {}{unit}{}", best.method, overall(best), unranked(data))
        }
        Some(_) if others == 0 => format!("Only {reference} has results so far"),
        Some(best) if best.is_reference => {
            let ranked = if data.unranked().next().is_some() { "ranked method" } else { "method" };
            format!("No {ranked} beats {reference}")
        }
        Some(best) => {
            let change = best.overall.map_or_else(|| "-".to_owned(), change);
            let noun = &data.words.noun;
            format!("{}: {change} {noun} than {reference}{}", best.method, unranked(data))
        }
    }
}

/// Says how many methods are not ranked.
fn unranked(data: &Report) -> String {
    match data.unranked().count() {
        0 => String::new(),
        n => format!("; {} not ranked", format::count(n, "method")),
    }
}

/// Returns the score as text.
fn overall(m: &MethodSummary) -> String {
    m.overall.map_or_else(|| "-".to_owned(), |value| format::score_within(value, m.interval))
}

/// Says by how much the best method is ahead of the next; `None` without two methods.
pub(super) fn lead(data: &Report) -> Option<String> {
    let lead = data.lead.as_ref()?;
    Some(format!(
        "The runner-up {} is {} behind in score (95% interval {}, both on the same {}).",
        lead.runner_up,
        format::score_within(lead.difference, Some(lead.interval)),
        format::interval(lead.interval),
        data.words.met,
    ))
}

//! The headline of a report: who won, and by how much.

use super::answers::{AS_MUCH, change};
use super::format;
use super::sections::About;
use super::whole::Report;
use super::words::Words;
use super::{text, today};
use crate::analysis::{Decided, MethodSummary, Pair};

/// Returns the headline: the best method and its score, and what the domain adds.
pub(super) fn headline(data: &Report) -> String {
    verdict(data) + data.sections.says(About::Headline, data).unwrap_or_default().as_str()
}

/// Returns the best method and its score.
fn verdict(data: &Report) -> String {
    if let Some(headline) = today::headline(data) {
        return headline + &unranked(data);
    }
    let reference = data.reference.in_full();
    let others = data.methods.iter().filter(|m| !m.is_reference && m.overall.is_some()).count();
    match data.best() {
        None if data.unranked().next().is_some() => {
            "No method is ranked: all lack point MDPs".to_owned()
        }
        None => "No method can be scored yet".to_owned(),
        Some(best) if data.reference.is_none() => {
            let Words { noun, unit, .. } = &data.words;
            let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
            format!("{}: mean {noun} {}{unit}{}", best.method, overall(best), unranked(data))
        }
        Some(_) if others == 0 => format!("Only {reference} has results so far"),
        Some(best) if best.is_reference && alone(data) => {
            let lacking = format::count(data.unranked().count(), "method");
            format!("Only {reference} is ranked; {lacking} not, for want of point MDPs")
        }
        Some(best) if best.is_reference => {
            let ranked = if data.unranked().next().is_some() { "ranked method" } else { "method" };
            format!("No {ranked} beats {reference}")
        }
        Some(best) => {
            let change = best.overall.map_or_else(|| "-".to_owned(), change);
            let noun = &data.words.noun;
            let than = if change == AS_MUCH { "as" } else { "than" };
            let (perhaps, chance) = match is_open(data, best) {
                true => ("perhaps ", " (open: it may be chance)"),
                false => ("", ""),
            };
            format!(
                "{}: {perhaps}{change} {noun} {than} {reference}{chance}{}",
                best.method,
                unranked(data)
            )
        }
    }
}

/// Whether the best method may be no better than what scores are divided by: the interval of its score contains 1, or
/// that of their difference contains 0.
fn is_open(data: &Report, best: &MethodSummary) -> bool {
    let within = best.interval.is_some_and(|(low, high)| low <= 1.0 && high >= 1.0);
    let place = |of: &dyn Fn(&MethodSummary) -> bool| data.methods.iter().position(of);
    let two = [place(&|m| m.method == best.method), place(&|m| m.is_reference)];
    let of_both = |p: &&Pair| two.contains(&Some(p.first)) && two.contains(&Some(p.second));
    let pair = data.comparison.pairs.iter().find(of_both);
    within || pair.is_some_and(|p| p.decided() == Decided::Open)
}

/// Whether one method only is ranked.
fn alone(data: &Report) -> bool {
    data.methods.iter().filter(|m| m.rank.is_some()).count() == 1
}

/// Says how many methods are not ranked, or dropped out.
fn unranked(data: &Report) -> String {
    match data.unranked().count() {
        0 => String::new(),
        n if text::only_dropped_lack(data) => {
            format!("; {} dropped out", format::count(n, "method"))
        }
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
    let best = data.best().map(|m| &m.method);
    let is_paired = !data.unpaired.iter().any(|name| *name == lead.runner_up || Some(name) == best);
    let (difference, interval) = format::lead(lead.difference, Some(lead.interval));
    Some(format!(
        "The runner-up {} is {} behind in score (95% interval {}, {}).",
        lead.runner_up,
        difference,
        interval.unwrap_or_default(),
        match is_paired {
            true => format!("both on the same {}", data.words.met),
            false => format!("unpaired: nothing shows that both met the same {}", data.words.met),
        },
    ))
}

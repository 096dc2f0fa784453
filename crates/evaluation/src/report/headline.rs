//! The headline of a report and what it is followed by: who won, and by how much.

use super::format;
use super::sections::About;
use super::text;
use super::whole::Report;
use crate::analysis::{Decided, MethodSummary, Pair, PointSummary};
use crate::stats::score::weighted_mean;

/// What [`change`] says of no change.
const AS_MUCH: &str = "as much";

/// Returns the headline: the best method and by how much it differs from what is there today, or from what scores are
/// divided by, and what the domain adds.
pub(super) fn headline(data: &Report) -> String {
    let unranked = match data.unranked().count() {
        0 => String::new(),
        n if text::only_dropped_lack(data) => {
            format!("; {} dropped out", format::count(n, "method"))
        }
        n => format!("; {} not ranked", format::count(n, "method")),
    };
    verdict(data)
        + &unranked
        + data.sections.says(About::Headline, data).unwrap_or_default().as_str()
}

fn verdict(data: &Report) -> String {
    let Some(best) = data.best() else {
        return match data.unranked().next() {
            Some(_) => "No method is ranked: all lack point MDPs".to_owned(),
            None => "No method can be scored yet".to_owned(),
        };
    };
    let noun = &data.words.noun;
    let Some(rival) = rival(data) else {
        let overall =
            best.overall.map_or_else(String::new, |v| format::score_within(v, best.interval));
        return format!("{}: mean {noun} {overall} {}", best.method, data.words.unit)
            .trim_end()
            .to_owned();
    };
    let than = match today(data) {
        Some(today) => format!("{}, which is what is done today", today.method),
        None => data.reference.in_full(),
    };
    if best.index == rival.index {
        let others = data.methods.iter().filter(|m| m.index != best.index && m.overall.is_some());
        return match others.count() {
            0 => format!("Only {than} has results so far"),
            _ => format!("No method beats {than}"),
        };
    }
    let change = relative(data, best, rival).map_or_else(|| "-".to_owned(), change);
    let as_than = if change == AS_MUCH { "as" } else { "than" };
    let (perhaps, chance) = match is_open(data, best, rival) {
        true => ("perhaps ", " (open: it may be chance)"),
        false => ("", ""),
    };
    format!("{}: {perhaps}{change} {noun} {as_than} {than}{chance}", best.method)
}

/// Returns the method that does what is done today, if it is ranked and not what scores are divided by anyway.
pub(super) fn today(data: &Report) -> Option<&MethodSummary> {
    let name = data.sections.today(data)?;
    data.methods.iter().find(|m| m.method == name && m.rank.is_some() && !m.is_reference)
}

/// Returns what the best method is held against: what is done today, or what scores are divided by; `None` without either.
pub(super) fn rival(data: &Report) -> Option<&MethodSummary> {
    today(data).or_else(|| data.methods.iter().find(|m| m.is_reference))
}

/// Returns the mean over point MDPs of what one method has of the objective of another; `None` where there is none.
pub(super) fn relative(data: &Report, own: &MethodSummary, other: &MethodSummary) -> Option<f64> {
    if other.is_reference {
        return own.overall;
    }
    let ratio = |p: &PointSummary| {
        let [own, other] = [own, other].map(|m| Some(p.results[m.index].as_ref()?.objective));
        let other = other.filter(|value| *value > 0.0)?;
        Some((p.weight, own? / other))
    };
    weighted_mean(data.points.iter().filter_map(ratio))
}

/// Returns a score as a change from what it is relative to: `41% less`.
pub(super) fn change(score: f64) -> String {
    let direction = if score < 1.0 { "less" } else { "more" };
    match (1.0 - score).abs() {
        change if change < 0.000_5 => AS_MUCH.to_owned(),
        change => format!("{} {direction}", format::percent(change)),
    }
}

/// Whether the best method may be no better than another one: the interval of their difference contains 0, or that of its
/// score contains the other's of 1.
fn is_open(data: &Report, best: &MethodSummary, rival: &MethodSummary) -> bool {
    let place = |index: usize| data.methods.iter().position(|m| m.index == index);
    let two = [place(best.index), place(rival.index)];
    let of_both = |p: &&Pair| two.contains(&Some(p.first)) && two.contains(&Some(p.second));
    let pair = data.comparison.pairs.iter().find(of_both);
    let within = best.interval.is_some_and(|(low, high)| low <= 1.0 && high >= 1.0);
    (rival.is_reference && within) || pair.is_some_and(|p| p.decided() == Decided::Open)
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

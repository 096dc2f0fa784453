//! The first sentences of a report: who won, by how much, and how sure that is.

use super::figures::with_interval;
use super::format;
use super::sections::About;
use super::whole::Report;
use super::words::Words;
use crate::analysis::MethodSummary;

/// Evaluation seeds below which an interval is too rough for a verdict.
const FEW_SEEDS: usize = 5;

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
            let unranked = match data.unranked().count() {
                0 => String::new(),
                n => format!("; {} not ranked", format::count(n, "method")),
            };
            let interval = best
                .interval
                .map_or_else(String::new, |i| format!(", 95% interval {}", format::interval(i)));
            let Words { noun, unit, .. } = &data.words;
            let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
            format!("{}: mean {noun} {}{unit}{interval}{unranked}", best.method, overall(best))
        }
        Some(_) if others == 0 => format!("Only {reference} has results so far"),
        Some(best) if best.is_reference => {
            let ranked = if data.unranked().next().is_some() { "ranked method" } else { "method" };
            format!("No {ranked} beats {reference}")
        }
        Some(best) => {
            let interval = best
                .interval
                .map_or_else(String::new, |i| format!(", 95% interval {}", format::interval(i)));
            let unranked = match data.unranked().count() {
                0 => String::new(),
                n => format!("; {} not ranked", format::count(n, "method")),
            };
            format!(
                "{}: {} of {}\u{2019}s {}{interval}{unranked}",
                best.method,
                overall(best),
                data.reference.in_short(),
                data.words.noun
            )
        }
    }
}

/// Returns the sentences below the headline.
pub(super) fn sentences(data: &Report) -> Vec<String> {
    let mut sentences = Vec::new();
    let Some(best) = data.best() else {
        if data.reference.is_none() {
            return vec!["There is no finished task yet.".to_owned()];
        }
        return vec![format!(
            "A score needs a finished task of a method and of {} on the same point MDP, and there is \
             no such pair yet.",
            data.reference.in_full()
        )];
    };
    let rival = data.methods.iter().find(|m| !m.is_reference && m.overall.is_some());
    let shown = if best.is_reference { rival } else { Some(best) };
    if let Some(m) = shown.filter(|_| !data.reference.is_none()) {
        sentences.extend(against_reference(data, m));
    }
    if let Some(lead) = data.lead.as_ref().filter(|_| rival.is_some() && !best.is_reference) {
        let few = data.manifest.identity.evaluation_seeds.len() < FEW_SEEDS;
        let sure = if lead.interval.0 > 0.0 && few {
            "more evaluation seeds should confirm it, so few make intervals rough"
        } else if lead.interval.0 > 0.0 {
            "the lead is larger than what chance explains"
        } else {
            "which of the two is better remains open"
        };
        sentences.push(format!(
            "The runner-up {} is {} behind (95% interval {}, both on the same {}): {sure}.",
            lead.runner_up,
            format::score_within(lead.difference, Some(lead.interval)),
            format::interval(lead.interval),
            data.words.met,
        ));
    }
    if let Some(common) = &data.common {
        let order: Vec<String> = (common.methods.iter())
            .map(|m| format!("{} {}", m.method, m.overall.map_or_else(String::new, format::score)))
            .collect();
        sentences.push(format!(
            "Methods that lack point MDPs are not ranked. On the {} that all of them finished the order is: {}.",
            format::count(common.points, "point MDP"),
            order.join(", ")
        ));
    }
    sentences.push(basis(data, best));
    sentences
}

/// Returns the score as text.
fn overall(m: &MethodSummary) -> String {
    m.overall.map_or_else(|| "-".to_owned(), |value| format::score_within(value, m.interval))
}

fn against_reference(data: &Report, m: &MethodSummary) -> Option<String> {
    let value = m.overall?;
    let (name, of) = (&data.reference.name, data.reference.in_short());
    let sure = match m.interval {
        Some((_, high)) if high < 1.0 => format!("the whole interval is below {of}\u{2019}s 1"),
        Some((low, _)) if low > 1.0 => format!("the whole interval is above {of}\u{2019}s 1"),
        Some(_) => format!("the interval contains 1, so it may be no different from {of}"),
        None => "no interval can be given, see the notes".to_owned(),
    };
    let direction = if value < 1.0 { "less" } else { "more" };
    // The headline names the best method and its score already.
    let subject = match m.rank {
        Some(1) => "On average".to_owned(),
        _ => {
            format!("The best of the others, {}, scores {}: on average", m.method, with_interval(m))
        }
    };
    let mut text = format!(
        "{subject} {} {direction} {} than under {name}; {sure}.",
        format::percent((1.0 - value).abs()),
        data.words.noun,
    );
    let reference = data.methods.iter().find(|b| b.is_reference).and_then(|b| b.objective);
    if let (Some(own), Some(of_reference)) = (m.objective, reference) {
        let Words { instance, unit, amount, .. } = &data.words;
        let with_unit = |value: f64| match unit.as_str() {
            "" => data.words.value(value),
            unit => format!("{} {unit}", data.words.value(value)),
        };
        text.push_str(&format!(
            " The average {instance} has {} of {amount}, against {}.",
            with_unit(own),
            with_unit(of_reference)
        ));
    }
    Some(text)
}

/// Says how much of the family the estimates rest on.
fn basis(data: &Report, best: &MethodSummary) -> String {
    let identity = &data.manifest.identity;
    let (chosen, size) = (data.points.len(), identity.sample.family_size);
    let seeds = format::count(identity.evaluation_seeds.len(), "evaluation seed");
    let points = match chosen == size {
        true => format!("all {}", format::count(size, "point MDP")),
        false => format!("{chosen} of {} ({})", format::count(size, "point MDP"), data.sampling()),
    };
    let so_far = match best.points == chosen {
        true => String::new(),
        false => format!("; so far results of {} on {}", best.method, best.points),
    };
    let conditions = data.sections.says(About::Conditions, data).unwrap_or_default();
    format!("Basis: {points} of {}, {seeds} each{so_far}.{conditions}", identity.scenario)
}

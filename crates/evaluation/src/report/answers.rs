//! The first page: what everybody asks of a comparison, answered in plain words.
//!
//! What a domain knows beside the objective it says through [`About`], such as gains in its own units.

use super::headline::{change, relative, rival, today};
use super::sections::About;
use super::sure::certain;
use super::whole::Report;
use super::words::Words;
use super::{decisive_points, format, policies, text};
use crate::analysis::MethodSummary;

/// Evaluation seeds below which an interval is too rough for a verdict.
pub(super) const FEW_SEEDS: usize = 5;

/// Returns the questions that can be answered, each with the sentences of its answer.
pub(super) fn answers(data: &Report) -> Vec<(&'static str, Vec<String>)> {
    let Some(best) = data.best() else {
        let sentence = match data.reference.is_none() {
            _ if data.unranked().next().is_some() => {
                "Methods that lack point MDPs are not ranked, and all do. Their scores below are of what they \
                 have; what they lack may be what is hard."
                    .to_owned()
            }
            true => "No task is finished yet.".to_owned(),
            false => format!(
                "A score needs a finished task of a method and of {} on the same point MDP, and there is \
                 no such pair yet.",
                data.reference.in_full()
            ),
        };
        return vec![("Why?", vec![sentence])];
    };
    let mut answers = vec![
        ("By how much?", gain(data, best)),
        ("How sure?", sure(data, best)),
        ("What does it hold for?", basis(data, best)),
    ];
    answers.retain(|(_, sentences)| !sentences.is_empty());
    answers
}

/// Returns an amount with its unit.
fn with_unit(words: &Words, value: f64) -> String {
    format!("{} {}", words.value(value), words.unit).trim_end().to_owned()
}

/// Says by how much the best method differs from what it is held against, or from the next one.
fn gain(data: &Report, best: &MethodSummary) -> Vec<String> {
    let Words { instance, amount, noun, .. } = &data.words;
    let next = || data.methods.iter().find(|m| m.rank.is_some() && m.index != best.index);
    let Some(rival) = rival(data).filter(|m| m.index != best.index).or_else(next) else {
        return Vec::new();
    };
    let (Some(own), Some(other)) = (best.objective, rival.objective) else { return Vec::new() };
    // Means over different point MDPs are not compared.
    let shared = data
        .objectives_shared(best.index, rival.index)
        .filter(|(.., points)| *points < best.points.max(rival.points));
    let (own, other) = shared.map_or((own, other), |(own, other, _)| (own, other));
    let (less, value) = (own < other, |v: f64| with_unit(&data.words, v));
    let mut text = format!(
        "The average {instance} has {} of {amount} under {}, against {} under {}: {} {}",
        value(own),
        best.method,
        value(other),
        rival.method,
        value((own - other).abs()),
        if less { "less" } else { "more" },
    );
    let score = match data.reference.is_none() || best.is_reference {
        true => None,
        false => relative(data, best, rival),
    };
    text.push_str(&match (score, data.direction().is_worse(own, other)) {
        (Some(score), true) => format!(
            ", but {instance} by {instance} {} on average: it loses where there is much {noun}.",
            change(score)
        ),
        (Some(score), false) if other > 0.0 => format!(
            " ({}). This compares the means; {instance} by {instance} it is {} on average.",
            format::percent(((own - other) / other).abs()),
            change(score)
        ),
        _ => ".".to_owned(),
    });
    let mut sentences = vec![text];
    sentences.extend(shared.map(|(.., points)| {
        let points = format::count(points, "point MDP");
        format!("These means are over the {points} on which both have results.")
    }));
    if !best.is_reference && today(data).is_none_or(|today| today.index != best.index) {
        sentences.extend(data.sections.says(About::Gain, data));
    }
    sentences
}

/// Says how much of this may be chance.
fn sure(data: &Report, best: &MethodSummary) -> Vec<String> {
    let mut sentences = Vec::new();
    let ranked = data.methods.iter().filter(|m| m.rank.is_some()).count();
    // A share of resamples beside an open lead would be two answers to one question.
    let is_open = data.lead.as_ref().is_some_and(|lead| lead.interval.0 <= 0.0);
    if let Some(ranks) = data.comparison.ranks.as_ref().filter(|_| !is_open) {
        sentences.push(format!(
            "The probability that {} is the best of the {ranked} methods is {}.",
            best.method,
            certain(ranks[0][0])
        ));
    }
    let (of, noun) = (&data.reference.name, &data.words.noun);
    sentences.extend(match (best.interval, data.reference.is_none()) {
        _ if best.is_reference => None,
        (None, _) => Some("How much of this is chance is not known: see the warnings.".to_owned()),
        (Some((low, high)), true) => {
            let [low, high] = [low, high].map(|v| with_unit(&data.words, v));
            Some(format!("With 95% certainty its mean {noun} is between {low} and {high}."))
        }
        (Some((low, high)), false) => {
            let (low, high) = (change(low.max(0.0)), change(high.max(0.0)));
            let within = match (low.strip_suffix(" less"), high.strip_suffix(" less")) {
                (Some(_), Some(_)) if low == high => format!("about {high}"),
                (Some(a), Some(b)) => format!("between {b} and {a} less"),
                _ => format!("between {low} and {high}"),
            };
            Some(format!("With 95% certainty it has on average {within} {noun} than {of}."))
        }
    });
    if let Some(lead) = &data.lead {
        let few = data.manifest.identity.evaluation_seeds.len() < FEW_SEEDS;
        let verdict = match (lead.interval.0 > 0.0, few) {
            (true, false) => "is more than chance explains",
            (true, true) => {
                "is more than chance explains, but with so few seeds this is only rough"
            }
            (false, _) => "may be chance: it is open which of the two is better",
        };
        sentences.push(format!("Its lead on the next, {}, {verdict}.", lead.runner_up));
        sentences.extend(decisive_points::sentence(data));
    }
    if let Some(common) = &data.common {
        let score = |m: &MethodSummary| m.overall.map_or_else(String::new, format::score);
        let order: Vec<String> =
            common.methods.iter().map(|m| format!("{} {}", m.method, score(m))).collect();
        let which = match text::only_dropped_lack(data) {
            true => "that dropped out",
            false => "without results on some point MDPs",
        };
        sentences.push(format!(
            "Methods {which} are not ranked. On the {} that all methods finished, the order is: {}.",
            format::count(common.points, "point MDP"),
            order.join(", ")
        ));
    }
    let tuned = text::once(data, false);
    if !best.is_reference && tuned.contains(&best.method.as_str()) {
        let m = &best.method;
        sentences.push(format!("Not included: {m} was tuned only once per point MDP."));
    }
    sentences
}

/// Says what was evaluated, under which conditions, and by which policies.
fn basis(data: &Report, best: &MethodSummary) -> Vec<String> {
    let identity = &data.manifest.identity;
    let (chosen, size) = (data.points.len(), identity.sample.family_size);
    let seeds = format::count(identity.evaluation_seeds.len(), "evaluation seed");
    let stands = match data.family_instances() {
        Some(n) if n > size as f64 => {
            format!(", which stand for {}", format::count(n as usize, &data.words.instance))
        }
        _ => String::new(),
    };
    let points = match chosen == size {
        true => format!("All {}", format::count(size, "point MDP")),
        false => format!("{chosen} of {} ({})", format::count(size, "point MDP"), data.sampling()),
    };
    let so_far = match best.points == chosen {
        true => String::new(),
        false => format!("; so far results of {} on {}", best.method, best.points),
    };
    let conditions = data.sections.says(About::Conditions, data).unwrap_or_default();
    let (scenario, simulator) = (&identity.scenario, &identity.simulator);
    let mut sentences = vec![format!(
        "{points} of {scenario}{stands}, {seeds} each, with {simulator}{so_far}.{conditions}"
    )];
    sentences.extend(policies::sentences(data));
    sentences.extend(text::growth(data));
    sentences
}

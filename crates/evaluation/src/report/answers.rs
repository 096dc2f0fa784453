//! The first page: questions that everybody asks of a comparison, answered in plain words.
//!
//! What a domain knows beside the objective it says through [`About`]: gains in its own units, where a method fails,
//! what a sample misses.

use super::sections::About;
use super::sure::certain;
use super::today::{relative, today};
use super::whole::Report;
use super::words::{Words, limit_in_words};
use super::{decisive_points, format, policies, text};
use crate::analysis::{FamilyShare, MethodSummary, PointSummary};
use crate::sample::Design;
use crate::stats::score::weighted_mean;

/// Evaluation seeds below which an interval is too rough for a verdict.
pub(super) const FEW_SEEDS: usize = 5;

/// A question with its answer, sentence by sentence.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Answer {
    /// The question, short.
    pub(super) question: &'static str,
    /// The sentences.
    pub(super) sentences: Vec<String>,
}

/// Returns the questions that can be answered.
pub(super) fn answers(data: &Report) -> Vec<Answer> {
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
        return vec![Answer { question: "Why?", sentences: vec![sentence] }];
    };
    [
        ("By how much?", gain(data, best)),
        ("How sure?", sure(data, best)),
        ("Which policies?", policies::sentences(data)),
        ("Which is best where?", wins(data)),
        ("Where does it fail?", fails(data, best)),
        (
            "What does it hold for?",
            [Some(basis(data, best)), text::growth(data)].into_iter().flatten().collect(),
        ),
        ("What does the sample not cover?", misses(data)),
    ]
    .into_iter()
    .filter(|(_, sentences)| !sentences.is_empty())
    .map(|(question, sentences)| Answer { question, sentences })
    .collect()
}

/// What [`change`] says of no change.
pub(super) const AS_MUCH: &str = "as much";

/// Returns a score as a change from what it is relative to: `41% less`.
pub(super) fn change(score: f64) -> String {
    let direction = if score < 1.0 { "less" } else { "more" };
    match (1.0 - score).abs() {
        change if change < 0.000_5 => AS_MUCH.to_owned(),
        change => format!("{} {direction}", format::percent(change)),
    }
}

/// Returns an amount with its unit.
fn with_unit(words: &Words, value: f64) -> String {
    match words.unit.as_str() {
        "" => words.value(value),
        unit => format!("{} {unit}", words.value(value)),
    }
}

/// Says by how much the best method, or the best beside the reference, differs from the reference or the next.
fn gain(data: &Report, best: &MethodSummary) -> Vec<String> {
    let Words { instance, amount, noun, .. } = &data.words;
    let others = || data.methods.iter().filter(|m| m.rank.is_some() && m.method != best.method);
    let today = today(data);
    let rival = if today.is_some_and(|today| today.index != best.index) {
        today
    } else if data.reference.is_none() || best.is_reference || today.is_some() {
        others().next()
    } else {
        data.methods.iter().find(|m| m.is_reference)
    };
    let (Some(own), Some((rival, of_rival))) =
        (best.objective, rival.and_then(|m| Some((m, m.objective?))))
    else {
        return Vec::new();
    };
    // Means over different point MDPs are not compared.
    let shared = data
        .objectives_shared(best.index, rival.index)
        .filter(|(.., points)| *points < best.points.max(rival.points));
    let (own, of_rival) = shared.map_or((own, of_rival), |(own, of_rival, _)| (own, of_rival));
    let difference = own - of_rival;
    let mut text = format!(
        "The average {instance} has {} of {amount} under {}, against {} under {}: {} {}",
        with_unit(&data.words, own),
        best.method,
        with_unit(&data.words, of_rival),
        rival.method,
        with_unit(&data.words, difference.abs()),
        if difference < 0.0 { "less" } else { "more" },
    );
    let worse = data.direction().is_worse(own, of_rival);
    let score = match today {
        Some(_) => relative(data, best, rival),
        None => best.overall.filter(|_| !data.reference.is_none() && !best.is_reference),
    };
    text.push_str(&match (score, worse) {
        (Some(score), true) => format!(
            ", but {instance} by {instance} {} on average: it loses where there is much {noun}.",
            change(score)
        ),
        (Some(score), false) if of_rival > 0.0 => format!(
            " ({}). This compares the means; {instance} by {instance} it is {} on average.",
            format::percent((difference / of_rival).abs()),
            change(score)
        ),
        _ => ".".to_owned(),
    });
    let mut sentences = vec![text];
    sentences.extend(shared.map(|(.., points)| {
        let points = format::count(points, "point MDP");
        format!("These means are over the {points} on which both have results.")
    }));
    if !best.is_reference && today.is_none_or(|today| today.index != best.index) {
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
    let of = &data.reference.name;
    let noun = &data.words.noun;
    sentences.extend(match (best.interval, data.reference.is_none(), best.is_reference) {
        (None, ..) => Some("How much of this is chance is not known: see the warnings.".to_owned())
            .filter(|_| !best.is_reference),
        (_, _, true) => None,
        (Some((low, high)), true, _) => {
            let [low, high] = [low, high].map(|v| with_unit(&data.words, v));
            Some(format!("With 95% certainty its mean {noun} is between {low} and {high}."))
        }
        (Some((low, high)), false, _) => {
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
            (true, false) => "is more than chance explains".to_owned(),
            (true, true) => {
                "is more than chance explains, but with so few seeds this is only rough".to_owned()
            }
            (false, _) => "may be chance: it is open which of the two is better".to_owned(),
        };
        sentences.push(format!("Its lead on the next, {}, {verdict}.", lead.runner_up));
        sentences.extend(decisive_points::sentence(data));
    }
    if let Some(common) = &data.common {
        let order: Vec<String> = (common.methods.iter())
            .map(|m| format!("{} {}", m.method, m.overall.map_or_else(String::new, format::score)))
            .collect();
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
    if let (false, Some(m)) = (best.is_reference, tuned.iter().find(|m| **m == best.method)) {
        sentences.push(format!("Not included: {m} was tuned only once per point MDP."));
    }
    sentences
}

/// Says on how much of the family each method is the best, and on how much that is open.
fn wins(data: &Report) -> Vec<String> {
    let identity = &data.manifest.identity;
    let winner = |p: &PointSummary| data.winners[p.index].as_ref();
    let contested = |p: &PointSummary| winner(p).is_some_and(|w| w.runner_up.is_some());
    if !data.points.iter().any(contested) {
        return Vec::new();
    }
    let known = data.winners.iter().flatten().any(|w| w.lead.is_some());
    let instance = &data.words.instance;
    let mut best: Vec<(usize, f64, FamilyShare)> = (0..identity.methods.len())
        .map(|m| {
            let is_won = |p: &PointSummary| {
                contested(p) && winner(p).is_some_and(|w| w.best == m && (!known || w.is_decided))
            };
            let weight = data.points.iter().filter(|p| is_won(p)).map(|p| p.weight).sum();
            (m, weight, data.extent(is_won))
        })
        .filter(|(.., extent)| !extent.is_none())
        .collect();
    best.sort_by(|a, b| b.1.total_cmp(&a.1));
    let named = best.iter().enumerate().map(|(i, (m, _, extent))| {
        let much = match i {
            0 => extent.in_words(instance, format::percent),
            _ => extent.alone(format::percent),
        };
        format!("{} on {much}", identity.methods[*m])
    });
    let named: Vec<String> = named.collect();
    if !known {
        return vec![format!("{}. With one seed each of these may be chance.", named.join(", "))];
    }
    let open = data.extent(|p| contested(p) && winner(p).is_some_and(|w| !w.is_decided));
    let unknown = data.extent(|p| !contested(p));
    let mut sentences = Vec::new();
    if !named.is_empty() {
        sentences.push(format!("Surely the best: {}.", named.join(", ")));
    }
    sentences.push(match open.is_none() {
        true if !unknown.is_none() => "It is decided wherever two methods have results.".to_owned(),
        true => "It is decided on all.".to_owned(),
        false => {
            format!("Undecided: {}.", open.in_words(instance, format::percent))
        }
    });
    if !unknown.is_none() {
        sentences.push(format!(
            "Not known: {}, where fewer than two methods have results.",
            unknown.in_words(instance, format::percent)
        ));
    }
    sentences
}

/// Says where the best method is bad.
fn fails(data: &Report, best: &MethodSummary) -> Vec<String> {
    let Words { instance, noun, sizes, .. } = &data.words;
    let mut sentences = Vec::new();
    let unknown = data.without_result(best.index);
    sentences.extend(unknown.map(|extent| {
        let lacks = extent.in_words(instance, format::percent);
        format!("{} has no result on {lacks}; these are not included here.", best.method)
    }));
    let known = if unknown.is_some() { " where it has results" } else { "" };
    if !data.reference.is_none() && !best.is_reference {
        let worse = data.extent(|p| {
            let score = p.results[best.index].as_ref().and_then(|r| r.score);
            score.is_some_and(|score| data.direction().is_worse(score, 1.0))
        });
        sentences.push(match worse.is_none() {
            true => {
                format!("{} is nowhere worse than {}{known}.", best.method, data.reference.name)
            }
            false => format!(
                "{} is worse than {} on {}.",
                best.method,
                data.reference.name,
                worse.in_words(instance, format::percent)
            ),
        });
    }
    sentences.extend(data.sections.says(About::Fails, data));
    let fails = |p: &PointSummary| data.fails(p, best.index);
    if let Some(limit) =
        data.failure.as_ref().filter(|_| data.points.iter().any(|p| fails(p).is_some()))
    {
        let extent = data.extent(|p| fails(p) == Some(true));
        let what = format!(
            "{} on average counts as a failure",
            format::capitalised(&limit_in_words(limit))
        );
        sentences.push(match extent.is_none() {
            true => format!("{what}: {} fails nowhere{known}.", best.method),
            false => format!(
                "{what}: {} fails on {}.",
                best.method,
                extent.in_words(instance, format::percent)
            ),
        });
    }
    let worst = data
        .results_of(best.index)
        .max_by(|a, b| data.direction().compare(a.1.objective, b.1.objective));
    if let Some((point, result)) = worst {
        let most = if data.direction().is_lower() { sizes[2].as_str() } else { "worst" };
        sentences.push(format!(
            "The {most} {noun}: {} on {}.",
            with_unit(&data.words, result.objective),
            data.title_of(&point.row.point)
        ));
    }
    sentences
}

/// Says what was evaluated, and under which conditions.
fn basis(data: &Report, best: &MethodSummary) -> String {
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
    format!("{points} of {scenario}{stands}, {seeds} each, with {simulator}{so_far}.{conditions}")
}

/// Says what a sample has too much or too little of.
fn misses(data: &Report) -> Vec<String> {
    if data.is_whole() {
        return Vec::new();
    }
    let mut sentences: Vec<String> = data.sections.says(About::Misses, data).into_iter().collect();
    sentences.push(match &data.design {
        Some(design) => unlike(data, design).unwrap_or_else(|| {
            "The features of the point MDPs have no names, so the sample cannot be compared with the family."
                .to_owned()
        }),
        None => "The run has no list of the whole family, so it is not known what else the sample does not cover."
            .to_owned(),
    });
    sentences
}

/// Says in which feature the weighted sample differs most from the family, in standard deviations of the family;
/// `None` where what describes point MDPs is not their features.
fn unlike(data: &Report, design: &Design) -> Option<String> {
    let columns = &data.manifest.identity.features;
    if design.points.iter().any(|p| p.describing.len() != columns.len()) {
        return None;
    }
    let most = (0..columns.len()).filter_map(|f| {
        let family = || design.points.iter().map(|p| (p.importance, p.describing[f]));
        let mean = weighted_mean(family())?;
        let variance = weighted_mean(family().map(|(w, x)| (w, (x - mean).powi(2))))?;
        let sample = data.points.iter().map(|p| {
            let row = design.position(&p.row.point).map(|row| &design.points[row]);
            (p.weight, row.map_or(mean, |row| row.describing[f]))
        });
        let sample = weighted_mean(sample)?;
        (variance > 0.0).then(|| (f, sample, mean, (sample - mean).abs() / variance.sqrt()))
    });
    let (f, sample, mean, off) = most.max_by(|a, b| a.3.total_cmp(&b.3))?;
    Some(format!(
        "The feature that differs most from the family is \u{201c}{}\u{201d}: on average {} in the sample, {} in the \
         family ({} of its standard deviation).",
        format::feature_label(&columns[f]),
        format::feature(sample),
        format::feature(mean),
        format::percent(off)
    ))
}

//! The first page: who won and by how much, how sure that is, what it holds for, and by which policies learners are ranked.
//!
//! What a domain knows beside the objective it says through [`About`], such as gains in its own units.

use super::figures::sentence;
use super::sections::About;
use super::whole::Report;
use super::words::Words;
use super::{format, text};
use crate::analysis::{Decided, LearnerSummary, MethodSummary, Pair, PointSummary};
use crate::stats::score::weighted_mean;

/// What [`change`] says of no change.
const AS_MUCH: &str = "as much";

/// Evaluation seeds below which an interval is too rough for a verdict.
pub(super) const FEW_SEEDS: usize = 5;

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

fn today(data: &Report) -> Option<&MethodSummary> {
    let name = data.sections.today(data)?;
    data.methods.iter().find(|m| m.method == name && m.rank.is_some() && !m.is_reference)
}

/// Returns what the best method is held against: what is done today, or what scores are divided by; `None` without either.
fn rival(data: &Report) -> Option<&MethodSummary> {
    today(data).or_else(|| data.methods.iter().find(|m| m.is_reference))
}

/// Returns the mean over point MDPs of what one method has of the objective of another; `None` where there is none.
fn relative(data: &Report, own: &MethodSummary, other: &MethodSummary) -> Option<f64> {
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

fn change(score: f64) -> String {
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

fn best_two(data: &Report) -> Option<(&Pair, (f64, f64))> {
    let pair = data.comparison.pairs.iter().find(|pair| (pair.first, pair.second) == (0, 1))?;
    let same = [0, 1].iter().all(|m| data.methods[*m].points == pair.points);
    pair.ahead.interval.filter(|_| same).map(|interval| (pair, interval))
}

/// Says by how much the best method is ahead of the next; `None` without two methods.
pub(super) fn lead(data: &Report) -> Option<String> {
    let (pair, interval) = best_two(data)?;
    let two = [0, 1].map(|m| &data.methods[m].method);
    let met = &data.words.met;
    let (difference, interval) = format::lead(pair.ahead.value, Some(interval));
    Some(format!(
        "The runner-up {} is {difference} behind in score (95% interval {}, both on the same {met}).",
        two[1],
        interval.unwrap_or_default(),
    ))
}

/// Says that the first place is not robust, and on which point MDPs it rests; `None` where it is robust.
pub(super) fn fragile(data: &Report) -> Option<String> {
    let (pair, _) = best_two(data)?;
    let [first, second] = [0, 1].map(|m| &data.methods[m].method);
    let called = pair.fragile.iter().map(|p| data.called(&data.points[*p].row.point));
    (!pair.fragile.is_empty()).then(|| {
        format!(
            "{first} is first by the mean; not robust: it was trained once, and without its {} most influential point MDPs \
             ({}) {second} would be ahead.",
            pair.fragile.len(),
            sentence(called)
        )
    })
}

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

fn with_unit(words: &Words, value: f64) -> String {
    format!("{} {}", words.value(value), words.unit).trim_end().to_owned()
}

/// Says by how much the best method differs from what it is held against, or from the next one: by the measure of the
/// headline, and by means beside it.
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
    let by_score = match data.reference.is_none() || best.is_reference {
        true => None,
        false => relative(data, best, rival),
    };
    let mut sentences: Vec<String> = by_score
        .map(|score| {
            let (change, than) = (change(score), &rival.method);
            let than =
                if change == AS_MUCH { format!("as {than}") } else { format!("than {than}") };
            format!(
                "{} by {instance}, {} has on average {change} {noun} {than}.",
                format::capitalised(instance),
                best.method
            )
        })
        .into_iter()
        .collect();
    let value = |v: f64| with_unit(&data.words, v);
    let over = shared.map_or_else(String::new, |(.., points)| {
        format!(" over the {} on which both have results", format::count(points, "point MDP"))
    });
    let less = if own < other { "less" } else { "more" };
    let difference = match other > 0.0 {
        true => format!(
            "{} ({})",
            value((own - other).abs()),
            format::percent(((own - other) / other).abs())
        ),
        false => value((own - other).abs()),
    };
    let but = match data.direction().is_worse(own, other) && by_score.is_some() {
        true => format!(", because it loses where there is much {noun}"),
        false => String::new(),
    };
    sentences.push(format!(
        "The mean {amount}{over} is {} under {} and {} under {}: {difference} {less}{but}.",
        value(own),
        best.method,
        value(other),
        rival.method,
    ));
    if !best.is_reference && today(data).is_none_or(|today| today.index != best.index) {
        sentences.extend(data.sections.says(About::Gain, data));
    }
    sentences
}

/// Says how much of this may be chance.
fn sure(data: &Report, best: &MethodSummary) -> Vec<String> {
    let mut sentences = Vec::new();
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
    if let Some((pair, _)) = best_two(data).filter(|(pair, _)| pair.fragile.is_empty()) {
        let few = data.manifest.identity.evaluation_seeds.len() < FEW_SEEDS;
        let verdict = match (pair.decided(), few) {
            (Decided::First, false) => "is more than chance explains",
            (Decided::First, true) => {
                "is more than chance explains, but with so few seeds this is only rough"
            }
            _ => "may be chance: it is open which of the two is better",
        };
        sentences.push(format!("Its lead on the next, {}, {verdict}.", data.methods[1].method));
    }
    sentences.extend(fragile(data));
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
    sentences.extend(policies(data));
    sentences.extend(text::growth(data));
    sentences
}

/// Says by which policies the learners are ranked, what their last policies would have scored, and which trainings
/// started again or ended with a dead network.
pub(super) fn policies(data: &Report) -> Vec<String> {
    let learners = data.learners();
    let mut sentences: Vec<String> = learners.iter().filter_map(|l| chosen(l)).collect();
    let by_last: Vec<&str> = (learners.iter())
        .filter(|l| l.scored > 0 && l.validated == 0)
        .map(|l| l.method.method.as_str())
        .collect();
    if !by_last.is_empty() {
        let is = if by_last.len() == 1 { "is" } else { "are" };
        sentences.push(format!(
            "{} {is} ranked by the last policy of each training; validation did not choose among policies.",
            by_last.join(", ")
        ));
    }
    for l in &learners {
        let of = format::count(l.scored, "training");
        let name = &l.method.method;
        let fates = [
            (l.restarted, "started again from another seed, because the network was dead"),
            (l.dead, "ended with a dead network, which acts the same whatever it sees"),
        ];
        let of_some = fates.into_iter().filter(|(n, _)| *n > 0);
        sentences.extend(of_some.map(|(n, what)| format!("{n} of {of} of {name} {what}.")));
    }
    sentences
}

/// Says what validation changed for a learner; `None` where it chose nothing.
fn chosen(l: &LearnerSummary<'_>) -> Option<String> {
    let (overall, last) = l.method.overall.zip(l.last_policy)?;
    let (name, of) = (&l.method.method, format::count(l.validated, "training"));
    Some(match l.replaced {
        0 => format!(
            "{name} is ranked by the last policy of each training: in none of {of} did validation find a better one."
        ),
        n => format!(
            "{name} is ranked by the policies that validation chose ({}). The last policies score {}; validation \
             replaced them in {n} of {of}.",
            format::score(overall),
            format::score(last)
        ),
    })
}

//! What a report says in sentences on the first page; [`findings`](super::findings) are apart.
//!
//! What a domain knows beside the objective it says through [`About`], such as gains in its own units.

use super::findings::{best_two, fragile, growth, policies};
use super::format;
use super::sections::About;
use super::tables::{ranking, summaries};
use super::whole::Report;
use super::words::{Words, baseline_in_full};
use crate::analysis::{Decided, FEWEST_SEEDS_FOR_PLACES, MethodSummary, Pair, PointSummary};
use crate::stats::Direction;
use crate::stats::score::weighted_mean;

/// Most pairs that are all shown at once; of more the neighbours in the ranking are.
pub(super) const MOST_PAIRS: usize = 10;

/// Least probability of the first place that is worth a word.
const LIKELY: f64 = 0.01;

/// By how much rounding may keep a sum of shares from 1.
const ROUNDING: f64 = 1e-12;

/// Returns the ranking of the methods, best first, below it further summaries, and, where some are not
/// ranked, all of them on the point MDPs that they have in common; [`notes`](super::findings::notes) belong below it.
///
/// No line is longer than 100 characters as long as names of methods have at most 24.
pub fn table(data: &Report) -> String {
    let mut text = String::new();
    if !data.reference.is_baseline {
        let not = match data.manifest.identity.baseline.as_str() {
            "" => String::new(),
            baseline => format!(", not against {}", baseline_in_full(baseline)),
        };
        text.push_str(&format!("Scores against {}{not}:\n\n", data.reference.name));
    }
    text.push_str(&data.ranking().plain());
    if data.methods.iter().any(|m| m.overall.is_some() && !m.is_reference) {
        text.push_str(&format!("\n\n{}\n\n{}", legend(data), summaries(data).plain()));
    }
    if let Some((points, methods)) = &data.common {
        text.push_str(&format!("\n\n{}\n\n", common_title(*points, methods.len())));
        text.push_str(&ranking(data, methods, *points).plain());
    }
    text
}

/// Returns the title of the table of what methods have in common.
pub(super) fn common_title(points: usize, methods: usize) -> String {
    let n = format::count(points, "point MDP");
    format!("On the {n} that all {methods} methods with results finished:")
}

/// Whether there are methods without a rank, and all of them have dropped out of a growing run.
fn only_dropped_lack(data: &Report) -> bool {
    let is_dropped = |m: &MethodSummary| data.results.dropped.iter().any(|d| d.method == m.method);
    data.unranked().next().is_some() && data.unranked().all(is_dropped)
}

/// What [`change`] says of no change.
const AS_MUCH: &str = "as much";

/// Evaluation seeds below which an interval is too rough for a verdict.
pub(super) const FEW_SEEDS: usize = 5;

/// Returns the headline: the best method and by how much it differs from what is there today, or from what scores are
/// divided by, and what the domain adds.
pub(super) fn headline(data: &Report) -> String {
    let unranked = match data.unranked().count() {
        0 => String::new(),
        n if only_dropped_lack(data) => {
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
    let within = best.interval.is_some_and(|(low, high)| low <= 1.0 && high >= 1.0);
    let is_pair_open = |p: &Pair| p.decided() == Decided::Open;
    (rival.is_reference && within) || pair_of(data, best, rival).is_some_and(is_pair_open)
}

fn pair_of<'a>(data: &'a Report, a: &MethodSummary, b: &MethodSummary) -> Option<&'a Pair> {
    let place = |index: usize| data.methods.iter().position(|m| m.index == index);
    let two = [place(a.index), place(b.index)];
    let of_both = |p: &&Pair| two.contains(&Some(p.first)) && two.contains(&Some(p.second));
    data.comparison.pairs.iter().find(of_both)
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
    let shared = shared_objectives(data, best.index, rival.index)
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

/// Returns the mean objectives of two methods over the point MDPs that both finished, and how many these are.
fn shared_objectives(data: &Report, a: usize, b: usize) -> Option<(f64, f64, usize)> {
    let objective = |p: &PointSummary, m: usize| Some(p.results[m].as_ref()?.objective);
    let both =
        data.points.iter().filter_map(|p| Some((p.weight, objective(p, a)?, objective(p, b)?)));
    let both: Vec<(f64, f64, f64)> = both.collect();
    let of_a = weighted_mean(both.iter().map(|(w, a, _)| (*w, *a)))?;
    let of_b = weighted_mean(both.iter().map(|(w, _, b)| (*w, *b)))?;
    Some((of_a, of_b, both.len()))
}

/// Says how much of this may be chance.
fn sure(data: &Report, best: &MethodSummary) -> Vec<String> {
    let mut sentences = Vec::new();
    let (of, noun) = (&data.reference.name, &data.words.noun);
    // The same two as in the headline.
    let ahead = today(data).filter(|m| m.index != best.index).and_then(|m| {
        let ahead = pair_of(data, best, m)?.ahead;
        let interval = format::lead(ahead.value, ahead.interval).1?;
        Some(format!(
            "With 95% certainty its score is {interval} better than that of {}.",
            m.method
        ))
    });
    sentences.extend(match (best.interval, data.reference.is_none()) {
        _ if best.is_reference => None,
        _ if ahead.is_some() => ahead,
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
    sentences.extend(growth(data));
    sentences
}

/// Returns what the columns of the table mean, a line or two.
fn legend(data: &Report) -> String {
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

/// Says who is first and how sure that is, and which pairs are open.
pub(super) fn answer(data: &Report) -> String {
    let pairs = &data.comparison.pairs;
    let mut text = String::new();
    if let Some(ranks) = &data.comparison.ranks {
        let mut first: Vec<(&str, f64)> =
            data.methods.iter().zip(ranks).map(|(m, r)| (m.method.as_str(), r[0])).collect();
        first.sort_by(|a, b| b.1.total_cmp(&a.1));
        let likely: Vec<String> = (first.iter())
            .filter(|(_, p)| *p >= LIKELY)
            .map(|(m, p)| format!("{m} {}", certain(*p)))
            .collect();
        text.push_str(&match first.first() {
            Some((m, p)) if *p >= 1.0 - ROUNDING => format!("{m} is first in every resample. "),
            _ => format!("Probability of the first place: {}. ", likely.join(", ")),
        });
    }
    let open: Vec<String> = (pairs.iter())
        .filter(|p| p.decided() == Decided::Open)
        .map(|p| format!("{} and {}", data.methods[p.first].method, data.methods[p.second].method))
        .collect();
    let known = pairs.iter().filter(|p| p.decided() != Decided::Unknown).count();
    text.push_str(&match (known, open.len()) {
        (0, _) => {
            "There are no intervals, so any difference between methods may be chance.".to_owned()
        }
        (1, 0) => "It is decided which of the two is better.".to_owned(),
        (n, 0) => format!("All {n} pairs are decided."),
        (n, open_pairs) => {
            let named = if open.len() <= MOST_PAIRS {
                open.join("; ")
            } else {
                format!("{}; and others", open[..MOST_PAIRS].join("; "))
            };
            format!(
                "Of {} {open_pairs} {} open: {named}.",
                format::count(n, "pair"),
                if open_pairs == 1 { "is" } else { "are" }
            )
        }
    });
    text
}

/// Returns a probability in per cent that does not claim all of less.
pub(super) fn certain(p: f64) -> String {
    if p > 0.995 { ">99%".to_owned() } else { format::percent(p) }
}

/// Says what the probabilities cover.
pub(super) fn covers(data: &Report) -> String {
    let identity = &data.manifest.identity;
    let seeds = identity.evaluation_seeds.len();
    let ranked = data.methods.iter().filter(|m| m.rank.is_some());
    let evaluated = ranked.map(|m| m.points).min().unwrap_or(data.points.len());
    let whole = data.estimator().is_whole(identity.sample.family_size, evaluated);
    let repeated: Vec<&str> = (data.methods.iter())
        .map(|m| m.method.as_str())
        .filter(|m| data.trained.contains(*m) && identity.replicates_of(m) > 1)
        .collect();
    let mut causes = Vec::new();
    if !whole {
        causes.push(format!(
            "which {evaluated} of {} point MDPs were evaluated",
            identity.sample.family_size
        ));
    }
    if seeds > 1 {
        causes.push(format!("the choice of {seeds} evaluation seeds"));
    }
    if !repeated.is_empty() {
        causes.push(format!("the luck of the trainings of {}", repeated.join(", ")));
    }
    match causes.is_empty() {
        true => "One seed on every point MDP of a family does not show chance.".to_owned(),
        false if seeds < FEWEST_SEEDS_FOR_PLACES => format!(
            "Probabilities and intervals cover only {}. Probabilities of places need at least {FEWEST_SEEDS_FOR_PLACES} evaluation \
             seeds.",
            causes.join(" and ")
        ),
        false => format!("Probabilities and intervals cover only {}.", causes.join(" and ")),
    }
}

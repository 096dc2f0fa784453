//! What a report says in sentences: the first page, and what a reader of the ranking must know, for page and terminal.
//!
//! What a domain knows beside the objective it says through [`About`], such as gains in its own units.

use super::figures::sentence;
use super::format;
use super::sections::About;
use super::tables::{ranking, summaries};
use super::whole::Report;
use super::words::{Words, baseline_in_full};
use crate::analysis::{
    Decided, Estimated, FEWEST_SEEDS_FOR_PLACES, LearnerSummary, MethodSummary, Mix, Pair,
    PointSummary,
};
use crate::stats::Direction;
use crate::stats::score::weighted_mean;
use crate::store::assisting;
use crate::store::dropped::Dropped;

/// Most pairs that are all shown at once; of more the neighbours in the ranking are.
pub(super) const MOST_PAIRS: usize = 10;

/// Least probability of the first place that is worth a word.
const LIKELY: f64 = 0.01;

/// By how much rounding may keep a sum of shares from 1.
const ROUNDING: f64 = 1e-12;

/// Returns the ranking of the methods, best first, below it further summaries, and, where some are not
/// ranked, all of them on the point MDPs that they have in common; [`notes`] belong below it.
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

/// Returns what a reader of the ranking must know: what is missing, what is not in the interval, and
/// where summaries disagree.
pub fn notes(data: &Report) -> Vec<String> {
    let mut notes = warnings(data);
    let evaluated = evaluated(data).len();
    if evaluated > 0 {
        let count = format::count(evaluated, "warning");
        notes.push(format!("{count} on what was evaluated: the page has them beside the ranking."));
    }
    // A comparison says first which builds there are.
    notes.extend(data.results.warning_of_builds().filter(|_| data.runs.is_none()));
    notes.extend(disagreements(data));
    notes.extend(fragile(data));
    notes.extend(policies(data));
    notes.extend(data.mix().map(|mix| mixed(data, mix)));
    notes
}

/// Returns what a reader should know of what was evaluated: what was known when the run began, and what happened.
pub(super) fn evaluated(data: &Report) -> Vec<String> {
    let known = data.manifest.provenance.warnings.iter().cloned();
    known.chain(data.sections.happened(data)).collect()
}

/// Returns the notes without where summaries disagree.
pub(super) fn warnings(data: &Report) -> Vec<String> {
    let mut notes = Vec::new();
    let planned = data.tasks.len();
    let missing = data.missing();
    if missing > 0 {
        let (have, them) = if missing == 1 { ("has", "it") } else { ("have", "them") };
        notes.push(format!(
            "Incomplete: {} of {planned} tasks are done, {missing} {have} no record yet; run again to compute \
             {them}.",
            planned - missing
        ));
    }
    let failed = data.failed().count();
    if failed > 0 {
        notes.push(format!("{failed} of {planned} tasks failed; the reasons are in the report's section \"Failed and \
             missing\"."));
    }
    let identity = &data.manifest.identity;
    let still: Vec<String> = (data.tasks.iter())
        .filter(|r| Some(r.method) == data.reference.index && !data.reference.is_none())
        .filter(|r| r.metrics.get(&identity.objective) == Some(&0.0))
        .map(|r| data.called(&data.points[r.point].row.point))
        .collect();
    if !still.is_empty() {
        notes.push(format!(
            "No score on {}: {} has no {} there{}.",
            still.join(", "),
            data.reference.in_short(),
            data.words.noun,
            data.words.nothing
        ));
    }
    let chosen = data.points.len();
    let unranked: Vec<String> =
        data.unranked().map(|m| format!("{} ({} of {chosen})", m.method, m.points)).collect();
    if !unranked.is_empty() {
        let where_to_compare = match &data.common {
            Some(_) => "a second table compares all methods where all have results",
            None => "no point MDP has results of all methods yet, so they cannot be compared",
        };
        notes.push(format!(
            "Not ranked, because they have no results on some point MDPs: {}. Their scores are over other point MDPs \
             than those above them; {where_to_compare}.",
            unranked.join(", ")
        ));
    } else if data.reference.is_none() && data.methods.iter().any(|m| m.points != chosen) {
        notes.push("Scores are over the point MDPs that the method finished.".to_owned());
    } else if data.methods.iter().any(|m| m.points != chosen) {
        notes.push(format!(
            "Scores are over the point MDPs that both the method and {} finished.",
            data.reference.in_short()
        ));
    }
    let partly: Vec<String> = (data.methods.iter())
        .filter(|m| m.left_out > 0)
        .map(|m| format!("{} ({} of {})", m.method, m.left_out, m.replicates))
        .collect();
    if !partly.is_empty() {
        notes.push(format!(
            "Some replicates of {} failed or are missing; the score on such a point MDP is the mean over the \
             others, which flatters a method that fails where it is bad.",
            partly.join(", ")
        ));
    }
    let others = || data.methods.iter().filter(|m| !m.is_reference && m.overall.is_some());
    if others().any(|m| m.interval.is_none()) {
        notes.push(
            "Without interval: this needs at least two evaluation seeds, and two point MDPs where others of \
             the family have no result."
                .to_owned(),
        );
    }
    notes.extend(assisted_otherwise(data));
    notes.extend(luck(data));
    notes
}

/// Says where what assists the sample was computed with other settings; `None` where it was not, or that is not known.
fn assisted_otherwise(data: &Report) -> Option<String> {
    let there = data.manifest.provenance.assisting.as_ref()?;
    let named = assisting::differences(there, &data.manifest.identity.settings)?;
    Some(format!(
        "The results that assist the sample were computed with other settings ({named}). They help less than results \
         with the same settings would."
    ))
}

/// Says how a sample has grown, and whether it says enough; `None` where it does not grow.
pub fn growth(data: &Report) -> Option<String> {
    if data.runs.is_some() {
        return None;
    }
    if let Some(before) = data.manifest.smaller_budgets().first() {
        return Some(format!(
            "The sample grew from {before} to {} after results were seen. Each look at them had 95% intervals, so the chance \
             that one of these looks misleads is above 5%. `run --until-decided`, given from the start, keeps it at 5% \
             over all looks.",
            format::count(data.points.len(), "point MDP")
        ));
    }
    // What was asked for is of scores relative to the baseline.
    let standing = data.standing().filter(|_| data.reference.is_baseline)?;
    let growth = data.manifest.identity.sample.growth.as_ref()?;
    let (until, looks) = (&growth.until, standing.looks);
    let outcome = match (standing.is_enough, standing.look < looks) {
        (true, _) => standing.answer.as_ref().map_or_else(String::new, |answer| {
            let rest = if standing.look < looks {
                ", and the rest of the budget was not needed"
            } else {
                ""
            };
            format!("this is reached{rest}: {}", found(answer, until.question().1))
        }),
        (false, true) => {
            "this is not reached yet; the command of the run continues with more point MDPs"
                .to_owned()
        }
        (false, false) if standing.open.is_empty() => {
            "this is not reached, and the budget is spent".to_owned()
        }
        (false, false) => {
            let open: Vec<String> =
                standing.open.iter().map(|(a, b)| format!("{a} and {b}")).collect();
            format!("this is not reached for {}, and the budget is spent", open.join(", "))
        }
    };
    Some(format!(
        "The sample grows until {until}. After look {} of {looks}, with {}, {outcome}. Intervals are wider than from \
         a single look: each holds with 95% certainty over all looks together.{}",
        standing.look,
        format::count(data.points.len(), "point MDP"),
        dropped(data)
    ))
}

/// Says which method is the best or near it, and which ones may be as good or better.
pub fn found((method, others): &(String, Vec<String>), within: f64) -> String {
    match &others[..] {
        [] => format!("{method} is the best"),
        others => {
            let others = others.join(", ");
            format!("{method} is within {within} of the best; {others} may be equal to it")
        }
    }
}

/// Says which methods a growing run no longer evaluates.
fn dropped(data: &Report) -> String {
    let of = |d: &Dropped| format!("{} (after look {}, behind {})", d.method, d.look, d.behind);
    let all: Vec<String> = data.results.dropped.iter().map(of).collect();
    match all.is_empty() {
        true => String::new(),
        false => format!(" Dropped out, because another method was ahead: {}.", all.join(", ")),
    }
}

/// Whether there are methods without a rank, and all of them have dropped out of a growing run.
fn only_dropped_lack(data: &Report) -> bool {
    let is_dropped = |m: &MethodSummary| data.results.dropped.iter().any(|d| d.method == m.method);
    data.unranked().next().is_some() && data.unranked().all(is_dropped)
}

/// Returns the methods that tune or learn, once per point MDP, and have an interval.
pub(super) fn trained_once(data: &Report) -> Vec<&str> {
    let identity = &data.manifest.identity;
    (data.methods.iter())
        .filter(|m| !m.is_reference && m.interval.is_some())
        .map(|m| m.method.as_str())
        .filter(|m| data.trained.contains(*m) && identity.replicates_of(m) == 1)
        .collect()
}

/// Returns those of [`trained_once`] that tune, or with `learned` those that learn.
pub(super) fn once(data: &Report, learned: bool) -> Vec<&str> {
    let mut once = trained_once(data);
    once.retain(|m| data.learned.contains(*m) == learned);
    once
}

/// Says how intervals have the luck of tuning and training.
fn luck(data: &Report) -> Vec<String> {
    let mut sentences = Vec::new();
    let tuned = once(data, false);
    let how = match data.points.len() < data.manifest.identity.sample.family_size {
        true => "contain the luck of tuning only as far as it differs between point MDPs",
        false => "exclude the luck of tuning",
    };
    if !tuned.is_empty() {
        sentences.push(format!(
            "The intervals of {} {how}: each was tuned once per point MDP; --replicates R includes it.",
            tuned.join(", ")
        ));
    }
    let learned = once(data, true);
    if !learned.is_empty() {
        sentences.push(format!(
            "The intervals of {} rest on one training per point MDP, so all that neighbouring point MDPs differ by \
             counts as the luck of training. They are too wide where trainings go well alike, and too narrow where \
             some fail by chance; --replicates R measures it.",
            learned.join(", ")
        ));
    }
    let reference = &data.reference.name;
    sentences.extend(data.trained.contains(reference).then(|| {
        format!("No interval covers the chance in {reference}, by which all scores are divided.")
    }));
    sentences
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
fn fragile(data: &Report) -> Option<String> {
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
    sentences.extend(growth(data));
    sentences
}

/// Says by which policies the learners are ranked, what their last policies would have scored, and which trainings
/// started again or ended with a dead network.
fn policies(data: &Report) -> Vec<String> {
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

/// Distance from 1 below which two decimals show no difference from the reference.
const EQUAL: f64 = 0.005;

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
fn further(data: &Report, m: &MethodSummary) -> Vec<(String, Option<Estimated>)> {
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
    let others = further(data, m).into_iter();
    all.extend(others.filter_map(|(name, e)| e.map(|e| (name, e.value, e.interval))));
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

/// Says what the mix is, and how it compares with the best method alone.
pub(super) fn mixed(data: &Report, mix: &Mix) -> String {
    let best = &data.methods[mix.methods[0]];
    let (ahead, interval) = format::lead(mix.ahead.value.abs(), mix.ahead.interval);
    let side = if mix.ahead.value >= 0.0 { "better" } else { "worse" };
    let compared = match mix.shares[0] > 1.0 - 1e-9 {
        true => format!("which is {} alone, as it is always chosen", best.method),
        false => format!(
            "{ahead} {side} than {} alone{}",
            best.method,
            interval.map_or_else(String::new, |i| format!(" (95% interval of the lead {i})")),
        ),
    };
    format!(
        "On each point MDP, {} of {} evaluation seeds choose the best of {} methods, and the others score it: {}, {compared}.",
        mix.seeds.0,
        mix.seeds.1,
        mix.methods.len(),
        format::score_within(mix.score.value, mix.score.interval),
    )
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

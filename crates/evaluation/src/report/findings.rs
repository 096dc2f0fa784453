//! What a reader of the ranking must know: one list for terminal, page and JSON.

use serde::Serialize;
use serde_json::{Map, Value};

use super::figures::sentence;
use super::format;
use super::published::compared;
use super::whole::Report;
use crate::analysis::{Estimated, LearnerSummary, MethodSummary, Mix, Pair};
use crate::stats::score::weighted_mean;
use crate::store::assisting;
use crate::store::dropped::Dropped;

/// What a finding is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Tasks without a record.
    Incomplete,
    /// Tasks that failed.
    Failed,
    /// A point MDP on which nothing can be divided by the reference.
    NoScore,
    /// Methods without results on some point MDPs.
    NotRanked,
    /// Scores over part of the replicates.
    PartOfReplicates,
    /// A method without interval.
    NoInterval,
    /// A sample that was assisted by results with other settings.
    AssistedOtherwise,
    /// Luck of training that intervals have, or lack.
    Luck,
    /// What was known of what was evaluated when the run began, or happened in it.
    Evaluated,
    /// Records of several builds.
    Builds,
    /// Summaries that disagree.
    Disagreement,
    /// A first place that rests on few point MDPs.
    Fragile,
    /// Which policies of trainings are ranked.
    Policies,
    /// The best method on each point MDP.
    Mix,
    /// How a sample has grown.
    Growth,
    /// Whether methods score as published.
    Published,
}

impl Kind {
    /// Whether it limits what the ranking says.
    pub(super) fn is_warning(self) -> bool {
        (self as u8) < Self::Evaluated as u8
    }
}

/// A finding, in a sentence.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// What it is about.
    pub kind: Kind,
    /// The sentence.
    pub text: String,
}

/// Distance from 1 below which two decimals show no difference from the reference.
const EQUAL: f64 = 0.005;

/// Returns what a reader of the ranking must know: what is missing, what is not in the interval, and
/// where summaries disagree.
pub fn findings(data: &Report) -> Vec<Finding> {
    let mut all = warnings(data);
    let mut add = |kind, texts: Vec<String>| {
        all.extend(texts.into_iter().map(|text| Finding { kind, text }));
    };
    add(Kind::Evaluated, evaluated(data));
    // A comparison says first which builds there are.
    let builds = data.results.warning_of_builds().filter(|_| data.runs.is_none());
    add(Kind::Builds, builds.into_iter().collect());
    add(Kind::Disagreement, disagreements(data));
    add(Kind::Fragile, fragile(data).into_iter().collect());
    add(Kind::Policies, policies(data));
    add(Kind::Policies, seen(data));
    add(Kind::Mix, data.mix().map(|mix| mixed(data, mix)).into_iter().collect());
    add(Kind::Growth, growth(data).into_iter().collect());
    add(Kind::Published, compared(data));
    all
}

/// Returns the findings as rows of JSON: `kind` and `text`.
pub fn rows(data: &Report) -> Vec<Map<String, Value>> {
    let row = |finding| match serde_json::to_value(finding) {
        Ok(Value::Object(row)) => row,
        _ => unreachable!("a finding is two strings"),
    };
    findings(data).iter().map(row).collect()
}

/// Returns the findings for a terminal, which counts what was evaluated instead of saying it.
pub fn notes(data: &Report) -> Vec<String> {
    let mut notes = Vec::new();
    let mut evaluated = 0;
    let mut all = findings(data).into_iter().peekable();
    while let Some(Finding { kind, text }) = all.next() {
        if kind != Kind::Evaluated {
            notes.push(text);
            continue;
        }
        evaluated += 1;
        if all.peek().is_none_or(|next| next.kind != kind) {
            let count = format::count(evaluated, "warning");
            notes.push(format!(
                "{count} on what was evaluated: the page has them beside the ranking."
            ));
        }
    }
    notes
}

/// Returns what a reader should know of what was evaluated: what was known when the run began, and what happened.
fn evaluated(data: &Report) -> Vec<String> {
    let known = data.manifest.provenance.warnings.iter().cloned();
    known.chain(data.sections.happened(data)).collect()
}

/// Returns what limits the ranking.
fn warnings(data: &Report) -> Vec<Finding> {
    let mut all = Vec::new();
    let mut add = |kind, text: String| all.push(Finding { kind, text });
    let planned = data.tasks.len();
    let missing = data.missing();
    if missing > 0 {
        let (have, them) = if missing == 1 { ("has", "it") } else { ("have", "them") };
        add(
            Kind::Incomplete,
            format!(
                "Incomplete: {} of {planned} tasks are done, {missing} {have} no record yet; run again to compute \
             {them}.",
                planned - missing
            ),
        );
    }
    let failed = data.failed().count();
    if failed > 0 {
        add(
            Kind::Failed,
            format!(
                "{failed} of {planned} tasks failed; the reasons are in the report's section \"Failed and \
             missing\"."
            ),
        );
    }
    let identity = &data.manifest.identity;
    let still: Vec<String> = (data.tasks.iter())
        .filter(|r| Some(r.method) == data.reference.index && !data.reference.is_none())
        .filter(|r| r.metrics.get(&identity.objective) == Some(&0.0))
        .map(|r| data.called(&data.points[r.point].row.point))
        .collect();
    if !still.is_empty() {
        add(
            Kind::NoScore,
            format!(
                "No score on {}: {} has no {} there{}.",
                still.join(", "),
                data.reference.in_short(),
                data.words.noun,
                data.words.nothing
            ),
        );
    }
    let chosen = data.points.len();
    let unranked: Vec<String> =
        data.unranked().map(|m| format!("{} ({} of {chosen})", m.method, m.points)).collect();
    if !unranked.is_empty() {
        let where_to_compare = match &data.common {
            Some(_) => "a second table compares all methods where all have results",
            None => "no point MDP has results of all methods yet, so they cannot be compared",
        };
        add(
            Kind::NotRanked,
            format!(
                "Not ranked, because they have no results on some point MDPs: {}. Their scores are over other point MDPs \
             than those above them; {where_to_compare}.",
                unranked.join(", ")
            ),
        );
    } else if data.reference.is_none() && data.methods.iter().any(|m| m.points != chosen) {
        add(Kind::NotRanked, "Scores are over the point MDPs that the method finished.".to_owned());
    } else if data.methods.iter().any(|m| m.points != chosen) {
        add(
            Kind::NotRanked,
            format!(
                "Scores are over the point MDPs that both the method and {} finished.",
                data.reference.in_short()
            ),
        );
    }
    let partly: Vec<String> = (data.methods.iter())
        .filter(|m| m.left_out > 0)
        .map(|m| format!("{} ({} of {})", m.method, m.left_out, m.replicates))
        .collect();
    if !partly.is_empty() {
        add(
            Kind::PartOfReplicates,
            format!(
                "Some replicates of {} failed or are missing; the score on such a point MDP is the mean over the \
             others, which flatters a method that fails where it is bad.",
                partly.join(", ")
            ),
        );
    }
    let others = || data.methods.iter().filter(|m| !m.is_reference && m.overall.is_some());
    if others().any(|m| m.interval.is_none()) {
        add(
Kind::NoInterval,
            "Without interval: this needs at least two evaluation seeds, and two point MDPs where others of \
             the family have no result."
                .to_owned(),
        );
    }
    assisted_otherwise(data).into_iter().for_each(|text| add(Kind::AssistedOtherwise, text));
    luck(data).into_iter().for_each(|text| add(Kind::Luck, text));
    all
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

/// Says what models of several point MDPs score on those of their training, and on others.
fn seen(data: &Report) -> Vec<String> {
    let identity = &data.manifest.identity;
    let said = |m: &MethodSummary| {
        let trained_on =
            &identity.controller(&m.method).filter(|own| !own.trained_on.is_empty())?.trained_on;
        let scored = data.points.iter().filter_map(|p| {
            let score = p.results[m.index].as_ref()?.score?;
            Some((trained_on.contains(&p.row.point), (p.weight, score)))
        });
        let (known, others): (Vec<_>, Vec<_>) = scored.partition(|(is_known, _)| *is_known);
        let of = |part: &[(bool, (f64, f64))]| {
            let score = weighted_mean(part.iter().map(|(_, both)| *both))?;
            let points = format::count(part.len(), "point MDP");
            Some(format!("{} on {points}", format::score(score)))
        };
        let parts = [(of(&known), "of its training"), (of(&others), "that it had not seen")];
        let parts = parts.into_iter().filter_map(|(said, what)| Some(format!("{} {what}", said?)));
        let parts = parts.collect::<Vec<_>>().join(", and ");
        (!parts.is_empty()).then(|| format!("{} scores {parts}.", m.method))
    };
    data.methods.iter().filter_map(said).collect()
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

/// Returns a sentence per method that some summaries call better and others worse than the
/// reference, and one on the order if the ratio of means turns it round.
fn disagreements(data: &Report) -> Vec<String> {
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

pub(super) fn best_two(data: &Report) -> Option<(&Pair, (f64, f64))> {
    let pair = data.comparison.pairs.iter().find(|pair| (pair.first, pair.second) == (0, 1))?;
    let same = [0, 1].iter().all(|m| data.methods[*m].points == pair.points);
    pair.ahead.interval.filter(|_| same).map(|interval| (pair, interval))
}

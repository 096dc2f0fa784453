//! The ranking as a table for terminals: plain text, no colours.

use super::divisor::baseline_in_full;
use super::methods::ranking;
use super::table::{Cell, Columns, Table};
use super::whole::Report;
use super::{first, format, mix, summaries};
use crate::analysis::{LearnerSummary, MethodSummary};
use crate::store::assisting;
use crate::store::dropped::Dropped;

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
        text.push_str(&format!(
            "\n\n{}\n\n{}",
            summaries::legend(data),
            summaries::table(data).plain()
        ));
    }
    if let Some(common) = &data.common {
        text.push_str(&format!("\n\n{}\n\n", common_title(data)));
        text.push_str(&ranking(data, &common.methods, common.points).plain());
    }
    text
}

/// Returns the title of the table of what methods have in common; empty when they are all ranked.
pub(super) fn common_title(data: &Report) -> String {
    let Some(common) = &data.common else { return String::new() };
    let n = format::count(common.points, "point MDP");
    format!("On the {n} that all {} methods with results finished:", common.methods.len())
}

/// Returns the learners with their trainings.
pub(super) fn trainings(data: &Report) -> Table {
    let score = |v: Option<f64>| Cell::number(v, format::score);
    let [_, [best, last]] = data.sections.training_columns();
    let columns = Columns::new()
        .text("", "learner", |l: &LearnerSummary<'_>| l.method.method.clone())
        .shown("trainings", |l| Cell::text(format!("{}/{}", l.scored, l.planned)))
        .shown("failed", |l| Cell::count(l.failed))
        .shown(format!("{}s", data.words.row), |l| Cell::text(l.episodes.to_string()))
        .shown("score", |l| {
            Cell::number(l.method.overall, |v| format::score_within(v, l.method.interval))
        })
        .shown("last policy", |l| score(l.last_policy))
        .shown(best, |l| score(l.best_episode))
        .shown(last, |l| score(l.last_episodes))
        .shown("median", |l| score(l.median))
        .shown("worst", |l| score(l.worst))
        .shown("time", |l| Cell::number(l.wall_s, format::duration));
    columns.table(data.learners())
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
    notes.extend(summaries::disagreements(data));
    notes.extend(first::fragile(data));
    notes.extend(first::policies(data));
    notes.extend(data.mix().map(|mix| mix::sentence(data, mix)));
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
pub(super) fn only_dropped_lack(data: &Report) -> bool {
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

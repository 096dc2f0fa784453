//! The leaderboard: all methods of many results directories, ranked per family and preset, as a page in Markdown and as lines
//! of JSON.
//!
//! Runs are of one table when a method that both have met the same episodes: the same point MDPs, of the same content, the same
//! seeds, and equal records of the baseline wherever both have some. Without a baseline the settings that decide episodes have to
//! be equal. A method has a row per run, unless a run with more point MDPs and as many trainings has the same records of it.
//!
//! A score is the estimate of its own run over the family, with that run's interval, so a run on a sample is beside runs on all
//! point MDPs. A method's places are those that the intervals allow: as many are surely before it as have an interval wholly
//! on the better side of its own.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use serde_json::{Map, Value};

use super::format;
use crate::analysis::joined::{Known, Source, agree, check_together, evaluations, settings};
use crate::analysis::{Analysis, MethodSummary};
use crate::sample::Sampling;
use crate::stats::Direction;
use crate::store::manifest::{Identity, PointRow};

/// What stands above the tables.
const ABOVE: &str = "\
# Leaderboard

This page ranks all published methods on each family. `tsc-family compare --leaderboard` made it from the records; do not edit it.

- **Place**: the first and the last place that the 95% intervals allow; a method that lacks results has none. `tsc-family compare` decides
  more pairs, because it compares two methods on the same vehicles.
- **One table** has runs with the same records of the baseline. Compare methods within one table only.
- **Point MDPs**: those of the sample. A run with *looks*, which could have stopped early, has wider intervals.
- **Training**: trainings per point MDP, and episodes or steps of each. *Chosen*: validation chose the policies that count; *last*: they are
  those after the last episode.
- **Run**: the day on which it began, and the version of the program.
";

/// Methods on the same episodes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Table {
    /// Name of the scenario.
    pub scenario: String,
    /// The preset, if the domain has some.
    pub preset: Option<String>,
    /// Number of point MDPs of the family.
    pub family_size: usize,
    /// Settings in which the tables of its scenario and preset differ, `key = value`.
    pub settings: BTreeSet<String>,
    /// Version of tsc-family of its first run, where another table of the scenario and preset has another.
    #[serde(skip)]
    pub version: Option<String>,
    /// Name of the metric that scores compare.
    #[serde(skip)]
    pub objective: String,
    /// Whether less or more of a score is better.
    #[serde(skip)]
    pub direction: Direction,
    /// Name of the method by which scores are divided; empty where the objective is the score.
    #[serde(skip)]
    pub baseline: String,
    /// The methods, best first.
    #[serde(skip)]
    pub rows: Vec<Row>,
}

/// A method of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Name of the method.
    pub method: String,
    /// Settings that all methods read and in which its run differs from the first one of the table, `key = value`.
    pub run_settings: Vec<String>,
    /// Path of its results directory, as it was given.
    pub path: String,
    /// First place that the intervals allow, from 1; `None` for a method that lacks results on point MDPs of its run.
    pub first_place: Option<usize>,
    /// Last place that they allow.
    pub last_place: Option<usize>,
    /// The score.
    pub score: f64,
    /// Its interval.
    pub interval: Option<(f64, f64)>,
    /// Point MDPs with a score.
    pub points: usize,
    /// Replicates on these that failed or have no record: the score is a mean over the others.
    pub replicates_left_out: usize,
    /// How the point MDPs were chosen.
    pub sampling: Sampling,
    /// Whether it was a run with looks, whose intervals are wider.
    pub looks: bool,
    /// Whether its sample grew after results were seen, with an interval at each look.
    pub grown: bool,
    /// Evaluation episodes per task.
    pub evaluation_seeds: usize,
    /// Trainings per point MDP; `None`, as the next three, for a method that does not learn.
    pub trainings: Option<u32>,
    /// Episodes of each at most, where it is not counted in steps.
    pub episodes: Option<usize>,
    /// Steps of each at most, where it is.
    pub steps: Option<u64>,
    /// Which policies count: those that validation has `chosen`, or the `last` ones.
    pub policies: Option<&'static str>,
    /// Version of the simulator.
    pub simulator: String,
    /// Version of tsc-family.
    pub tsc_family: String,
    /// Day on which the run began, such as `2026-11-22`.
    pub date: String,
}

/// A run with what its records say.
type Run = (Source, Analysis);

/// Returns the tables: those of one scenario after one another, the one with the most rows first; before all others those of
/// scenarios whose scores are relative to a baseline.
///
/// # Arguments
///
/// * `known` — what must be known of the domain of a run, by its name.
pub fn leaderboard(mut runs: Vec<Run>, known: &dyn Fn(&str) -> Known) -> Vec<Table> {
    runs.sort_by_cached_key(|(source, _)| {
        let identity = source.identity();
        let size = Reverse(identity.points.len());
        let started = source.results.manifest.provenance.started.clone();
        (identity.baseline.is_empty(), of_table(identity), size, started)
    });
    let mut groups: Vec<Vec<&Run>> = Vec::new();
    for run in &runs {
        let known = known(&run.0.identity().domain);
        let fits = |group: &&mut Vec<&Run>| {
            group.iter().any(|member| are_of_one(&member.0, &run.0, &known))
        };
        match groups.iter_mut().find(fits) {
            Some(group) => group.push(run),
            None => groups.push(vec![run]),
        }
    }
    let of_group = |group: &Vec<&Run>| {
        let first = &group[0].0;
        let identity = first.identity();
        let known = known(&identity.domain);
        let siblings = || {
            let firsts = groups.iter().map(|group| &group[0].0);
            firsts.filter(|other| of_table(other.identity()) == of_table(identity))
        };
        let version = &identity.tsc_family;
        // What else two tables of one scenario and preset differ in is the version that made them.
        let other_version = siblings().any(|other| other.identity().tsc_family != *version);
        Table {
            scenario: identity.scenario.clone(),
            preset: Some(preset(identity)).filter(|preset| !preset.is_empty()),
            family_size: identity.sample.family_size,
            settings: siblings().flat_map(|other| settings(other, first, &known)).collect(),
            version: other_version.then(|| version.clone()),
            objective: identity.objective.clone(),
            direction: identity.direction,
            baseline: identity.baseline.clone(),
            rows: rows(group, &known),
        }
    };
    let mut tables: Vec<Table> = groups.iter().map(of_group).collect();
    let scenarios: Vec<String> = tables.iter().map(|table| table.scenario.clone()).collect();
    tables.sort_by_key(|table| {
        let scenario = scenarios.iter().position(|scenario| *scenario == table.scenario);
        (scenario, Reverse(table.rows.len()))
    });
    tables
}

fn preset(identity: &Identity) -> String {
    identity.settings["preset"].as_str().unwrap_or_default().to_owned()
}

fn of_table(identity: &Identity) -> (String, String, String) {
    (identity.domain.clone(), identity.scenario.clone(), preset(identity))
}

/// Whether methods of two runs met the same episodes.
fn are_of_one(a: &Source, b: &Source, known: &Known) -> bool {
    let (one, other) = (a.identity(), b.identity());
    let of =
        |i: &Identity| (of_table(i), i.objective.clone(), i.baseline.clone(), i.sample.family_size);
    let same = |p: &&PointRow| {
        other.points.iter().any(|q| (&q.point, &q.content) == (&p.point, &p.content))
    };
    let common: Vec<PointRow> = one.points.iter().filter(same).cloned().collect();
    let seeds = common_seeds(one, other);
    let is_enough = common.len() == one.points.len().min(other.points.len());
    if of(one) != of(other) || !is_enough || seeds.is_empty() {
        return false;
    }
    if one.baseline.is_empty() {
        return check_together(a, b, known).is_ok();
    }
    let of = |source| evaluations(source, &common, &seeds);
    agree(&of(a), &of(b), &one.baseline)
}

fn common_seeds(one: &Identity, other: &Identity) -> Vec<u64> {
    let seeds = one.evaluation_seeds.iter();
    seeds.filter(|seed| other.evaluation_seeds.contains(seed)).copied().collect()
}

fn rows(group: &[&Run], known: &Known) -> Vec<Row> {
    let first = group[0].0.identity();
    let mut rows: Vec<Row> = Vec::new();
    let mut by_method: BTreeMap<&str, Vec<&Source>> = BTreeMap::new();
    for (source, analysis) in group {
        for summary in &analysis.methods {
            let Some(score) = summary.overall else { continue };
            let others = by_method.entry(summary.method.as_str()).or_default();
            if others.iter().any(|other| has_it(other, source, &summary.method)) {
                continue;
            }
            // Who dropped out has all that it was to have; who failed somewhere has not.
            let dropped_out = source.results.dropped.iter().any(|d| d.method == summary.method);
            let has_place = summary.rank.is_some() || (dropped_out && summary.failed == 0);
            if has_place {
                others.push(source);
            }
            let of_first = settings(&group[0].0, source, known);
            rows.push(row((source, analysis), (summary, score), of_first, has_place));
        }
    }
    let direction = first.direction;
    rows.sort_by(|a, b| {
        (b.first_place.cmp(&a.first_place))
            .then_with(|| direction.compare(a.score, b.score))
            .then_with(|| (&a.method, &a.path).cmp(&(&b.method, &b.path)))
    });
    // Without an interval nothing is known, but of the baseline, whose score is 1 by definition.
    let unknown = (f64::NEG_INFINITY, f64::INFINITY);
    let ends = |row: &Row| match row.method == first.baseline {
        true => (1.0, 1.0),
        false => row.interval.unwrap_or(unknown),
    };
    let ranked = || rows.iter().filter(|row| row.first_place.is_some());
    let places = places(&ranked().map(ends).collect::<Vec<_>>(), direction);
    for (row, (first, last)) in rows.iter_mut().zip(places) {
        (row.first_place, row.last_place) = (Some(first), Some(last));
    }
    rows
}

fn row(
    (source, analysis): (&Source, &Analysis),
    (summary, score): (&MethodSummary, f64),
    run_settings: Vec<String>,
    has_place: bool,
) -> Row {
    let (identity, manifest) = (source.identity(), &source.results.manifest);
    let trainings: Vec<_> = analysis.trainings_of(&summary.method).collect();
    let steps = trainings.iter().filter_map(|t| t.steps).max();
    let is_chosen = trainings.iter().any(|t| t.policy_row.is_some());
    let learns = !trainings.is_empty();
    Row {
        method: summary.method.clone(),
        run_settings,
        path: source.path.clone(),
        first_place: has_place.then_some(1),
        last_place: None,
        score,
        interval: summary.interval,
        points: summary.points,
        replicates_left_out: summary.left_out,
        sampling: identity.sample.sampling,
        looks: identity.sample.growth.is_some(),
        grown: !manifest.smaller_budgets().is_empty(),
        evaluation_seeds: identity.evaluation_seeds.len(),
        trainings: learns.then(|| identity.replicates_of(&summary.method)),
        episodes: trainings.iter().map(|t| t.episodes).max().filter(|_| steps.is_none()),
        steps,
        policies: learns.then_some(if is_chosen { "chosen" } else { "last" }),
        simulator: identity.simulator.clone(),
        tsc_family: identity.tsc_family.clone(),
        date: manifest.provenance.started.chars().take("2026-11-22".len()).collect(),
    }
}

/// Whether a run has all point MDPs of another and as many trainings, with the same records of a method wherever both have some.
fn has_it(a: &Source, b: &Source, method: &str) -> bool {
    let (one, other) = (a.identity(), b.identity());
    let there: BTreeSet<&str> = one.points.iter().map(|p| p.point.as_str()).collect();
    let is_larger = one.replicates_of(method) >= other.replicates_of(method)
        && other.points.iter().all(|p| there.contains(p.point.as_str()));
    let seeds = common_seeds(other, one);
    let of = |source| evaluations(source, &one.points, &seeds);
    is_larger && agree(&of(a), &of(b), method)
}

fn places(ends: &[(f64, f64)], direction: Direction) -> Vec<(usize, usize)> {
    let is_before =
        |a: (f64, f64), b: (f64, f64)| if direction.is_lower() { a.1 < b.0 } else { a.0 > b.1 };
    let of = |own: &(f64, f64)| {
        let before = ends.iter().filter(|other| is_before(**other, *own)).count();
        let behind = ends.iter().filter(|other| is_before(*own, **other)).count();
        (before + 1, ends.len() - behind)
    };
    ends.iter().map(of).collect()
}

/// Returns the page.
///
/// # Arguments
///
/// * `link` — returns the path of a results directory as seen from the page.
pub fn markdown(tables: &[Table], link: &dyn Fn(&str) -> String) -> String {
    let mut page = ABOVE.to_owned();
    for table in tables {
        page.push_str(&format!("\n## {}\n\n{}\n\n", title(table), about(table)));
        page.push_str(
            "| place | method | score (95% interval) | point MDPs | training | run |\n\
             | --- | --- | ---: | --- | --- | --- |\n",
        );
        for row in &table.rows {
            page.push_str(&line(row, table.family_size, link));
        }
    }
    page
}

fn title(table: &Table) -> String {
    let mut title = table.scenario.clone();
    if let Some(preset) = &table.preset {
        title.push_str(&format!(", preset {preset}"));
    }
    title.push_str(&format!(", {}", format::count(table.family_size, "point MDP")));
    if let Some(version) = &table.version {
        let baseline = table.rows.iter().find(|row| row.method == table.baseline);
        title.push_str(&match baseline {
            Some(row) => format!(", {}, baseline of version {version}", row.simulator),
            None => format!(", version {version}"),
        });
    }
    if !table.settings.is_empty() {
        title.push_str(&format!(": {}", quoted(&table.settings)));
    }
    title
}

fn quoted<'a>(settings: impl IntoIterator<Item = &'a String>) -> String {
    settings.into_iter().map(|setting| format!("`{setting}`")).collect::<Vec<_>>().join(", ")
}

fn about(table: &Table) -> String {
    let better = if table.direction.is_lower() { "less is better" } else { "more is better" };
    let seeds: BTreeSet<_> =
        table.rows.iter().map(|row| row.evaluation_seeds.to_string()).collect();
    let simulators: BTreeSet<_> = table.rows.iter().map(|row| row.simulator.clone()).collect();
    let listed = |names: BTreeSet<String>| Vec::from_iter(names).join(" or ");
    let baseline = match table.baseline.as_str() {
        "" => String::new(),
        baseline => format!(" divided by that of `{baseline}`"),
    };
    format!(
        "The score is `{}`{baseline}; {better}. Evaluation seeds: {}. Simulator: {}.",
        table.objective,
        listed(seeds),
        listed(simulators)
    )
}

fn line(row: &Row, of: usize, link: &dyn Fn(&str) -> String) -> String {
    let place = match (row.first_place, row.last_place) {
        (Some(first), Some(last)) if first != last => format!("{first} to {last}"),
        (Some(first), _) => first.to_string(),
        _ => "-".to_owned(),
    };
    let points = match (row.points, row.sampling) {
        (all, _) if all == of => "all".to_owned(),
        (some, Sampling::All) => format!("{some} of {of}"),
        (some, sampling) => format!("{some} of {of}, {}", sampling.name()),
    };
    let looks = match (row.looks, row.grown) {
        (true, _) => ", looks",
        (false, true) => ", grown after results were seen",
        (false, false) => "",
    };
    let left_out = match row.replicates_left_out {
        0 => String::new(),
        count => format!(", without {}", format::count(count, "replicate")),
    };
    let trained = row.trainings.zip(row.policies).map(|(trainings, policies)| {
        let length = match (row.steps, row.episodes) {
            (Some(steps), _) => format!("{} steps", format::thousands(steps as f64)),
            (None, episodes) => format!("{} episodes", episodes.unwrap_or_default()),
        };
        format!("{trainings} of {length}, {policies}")
    });
    let trained = trained.unwrap_or_else(|| "-".to_owned());
    let method = match row.run_settings.is_empty() {
        true => row.method.clone(),
        false => format!("{} with {}", row.method, quoted(&row.run_settings)),
    };
    let score = format::score_within(row.score, row.interval);
    let interval = row.interval.filter(|(low, high)| low < high);
    let interval = interval.map(|ends| format!(" ({})", format::interval(ends)));
    format!(
        "| {place} | {method} | {score}{} | {points}{looks}{left_out} | {trained} | [{}, {}]({}) |\n",
        interval.unwrap_or_default(),
        row.date,
        row.tsc_family,
        link(&row.path),
    )
}

/// Returns the lines of `--json`: one per row.
pub fn json(tables: &[Table]) -> Vec<Value> {
    let fields = |value: Value| match value {
        Value::Object(fields) => fields,
        _ => Map::new(),
    };
    let line = |table: &Table, row: &Row| {
        let mut line = Map::from_iter([("event".to_owned(), "row".into())]);
        for part in [serde_json::to_value(table), serde_json::to_value(row)] {
            line.extend(fields(part.expect("plain data can be written as JSON")));
        }
        Value::Object(line)
    };
    tables.iter().flat_map(|table| table.rows.iter().map(move |row| line(table, row))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_those_that_intervals_allow() {
        let ends = [(0.46, 0.48), (0.40, 0.62), (0.58, 0.61), (1.0, 1.0)];
        assert_eq!(places(&ends, Direction::Lower), [(1, 2), (1, 3), (2, 3), (4, 4)]);
        assert_eq!(places(&ends, Direction::Higher)[3], (1, 1));
        let unknown = (f64::NEG_INFINITY, f64::INFINITY);
        assert_eq!(places(&[unknown; 2], Direction::Lower), [(1, 2); 2]);
    }
}

//! All methods of several results directories, ranked per family and preset.
//!
//! Runs are of one table when a method that both have met the same episodes: the same point MDPs, of the same content, the same
//! seeds, and equal records of the baseline wherever both have some. Without a baseline the settings that decide episodes have to
//! be equal. A method has a row per run, unless a run with more point MDPs and as many trainings has the same records of it.
//!
//! A score is the estimate of its own run over the family, with that run's interval, so a run on a sample is beside runs on all
//! point MDPs. A method's places are those that the intervals allow: as many are surely before it as have an interval wholly
//! on the better side of its own.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

use super::joined::{
    Known, OF_LEARNERS, Source, agree, check_together, evaluations, have_section, method_of,
    section,
};
use super::whole::Analysis;
use crate::sample::Sampling;
use crate::stats::Direction;
use crate::store::difference::{differing, flat};
use crate::store::manifest::{Identity, PointRow};

/// Settings that name a family or say where its tables are.
const NAMES: [&str; 5] = ["name", "title", "version", "family.approaches", "family.points"];

/// Methods on the same episodes.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Name of the scenario.
    pub scenario: String,
    /// The preset, if the domain has some.
    pub preset: Option<String>,
    /// Number of point MDPs of the family.
    pub family_size: usize,
    /// Settings in which the tables of its scenario and preset differ, `key = value`.
    pub settings: Vec<String>,
    /// Version of tsc-family of its first run, where another table of the scenario and preset has another.
    pub version: Option<String>,
    /// Name of the metric that scores compare.
    pub objective: String,
    /// Whether less or more of a score is better.
    pub direction: Direction,
    /// Name of the method by which scores are divided; empty where the objective is the score.
    pub baseline: String,
    /// The methods, best first.
    pub rows: Vec<Row>,
}

/// How a method of a run was trained.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Trained {
    /// Trainings per point MDP.
    pub trainings: u32,
    /// Episodes of each at most.
    pub episodes: usize,
    /// Steps of each at most, where it is counted in steps.
    pub steps: Option<u64>,
    /// Whether validation chose the policies that count; else they are the last ones.
    pub is_chosen: bool,
}

/// A method of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Name of the method.
    pub method: String,
    /// Settings that all methods read and in which its run differs from the first one of the table, `key = value`.
    pub settings: Vec<String>,
    /// Path of its results directory, as it was given.
    pub path: String,
    /// First and last place that the intervals allow, from 1; `None` for a method that lacks results on point MDPs of its run.
    pub places: Option<(usize, usize)>,
    /// The score.
    pub score: f64,
    /// Its interval.
    pub interval: Option<(f64, f64)>,
    /// Point MDPs with a score, and of how many.
    pub points: (usize, usize),
    /// Replicates on these point MDPs that failed or have no record: the score is a mean over the others.
    pub left_out: usize,
    /// How the point MDPs were chosen.
    pub sampling: Sampling,
    /// Whether it was a run with looks, whose intervals are wider.
    pub has_looks: bool,
    /// Whether its sample grew after results were seen, with an interval at each look.
    pub has_grown: bool,
    /// Evaluation episodes per task.
    pub seeds: usize,
    /// How it was trained; `None` for a method that does not learn.
    pub trained: Option<Trained>,
    /// Version of the simulator.
    pub simulator: String,
    /// Version of tsc-family.
    pub version: String,
    /// Day on which the run began, such as `2026-11-22`.
    pub date: String,
}

/// Returns the tables: those of one scenario after one another, the one with the most rows first; before all others those of
/// scenarios whose scores are relative to a baseline.
///
/// # Arguments
///
/// * `runs` — each with what its records say.
/// * `known` — what must be known of the domain of a run, by its name.
pub fn leaderboard<'a>(
    runs: Vec<(Source, Analysis)>,
    known: &dyn Fn(&str) -> Known<'a>,
) -> Vec<Table> {
    let mut runs = runs;
    let started = |source: &Source| source.results.manifest.provenance.started.clone();
    let order = |source: &Source| {
        let identity = source.identity();
        let size = std::cmp::Reverse(identity.points.len());
        (
            // Traffic signals, whose scores are relative to a baseline, stand first.
            identity.baseline.is_empty(),
            identity.domain.clone(),
            identity.scenario.clone(),
            preset(identity),
            size,
            started(source),
        )
    };
    runs.sort_by_cached_key(|(source, _)| order(source));
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for run in 0..runs.len() {
        let (source, _) = &runs[run];
        let known = known(&source.identity().domain);
        let fits = |group: &&mut Vec<usize>| {
            group.iter().any(|member| are_of_one(&runs[*member].0, source, known))
        };
        match groups.iter_mut().find(fits) {
            Some(group) => group.push(run),
            None => groups.push(vec![run]),
        }
    }
    let firsts: Vec<usize> = groups.iter().map(|group| group[0]).collect();
    let is_sibling = |a: usize, b: usize| {
        let of = |run: usize| {
            let identity = runs[run].0.identity();
            (&identity.domain, &identity.scenario, preset(identity))
        };
        of(a) == of(b)
    };
    let mut tables: Vec<Table> = Vec::new();
    for (group, first) in groups.iter().zip(&firsts) {
        let source = &runs[*first].0;
        let known = known(&source.identity().domain);
        let siblings = firsts.iter().filter(|other| is_sibling(**other, *first));
        let mut settings: Vec<String> =
            siblings.flat_map(|other| self::settings(&runs[*other].0, source, known)).collect();
        settings.sort();
        settings.dedup();
        tables.push(table(&runs, group, settings, known));
    }
    // What else two tables of one scenario and preset differ in is the version that made them.
    for t in 0..tables.len() {
        let version = runs[firsts[t]].0.identity().tsc_family.clone();
        let is_other = |(other, first): (&Table, &usize)| {
            (&other.scenario, &other.preset) == (&tables[t].scenario, &tables[t].preset)
                && runs[*first].0.identity().tsc_family != version
        };
        let differs = tables.iter().zip(&firsts).any(is_other);
        tables[t].version = differs.then_some(version);
    }
    let scenarios: Vec<String> = tables.iter().map(|table| table.scenario.clone()).collect();
    tables.sort_by_key(|table| {
        let scenario = scenarios.iter().position(|scenario| *scenario == table.scenario);
        (scenario, std::cmp::Reverse(table.rows.len()))
    });
    tables
}

/// Returns the preset of a run; empty where its domain has none.
fn preset(identity: &Identity) -> String {
    identity.settings["preset"].as_str().unwrap_or_default().to_owned()
}

/// Whether methods of two runs met the same episodes.
fn are_of_one(a: &Source, b: &Source, known: Known<'_>) -> bool {
    let (one, other) = (a.identity(), b.identity());
    let of = |i: &Identity| {
        let head = (i.domain.clone(), i.scenario.clone(), preset(i), i.objective.clone());
        (head, i.baseline.clone(), i.sample.family_size)
    };
    if of(one) != of(other) {
        return false;
    }
    let same = |p: &&PointRow| {
        other.points.iter().any(|q| (&q.point, &q.content) == (&p.point, &p.content))
    };
    let common: Vec<PointRow> = one.points.iter().filter(same).cloned().collect();
    let seeds = &one.evaluation_seeds;
    let seeds: Vec<u64> =
        seeds.iter().filter(|seed| other.evaluation_seeds.contains(seed)).copied().collect();
    if common.len() < one.points.len().min(other.points.len()) || seeds.is_empty() {
        return false;
    }
    if one.baseline.is_empty() {
        return check_together(a, b, known).is_ok();
    }
    let of = |source| evaluations(source, &common, &seeds);
    agree(&of(a), &of(b), &one.baseline)
}

/// Returns the settings that all methods read by which a run differs from another; one at its default may be left out.
pub fn settings(from: &Source, run: &Source, known: Known<'_>) -> Vec<String> {
    let of = |source: &Source| flat(&source.identity().settings);
    let (there, here) = (of(from), of(run));
    let is_of_all = |key: &str| {
        section(key) != OF_LEARNERS
            && have_section([from, run], key)
            && !known.methods.contains(&method_of(key).as_str())
            && !NAMES.contains(&key)
    };
    let said = |value: Option<&Value>| match value {
        None => "not set".to_owned(),
        Some(value) => value.as_f64().filter(|_| value.is_f64()).map_or(value.to_string(), short),
    };
    let named = |key: &String| format!("{key} = {}", said(here.get(key)));
    differing(&there, &here).into_iter().filter(|key| is_of_all(key)).map(named).collect()
}

/// Returns a number with at most five significant digits.
fn short(number: f64) -> String {
    let rounded = format!("{number:.4e}");
    rounded.parse::<f64>().map_or(rounded, |number| number.to_string())
}

/// Returns the table of a group of runs.
fn table(
    runs: &[(Source, Analysis)],
    group: &[usize],
    settings: Vec<String>,
    known: Known<'_>,
) -> Table {
    let (first, _) = &runs[group[0]];
    let identity = first.identity();
    let mut rows: Vec<Row> = Vec::new();
    let mut by_method: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for run in group {
        let (source, analysis) = &runs[*run];
        for summary in &analysis.methods {
            let Some(score) = summary.overall else { continue };
            let has_looks = source.identity().sample.growth.is_some();
            // Who dropped out has all that it was to have; who failed somewhere has not.
            let dropped_out = source.results.dropped.iter().any(|d| d.method == summary.method);
            let has_place = summary.rank.is_some() || (dropped_out && summary.failed == 0);
            let others = by_method.entry(summary.method.as_str()).or_default();
            let trained = source.identity().replicates_of(&summary.method);
            let has_it = |other: &usize| {
                let other = &runs[*other].0;
                other.identity().replicates_of(&summary.method) >= trained
                    && are_the_same(other, source, &summary.method)
            };
            if others.iter().any(has_it) {
                continue;
            }
            if has_place {
                others.push(*run);
            }
            let trainings: Vec<_> = analysis.trainings_of(&summary.method).collect();
            let trained = trainings.iter().map(|t| t.episodes).max().map(|episodes| Trained {
                trainings: source.identity().replicates_of(&summary.method),
                episodes,
                steps: trainings.iter().filter_map(|t| t.steps).max(),
                is_chosen: trainings.iter().any(|t| t.policy_row.is_some()),
            });
            let provenance = &source.results.manifest.provenance;
            rows.push(Row {
                method: summary.method.clone(),
                settings: self::settings(first, source, known),
                path: source.path.clone(),
                places: has_place.then_some((1, 1)),
                score,
                interval: summary.interval,
                points: (summary.points, source.identity().sample.family_size),
                left_out: summary.left_out,
                sampling: source.identity().sample.sampling,
                has_looks,
                has_grown: !source.results.manifest.smaller_budgets().is_empty(),
                seeds: source.identity().evaluation_seeds.len(),
                trained,
                simulator: source.identity().simulator.clone(),
                version: source.identity().tsc_family.clone(),
                date: provenance.started.chars().take("2026-11-22".len()).collect(),
            });
        }
    }
    let direction = identity.direction;
    rows.sort_by(|a, b| {
        (b.places.cmp(&a.places))
            .then_with(|| direction.compare(a.score, b.score))
            .then_with(|| (&a.method, &a.path).cmp(&(&b.method, &b.path)))
    });
    place(&mut rows, &identity.baseline, direction);
    Table {
        scenario: identity.scenario.clone(),
        preset: Some(preset(identity)).filter(|preset| !preset.is_empty()),
        family_size: identity.sample.family_size,
        settings,
        version: None,
        objective: identity.objective.clone(),
        direction,
        baseline: identity.baseline.clone(),
        rows,
    }
}

/// Whether a run has all point MDPs of another, with the same records of a method wherever both have some.
fn are_the_same(a: &Source, b: &Source, method: &str) -> bool {
    let there: BTreeSet<&str> = a.identity().points.iter().map(|p| p.point.as_str()).collect();
    if !b.identity().points.iter().all(|p| there.contains(p.point.as_str())) {
        return false;
    }
    let seeds: BTreeSet<u64> = a.identity().evaluation_seeds.iter().copied().collect();
    let seeds: Vec<u64> =
        b.identity().evaluation_seeds.iter().filter(|s| seeds.contains(s)).copied().collect();
    let of = |source| evaluations(source, &a.identity().points, &seeds);
    agree(&of(a), &of(b), method)
}

/// Sets the places that intervals allow, of the rows that have one. Without an interval nothing is known, but of the baseline,
/// whose score is 1 by definition.
fn place(rows: &mut [Row], baseline: &str, direction: Direction) {
    let mut rows: Vec<&mut Row> = rows.iter_mut().filter(|row| row.places.is_some()).collect();
    let unknown = (f64::NEG_INFINITY, f64::INFINITY);
    let ends_of = |row: &Row| match row.method == baseline {
        true => (1.0, 1.0),
        false => row.interval.unwrap_or(unknown),
    };
    let ends: Vec<(f64, f64)> = rows.iter().map(|row| ends_of(row)).collect();
    let is_before = |a: (f64, f64), b: (f64, f64)| match direction {
        Direction::Lower => a.1 < b.0,
        Direction::Higher => a.0 > b.1,
    };
    for (i, row) in rows.iter_mut().enumerate() {
        let before = ends.iter().filter(|other| is_before(**other, ends[i])).count();
        let behind = ends.iter().filter(|other| is_before(ends[i], **other)).count();
        row.places = Some((before + 1, ends.len() - behind));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(score: f64, interval: Option<(f64, f64)>) -> Row {
        Row {
            method: format!("m{score}"),
            settings: Vec::new(),
            path: String::new(),
            places: Some((1, 1)),
            score,
            interval,
            points: (1, 1),
            left_out: 0,
            sampling: Sampling::All,
            has_looks: false,
            has_grown: false,
            seeds: 5,
            trained: None,
            simulator: String::new(),
            version: String::new(),
            date: String::new(),
        }
    }

    #[test]
    fn places_are_those_that_intervals_allow() {
        let mut rows = [
            row(0.47, Some((0.46, 0.48))),
            row(0.50, Some((0.40, 0.62))),
            row(0.60, Some((0.58, 0.61))),
            row(1.0, None),
            Row { places: None, ..row(0.30, Some((0.29, 0.31))) },
        ];
        place(&mut rows, "m1", Direction::Lower);
        let allowed = [Some((1, 2)), Some((1, 3)), Some((2, 3)), Some((4, 4)), None];
        assert_eq!(rows.clone().map(|r| r.places), allowed);
        place(&mut rows, "m1", Direction::Higher);
        assert_eq!(rows[3].places, Some((1, 1)));
    }

    #[test]
    fn without_intervals_every_place_is_possible() {
        let mut rows = [row(0.47, None), row(0.50, None)];
        place(&mut rows, "baseline", Direction::Lower);
        assert_eq!(rows.map(|r| r.places), [Some((1, 2)); 2]);
    }
}

//! The page: prepares every text and number, so that the template only places them.

use minijinja::{Value, context};

use super::csv::events;
use super::curve::{FEW_TRAININGS, SMOOTHED_OVER};
use super::curves::common_points;
use super::data::ReportData;
use super::divisor::baseline_in_full;
use super::figures::{Figure, label, level_shares};
use super::headline::{headline, sentences};
use super::names::streets;
use super::page::render;
use super::plan_values::plan_values;
use super::{format, further, narrow, text};
use crate::analysis::EpisodeSummary;
use crate::analysis::Estimated;
use crate::analysis::LearnerSummary;
use crate::analysis::{MethodSummary, TaskScore};
use crate::stats::bootstrap::RESAMPLES;
use crate::store::manifest::{FeatureColumn, PointRow};
use crate::store::places::Place;
use crate::traffic::report::level_of_service::{DELAY, LEVELS, letter, range};
use crate::traffic::report::{GRIDLOCK_EXCESS, GRIDLOCK_SHARE};

const TEMPLATE: &str = include_str!("templates/index.html");
const STYLE: &str = include_str!("templates/style.css");

/// Rows of the table of point MDPs that stay worst under the best method.
const WORST_ROWS: usize = 10;

/// Failures that are listed one by one; the others are in `scores.csv`.
const FAILURE_ROWS: usize = 20;

/// Places of a point MDP that are written out.
const PLACES: usize = 2;

/// Returns the page.
///
/// # Errors
///
/// The template engine's message.
pub(super) fn page(data: &ReportData, figures: &[Figure]) -> Result<String, String> {
    render("index.html", TEMPLATE, values(data, figures))
}

fn values(data: &ReportData, figures: &[Figure]) -> Value {
    let identity = &data.manifest.identity;
    let figure = |name: &str| figures.iter().find(|f| f.name == name).map(|f| f.svg.clone());
    let is_delay = identity.objective == DELAY;
    context! {
        style => STYLE,
        scenario => identity.scenario.as_str(),
        headline => headline(data),
        sentences => sentences(data),
        warnings => text::warnings(data),
        disagree => further::disagreements(data).len(),
        is_delay,
        objective => identity.objective.as_str(),
        baseline => data.reference.name.as_str(),
        of => data.reference.in_short(),
        label => data.reference.as_label(),
        divisor => if data.reference.is_baseline { "baseline" } else { "divisor" },
        against => (!data.reference.is_baseline).then(|| baseline_in_full(&identity.baseline)),
        best => data.best().map(|m| m.method.clone()),
        methods => data.methods.iter().map(|m| method(data, m)).collect::<Vec<_>>(),
        names => data.methods.iter().map(|m| m.method.clone()).collect::<Vec<_>>(),
        chosen => data.points.len(),
        common => common(data),
        further => further_values(data),
        gridlock_excess => (100.0 * GRIDLOCK_EXCESS).round() as u32,
        gridlock_share => format::percent(GRIDLOCK_SHARE),
        once => text::trained_once(data).join(", "),
        overall => figure("overall"),
        narrow => narrow::overall(data),
        plans => plan_values(data),
        placed => !data.places.intersections.is_empty(),
        any_failed => data.failed().count() > 0,
        learning => figure("learning"),
        training => training(data),
        distribution => figure("distribution"),
        levels => figure("level-of-service"),
        map => figure("map"),
        level_heads => LEVELS
            .iter()
            .enumerate()
            .map(|(l, letter)| context! { letter => letter.to_string(), range => range(l) })
            .collect::<Vec<_>>(),
        worst => worst(data),
        units => units(data),
        regimes => data.regimes.iter().map(|r| r.heading.to_vec()).collect::<Vec<_>>(),
        shares => data.shares.iter().map(|s| s.heading.to_vec()).collect::<Vec<_>>(),
        events => events(data).map(|(i, _)| data.shares[i].heading.to_vec()).collect::<Vec<_>>(),
        context => figure("context"),
        failures => data.failed().take(FAILURE_ROWS).map(|r| failure(data, r)).collect::<Vec<_>>(),
        failed => data.failed().count(),
        without_reference => data.methods.iter().map(|m| m.without_reference).max().unwrap_or(0),
        missing => data.missing(),
        planned => data.tasks.len(),
        sampling => data.sampling(),
        budget => identity.sample.budget,
        family_size => identity.sample.family_size,
        seeds => identity.evaluation_seeds.len(),
        replicates => identity.replicates,
        replicated => identity.replicated.join(", "),
        resamples => RESAMPLES,
        provenance => provenance(data),
        settings => serde_json::to_string_pretty(&identity.settings)
            .expect("JSON read from a manifest can be written"),
        hashes => hashes(data),
    }
}

fn method(data: &ReportData, m: &MethodSummary) -> Value {
    let metric = |name: &str| m.metrics.get(name).map_or_else(dash, |v| format::delay(*v));
    let interval = match m.interval {
        _ if m.is_reference && m.overall.is_some() => "by definition".to_owned(),
        Some(i) => format::interval(i),
        None => dash(),
    };
    // The baseline scores 1 everywhere.
    let worst = m.worst.as_ref().filter(|_| !m.is_reference);
    context! {
        name => m.method.as_str(),
        label => label(data, m),
        is_reference => m.is_reference,
        rank => m.rank.map_or_else(dash, |r| r.to_string()),
        overall => m.overall.map_or_else(dash, |v| format::score_within(v, m.interval)),
        interval,
        objective => m.objective.map_or_else(dash, format::delay),
        waiting => metric("waiting_s"),
        queue => metric("queue_veh"),
        unfinished => metric("unfinished_veh"),
        worst_point => worst.map_or_else(dash, |w| data.title_of(&w.0)),
        worst_id => worst.map(|w| &w.0).filter(|id| data.title_of(id) != **id),
        worst_score => worst.map(|w| format::score(w.1)),
        points => m.points,
        failed => m.failed,
        missing => m.missing,
        levels => level_shares(data, m).map(format::percent).to_vec(),
        summaries => summaries(m),
        episodes => episodes(&m.episodes),
    }
}

/// Returns the score and the summaries beside it; those by level of service need a delay.
fn summaries(m: &MethodSummary) -> Vec<Value> {
    let s = &m.summaries;
    let score = m.overall.map(|value| Estimated { value, interval: m.interval });
    let mut all = vec![score, s.ratio_of_means, s.median, s.geometric_mean];
    all.extend(&s.by_regime);
    let value = |e: Option<Estimated>| {
        let interval = e.and_then(|e| e.interval).filter(|_| !m.is_reference);
        context! {
            value => e.map_or_else(dash, |e| format::score_within(e.value, e.interval)),
            interval => interval.map(format::interval),
        }
    };
    all.into_iter().map(value).collect()
}

fn dash() -> String {
    "\u{2013}".to_owned()
}

fn share(share: Option<f64>) -> String {
    share.map_or_else(dash, |s| format!("{:.1}%", 100.0 * s))
}

fn episodes(e: &EpisodeSummary) -> Value {
    context! {
        count => e.episodes,
        shares => e.shares.iter().copied().map(share).collect::<Vec<_>>(),
        median => e.median_relative.map_or_else(dash, format::score),
        worst => e.worst_relative.map_or_else(dash, format::score),
        median_s => e.median.map_or_else(dash, format::delay),
        worst_s => e.worst.map_or_else(dash, format::delay),
    }
}

/// Returns what the section of further summaries says; undefined without a method beside the
/// reference.
fn further_values(data: &ReportData) -> Option<Value> {
    let others = data.methods.iter().any(|m| m.overall.is_some() && !m.is_reference);
    others.then(|| {
        context! {
            disagreements => further::disagreements(data),
            overloaded => data.overloaded.map(|o| o.in_words()),
            unfinished => further::unfinished(data),
        }
    })
}

/// Returns the comparison on the point MDPs that all methods have; undefined when all are ranked.
fn common(data: &ReportData) -> Option<Value> {
    let common = data.common.as_ref()?;
    Some(context! {
        title => text::common_title(data),
        methods => common.methods.iter().map(|m| method(data, m)).collect::<Vec<_>>(),
    })
}

/// Returns the table of trainings; undefined without learners.
fn training(data: &ReportData) -> Option<Value> {
    let learners = data.learners();
    let curves: Vec<_> = learners.iter().filter(|l| l.scored > 0).collect();
    let points = common_points(data).len();
    (!learners.is_empty()).then(|| {
        context! {
            rows => learners.iter().map(|l| learner(data, l)).collect::<Vec<_>>(),
            single => curves.len() < 2,
            points,
            few => FEW_TRAININGS,
            smoothed => SMOOTHED_OVER,
            failed => learners.iter().map(|l| l.failed).sum::<usize>(),
        }
    })
}

fn learner(data: &ReportData, l: &LearnerSummary<'_>) -> Value {
    let score = |v: Option<f64>| v.map_or_else(dash, format::score);
    let m = l.method;
    context! {
        name => m.method.as_str(),
        planned => l.planned,
        scored => l.scored,
        failed => l.failed,
        diverged => l.diverged,
        episodes => l.episodes,
        overall => m.overall.map_or_else(dash, |v| format::score_within(v, m.interval)),
        best => score(l.best),
        last_ten => score(l.last_ten),
        worse => l.worse,
        with_event => events(data)
            .map(|(i, _)| l.with_share[i].map_or_else(dash, |n| n.to_string()))
            .collect::<Vec<_>>(),
        events => events(data).map(|(i, _)| share(m.episodes.shares[i])).collect::<Vec<_>>(),
        evaluated => episodes(&m.episodes),
        median => score(l.median),
        worst => score(l.worst),
        time => l.wall_s.map_or_else(dash, format::duration),
    }
}

/// Returns the point MDPs with the largest objective under the best method.
fn worst(data: &ReportData) -> Vec<Value> {
    let Some(best) = data.best() else { return Vec::new() };
    let mut results: Vec<_> = data.results_of(best.index).collect();
    results.sort_by(|a, b| b.1.objective.total_cmp(&a.1.objective));
    results
        .into_iter()
        .take(WORST_ROWS)
        .map(|(p, r)| {
            let delay = |m: &MethodSummary| {
                let result = p.results[m.index].as_ref();
                result.map_or_else(dash, |r| format::delay(r.objective))
            };
            context! {
                point => data.title_of(&p.row.point),
                id => Some(&p.row.point).filter(|id| data.title_of(id) != **id),
                weight => format!("{:.2}%", 100.0 * p.weight),
                instances => instances(data, &p.row),
                features => features(data, &p.row),
                places => places(data, &p.row),
                level => letter(r.objective).to_string(),
                delays => data.methods.iter().map(delay).collect::<Vec<_>>(),
            }
        })
        .collect()
}

/// Returns the features and their units.
fn units(data: &ReportData) -> String {
    let columns = &data.manifest.identity.features;
    columns.iter().map(format::feature_label).collect::<Vec<_>>().join("; ")
}

/// Returns the features as text, without the units, which the caption names.
fn features(data: &ReportData, row: &PointRow) -> String {
    let columns = &data.manifest.identity.features;
    let text = |(f, value): (&FeatureColumn, &f64)| {
        format!("{} {}", format::words(&f.name, &f.unit), format::feature(*value))
    };
    columns.iter().zip(&row.features).map(text).collect::<Vec<_>>().join(", ")
}

/// Returns how many intersections a point MDP has, and how many it stands for where these are more.
fn instances(data: &ReportData, row: &PointRow) -> String {
    let stands = |place: &&Place| place.stands.as_ref() == Some(&row.point);
    let all = data.places.intersections.iter().filter(stands).count();
    let own = format::count(row.instances as usize, "intersection");
    match all > row.instances as usize {
        true => format!("for {all} intersections, {} its own", row.instances),
        false => own,
    }
}

/// Returns where a point MDP is: streets, or coordinates where there are no names.
fn places(data: &ReportData, row: &PointRow) -> Vec<String> {
    let places: Vec<&Place> = data.places_of(&row.point).collect();
    // A single intersection is called by its streets already.
    let name = |place: &&Place| match streets(place).filter(|_| places.len() > 1) {
        Some(streets) => streets,
        None => format!("{:.5}, {:.5}", place.latitude, place.longitude),
    };
    let mut texts: Vec<_> = places.iter().take(PLACES).map(name).collect();
    if places.len() > PLACES {
        texts.push(format!("and {} more", places.len() - PLACES));
    }
    texts
}

fn failure(data: &ReportData, row: &TaskScore) -> Value {
    context! {
        method => row.method.as_str(),
        point => data.called(&data.points[row.point].row.point),
        replicate => row.replicate,
        reason => row.reason.clone().unwrap_or_else(|| "no reason was recorded".to_owned()),
    }
}

fn provenance(data: &ReportData) -> Vec<Value> {
    let (i, p) = (&data.manifest.identity, &data.manifest.provenance);
    let seeds: Vec<_> = i.evaluation_seeds.iter().map(u64::to_string).collect();
    [
        ("command", p.command.clone()),
        ("tsc-family", format!("{} (git {}, {})", i.tsc_family, p.git, p.rustc)),
        ("simulator", i.simulator.clone()),
        ("host", p.host.clone()),
        ("started", p.started.clone()),
        ("networks", p.networks.clone()),
        ("base seed", i.base_seed.to_string()),
        ("evaluation seeds", seeds.join(", ")),
        ("sampling", format!("{}, seed {}", data.sampling(), i.sample.seed)),
        ("manifest sha256", data.manifest.sha256()),
        ("schema version", i.schema_version.to_string()),
    ]
    .into_iter()
    .map(|(name, value)| context! { name, value })
    .collect()
}

fn hashes(data: &ReportData) -> Vec<Value> {
    let points = data.manifest.identity.points.iter();
    let files = points.flat_map(|p| p.sha256.iter().map(move |(file, sha)| (p, file, sha)));
    files
        .map(|(p, file, sha256)| {
            context! { point => p.point.as_str(), file => file.as_str(), sha256 => sha256.as_str() }
        })
        .collect()
}

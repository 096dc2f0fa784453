//! The page: prepares every text and number, so that the template only places them.

use minijinja::value::merge_maps;
use minijinja::{Value, context};

use super::all::dash;
use super::curves::{FEW_TRAININGS, common_points};
use super::divisor::baseline_in_full;
use super::error::ReportError;
use super::figure::Figure;
use super::figures::label;
use super::first::{answers, headline, lead};
use super::methods::ranking;
use super::page::render;
use super::provenance::{CITATIONS, hashes, provenance, settings};
use super::sections::{About, Metric, Part, Slot, Table};
use super::whole::{Report, Runs};
use super::words::Words;
use super::{all, format, mix, summaries, sure, text};
use crate::analysis::{EpisodeSummary, Estimated, MethodSummary, SMOOTHED_OVER, TaskScore};
use crate::stats::bootstrap::RESAMPLES;

const TEMPLATE: &str = include_str!("templates/index.html");

/// Failures that are listed one by one; the others are in `scores.csv`.
const FAILURE_ROWS: usize = 20;

/// Returns the page.
pub(super) fn page(data: &Report, figures: &[Figure]) -> Result<String, ReportError> {
    let parts = data.sections.parts(data, figures)?;
    let further = context! {
        mix => data.mix().map(|mix| mix::section(data, mix)),
        sure => sure::section(data, figures)?,
        all => all::section(data)?,
        all_title => all::title(data),
    };
    let values = merge_maps([values(data, figures, &parts), further]);
    render("index.html", TEMPLATE, values).map_err(ReportError::Template)
}

fn values(data: &Report, figures: &[Figure], parts: &[Part]) -> Value {
    let figure = |name: &str| figures.iter().find(|f| f.name == name).map(|f| f.svg.clone());
    let metrics = data.sections.metrics(Table::Ranking, data);
    let heading = |m: &Metric| vec![m.heading.clone(), m.unit.clone()];
    let others = data.methods.iter().any(|m| m.overall.is_some() && !m.is_reference);
    context! {
        headline => headline(data),
        runs => data.runs.as_ref().map(runs),
        answers => answers(data),
        lead => lead(data),
        warnings => text::warnings(data),
        evaluated => text::evaluated(data),
        disagree => summaries::disagreements(data).len(),
        metrics => metrics.iter().map(heading).collect::<Vec<_>>(),
        best => data.best().map(|m| m.method.clone()),
        methods => data.methods.iter().map(|m| method(data, m, &metrics)).collect::<Vec<_>>(),
        mix_row => data.mix().map(|mix| method(data, &mix::row(data, mix), &metrics)),
        common => common(data),
        further => others.then(|| context! { disagreements => summaries::disagreements(data) }),
        tuned_once => text::once(data, false).join(", "),
        learned_once => text::once(data, true).join(", "),
        overall => figure("overall"),
        any_failed => data.failed().count() > 0,
        learning => figure("learning"),
        training => training(data),
        distribution => figure("distribution"),
        regimes => data.regimes.iter().map(|r| r.heading.to_vec()).collect::<Vec<_>>(),
        shares => data.shares.iter().map(|s| s.heading.to_vec()).collect::<Vec<_>>(),
        failures => data.failed().take(FAILURE_ROWS).map(|r| failure(data, r)).collect::<Vec<_>>(),
        failed => data.failed().count(),
        without_reference => data.methods.iter().map(|m| m.without_reference).max().unwrap_or(0),
        missing => data.missing(),
        ..merge_maps([words(data), said(data, parts), run(data)])
    }
}

fn runs(runs: &Runs) -> Value {
    let names: Vec<&str> = runs.sources.iter().map(|(name, ..)| name.as_str()).collect();
    context! { names => names.join(", "), differences => runs.differences.clone(), repeated => runs.repeated.clone() }
}

fn words(data: &Report) -> Value {
    let lower = data.direction().is_lower();
    context! {
        noun => data.words.noun.as_str(),
        nouns => data.words.nouns.as_str(),
        heading => data.words.heading(),
        amount => data.words.amount.as_str(),
        unit => data.words.unit.as_str(),
        unit_in_full => data.words.unit_in_full.as_str(),
        instance => data.words.instance.as_str(),
        met => data.words.met.as_str(),
        row => data.words.row.as_str(),
        row_is => data.words.row_is.as_str(),
        relative => data.relative(),
        is_relative => !data.reference.is_none(),
        better => data.better(),
        best_is => if lower { "smallest" } else { "largest" },
        worse_side => if lower { "right" } else { "left" },
        baseline => data.reference.name.as_str(),
        of => data.reference.in_short(),
        label => data.reference.as_label(),
        divisor => if data.reference.is_baseline { "baseline" } else { "divisor" },
    }
}

fn said(data: &Report, parts: &[Part]) -> Value {
    let says = |about: About| data.sections.says(about, data);
    let of = |slot: Slot| {
        let parts = parts.iter().filter(move |part| part.slot == slot);
        let part = |p: &Part| context! { id => p.id, title => p.title, html => p.html.as_str() };
        parts.map(part).collect::<Vec<_>>()
    };
    context! {
        audience => data.sections.audience(),
        regimes_say => says(About::Regimes),
        summaries_say => says(About::Summaries),
        episodes_heading => says(About::Episodes),
        before_episodes => says(About::BeforeEpisodes),
        after_episodes => says(About::AfterEpisodes),
        training_says => says(About::Training),
        points_say => says(About::Points),
        not_covered => says(About::NotCovered),
        elsewhere => says(About::Elsewhere),
        apply => context! {
            ranking => says(About::ApplyRanking),
            summaries => says(About::ApplySummaries),
            spread => says(About::ApplySpread),
            training => says(About::ApplyTraining),
        },
        body => of(Slot::Body),
        notes => of(Slot::Notes),
    }
}

fn run(data: &Report) -> Value {
    let identity = &data.manifest.identity;
    context! {
        scenario => identity.scenario.as_str(),
        is_against => !data.reference.is_baseline,
        against => Some(&identity.baseline)
            .filter(|name| !data.reference.is_baseline && !name.is_empty())
            .map(|name| baseline_in_full(name)),
        chosen => data.points.len(),
        planned => data.tasks.len(),
        sampling => data.sampling(),
        assumptions => data.estimator().assumptions(),
        budget => identity.sample.budget,
        family_size => identity.sample.family_size,
        seeds => identity.evaluation_seeds.len(),
        replicates => identity.replicates,
        replicated => identity.replicated.join(", "),
        resamples => identity.sample.resamples(RESAMPLES),
        provenance => provenance(data),
        settings => settings(data),
        hashes => hashes(data),
        cite => CITATIONS.trim_end(),
        files => data.sections.tables(data),
    }
}

fn method(data: &Report, m: &MethodSummary, metrics: &[Metric]) -> Value {
    let metric = |of: &Metric| m.metrics.get(&of.name).map_or_else(dash, |v| format::amount(*v));
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
        objective => m.objective.map_or_else(dash, |v| data.words.value(v)),
        metrics => metrics.iter().map(metric).collect::<Vec<_>>(),
        worst_point => worst.map_or_else(dash, |w| data.title_of(&w.0)),
        worst_id => worst.map(|w| &w.0).filter(|id| data.title_of(id) != **id),
        worst_score => worst.map(|w| format::score(w.1)),
        points => m.points,
        left_out => m.left_out,
        replicates => m.replicates,
        failed => m.failed,
        missing => m.missing,
        summaries => summaries(data, m),
        episodes => episodes(&m.episodes, &data.words),
    }
}

fn summaries(data: &Report, m: &MethodSummary) -> Vec<Value> {
    let s = &m.summaries;
    let score = m.overall.map(|value| Estimated { value, interval: m.interval });
    let mut all = match data.reference.is_none() {
        true => vec![score, s.median, s.interquartile_mean],
        false => vec![score, s.ratio_of_means, s.median, s.interquartile_mean, s.geometric_mean],
    };
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

fn share(share: Option<f64>) -> String {
    share.map_or_else(dash, |s| format!("{:.1}%", 100.0 * s))
}

fn episodes(e: &EpisodeSummary, words: &Words) -> Value {
    let value = |v: Option<f64>| v.map_or_else(dash, |v| words.value(v));
    context! {
        count => e.episodes,
        shares => e.shares.iter().copied().map(share).collect::<Vec<_>>(),
        median => e.median_relative.map_or_else(dash, format::score),
        worst => e.worst_relative.map_or_else(dash, format::score),
        median_value => value(e.median),
        worst_value => value(e.worst),
    }
}

fn common(data: &Report) -> Option<String> {
    let common = data.common.as_ref()?;
    let caption = format!(
        "{} the fair comparison while some methods have no results on some point MDPs. Weights are scaled to sum to 1.",
        text::common_title(data)
    );
    Some(ranking(data, &common.methods, common.points).html(&caption))
}

fn training(data: &Report) -> Option<Value> {
    let learners = data.learners();
    let curves: Vec<_> = learners.iter().filter(|l| l.scored > 0).collect();
    let points = common_points(data).len();
    let figures = match data.reference.is_none() {
        true => format!("Figures but counts and time are values of {}", data.words.noun),
        false => format!("All figures but counts and time are relative to {}", data.reference.name),
    };
    let caption = format!(
        "Trainings: each is one learner on one point MDP, once. {figures}; {}. Median and worst: scores of trainings. Every \
         training: training.csv.",
        data.better()
    );
    (!learners.is_empty()).then(|| {
        context! {
            table => text::trainings(data).html(&caption),
            single => curves.len() < 2,
            points,
            few => FEW_TRAININGS,
            smoothed => SMOOTHED_OVER,
            validated => learners.iter().any(|l| l.validated > 0),
            failed => learners.iter().map(|l| l.failed).sum::<usize>(),
        }
    })
}

fn failure(data: &Report, row: &TaskScore) -> Value {
    context! {
        method => &data.manifest.identity.methods[row.method],
        point => data.called(&data.points[row.point].row.point),
        replicate => row.replicate,
        reason => row.reason.as_deref().unwrap_or("no reason was recorded"),
    }
}

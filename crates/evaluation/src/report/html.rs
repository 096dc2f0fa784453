//! The page: prepares every text and number, so that the templates only place them.

use minijinja::value::merge_maps;
use minijinja::{Value, context};
use serde_json::{Value as Json, json};

use super::figures::{FEW_TRAININGS, common_points, label};
use super::findings::{Kind, findings, mixed, once, trained_once};
use super::page::render;
use super::sections::{About, Metric, Part, ReportError, Slot, Spot, Table};
use super::svg::Figure;
use super::table::{Cell, Columns};
use super::tables::{self, mix_row, ranking, trainings};
use super::text::{FEW_SEEDS, MOST_PAIRS, certain};
use super::whole::{Report, Runs};
use super::words::{Words, baseline_in_full, limit_in_words};
use super::{format, text};
use crate::analysis::{
    EpisodeSummary, Estimated, MethodSummary, Mix, MixPoint, Pair, PointSummary, SMOOTHED_OVER,
    TaskScore, Winner,
};
use crate::family::Feature;
use crate::stats::bootstrap::RESAMPLES;
use crate::store::own::OwnMethod;

const SURE: &str = include_str!("templates/sure.html");

const TEMPLATE: &str = include_str!("templates/index.html");

/// Failures that are listed one by one; the others are in `scores.csv`.
const FAILURE_ROWS: usize = 20;

pub(super) fn page(data: &Report, figures: &[Figure]) -> Result<String, ReportError> {
    let parts = data.sections.parts(data, figures)?;
    let further = context! {
        mix => data.mix().map(|mix| self::mix(data, mix)),
        sure => sure(data, figures)?,
        all => all(data)?,
        all_title => all_title(data),
    };
    let values = merge_maps([values(data, figures, &parts), further]);
    render("index.html", TEMPLATE, values).map_err(ReportError::Template)
}

fn values(data: &Report, figures: &[Figure], parts: &[Part]) -> Value {
    let figure = |name: &str| figures.iter().find(|f| f.name == name).map(|f| f.svg.clone());
    let metrics = data.sections.metrics(Table::Ranking, data);
    let heading = |m: &Metric| vec![m.heading.clone(), m.unit.clone()];
    let others = data.methods.iter().any(|m| m.overall.is_some() && !m.is_reference);
    let findings = findings(data);
    let sentences = |has: &dyn Fn(Kind) -> bool| -> Vec<String> {
        let own = findings.iter().filter(|finding| has(finding.kind));
        own.map(|finding| finding.text.clone()).collect()
    };
    let disagreements = sentences(&|kind| kind == Kind::Disagreement);
    context! {
        headline => text::headline(data),
        runs => data.runs.as_ref().map(runs),
        answers => text::answers(data),
        lead => text::lead(data),
        warnings => sentences(&|kind| kind.is_warning()),
        evaluated => sentences(&|kind| kind == Kind::Evaluated),
        disagree => disagreements.len(),
        metrics => metrics.iter().map(heading).collect::<Vec<_>>(),
        best => data.best().map(|m| m.method.clone()),
        methods => data.methods.iter().map(|m| method(data, m, &metrics)).collect::<Vec<_>>(),
        mix_row => data.mix().map(|mix| method(data, &mix_row(data, mix), &metrics)),
        common => common(data),
        further => others.then(|| context! { disagreements }),
        tuned_once => once(data, false).join(", "),
        learned_once => once(data, true).join(", "),
        overall => figure("overall"),
        any_failed => data.failed().count() > 0,
        learning => figure("learning"),
        training => training(data),
        distribution => figure("distribution"),
        regimes => data.regimes.iter().map(|r| r.heading.to_vec()).collect::<Vec<_>>(),
        shares => data.shares.iter().map(|s| s.heading.to_vec()).collect::<Vec<_>>(),
        failures => data.failed().take(FAILURE_ROWS).map(|r| failed_task(data, r)).collect::<Vec<_>>(),
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
        first => of(Slot::First),
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
    let (points, methods) = data.common.as_ref()?;
    let caption = format!(
        "{} the fair comparison while some methods have no results on some point MDPs. Weights are scaled to sum to 1.",
        text::common_title(*points, methods.len())
    );
    Some(ranking(data, methods, *points).html(&caption))
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
            table => trainings(data).html(&caption),
            single => curves.len() < 2,
            points,
            few => FEW_TRAININGS,
            smoothed => SMOOTHED_OVER,
            validated => learners.iter().any(|l| l.validated > 0),
            failed => learners.iter().map(|l| l.failed).sum::<usize>(),
        }
    })
}

fn failed_task(data: &Report, row: &TaskScore) -> Value {
    context! {
        method => &data.manifest.identity.methods[row.method],
        point => data.called(&data.points[row.point].row.point),
        replicate => row.replicate,
        reason => row.reason.as_deref().unwrap_or("no reason was recorded"),
    }
}

const ALL: &str = include_str!("templates/all.html");

/// Returns the section; `None` where no point MDP has a result, and in a comparison, whose files have the rows.
fn all(data: &Report) -> Result<Option<String>, ReportError> {
    if data.runs.is_some() || data.winners.iter().all(Option::is_none) {
        return Ok(None);
    }
    render("all.html", ALL, all_values(data)).map(Some).map_err(ReportError::Template)
}

/// Returns what the section is called.
fn all_title(data: &Report) -> String {
    match data.sections.spots(data) {
        Some(_) => format!("All {}s", data.words.instance),
        None => "All point MDPs".to_owned(),
    }
}

fn all_values(data: &Report) -> Value {
    let placed = data.sections.spots(data);
    let (is_placed, linked) =
        (placed.is_some(), placed.iter().flatten().any(|spot| spot.dot.is_some()));
    let spots = placed.unwrap_or_else(|| data.points.iter().map(|p| of_point(data, p)).collect());
    let columns = &data.manifest.identity.features;
    let first = if is_placed { data.words.instance.as_str() } else { "point MDP" };
    let probable = data.winners.iter().flatten().any(|w| w.probability.is_some());
    let failure = data.failure.as_ref().filter(|_| fails_known(data)).map(limit_in_words);
    context! {
        title => all_title(data),
        says => data.sections.says(About::Worst, data),
        first => format::capitalised(first),
        linked,
        amount => data.words.amount.as_str(),
        unit => data.words.unit.as_str(),
        met => data.words.met.as_str(),
        instance => data.words.instance.as_str(),
        resamples => RESAMPLES,
        seeds => data.manifest.identity.evaluation_seeds.len(),
        few => data.manifest.identity.evaluation_seeds.len() < FEW_SEEDS,
        replicated => data.manifest.identity.replicates > 1,
        once => trained_once(data).join(", "),
        probable,
        failure,
        cells => data.sections.point_columns(data).join(", ").to_lowercase(),
        methods => &data.manifest.identity.methods,
        features => columns.iter().map(heading).collect::<Vec<_>>(),
        count => spots.len(),
        rows => spots.iter().enumerate().map(|(i, s)| row(data, i, s)).collect::<Vec<_>>(),
    }
}

/// Whether it is known of any winner whether it fails.
fn fails_known(data: &Report) -> bool {
    let of = |(p, w): (&PointSummary, &Option<Winner>)| data.fails(p, w.as_ref()?.best);
    data.points.iter().zip(&data.winners).any(|pair| of(pair).is_some())
}

fn heading(feature: &Feature) -> [String; 2] {
    [format::words(&feature.name, &feature.unit), feature.unit.clone()]
}

fn of_point(data: &Report, p: &PointSummary) -> Spot {
    let name = data.title_of(&p.row.point);
    let stands_for = data.sections.stands_for(&p.row);
    let detail = match name == p.row.point {
        true => stands_for,
        false => format!("{}, {stands_for}", p.row.point),
    };
    Spot { name, detail, point: Some(p.index), dot: None, withheld: None }
}

fn detail(spot: &Spot, winner: Option<&Winner>) -> String {
    let given = winner.is_some_and(|w| w.probability.is_some());
    match spot.withheld.filter(|_| given) {
        Some(why) => format!("{}; no probability, because {why}", spot.detail),
        None => spot.detail.clone(),
    }
}

fn row(data: &Report, number: usize, spot: &Spot) -> Value {
    let point = spot.point.map(|index| &data.points[index]);
    let winner = point.and_then(|p| data.winners[p.index].as_ref());
    let methods = &data.manifest.identity.methods;
    let value = |m: usize| {
        let Some(result) = point.and_then(|p| p.results[m].as_ref()) else { return dash() };
        let mut text = data.words.value(result.objective);
        for cell in data.sections.point_cells(data, result) {
            text.push(' ');
            text.push_str(&cell);
        }
        text
    };
    let ahead = |w: &Winner| {
        let objective = |m: usize| Some(point?.results[m].as_ref()?.objective);
        let next = objective(w.runner_up?)?;
        Some(data.words.value((next - objective(w.best)?).abs()))
    };
    let features = point.map(|p| p.row.features.as_slice()).unwrap_or_default();
    let known = features.iter().map(|f| format::feature(*f));
    let missing = data.manifest.identity.features.len() - features.len();
    context! {
        id => format!("row-{number}"),
        dot => spot.dot.map(|dot| format!("dot-{dot}")),
        name => spot.name.as_str(),
        detail => detail(spot, winner),
        best => winner.map_or_else(dash, |w| methods[w.best].clone()),
        probability => probability(winner.filter(|_| spot.withheld.is_none())),
        decided => decided(winner),
        fails => match point.zip(winner).and_then(|(p, w)| data.fails(p, w.best)) {
            Some(true) => "yes".to_owned(),
            Some(false) => "no".to_owned(),
            None => dash(),
        },
        ahead => winner.and_then(ahead).unwrap_or_else(dash),
        values => (0..methods.len()).map(value).collect::<Vec<_>>(),
        features => known.chain((0..missing).map(|_| dash())).collect::<Vec<_>>(),
    }
}

fn probability(winner: Option<&Winner>) -> String {
    winner.and_then(|w| w.probability).map_or_else(dash, certain)
}

/// Says whether the leads of a winner are more than chance.
fn decided(winner: Option<&Winner>) -> String {
    match winner {
        Some(w) if w.lead.is_some() => if w.is_decided { "yes" } else { "open" }.to_owned(),
        _ => dash(),
    }
}

fn dash() -> String {
    "\u{2013}".to_owned()
}

/// Returns the section; `None` where no two methods have a result on the same point MDP.
fn sure(data: &Report, figures: &[Figure]) -> Result<Option<String>, ReportError> {
    if data.comparison.pairs.is_empty() {
        return Ok(None);
    }
    render("sure.html", SURE, sure_values(data, figures)).map(Some).map_err(ReportError::Template)
}

fn sure_values(data: &Report, figures: &[Figure]) -> Value {
    let figure = |name: &str| figures.iter().find(|f| f.name == name).map(|f| f.svg.clone());
    let pairs = &data.comparison.pairs;
    let many = pairs.len() > MOST_PAIRS;
    let neighbours = |p: &&Pair| !many || p.second == p.first + 1;
    let met = &data.words.met;
    let caption = match many {
        true => format!(
            "Neighbours in the ranking: the lead of a method over the next one, on the same point MDPs and {met}. All {} \
             pairs are below.",
            pairs.len()
        ),
        false => format!(
            "Every pair of methods, the better one first, with its lead on the same point MDPs and {met}. Full precision: \
             pairs.csv."
        ),
    };
    context! {
        answer => text::answer(data),
        covers => text::covers(data),
        met => data.words.met.as_str(),
        resamples => data.manifest.identity.sample.resamples(RESAMPLES),
        ranks => figure("ranks"),
        pairs => tables::pairs(data, pairs.iter().filter(neighbours)).html(&caption),
        matrix => many.then(|| {
            tables::matrix(data).html(
                "By how much the method of a row is ahead of that of a column, with the 95% interval; open where it \
                 contains 0. Full precision: pairs.csv.",
            )
        }),
        count => pairs.len(),
        left_out => data.unranked().map(|m| m.method.clone()).collect::<Vec<_>>().join(", "),
    }
}

fn names(data: &Report, methods: &[usize]) -> String {
    let all: Vec<&str> = methods.iter().map(|m| data.methods[*m].method.as_str()).collect();
    all.join(" and ")
}

/// Returns the section of the page: what it consists of, and what smaller mixes reach.
fn mix(data: &Report, mix: &Mix) -> String {
    let rows = mix.methods.iter().zip(&mix.shares);
    let is_best = |m: usize| move |p: &&MixPoint| p.method == m;
    let columns = Columns::new()
        .text("", "Method", |(m, _): &(&usize, &f64)| data.methods[**m].method.clone())
        .shown("Share of the mix", |(_, share)| Cell::number(**share, format::percent))
        .shown("Point MDPs", |(m, _)| Cell::count(mix.points.iter().filter(is_best(**m)).count()));
    let smaller: Vec<String> = (mix.smaller.iter())
        .map(|(set, score)| {
            let size = if set.len() == 2 { "two" } else { "three" };
            format!(
                "The best {size} are {} with {}.",
                names(data, set),
                format::lead(*score, mix.score.interval).0
            )
        })
        .collect();
    let escape = |text: &str| quick_xml::escape::escape(text).into_owned();
    let caption = "Share of the weight for which a method is chosen, and the point MDPs on which it is the best on all seeds: \
                   mix.csv has which.";
    format!(
        "<p>{} {} No seed scores what it chose. The interval covers choice and scoring.</p>\n<div class=\"scroll\">\n{}</div>\n",
        escape(&mixed(data, mix)),
        escape(&smaller.join(" ")),
        columns.table(rows).html(caption)
    )
}

/// What to cite, as entries of BibTeX. A test compares the first with `CITATION.cff`.
pub const CITATIONS: &str = concat!(
    "@software{tsc-family,\n  title = {tsc-family},\n  author = {{The tsc-family developers}},\n  year = {2026},\n  version = {",
    env!("CARGO_PKG_VERSION"),
    "}\n}\n@inproceedings{jayawardana2022impact,\n  title = {The Impact of Task Underspecification in Evaluating Deep \
     Reinforcement Learning},\n  author = {Jayawardana, Vindula and Tang, Catherine and Li, Sirui and Suo, Dajiang and Wu, \
     Cathy},\n  booktitle = {Advances in Neural Information Processing Systems 35},\n  year = {2022}\n}\n"
);

/// Returns what the run was, by name.
fn provenance(data: &Report) -> Vec<Value> {
    let (i, p) = (&data.manifest.identity, &data.manifest.provenance);
    let seeds: Vec<_> = i.evaluation_seeds.iter().map(u64::to_string).collect();
    let own = i.controllers.iter().map(|own| (format!("controller {}", own.name), told(own)));
    [
        ("command", p.command.clone()),
        ("tsc-family", format!("{} (git {}, {})", i.tsc_family, p.git, p.rustc)),
        ("builds", data.results.several_builds().unwrap_or_default()),
        ("simulator", i.simulator.clone()),
        ("host", p.host.clone()),
        ("started", p.started.clone()),
        ("networks", p.networks.clone()),
        ("base seed", i.base_seed.to_string()),
        ("evaluation seeds", seeds.join(", ")),
        ("sampling", format!("{}, seed {}", data.sampling(), i.sample.seed)),
        ("manifest sha256", data.results.sha256.clone()),
        ("schema version", i.schema_version.to_string()),
    ]
    .into_iter()
    .map(|(name, value)| (name.to_owned(), value))
    .chain(runs_of(data))
    .chain(own)
    .filter(|(_, value)| !value.is_empty())
    .map(|(name, value)| context! { name, value })
    .collect()
}

fn runs_of(data: &Report) -> impl Iterator<Item = (String, String)> {
    let sources = data.runs.iter().flat_map(|runs| &runs.sources);
    sources.map(|(name, path, manifest)| {
        (format!("run {name}"), format!("{path}, manifest sha256 {}", manifest.sha256()))
    })
}

/// Returns the settings of the run, or of each run that is compared.
fn settings(data: &Report) -> String {
    let of_run = || data.manifest.identity.settings.clone();
    let of_each = |runs: &Runs| {
        runs.sources
            .iter()
            .map(|(name, _, m)| (name.clone(), m.identity.settings.clone()))
            .collect()
    };
    let mut settings = data.runs.as_ref().map_or_else(of_run, of_each);
    shorten(&mut settings);
    serde_json::to_string_pretty(&settings).expect("JSON read from a manifest can be written")
}

/// Writes numbers that were given in single precision as they were given: 0.99, not 0.9900000095367432.
fn shorten(value: &mut Json) {
    match value {
        Json::Object(fields) => fields.values_mut().for_each(shorten),
        Json::Array(values) => values.iter_mut().for_each(shorten),
        Json::Number(number) if number.is_f64() => {
            let full = number.as_f64().unwrap_or_default();
            let single = full as f32;
            let short: Option<f64> = single.to_string().parse().ok();
            if let Some(short) = short.filter(|_| f64::from(single) == full) {
                *value = json!(short);
            }
        }
        _ => {}
    }
}

fn told(own: &OwnMethod) -> String {
    let files = own.sha256.iter().map(|(file, sha256)| format!("{file} {sha256}"));
    let versions = own.versions.iter().map(|(what, version)| format!("{what} {version}"));
    let about = [format!("{} ({})", own.source, own.kind.in_words()), own.summary.clone()];
    let parts = about.into_iter().chain(files).chain(versions).filter(|part| !part.is_empty());
    parts.collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_single_precision_are_written_as_they_were_given() {
        let mut settings = json!({"gamma": 0.99f32, "list": [0.1f32, 0.1f64, 2.5], "episodes": 100, "small": 1e-9});
        shorten(&mut settings);
        let text = settings.to_string();
        assert_eq!(text, r#"{"episodes":100,"gamma":0.99,"list":[0.1,0.1,2.5],"small":1e-9}"#);
    }
}

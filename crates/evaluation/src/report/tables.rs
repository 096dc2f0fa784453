//! The tables of a report: the ranking for `summary.csv`, lines of JSON, terminals and LaTeX; summaries beside the score; pairs,
//! places and profiles; trainings; the mix; a row per task and per episode.

use serde_json::{Map, Value};

use super::csv::{Titled, number};
use super::figures::{label, learning_csv as learning};
use super::format;
use super::sections::Table;
use super::table::{Cell, Columns, Table as Cells};
use super::whole::Report;
use crate::analysis::{
    Decided, EpisodeSummary, Estimated, LearnerSummary, MethodSummary, Mix, MixPoint, Pair,
    Summaries, TaskScore, TrainingSummary,
};
use crate::store::record::{Metrics, Outcome, Row};

/// The columns of the ranking.
type Of<'a> = Columns<'a, &'a MethodSummary>;

/// Returns methods over some point MDPs, in their order.
pub(super) fn ranking(data: &Report, methods: &[MethodSummary], points: usize) -> Cells {
    let identity = &data.manifest.identity;
    let relative = !data.reference.is_none();
    let rank = |m: &&MethodSummary| m.rank.map_or_else(Cell::unknown, Cell::count);
    let mut columns: Of<'_> = Columns::new()
        .shown("rank", rank)
        .text("method", "", |m: &&MethodSummary| m.method.clone())
        .text("", "method", |m| match m.is_reference {
            true => data.reference.marked(),
            false => m.method.clone(),
        })
        .file("rank", rank)
        .column("overall", "score", |m| {
            Cell::number(m.overall, |v| format::score_within(v, m.interval))
        })
        .file("overall_low", |m| Cell::exact(m.interval.map(|i| i.0)))
        .file("overall_high", |m| Cell::exact(m.interval.map(|i| i.1)))
        .shown("95% interval", |m| match m.interval {
            _ if m.is_reference && m.overall.is_some() => Cell::text("by definition"),
            interval => interval.map_or_else(Cell::unknown, |i| Cell::text(format::interval(i))),
        })
        // Without a reference the score is the objective.
        .column(
            &*identity.objective,
            if relative { data.words.column() } else { String::new() },
            |m| Cell::number(m.objective, |v| data.words.value(v)),
        );
    for metric in data.sections.metrics(Table::Summary, data) {
        let name = metric.name.clone();
        columns = columns.file(metric.name, move |m| Cell::exact(m.metrics.get(&name).copied()));
    }
    columns = columns
        .file("worst_point", |m: &&MethodSummary| {
            m.worst.as_ref().map_or_else(Cell::unknown, |w| Cell::text(&*w.0))
        })
        .file("worst_score", |m| Cell::exact(m.worst.as_ref().map(|w| w.1)))
        .shown("worst", |m| {
            let worst = m.worst.as_ref().filter(|_| !m.is_reference);
            Cell::number(worst.map(|w| w.1), format::score)
        })
        .file("points", |m| Cell::count(m.points))
        .shown("points", move |m| Cell::text(format!("{}/{points}", m.points)))
        .column("failed", "failed", |m| Cell::count(m.failed))
        .file("missing", |m| Cell::count(m.missing))
        .file("sampling", |_| Cell::text(data.sampling()))
        .file("budget", |_| Cell::parsed(&identity.sample.budget.to_string()))
        .file("family_size", |_| Cell::parsed(&identity.sample.family_size.to_string()))
        .file("evaluation_seeds", |_| Cell::parsed(&identity.evaluation_seeds.len().to_string()))
        .text("against", "", |_| data.reference.name.clone());
    if relative {
        columns = estimated(columns, "ratio_of_means", |m| m.summaries.ratio_of_means);
    }
    columns = estimated(columns, "median", |m| m.summaries.median);
    if relative {
        columns = estimated(columns, "geometric_mean", |m| m.summaries.geometric_mean);
    }
    for (i, regime) in data.regimes.iter().enumerate() {
        columns = estimated(columns, regime.name, move |m| {
            m.summaries.by_regime.get(i).copied().flatten()
        });
    }
    for (name, text) in data.sections.summary_columns(data) {
        columns = columns.file(name, move |_| Cell::parsed(&text));
    }
    columns = of_episodes(columns, data, |m| &m.episodes);
    columns = estimated(columns, "iqm", |m| m.summaries.interquartile_mean);
    let tuned = |n: Option<usize>| n.map_or_else(Cell::unknown, Cell::count);
    columns = columns
        .file("points_tuned", move |m: &&MethodSummary| tuned(m.tuning.map(|(_, all)| all)))
        .file("points_not_improved", move |m| tuned(m.tuning.map(|(kept, _)| kept)));
    columns.table(methods)
}

/// Adds the columns of a summary with its interval.
fn estimated<'a>(
    columns: Of<'a>,
    name: &str,
    of: impl Fn(&MethodSummary) -> Option<Estimated> + Copy + 'a,
) -> Of<'a> {
    let end = move |m: &MethodSummary| of(m).and_then(|e| e.interval);
    columns
        .file(name, move |m| Cell::exact(of(m).map(|e| e.value)))
        .file(format!("{name}_low"), move |m| Cell::exact(end(m).map(|i| i.0)))
        .file(format!("{name}_high"), move |m| Cell::exact(end(m).map(|i| i.1)))
}

impl Report {
    /// Returns the ranking of all methods, and the mix below it.
    pub fn ranking(&self) -> Cells {
        let mut methods = self.methods.clone();
        methods.extend(self.mix().map(|mix| mix_row(self, mix)));
        ranking(self, &methods, self.points.len())
    }

    /// Returns the methods as `--json` prints them, best first; `null` is what is not known.
    pub fn json_rows(&self) -> Vec<Map<String, Value>> {
        let mut rows = self.ranking().json();
        for (i, row) in rows.iter_mut().enumerate() {
            let places = self.comparison.ranks.as_ref().and_then(|ranks| ranks.get(i));
            row.insert("rank_probabilities".to_owned(), places.cloned().into());
            if let Some(mix) = self.mix().filter(|_| i == self.methods.len()) {
                let names = mix.methods.iter().map(|m| self.methods[*m].method.clone());
                let shares = names.zip(mix.shares.iter().map(|share| (*share).into()));
                row.insert("mix_shares".to_owned(), Value::Object(shares.collect()));
            }
        }
        rows
    }
}

/// Returns the further summaries of the methods that have an estimate, in the order of the ranking; no rows where only what
/// scores are divided by has one.
pub(super) fn summaries(data: &Report) -> Cells {
    let value = |e: Option<Estimated>| Cell::number(e.map(|e| e.value), format::score);
    let absolute = data.reference.is_none();
    let mut columns = Columns::new().text("", "method", |m: &&MethodSummary| m.method.clone());
    if !absolute {
        columns = columns.shown("ratio", move |m| value(m.summaries.ratio_of_means));
    }
    columns = columns.shown("median", move |m| value(m.summaries.median));
    if !absolute {
        columns = columns.shown("geometric", move |m| value(m.summaries.geometric_mean));
    }
    for (i, regime) in data.regimes.iter().enumerate() {
        let of = move |m: &&MethodSummary| value(m.summaries.by_regime.get(i).copied().flatten());
        columns = columns.shown(regime.short, of);
    }
    for (i, share) in data.shares.iter().enumerate() {
        let of = move |m: &&MethodSummary| Cell::number(m.episodes.shares[i], format::percent);
        columns = columns.shown(share.short, of);
    }
    columns = columns.shown("worst", move |m| {
        let e = &m.episodes;
        Cell::number(if absolute { e.worst } else { e.worst_relative }, format::score)
    });
    let shown = data.methods.iter().filter(|m| m.overall.is_some());
    let others = shown.clone().any(|m| !m.is_reference);
    columns.table(shown.filter(|_| others))
}

/// Returns pairs of methods with their differences.
pub(super) fn pairs<'a>(data: &'a Report, pairs: impl IntoIterator<Item = &'a Pair>) -> Cells {
    let pairs: Vec<&Pair> = pairs.into_iter().collect();
    let name = |m: usize| data.methods[m].method.clone();
    let range = |(low, high): (f64, f64)| {
        (low != high).then(|| format!("{} to {}", format::percent(low), format::percent(high)))
    };
    let better = move |p: &&Pair| match p.decided() {
        Decided::First => name(p.first),
        Decided::Second => name(p.second),
        Decided::Open => "open".to_owned(),
        Decided::Unknown => String::new(),
    };
    let differ = pairs.iter().any(|p| p.points != data.points.len());
    let columns = Columns::new()
        .text("method", "", move |p: &&Pair| name(p.first))
        .text("other", "", move |p| name(p.second))
        .text("", "method", |p| label(data, &data.methods[p.first]))
        .text("", "other", |p| label(data, &data.methods[p.second]))
        .column("points", if differ { "point MDPs" } else { "" }, |p| Cell::count(p.points))
        .column("ahead", "ahead by", |p| {
            let (ahead, interval) = format::lead(p.ahead.value, p.ahead.interval);
            Cell::number(p.ahead.value, |_| ahead).above(interval)
        })
        .file("ahead_low", |p| Cell::exact(p.ahead.interval.map(|i| i.0)))
        .file("ahead_high", |p| Cell::exact(p.ahead.interval.map(|i| i.1)))
        .column("improvement", "probability of improvement", move |p| {
            let below = p.improvement.interval.and_then(range);
            Cell::number(p.improvement.value, format::percent).above(below)
        })
        .file("improvement_low", |p| Cell::exact(p.improvement.interval.map(|i| i.0)))
        .file("improvement_high", |p| Cell::exact(p.improvement.interval.map(|i| i.1)))
        .text("better", "better", better)
        .text("against", "", |_| data.reference.name.clone());
    columns.table(pairs)
}

/// Returns by how much each ranked method is ahead of each one behind it, in the order of the ranking.
pub(super) fn matrix(data: &Report) -> Cells {
    let pairs = &data.comparison.pairs;
    let mut columns = Columns::new().text("", "method", |m: &usize| label(data, &data.methods[*m]));
    for other in (1..data.methods.len()).filter(|m| !data.methods[*m].is_reference) {
        columns = columns.shown(data.methods[other].method.as_str(), move |m| {
            let pair = pairs.iter().find(|pair| (pair.first, pair.second) == (*m, other));
            pair.map_or_else(Cell::default, |pair| {
                let (ahead, interval) = format::lead(pair.ahead.value, pair.ahead.interval);
                let open = if pair.decided() == Decided::Open { "open: " } else { "" };
                Cell::number(pair.ahead.value, |_| ahead)
                    .above(interval.map(|interval| format!("{open}{interval}")))
            })
        });
    }
    columns.table(0..data.methods.len().saturating_sub(1))
}

/// Returns the probability of every place, a row per method and place.
fn places(data: &Report) -> Cells {
    let all = data.comparison.ranks.iter().flatten().zip(&data.methods);
    let rows = all.flat_map(|(of, m)| of.iter().enumerate().map(move |(place, p)| (m, place, *p)));
    Columns::new()
        .text("method", "", |(m, ..): &(&MethodSummary, usize, f64)| m.method.clone())
        .file("rank", |(_, place, _)| Cell::count(place + 1))
        .file("probability", |(.., p)| Cell::exact(*p))
        .text("against", "", |_| data.reference.name.clone())
        .table(rows)
}

/// Returns the performance profiles, a row per method and score.
fn profiles(data: &Report) -> Cells {
    let all = data.methods.iter().zip(&data.comparison.profiles);
    let rows =
        all.flat_map(|(m, steps)| steps.iter().map(move |(score, share)| (m, *score, *share)));
    Columns::new()
        .text("method", "", |(m, ..): &(&MethodSummary, f64, f64)| m.method.clone())
        .file("score", |(_, score, _)| Cell::exact(*score))
        .file("share", |(.., share)| Cell::exact(*share))
        .text("against", "", |_| data.reference.name.clone())
        .table(rows)
}

pub(super) fn trainings(data: &Report) -> Cells {
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

pub(super) fn mix_row(data: &Report, mix: &Mix) -> MethodSummary {
    let worst = mix.points.iter().max_by(|a, b| data.direction().compare(a.score, b.score));
    MethodSummary {
        method: "mix".to_owned(),
        index: data.methods.len(),
        is_reference: false,
        rank: None,
        overall: Some(mix.score.value),
        interval: mix.score.interval,
        summaries: Summaries::default(),
        episodes: EpisodeSummary {
            shares: vec![None; data.shares.len()],
            ..EpisodeSummary::default()
        },
        objective: Some(mix.objective),
        metrics: Metrics::new(),
        worst: worst.map(|p| (data.points[p.index].row.point.clone(), p.score)),
        points: mix.points.len(),
        left_out: 0,
        replicates: 0,
        failed: 0,
        missing: 0,
        without_reference: 0,
        tuning: None,
    }
}

/// Returns which point MDP gets which method.
fn mix_points(data: &Report, mix: &Mix) -> Cells {
    let row = |p: &&MixPoint| &data.points[p.index].row;
    let mut columns = Columns::new()
        .text("point", "", move |p: &&MixPoint| row(p).point.clone())
        .file("weight", |p| Cell::exact(data.points[p.index].weight))
        .text("method", "", |p| data.methods[p.method].method.clone())
        .file("chosen", |p| Cell::exact(p.share))
        .file("score", |p| Cell::exact(p.score));
    if data.titles().is_some() {
        columns = columns.text("title", "", move |p| data.title_of(&row(p).point));
    }
    columns.table(&mix.points)
}

/// Name of the column of the score.
const SCORE: &str = "score";

/// The same where the objective is called so.
const RELATIVE_SCORE: &str = "relative_score";

fn names(data: &Report, table: Table) -> Vec<String> {
    data.sections.metrics(table, data).into_iter().map(|metric| metric.name).collect()
}

fn cells_of<'a>(names: &'a [String], metrics: &'a Metrics) -> impl Iterator<Item = String> + 'a {
    names.iter().map(|name| number(metrics.get(name).copied()))
}

fn score_column(data: &Report) -> Option<&'static str> {
    match (data.manifest.identity.objective == SCORE, data.reference.is_none()) {
        (true, true) => None,
        (true, false) => Some(RELATIVE_SCORE),
        (false, _) => Some(SCORE),
    }
}

/// Returns `scores.csv`: one row per method, point MDP and replicate; without a successful record
/// the metrics are empty.
fn scores(data: &Report) -> String {
    let identity = &data.manifest.identity;
    let objective = identity.objective.as_str();
    let point = |t: &&TaskScore| &data.points[t.point].row;
    let value = |t: &&TaskScore| {
        t.metrics.get(objective).copied().filter(|_| t.outcome == Some(Outcome::Ok))
    };
    let mut columns = Columns::new()
        .text("method", "", |t: &&TaskScore| identity.methods[t.method].clone())
        .text("point", "", move |t| point(t).point.clone())
        .file("importance", move |t| Cell::exact(point(t).importance))
        .file("replicate", |t| Cell::count(t.replicate as usize))
        .file(objective, move |t| Cell::exact(value(t)));
    if !data.reference.is_none() {
        let divisor = if data.reference.is_baseline { "baseline" } else { "against" };
        columns = columns.file(format!("{divisor}_{objective}"), |t| Cell::exact(t.reference));
    }
    if let Some(name) = score_column(data) {
        columns = columns.file(name, |t| Cell::exact(t.score));
    }
    for name in names(data, Table::Scores) {
        columns = columns.file(name.clone(), move |t| Cell::exact(t.metrics.get(&name).copied()));
    }
    for (i, name) in data.sections.score_columns().iter().enumerate() {
        let cell =
            move |t: &&TaskScore| data.sections.score_cells(data, t, value(t)).swap_remove(i);
        columns = columns.text(name, "", cell);
    }
    for (i, feature) in identity.features.iter().enumerate() {
        columns = columns.file(&*feature.name, move |t| Cell::exact(point(t).features[i]));
    }
    let columns = columns.file("weight", |t| Cell::exact(data.points[t.point].weight)).text(
        "against",
        "",
        |_| data.reference.name.clone(),
    );
    titled(columns, data, |t| t.point).table(&data.tasks).csv()
}

/// Adds what point MDPs are called, where that is not their ids.
fn titled<'a, R>(
    columns: Columns<'a, R>,
    data: &'a Report,
    point: impl Fn(&R) -> usize + 'a,
) -> Columns<'a, R> {
    match data.titles() {
        Some(titles) => columns.text("title", "", move |row| titles[point(row)].clone()),
        None => columns,
    }
}

/// Returns `episodes.csv`: one row per episode of training and evaluation, in the order of the plan.
fn episodes(data: &Report) -> String {
    let names = names(data, Table::Episodes);
    let header = ["method", "point", "replicate", "kind", "episode", "seed"]
        .into_iter()
        .chain([data.manifest.identity.objective.as_str()])
        .map(str::to_owned)
        .chain(names.clone())
        .collect::<Vec<_>>();
    let titled = Titled(data.titles());
    let records = data.tasks.iter().zip(data.results.rows());
    let rows = records.flat_map(|(task, (_, record))| {
        record.into_iter().flat_map(move |record| record.rows.iter().map(move |row| (task, row)))
    });
    let row = |(task, row): (&TaskScore, &Row)| {
        titled.row(task.point, episode_row(data, (task, row), &names))
    };
    super::csv::table(&titled.header(header), rows.map(row))
}

fn episode_row(data: &Report, (task, e): (&TaskScore, &Row), names: &[String]) -> Vec<String> {
    let identity = &data.manifest.identity;
    let mut cells = vec![
        identity.methods[task.method].clone(),
        data.points[task.point].row.point.clone(),
        task.replicate.to_string(),
        e.kind.name().to_owned(),
        e.episode.to_string(),
        e.seed.to_string(),
        number(e.metrics.get(&identity.objective).copied()),
    ];
    cells.extend(cells_of(names, &e.metrics));
    cells
}

/// Returns `training.csv`: one row per training; `score` is of the evaluation, the columns of the best and the
/// last episodes are of training, all of them relative to the reference.
fn training(data: &Report) -> String {
    let outcome = |t: &&TrainingSummary| match t.outcome {
        Some(Outcome::Ok) => "ok",
        Some(Outcome::Failed) if t.diverged => "diverged",
        Some(Outcome::Failed) => "failed",
        None => "missing",
    };
    let whole = |n: Option<u32>| n.map_or_else(Cell::unknown, |n| Cell::count(n as usize));
    let [best, last] = data.sections.training_columns()[0];
    let mut columns = Columns::new()
        .text("method", "", |t: &&TrainingSummary| t.method.clone())
        .text("point", "", |t| data.points[t.point].row.point.clone())
        .file("replicate", |t| Cell::count(t.replicate as usize))
        .text("outcome", "", move |t| outcome(t).to_owned())
        .file("episodes", |t| Cell::count(t.episodes))
        .file("score", |t| Cell::exact(t.score))
        .file("policy_row", move |t| whole(t.policy_row))
        .file("last_policy", |t| Cell::exact(t.last_policy))
        .file("restarts", move |t| whole(t.restarts))
        .file("dead", |t| Cell::flag(t.is_dead))
        .file(best, |t| Cell::exact(t.best_episode))
        .file(last, |t| Cell::exact(t.last_episodes));
    for (i, event) in events(data) {
        columns = columns
            .file(event, move |t| Cell::flag(t.evaluations.shares[i].map(|share| share > 0.0)));
    }
    columns = columns
        .file("weight", |t: &&TrainingSummary| Cell::exact(data.points[t.point].weight))
        .text("against", "", |_| data.reference.name.clone());
    let columns = of_episodes(columns, data, |t| &t.evaluations);
    titled(columns, data, |t| t.point).table(&data.trainings).csv()
}

/// Adds the columns that summarise evaluation episodes.
fn of_episodes<'a, R: 'a>(
    mut columns: Columns<'a, R>,
    data: &'a Report,
    of: impl for<'r> Fn(&'r R) -> &'r EpisodeSummary + Copy + 'a,
) -> Columns<'a, R> {
    for (i, share) in data.shares.iter().enumerate() {
        columns = columns.file(share.name, move |row| Cell::exact(of(row).shares[i]));
    }
    let objective = &data.manifest.identity.objective;
    columns = columns
        .file(format!("episode_median_{objective}"), move |row| Cell::exact(of(row).median))
        .file(format!("episode_worst_{objective}"), move |row| Cell::exact(of(row).worst));
    match data.reference.is_none() {
        true => columns,
        false => columns
            .file("episode_median", move |row| Cell::exact(of(row).median_relative))
            .file("episode_worst", move |row| Cell::exact(of(row).worst_relative)),
    }
}

/// Returns what happens in an evaluation episode or does not, with its position among the shares.
fn events(data: &Report) -> impl Iterator<Item = (usize, &'static str)> {
    data.shares.iter().enumerate().filter_map(|(i, share)| Some((i, share.event?)))
}

/// Returns the tables as files, by name: CSV, and LaTeX for papers.
pub(super) fn files(data: &Report) -> Vec<(&'static str, String)> {
    let (of, relative) = (&data.manifest.identity.scenario, data.relative());
    let (noun, better) = (&data.words.noun, data.better());
    let (ranking, pairs) = (data.ranking(), pairs(data, &data.comparison.pairs));
    let latex = [
        (
            "ranking.tex",
            &ranking,
            format!("Methods on {of} by overall performance: {noun}{relative}; {better}"),
        ),
        (
            "summaries.tex",
            &summaries(data),
            format!("Further summaries of the methods on {of}, of {noun}{relative}"),
        ),
        (
            "pairs.tex",
            &pairs,
            format!(
                "Methods on {of} two at a time: by how much one is ahead, and how often it is better"
            ),
        ),
        (
            "training.tex",
            &trainings(data),
            format!("Trainings of the learners on {of}, of {noun}{relative}"),
        ),
    ];
    let latex = latex.into_iter().filter(|(_, table, _)| !table.is_empty());
    let best = |name: &str| name == "ranking.tex" && data.best().is_some();
    let latex = latex.map(|(name, table, about)| (name, table.latex(&about, best(name))));
    let csv = [
        ("scores.csv", Some(scores(data))),
        ("summary.csv", Some(ranking.csv())),
        ("pairs.csv", Some(pairs.csv())),
        ("ranks.csv", Some(places(data).csv())),
        ("profiles.csv", Some(profiles(data).csv())),
        ("mix.csv", data.mix().map(|mix| mix_points(data, mix).csv())),
        ("episodes.csv", Some(episodes(data))),
        ("learning.csv", learning(data)),
        ("training.csv", (!data.trainings.is_empty()).then(|| training(data))),
    ];
    latex.chain(csv.into_iter().filter_map(|(name, text)| Some((name, text?)))).collect()
}

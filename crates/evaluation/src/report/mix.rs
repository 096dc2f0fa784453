//! The mix: its row in the ranking, what it consists of, and which point MDP gets which method.

use super::format;
use super::table::{Cell, Columns, Table};
use super::whole::Report;
use crate::analysis::{EpisodeSummary, MethodSummary, Mix, MixPoint, Summaries};
use crate::store::record::Metrics;

/// What it is called among methods.
pub(super) const NAME: &str = "mix";

/// Returns it as a method of the ranking.
pub(super) fn row(data: &Report, mix: &Mix) -> MethodSummary {
    let worst = mix.points.iter().max_by(|a, b| data.direction().compare(a.score, b.score));
    MethodSummary {
        method: NAME.to_owned(),
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
pub(super) fn table(data: &Report, mix: &Mix) -> Table {
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

fn names(data: &Report, methods: &[usize]) -> String {
    let all: Vec<&str> = methods.iter().map(|m| data.methods[*m].method.as_str()).collect();
    all.join(" and ")
}

/// Says what the mix is, and how it compares with the best method alone.
pub(super) fn sentence(data: &Report, mix: &Mix) -> String {
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

/// Returns the section of the page: what it consists of, and what smaller mixes reach.
pub(super) fn section(data: &Report, mix: &Mix) -> String {
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
        escape(&sentence(data, mix)),
        escape(&smaller.join(" ")),
        columns.table(rows).html(caption)
    )
}

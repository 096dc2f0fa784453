//! The ranking: one table for `summary.csv`, lines of JSON, terminals and LaTeX.

use serde_json::{Map, Value};

use super::sections;
use super::table::{Cell, Columns, Table};
use super::whole::Report;
use super::{csv, format, mix};
use crate::analysis::{Estimated, MethodSummary, TuningSummary};

/// The columns of the ranking.
type Of<'a> = Columns<'a, &'a MethodSummary>;

/// Returns methods over some point MDPs, in their order.
pub(super) fn ranking(data: &Report, methods: &[MethodSummary], points: usize) -> Table {
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
    for metric in data.sections.metrics(sections::Table::Summary, data) {
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
    columns = csv::of_episodes(columns, data, |m| &m.episodes);
    columns = estimated(columns, "iqm", |m| m.summaries.interquartile_mean);
    let tuning = |m: &MethodSummary, of: fn(TuningSummary) -> usize| {
        m.tuning.map_or_else(Cell::unknown, |tuning| Cell::count(of(tuning)))
    };
    columns = columns
        .file("points_tuned", move |m: &&MethodSummary| tuning(m, |t| t.points))
        .file("points_not_improved", move |m| tuning(m, |t| t.kept));
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
    pub fn ranking(&self) -> Table {
        let mut methods = self.methods.clone();
        methods.extend(self.mix().map(|mix| mix::row(self, mix)));
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

//! What came of a study of estimators: a table for terminals, and `errors.csv`.

use clap::ValueEnum;

use super::format;
use super::table::{Cell, Columns, Table};
use crate::study;
use crate::study::{Kind, Recorded, RecordedMethod, StudyPlan};

/// Returns root-mean-square errors with the coverage of intervals, a row per method and estimator.
pub fn text(recorded: &Recorded, plan: &StudyPlan, cells: &[study::Cell]) -> String {
    let kinds = || plan.kinds.iter().copied();
    let rows = recorded.methods.iter().flat_map(|m| kinds().map(move |kind| (m, kind)));
    let title = |kind: Kind| kind.to_possible_value()?.get_help().map(ToString::to_string);
    let mut columns = Columns::new()
        .text("", "method", |(m, _): &(&RecordedMethod, Kind)| m.name.clone())
        .shown("overall", |(m, _)| Cell::number(recorded.truth(m), format::score))
        .text("", "estimator", move |(_, kind)| title(*kind).unwrap_or_default());
    for budget in &plan.budgets {
        columns = columns.shown(format!("N = {budget}"), move |(m, kind)| {
            let is =
                |c: &&study::Cell| c.kind == *kind && c.method == m.name && c.budget == *budget;
            let cell = cells.iter().find(is);
            let coverage = cell.and_then(|c| c.coverage).map(|c| format!("{c:.2}"));
            Cell::number(cell.map(|c| c.error), |e| format!("{e:.4}")).above(coverage)
        });
    }
    format!(
        "Root-mean-square error of the overall performance over {} samples, and how often its 95% interval \
         contains it:\n\n{}",
        plan.repeats,
        columns.table(rows).plain()
    )
}

/// Returns what came of it, a row per estimator, budget and method.
pub fn errors(cells: &[study::Cell]) -> Table {
    Columns::new()
        .text("method", "", |c: &&study::Cell| c.method.clone())
        .text("estimator", "", |c| c.kind.name())
        .file("budget", |c| Cell::count(c.budget))
        .file("repeats", |c| Cell::count(c.repeats))
        .file("truth", |c| Cell::exact(c.truth))
        .file("mean", |c| Cell::exact(c.mean))
        .file("deviation", |c| Cell::exact(c.deviation))
        .file("rmse", |c| Cell::exact(c.error))
        .file("coverage", |c| Cell::exact(c.coverage))
        .file("half_width", |c| Cell::exact(c.half_width))
        .file("cpu_hours", |c| Cell::exact(c.cpu_hours))
        .table(cells)
}

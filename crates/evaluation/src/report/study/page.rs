//! The page of a study.

use minijinja::{Value, context};

use super::StudyReport;
use super::stopping;
use super::table::RIGHT;
use crate::report::error::ReportError;
use crate::report::figure::Figure;
use crate::report::format;
use crate::report::page::render;
use crate::study::{Cell, Kind};

const TEMPLATE: &str = include_str!("../templates/study.html");

/// Returns the page.
pub(super) fn html(report: &StudyReport<'_>, figure: &Figure) -> Result<String, ReportError> {
    render("study.html", TEMPLATE, values(report, figure)).map_err(ReportError::Template)
}

fn values(report: &StudyReport<'_>, figure: &Figure) -> Value {
    let identity = &report.analysis.manifest.identity;
    context! {
        scenario => identity.scenario.clone(),
        headline => headline(report),
        notes => report.notes(),
        repeats => report.plan.repeats,
        seed => report.plan.seed,
        size => report.recorded.family.points.len(),
        budgets => report.plan.budgets.clone(),
        methods => methods(report),
        stopping => stopping::values(report),
        figure => figure.svg.clone(),
        manifest => report.analysis.results.sha256.clone(),
        version => env!("CARGO_PKG_VERSION"),
    }
}

/// Says which estimator misses least, over methods and budgets.
fn headline(report: &StudyReport<'_>) -> String {
    let mean = |kind: Kind| {
        let ratios: Vec<f64> = (report.cells.iter())
            .filter(|c| c.kind == kind)
            .filter_map(|c| {
                let all = report.cells.iter();
                let same = all.filter(|o| o.method == c.method && o.budget == c.budget);
                let least = same.map(|o| o.error).fold(f64::INFINITY, f64::min);
                (least > 0.0).then(|| (c.error / least).ln())
            })
            .collect();
        ratios.iter().sum::<f64>() / ratios.len().max(1) as f64
    };
    let best = report.plan.kinds.iter().copied().min_by(|a, b| mean(*a).total_cmp(&mean(*b)));
    match best {
        Some(best) if report.plan.kinds.len() > 1 => format!("Least error: {}", best.title()),
        _ => "What estimates miss".to_owned(),
    }
}

fn methods(report: &StudyReport<'_>) -> Vec<Value> {
    let of = |method: &crate::study::RecordedMethod| {
        let rows: Vec<Value> = (report.plan.kinds.iter())
            .map(|kind| {
                let cells = report.cells_of(*kind, &method.name);
                let cells: Vec<Value> = cells.iter().map(|c| cell(report, c)).collect();
                context! { estimator => kind.title(), cells }
            })
            .collect();
        let truth = format::score(report.recorded.truth(method));
        context! { name => method.name.clone(), truth, learns => method.learns, rows }
    };
    report.recorded.methods.iter().map(of).collect()
}

fn cell(report: &StudyReport<'_>, cell: &Cell) -> Value {
    let others = report.cells.iter();
    let m3 = others
        .filter(|o| o.kind == Kind::M3 && o.method == cell.method && o.budget == cell.budget)
        .map(|o| o.error)
        .find(|error| *error > 0.0 && cell.kind != Kind::M3);
    context! {
        error => format!("{:.4}", cell.error),
        ratio => m3.map(|error| format!("{:.2} of M3", cell.error / error)),
        bias => format!("{:+.4}", cell.mean - cell.truth),
        coverage => cell.coverage.map(|c| format!("{:.0}%", 100.0 * c)),
        is_off => cell.coverage.is_some_and(|c| !RIGHT.contains(&c)),
        half => cell.half_width.map(|h| format!("{h:.3}")),
        hours => cell.cpu_hours.map(|h| if h < 0.1 { format!("{:.1} min", 60.0 * h) } else { format!("{h:.1} h") }),
    }
}

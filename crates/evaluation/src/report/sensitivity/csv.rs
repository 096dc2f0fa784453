//! The tables of a sensitivity; a cell is empty where nothing is known.

use super::shown::SensitivityReport;
use crate::report::csv::{number, table};

/// Returns the tables by name; `None` for one that this question has none of.
pub(super) fn tables(report: &SensitivityReport<'_>) -> [(&'static str, Option<String>); 6] {
    [
        ("distributions.csv", Some(distributions(report))),
        ("weights.csv", Some(weights(report))),
        ("ranks.csv", Some(ranks(report))),
        ("failures.csv", failures(report)),
        ("reported.csv", reported(report)),
        ("cases.csv", cases(report)),
    ]
}

/// A row per distribution and method.
fn distributions(report: &SensitivityReport<'_>) -> String {
    let names = ["distribution", "method", "overall", "rank", "effective_points"];
    let methods = &report.data.board.methods;
    let rows = report.data.distributions.iter().flat_map(|d| {
        methods.iter().enumerate().map(|(m, method)| {
            let (overall, rank) = (d.overall[m].to_string(), d.ranks[m].to_string());
            vec![d.name.clone(), method.clone(), overall, rank, d.effective().to_string()]
        })
    });
    table(&names, rows)
}

/// A row per point MDP, a column per distribution.
fn weights(report: &SensitivityReport<'_>) -> String {
    let names = report.data.distributions.iter().map(|d| d.name.clone());
    let header: Vec<String> = std::iter::once("point".to_owned()).chain(names).collect();
    let rows = report.data.board.points.iter().enumerate().map(|(i, point)| {
        let weights = report.data.distributions.iter().map(|d| d.weights[i].to_string());
        std::iter::once(point.id.clone()).chain(weights).collect()
    });
    table(&header, rows)
}

/// A row per method: how often it takes which rank under random distributions.
fn ranks(report: &SensitivityReport<'_>) -> String {
    let (methods, random) = (&report.data.board.methods, &report.data.random);
    let mut header = vec!["method".to_owned()];
    header.extend((1..=methods.len()).map(|rank| format!("rank_{rank}")));
    header.extend(
        ["overall_low", "overall_high", "distributions", "concentration", "seed"]
            .map(str::to_owned),
    );
    let rows = methods.iter().enumerate().map(|(m, method)| {
        let mut row = vec![method.clone()];
        row.extend(random.shares[m].iter().map(f64::to_string));
        row.extend([number(random.range[m].map(|r| r.0)), number(random.range[m].map(|r| r.1))]);
        row.push(crate::analysis::sensitivity::RANDOM.to_string());
        row.extend([random.concentration.to_string(), random.seed.to_string()]);
        row
    });
    table(&header, rows)
}

/// A row per failure.
fn failures(report: &SensitivityReport<'_>) -> Option<String> {
    let failures = report.data.failures.as_ref()?;
    let (points, methods) = (&report.report.points, &report.report.manifest.identity.methods);
    let rows = failures.methods.iter().flat_map(|of| {
        let m = methods.iter().position(|name| *name == of.method);
        of.points.iter().map(move |p| {
            let result = m.and_then(|m| points[*p].results[m].as_ref());
            vec![
                of.method.clone(),
                points[*p].row.point.clone(),
                number(result.and_then(|r| r.metrics.get(&failures.limit.metric).copied())),
                number(result.and_then(|r| r.score)),
                points[*p].weight.to_string(),
            ]
        })
    });
    let names = ["method", "point", failures.limit.metric.as_str(), "score", "weight"];
    Some(table(&names, rows))
}

/// A row per reported value and method.
fn reported(report: &SensitivityReport<'_>) -> Option<String> {
    let all = &report.data.reported;
    if all.is_empty() {
        return None;
    }
    let names = ["reported", "method", "score", "rank", "overall", "overall_rank"];
    let (methods, overall) = (&report.data.board.methods, report.data.overall());
    let rows = all.iter().flat_map(|r| {
        methods.iter().enumerate().map(|(m, method)| {
            vec![
                r.name.clone(),
                method.clone(),
                number(r.scores[m]),
                number(r.ranks[m]),
                overall.overall[m].to_string(),
                number(r.overall_ranks[m]),
            ]
        })
    });
    Some(table(&names, rows))
}

/// A row per case, estimator, budget and method.
fn cases(report: &SensitivityReport<'_>) -> Option<String> {
    if report.cases.is_empty() {
        return None;
    }
    let names = [
        "case", "failures", "estimator", "method", "budget", "repeats", "overall", "mean",
        "deviation", "error",
    ];
    let rows = report.cases.iter().flat_map(|study| {
        study.cells.iter().map(|cell| {
            vec![
                study.case.number().to_string(),
                study.failures.to_string(),
                cell.kind.name().to_owned(),
                cell.method.clone(),
                cell.budget.to_string(),
                cell.repeats.to_string(),
                cell.truth.to_string(),
                cell.mean.to_string(),
                cell.deviation.to_string(),
                cell.error.to_string(),
            ]
        })
    });
    Some(table(&names, rows))
}

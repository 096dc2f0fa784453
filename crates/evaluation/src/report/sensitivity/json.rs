//! The lines of `sensitivity --json`.

use serde_json::{Map, Value, json};

use super::shown::SensitivityReport;
use crate::analysis::sensitivity::{Distribution, RANDOM, Reversal};

/// Returns a line per distribution, method with its random ranks, method with its failures, and reported value.
pub(super) fn lines(report: &SensitivityReport<'_>) -> Vec<Value> {
    let (data, methods) = (report.data, &report.data.board.methods);
    let mut lines: Vec<Value> =
        data.distributions.iter().map(|d| distribution(report, d)).collect();
    let random = &data.random;
    for (m, method) in methods.iter().enumerate() {
        let mut row = Map::new();
        row.insert("event".to_owned(), "ranks".into());
        row.insert("method".to_owned(), method.clone().into());
        for (r, share) in random.shares[m].iter().enumerate() {
            row.insert(format!("rank_{}", r + 1), (*share).into());
        }
        row.insert("overall_low".to_owned(), random.range[m].map(|r| r.0).into());
        row.insert("overall_high".to_owned(), random.range[m].map(|r| r.1).into());
        row.insert("distributions".to_owned(), RANDOM.into());
        row.insert("concentration".to_owned(), random.concentration.into());
        lines.push(Value::Object(row));
    }
    for of in data.failures.iter().flat_map(|f| &f.methods) {
        lines.push(json!({
            "event": "failures",
            "method": of.method,
            "limit": data.failures.as_ref().map(|f| f.limit.to_string()),
            "points": of.points.len(),
            "known": of.known,
            "importance": of.importance,
        }));
    }
    for r in &data.reported {
        lines.push(json!({
            "event": "reported",
            "reported": r.name,
            "scores": by_method(methods, |m| r.scores[m].into()),
            "ranks": by_method(methods, |m| r.ranks[m].into()),
            "overall_ranks": by_method(methods, |m| r.overall_ranks[m].into()),
            "reversals": pairs(&r.reversals),
        }));
    }
    for study in report.cases {
        lines.extend(study.cells.iter().map(|cell| {
            json!({
                "event": "case",
                "case": study.case.number(),
                "failures": study.failures,
                "estimator": cell.kind.name(),
                "method": cell.method,
                "budget": cell.budget,
                "repeats": cell.repeats,
                "overall": cell.truth,
                "mean": cell.mean,
                "deviation": cell.deviation,
                "error": cell.error,
            })
        }));
    }
    lines
}

fn distribution(report: &SensitivityReport<'_>, d: &Distribution) -> Value {
    let methods = &report.data.board.methods;
    json!({
        "event": "distribution",
        "distribution": d.name,
        "effective_points": d.effective(),
        "overall": by_method(methods, |m| d.overall[m].into()),
        "ranks": by_method(methods, |m| d.ranks[m].into()),
        "reversals": pairs(&report.data.reversals(d)),
    })
}

fn by_method(methods: &[String], value: impl Fn(usize) -> Value) -> Value {
    Value::Object(methods.iter().enumerate().map(|(m, name)| (name.clone(), value(m))).collect())
}

fn pairs(reversals: &[Reversal]) -> Value {
    reversals.iter().map(|r| json!({"here": r.here, "overall": r.overall})).collect()
}

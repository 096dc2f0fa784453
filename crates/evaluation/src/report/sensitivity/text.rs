//! A sensitivity for terminals: plain text, no colours.

use super::cases;
use super::shown::{SensitivityReport, in_words, score};
use crate::analysis::sensitivity::{Distribution, RANDOM};
use crate::report::across::{percent, rank};
use crate::report::format::count;
use crate::report::plain_table::plain_table;
use crate::report::words::limit_in_words;

/// Returns the tables: failures, importance that people mean, random importance, what is reported.
pub(super) fn tables(report: &SensitivityReport<'_>) -> String {
    let points = count(report.data.board.points.len(), "point MDP");
    let mut parts = Vec::new();
    parts.extend(failures(report));
    parts.push(format!(
        "Overall performance on {points} with the importance named (rank): {}:\n\n{}",
        report.score(),
        distributions(report, report.meant()),
    ));
    parts.push(format!(
        "The same under five random distributions, {}:\n\n{}",
        drawn_from(report),
        { distributions(report, report.drawn()) }
    ));
    parts.push(format!(
        "In how many of {RANDOM} such distributions a method takes which rank:\n\n{}",
        ranks(report)
    ));
    parts.extend(reported(report));
    parts.extend(cases::text(report));
    parts.join("\n\n")
}

/// Says where random distributions are from.
pub(super) fn drawn_from(report: &SensitivityReport<'_>) -> String {
    let random = &report.data.random;
    let likely = match random.concentration {
        1.0 => "all equally likely",
        c if c < 1.0 => "few point MDPs count",
        _ => "near equal weights",
    };
    format!("Dirichlet of concentration {} ({likely}), seed {}", random.concentration, random.seed)
}

fn failures(report: &SensitivityReport<'_>) -> Option<String> {
    let failures = report.data.failures.as_ref()?;
    let rows = failures.methods.iter().map(|of| {
        let points = format!("{} of {}", of.points.len(), of.known);
        vec![of.method.clone(), points, of.importance.map_or_else(|| "-".to_owned(), percent)]
    });
    let table = plain_table(&["method", "failures", "importance"], &[1, 2], rows.collect());
    Some(format!("Failures: point MDPs with {}:\n\n{table}", limit_in_words(&failures.limit)))
}

fn distributions(report: &SensitivityReport<'_>, all: &[Distribution]) -> String {
    let mut header = vec!["method".to_owned()];
    header.extend(all.iter().map(|d| report.heading(d)));
    let rows = report.data.board.methods.iter().enumerate().map(|(m, method)| {
        let of = |d: &Distribution| format!("{} ({})", score(d.overall[m]), rank(d.ranks[m]));
        std::iter::once(method.clone()).chain(all.iter().map(of)).collect()
    });
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    plain_table(&header, &(1..header.len()).collect::<Vec<_>>(), rows.collect())
}

fn ranks(report: &SensitivityReport<'_>) -> String {
    let (methods, random) = (&report.data.board.methods, &report.data.random);
    let mut header = vec!["method".to_owned()];
    header.extend((1..=methods.len()).map(|rank| format!("rank {rank}")));
    header.push("central 95%".to_owned());
    let rows = methods.iter().enumerate().map(|(m, method)| {
        let mut row = vec![method.clone()];
        row.extend(random.shares[m].iter().map(|share| one_decimal(*share)));
        row.push(range(random.range[m]));
        row
    });
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    plain_table(&header, &(1..header.len()).collect::<Vec<_>>(), rows.collect())
}

/// Returns a share of a thousand in percent.
pub(super) fn one_decimal(share: f64) -> String {
    match share {
        0.0 => "0%".to_owned(),
        1.0 => "100%".to_owned(),
        share => format!("{:.1}%", 100.0 * share),
    }
}

/// Returns a range of overall performance.
pub(super) fn range(range: Option<(f64, f64)>) -> String {
    range.map_or_else(|| "-".to_owned(), |(low, high)| format!("{} to {}", score(low), score(high)))
}

fn reported(report: &SensitivityReport<'_>) -> Option<String> {
    let all = &report.data.reported;
    if all.is_empty() {
        return None;
    }
    let overall = report.data.overall();
    let mut tables = Vec::new();
    for r in all {
        let dash = || "-".to_owned();
        let rows = report.data.board.methods.iter().enumerate().map(|(m, method)| {
            vec![
                method.clone(),
                r.scores[m].map_or_else(dash, score),
                r.ranks[m].map_or_else(dash, rank),
                score(overall.overall[m]),
                r.overall_ranks[m].map_or_else(dash, rank),
            ]
        });
        let header = ["method", "reported", "rank", "overall", "rank"];
        let table = plain_table(&header, &[1, 2, 3, 4], rows.collect());
        tables.push(format!("Reported at {} beside overall:\n\n{table}", r.name));
    }
    Some(tables.join("\n\n"))
}

/// Returns on what else than the whole family the tables rest.
pub(super) fn warnings(report: &SensitivityReport<'_>) -> Vec<String> {
    let mut warnings: Vec<String> = report.data.board.lacks().into_iter().collect();
    let unknown = |sampled| format!("{sampled}; the effect of the others is not known");
    warnings.extend(report.data.board.sampled().map(unknown));
    warnings
}

/// Returns what readers of the tables must know: what is left out, and where the order turns round.
pub(super) fn notes(report: &SensitivityReport<'_>) -> Vec<String> {
    let data = report.data;
    let mut notes = warnings(report);
    for d in &data.distributions[1..] {
        let reversals = data.reversals(d);
        if !reversals.is_empty() {
            let heading = report.heading(d);
            notes.push(format!("{heading}: {}, unlike by importance", in_words(&reversals)));
        }
    }
    notes.push(format!(
        "the order by importance holds under {} of the random distributions",
        one_decimal(data.random.as_overall)
    ));
    for r in &data.reported {
        notes.push(match r.reversals.as_slice() {
            [] => format!("reported at {}: the same order as overall", r.name),
            reversals => format!("reported at {}: {}, unlike overall", r.name, in_words(reversals)),
        });
    }
    notes
}

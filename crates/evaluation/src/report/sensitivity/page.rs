//! The page of a sensitivity.

use minijinja::{Value, context};

use super::cases::{self, CaseTable};
use super::shown::{SensitivityReport, in_words, score};
use super::text::{drawn_from, notes, one_decimal, range, warnings};
use crate::analysis::sensitivity::{Distribution, RANDOM, Reported};
use crate::report::across::{percent, rank};
use crate::report::error::ReportError;
use crate::report::figure::Figure;
use crate::report::page::render;
use crate::report::words::limit_in_words;

const TEMPLATE: &str = include_str!("../templates/sensitivity.html");

/// Returns the page.
///
/// # Errors
///
/// [`ReportError::Template`].
pub(super) fn page(report: &SensitivityReport<'_>, figure: &Figure) -> Result<String, ReportError> {
    render("sensitivity.html", TEMPLATE, values(report, figure)).map_err(ReportError::Template)
}

fn values(report: &SensitivityReport<'_>, figure: &Figure) -> Value {
    let (data, identity) = (report.data, &report.report.manifest.identity);
    context! {
        scenario => identity.scenario.as_str(),
        headline => headline(report),
        sentences => sentences(report),
        warnings => warnings(report),
        notes => notes(report)[warnings(report).len()..].to_vec(),
        score => report.score(),
        points => data.board.points.len(),
        figure => figure.svg.as_str(),
        meant => table(report, report.meant()),
        drawn => table(report, report.drawn()),
        drawn_from => drawn_from(report),
        random => RANDOM,
        ranks => (1..=data.board.methods.len()).collect::<Vec<_>>(),
        shares => shares(report),
        failures => failures(report),
        reported => data.reported.iter().map(|r| reported(report, r)).collect::<Vec<_>>(),
        cases => cases::tables(report).into_iter().map(case).collect::<Vec<_>>(),
        repeats => report.cases.first().and_then(|c| c.cells.first()).map_or(0, |c| c.repeats),
        command => report.command.as_str(),
        run => report.report.manifest.provenance.command.as_str(),
        version => env!("CARGO_PKG_VERSION"),
    }
}

fn headline(report: &SensitivityReport<'_>) -> String {
    let (data, best) = (report.data, &report.data.board.methods[0]);
    let first = data.distributions.iter().all(|d| d.ranks[0] == 1.0);
    let share = one_decimal(data.random.shares[0][0]);
    let at_random = match share.as_str() {
        "100%" => format!("all {RANDOM} random ones"),
        share => format!("{share} of random ones"),
    };
    match first {
        true => format!("{best} is best under every importance shown here, and under {at_random}"),
        false => format!(
            "Which method is best depends on how point MDPs are weighed: {best} is by importance, and under {at_random}"
        ),
    }
}

fn sentences(report: &SensitivityReport<'_>) -> Vec<String> {
    let data = report.data;
    let mut sentences = vec![format!(
        "The overall performance of a method is the mean of its scores, each point MDP counting by its importance. \
         Here {} methods are ranked again on the same {} point MDPs with other importance.",
        data.board.methods.len(),
        data.board.points.len(),
    )];
    if let Some(f) = &data.failures {
        sentences.push(format!(
            "A failure is a point MDP with {}: at least half of the methods fail on {} of the point MDPs, all of \
             them on {}, some on {}.",
            limit_in_words(&f.limit),
            f.by_half.len(),
            f.by_all,
            f.by_any
        ));
    }
    sentences
}

fn table(report: &SensitivityReport<'_>, all: &[Distribution]) -> Value {
    let headings: Vec<String> = all.iter().map(|d| report.heading(d)).collect();
    let cell = |d: &Distribution, m: usize| context! { value => score(d.overall[m]), rank => rank(d.ranks[m]) };
    let rows = report.data.board.methods.iter().enumerate().map(|(m, name)| {
        context! { name, cells => all.iter().map(|d| cell(d, m)).collect::<Vec<_>>() }
    });
    let effective = all.iter().map(|d| format!("{:.0}", d.effective())).collect::<Vec<_>>();
    context! { headings, effective, rows => rows.collect::<Vec<_>>() }
}

fn shares(report: &SensitivityReport<'_>) -> Vec<Value> {
    let random = &report.data.random;
    let row = |(m, name): (usize, &String)| {
        let shares = random.shares[m].iter().map(|share| one_decimal(*share)).collect::<Vec<_>>();
        context! { name, shares, range => range(random.range[m]) }
    };
    report.data.board.methods.iter().enumerate().map(row).collect()
}

fn failures(report: &SensitivityReport<'_>) -> Option<Value> {
    let failures = report.data.failures.as_ref()?;
    let rows = failures.methods.iter().map(|of| {
        context! {
            name => of.method.as_str(),
            points => of.points.len(),
            known => of.known,
            importance => of.importance.map_or_else(|| "-".to_owned(), percent),
        }
    });
    Some(context! { limit => limit_in_words(&failures.limit), rows => rows.collect::<Vec<_>>() })
}

fn reported(report: &SensitivityReport<'_>, r: &Reported) -> Value {
    let overall = report.data.overall();
    let dash = || "-".to_owned();
    let rows = report.data.board.methods.iter().enumerate().map(|(m, name)| {
        context! {
            name,
            value => r.scores[m].map_or_else(dash, score),
            rank => r.ranks[m].map_or_else(dash, rank),
            overall => score(overall.overall[m]),
            overall_rank => r.overall_ranks[m].map_or_else(dash, rank),
        }
    });
    context! {
        name => r.name.as_str(),
        rows => rows.collect::<Vec<_>>(),
        reversals => in_words(&r.reversals),
    }
}

fn case(table: CaseTable) -> Value {
    let rows = table.rows.into_iter().zip(table.cells);
    let rows = rows.map(|([name, truth, kind], cells)| context! { name, truth, kind, cells });
    context! { title => table.title, budgets => table.budgets, rows => rows.collect::<Vec<_>>() }
}

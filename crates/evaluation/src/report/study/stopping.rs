//! Runs that stop early: a table for terminals and the page, and `stopping.csv`.

use minijinja::{Value, context};

use super::StudyReport;
use crate::report::csv::{number, table};
use crate::report::format;
use crate::report::plain_table::plain_table;
use crate::sample::Until;
use crate::study::Stopped;

/// Columns of the terminal's table that are numbers.
const NUMBERS: [usize; 6] = [2, 3, 4, 5, 6, 7];

impl StudyReport<'_> {
    /// Returns what came of runs that stop early; `None` where none were tried.
    pub fn stopping_table(&self) -> Option<String> {
        let (until, all) = self.stopping?;
        let header =
            ["estimator", "intervals", "points", "early", "enough", "wrong", "held", "least of"];
        let row = |stopped: &Stopped| {
            let r = Row::of(stopped);
            let name = stopped.kind.title().to_owned();
            vec![name, r.intervals, r.points, r.early, r.enough, r.wrong, r.held, r.least]
        };
        let rows = plain_table(&header, &NUMBERS[..5], all.iter().map(row).collect());
        Some(format!(
            "Runs with looks at {} point MDPs, until {until}: mean number of point MDPs at the end, share of {} runs that \
             stopped before the last look, that had enough, that call the worse method better, and how often the \
             intervals at the end hold the truth:\n\n{rows}",
            looks(self),
            self.plan.repeats,
        ))
    }
}

fn looks(report: &StudyReport<'_>) -> String {
    report.plan.budgets.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

/// A row of a table.
struct Row {
    intervals: String,
    points: String,
    early: String,
    enough: String,
    wrong: String,
    held: String,
    least: String,
}

impl Row {
    fn of(stopped: &Stopped) -> Self {
        let held = stopped.coverage.iter().filter_map(|(name, share)| Some((name, (*share)?)));
        let least = held.min_by(|a, b| a.1.total_cmp(&b.1));
        let intervals = if stopped.is_spent { "over all looks" } else { "95% at every look" };
        Self {
            intervals: intervals.to_owned(),
            points: format!("{:.1}", stopped.points),
            early: format::percent(stopped.early),
            enough: format::percent(stopped.enough),
            wrong: stopped.wrong.map_or_else(|| "-".to_owned(), format::percent),
            held: least.map_or_else(|| "-".to_owned(), |(_, share)| format::percent(share)),
            least: least.map_or_else(String::new, |(name, _)| name.clone()),
        }
    }
}

/// Returns the section of the page; `None` where no runs that stop early were tried.
pub(super) fn values(report: &StudyReport<'_>) -> Option<Value> {
    let (until, all) = report.stopping?;
    let row = |stopped: &Stopped| {
        let r = Row::of(stopped);
        context! {
            estimator => stopped.kind.title(),
            intervals => r.intervals,
            points => r.points,
            early => r.early,
            enough => r.enough,
            wrong => r.wrong,
            held => r.held,
            least => r.least,
            hours => stopped.cpu_hours.map(|h| format!("{h:.1} h")),
        }
    };
    let judged = match until {
        Until::Decided(_) | Until::FirstPlace(_) => "the pairs",
        Until::HalfWidth(_) => "the methods",
    };
    Some(context! {
        until => until.to_string(),
        looks => looks(report),
        judged,
        has_wrong => all.iter().any(|s| s.wrong.is_some()),
        has_hours => all.iter().any(|s| s.cpu_hours.is_some()),
        rows => all.iter().map(row).collect::<Vec<_>>(),
    })
}

/// Returns `stopping.csv`, a row per estimator, way to look and thing that is judged; `None` where no runs that stop early
/// were tried.
pub(super) fn csv(report: &StudyReport<'_>) -> Option<String> {
    let (_, all) = report.stopping?;
    let header = [
        "estimator", "alpha_spent", "judged", "repeats", "points", "early", "enough", "wrong",
        "coverage", "cpu_hours",
    ];
    let of_run = |stopped: &Stopped| {
        let row = |(judged, coverage): &(String, Option<f64>)| {
            vec![
                stopped.kind.name().to_owned(),
                stopped.is_spent.to_string(),
                judged.clone(),
                stopped.repeats.to_string(),
                stopped.points.to_string(),
                stopped.early.to_string(),
                stopped.enough.to_string(),
                number(stopped.wrong),
                number(*coverage),
                number(stopped.cpu_hours),
            ]
        };
        stopped.coverage.iter().map(row).collect::<Vec<_>>()
    };
    Some(table(&header, all.iter().flat_map(of_run)))
}

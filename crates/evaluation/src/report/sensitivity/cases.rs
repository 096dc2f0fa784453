//! How well estimators do in the paper's cases 1 to 3: a table per case.

use super::shown::{SensitivityReport, score};
use crate::report::across::percent;
use crate::report::plain_table::plain_table;
use crate::study::{CaseStudy, Cell};

/// A table: heading of the case, names of its columns, and rows of method, truth, estimator and a cell per budget.
pub(super) struct CaseTable {
    pub(super) title: String,
    pub(super) budgets: Vec<usize>,
    pub(super) rows: Vec<[String; 3]>,
    pub(super) cells: Vec<Vec<String>>,
}

/// Returns a table per case.
pub(super) fn tables(report: &SensitivityReport<'_>) -> Vec<CaseTable> {
    report.cases.iter().map(|study| table(report, study)).collect()
}

fn table(report: &SensitivityReport<'_>, study: &CaseStudy) -> CaseTable {
    let mut budgets: Vec<usize> = study.cells.iter().map(|cell| cell.budget).collect();
    budgets.sort_unstable();
    budgets.dedup();
    let (mut rows, mut cells) = (Vec::new(), Vec::new());
    for method in &report.data.board.methods {
        let mut own: Vec<&Cell> = study.cells.iter().filter(|c| c.method == *method).collect();
        own.sort_by_key(|cell| (cell.kind, cell.budget));
        for of_kind in own.chunk_by(|a, b| a.kind == b.kind) {
            let first = of_kind[0];
            rows.push([method.clone(), score(first.truth), first.kind.title().to_owned()]);
            cells.push(of_kind.iter().map(|c| estimate(c)).collect());
        }
    }
    let title = format!(
        "Case {}: {}, {} of all",
        study.case.number(),
        study.case.title(),
        percent(study.failures)
    );
    let title = match study.case {
        crate::study::Case::Random => {
            format!("Case {}: {}", study.case.number(), study.case.title())
        }
        _ => title,
    };
    CaseTable { title, budgets, rows, cells }
}

/// Returns mean and standard deviation of the estimates.
fn estimate(cell: &Cell) -> String {
    format!("{} \u{b1} {}", score(cell.mean), score(cell.deviation))
}

/// Returns the tables for terminals.
pub(super) fn text(report: &SensitivityReport<'_>) -> Vec<String> {
    let repeats = report.cases.first().and_then(|c| c.cells.first()).map_or(0, |c| c.repeats);
    let tables = tables(report).into_iter().map(|t| {
        let mut header = ["method", "overall", "estimator"].map(str::to_owned).to_vec();
        header.extend(t.budgets.iter().map(|b| format!("N = {b}")));
        let header: Vec<&str> = header.iter().map(String::as_str).collect();
        let right: Vec<usize> = (0..header.len()).filter(|c| ![0, 2].contains(c)).collect();
        let rows = t.rows.iter().zip(t.cells).map(|(row, cells)| {
            row.iter().cloned().chain(cells).collect()
        });
        let table = plain_table(&header, &right, rows.collect());
        format!(
            "{}; mean and standard deviation of the estimates from {repeats} samples of N point MDPs:\n\n{table}",
            t.title
        )
    });
    tables.collect()
}

//! The ranking as a table for terminals: plain text, no colours.

use comfy_table::{CellAlignment, LineStyle, Table, TableStyle};

use super::data::{MethodSummary, ReportData};
use super::format;

const HEADER: [&str; 8] = [
    "rank",
    "method",
    "score",
    "95% interval",
    "delay (s)",
    "worst point MDP (score)",
    "points",
    "failed",
];

/// Columns of numbers, which are aligned to the right.
const RIGHT: [usize; 6] = [0, 2, 3, 4, 6, 7];

/// Returns the ranking of the methods, best first; [`notes`] belong below it.
pub fn table(data: &ReportData) -> String {
    let mut table = Table::new();
    let rule = LineStyle::none().fill('-').junction('-');
    table.load_style(TableStyle::new().header_separator(rule)).set_header(HEADER);
    for i in RIGHT {
        if let Some(column) = table.column_mut(i) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    for m in &data.methods {
        table.add_row(row(data, m));
    }
    table.trim_fmt()
}

fn row(data: &ReportData, m: &MethodSummary) -> [String; 8] {
    let dash = || "-".to_owned();
    [
        m.rank.map_or_else(dash, |r| r.to_string()),
        if m.is_baseline { format!("{} (baseline)", m.method) } else { m.method.clone() },
        m.overall.map_or_else(dash, |v| format::score_within(v, m.interval)),
        match m.interval {
            _ if m.is_baseline && m.overall.is_some() => "by definition".to_owned(),
            Some(i) => format::interval(i),
            None => dash(),
        },
        m.objective.map_or_else(dash, format::delay),
        match &m.worst {
            Some((point, score)) if !m.is_baseline => {
                format!("{point} ({})", format::score(*score))
            }
            _ => dash(),
        },
        format!("{}/{}", m.points, data.points.len()),
        m.failed.to_string(),
    ]
}

/// Returns what a reader of the ranking must know: what is missing and what is not in the interval.
pub fn notes(data: &ReportData) -> Vec<String> {
    let mut notes = Vec::new();
    let planned = data.rows.len();
    let missing = data.missing();
    if missing > 0 {
        notes.push(format!(
            "Incomplete: {missing} of {planned} tasks have no record yet; run again to compute them."
        ));
    }
    let failed = data.failed().count();
    if failed > 0 {
        notes.push(format!("{failed} of {planned} tasks failed; the reasons are in the report's section \"Failed and \
             missing\"."));
    }
    if data.methods.iter().any(|m| m.points != data.points.len()) {
        notes.push(
            "Scores are over the point MDPs that both the method and the baseline finished; methods \
             with different counts of points are not strictly comparable."
                .to_owned(),
        );
    }
    let others = || data.methods.iter().filter(|m| !m.is_baseline && m.overall.is_some());
    if others().any(|m| m.interval.is_none()) {
        notes.push(
            "Without interval: it takes at least two evaluation seeds, and two point MDPs where others of \
             the family have no result."
                .to_owned(),
        );
    }
    notes
}

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

/// Returns the ranking of the methods, best first, and below it, where some are not ranked, all of
/// them on the point MDPs that they have in common; [`notes`] belong below it.
pub fn table(data: &ReportData) -> String {
    let mut text = ranking(&data.methods, data.points.len());
    if let Some(common) = &data.common {
        text.push_str(&format!("\n\n{}\n\n", common_title(data)));
        text.push_str(&ranking(&common.methods, common.points));
    }
    text
}

/// Returns the title of the table of what methods have in common; empty when they are all ranked.
pub(super) fn common_title(data: &ReportData) -> String {
    let Some(common) = &data.common else { return String::new() };
    let n = format::count(common.points, "point MDP");
    format!("On the {n} that all {} methods with results finished:", common.methods.len())
}

fn ranking(methods: &[MethodSummary], points: usize) -> String {
    let mut table = Table::new();
    let rule = LineStyle::none().fill('-').junction('-');
    table.load_style(TableStyle::new().header_separator(rule)).set_header(HEADER);
    for i in RIGHT {
        if let Some(column) = table.column_mut(i) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    for m in methods {
        table.add_row(row(m, points));
    }
    table.trim_fmt()
}

fn row(m: &MethodSummary, points: usize) -> [String; 8] {
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
        format!("{}/{points}", m.points),
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
            "Incomplete: {} of {planned} tasks are done, {missing} have no record yet; run again to compute \
             them.",
            planned - missing
        ));
    }
    let failed = data.failed().count();
    if failed > 0 {
        notes.push(format!("{failed} of {planned} tasks failed; the reasons are in the report's section \"Failed and \
             missing\"."));
    }
    let identity = &data.manifest.identity;
    let still: Vec<&str> = (data.rows.iter())
        .filter(|r| r.method == identity.baseline)
        .filter(|r| r.metrics.get(&identity.objective) == Some(&0.0))
        .map(|r| data.points[r.point].row.point.as_str())
        .collect();
    if !still.is_empty() {
        notes.push(format!(
            "No score on {}: the baseline has no delay there, as on a road without vehicles; give it demand.",
            still.join(", ")
        ));
    }
    let chosen = data.points.len();
    let unranked: Vec<String> =
        data.unranked().map(|m| format!("{} ({} of {chosen})", m.method, m.points)).collect();
    if !unranked.is_empty() {
        let where_to_compare = match &data.common {
            Some(_) => "the second table compares all methods where all have results",
            None => "no point MDP has results of all methods, so nothing compares them yet",
        };
        notes.push(format!(
            "Not ranked, because they lack point MDPs that others have: {}. Their scores are over other point \
             MDPs than those above them; {where_to_compare}.",
            unranked.join(", ")
        ));
    } else if data.methods.iter().any(|m| m.points != chosen) {
        notes.push(
            "Scores are over the point MDPs that both the method and the baseline finished."
                .to_owned(),
        );
    }
    let partly = data.partly_replicated();
    if !partly.is_empty() {
        notes.push(format!(
            "Some replicates of {} failed or are missing; the score on such a point MDP is the mean over the \
             others, which flatters a method that fails where it is bad.",
            partly.into_iter().collect::<Vec<_>>().join(", ")
        ));
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

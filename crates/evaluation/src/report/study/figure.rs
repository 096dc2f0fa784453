//! The paper's figure: estimates against the budget, a panel per method, with the whole family as a line.

use super::StudyReport;
use crate::report::figure::{Figure, WIDTH};
use crate::report::format;
use crate::report::svg::{Anchor, Axes, Canvas, MUTED, TextStyle, nice_step, text_width};
use crate::study::{Kind, RecordedMethod};

/// Panels beside each other.
const COLUMNS: usize = 2;

/// Height of the plot area of a panel, and of a panel with its labels, pixels.
const HEIGHT_PX: (f64, f64) = (190.0, 282.0);

/// Height of a row of the legend, pixels.
const LEGEND_PX: f64 = 24.0;

/// Share of the distance of two budgets over which estimators lie side by side.
const SPREAD: f64 = 0.6;

/// Returns the colour of an estimator: apart for colour-blind readers, the paper's in lighter tones.
///
/// Source: M. Okabe and K. Ito, "Color universal design", 2008.
pub(super) fn color(kind: Kind) -> &'static str {
    match kind {
        Kind::M1 => "#56b4e9",
        Kind::M2 => "#e69f00",
        Kind::M3 => "#009e73",
        Kind::Balanced => "#0072b2",
        Kind::M4 => "#d55e00",
        Kind::BqFeatures => "#cc79a7",
        Kind::Bq => "#000000",
    }
}

/// Draws mean and standard deviation of the estimates over the budget.
pub(super) fn by_budget(report: &StudyReport<'_>) -> Figure {
    let methods = &report.recorded.methods;
    let kinds = &report.plan.kinds;
    let slots = kinds.iter().map(|k| text_width(k.title()) + 44.0);
    let rows = wrapped(slots.collect());
    let top = 30.0 + LEGEND_PX * rows.len() as f64;
    let height = top + HEIGHT_PX.1 * methods.len().div_ceil(COLUMNS) as f64;
    let mut canvas = Canvas::new(WIDTH, height);
    for (row, members) in rows.iter().enumerate() {
        for (k, x) in members {
            let y = 16.0 + LEGEND_PX * row as f64;
            canvas.line((x + 4.0, y), (x + 24.0, y), color(kinds[*k]), 2.0, None);
            canvas.circle((x + 14.0, y), 4.5, color(kinds[*k]), None);
            let style = TextStyle::new(Anchor::Start);
            canvas.text(x + 30.0, y + 4.5, kinds[*k].title(), style);
        }
    }
    let width = WIDTH / COLUMNS as f64;
    for (i, method) in methods.iter().enumerate() {
        let left = width * (i % COLUMNS) as f64 + 60.0;
        let top = top + HEIGHT_PX.1 * (i / COLUMNS) as f64 + 24.0;
        let area = (left, top, left + width - 80.0, top + HEIGHT_PX.0);
        panel(&mut canvas, report, method, area);
    }
    let description = methods.iter().map(|m| description(report, m)).collect::<Vec<_>>().join(" ");
    canvas.figure("budget", "Estimates against the budget", &description)
}

/// Puts slots of these widths into rows; a row has positions of slots and where they begin.
fn wrapped(slots: Vec<f64>) -> Vec<Vec<(usize, f64)>> {
    let mut rows: Vec<Vec<(usize, f64)>> = vec![Vec::new()];
    let mut x = 8.0;
    for (k, width) in slots.into_iter().enumerate() {
        if x + width > WIDTH && x > 8.0 {
            rows.push(Vec::new());
            x = 8.0;
        }
        if let Some(row) = rows.last_mut() {
            row.push((k, x));
        }
        x += width;
    }
    rows
}

fn panel(
    canvas: &mut Canvas,
    report: &StudyReport<'_>,
    method: &RecordedMethod,
    area: (f64, f64, f64, f64),
) {
    let budgets = &report.plan.budgets;
    let truth = report.recorded.truth(method);
    let cells = report.cells.iter().filter(|c| c.method == method.name);
    let ends = cells.flat_map(|c| [c.mean - c.deviation, c.mean + c.deviation]).chain([truth]);
    let (low, high) =
        ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| (a.min(y), b.max(y)));
    let pad = (0.08 * (high - low)).max(1e-3);
    let range = (low - pad, high + pad);
    let frame = canvas.axes(&Axes {
        area,
        x: (-0.6, budgets.len() as f64 - 0.4),
        y: range,
        x_step: 1.0,
        y_step: Some(nice_step(range.1 - range.0, 5.0)),
        x_last: -1.0,
        x_label: None,
        y_label: None,
    });
    let style = TextStyle::new(Anchor::Start);
    let title = format!("{}: score, whole family {}", method.name, format::score(truth));
    canvas.text(area.0 - 44.0, area.1 - 10.0, &title, style.bold());
    let y = frame.y(truth);
    canvas.line((area.0, y), (area.2, y), MUTED, 1.6, Some("6 4"));
    let middle = TextStyle::new(Anchor::Middle);
    for (b, budget) in budgets.iter().enumerate() {
        canvas.text(frame.x(b as f64), area.3 + 18.0, &budget.to_string(), middle);
    }
    let label = "budget (point MDPs); mean and standard deviation of estimates";
    canvas.text((area.0 + area.2) / 2.0, area.3 + 38.0, label, middle.small());
    let kinds = &report.plan.kinds;
    for (k, kind) in kinds.iter().enumerate() {
        let aside = SPREAD * ((k as f64 + 0.5) / kinds.len() as f64 - 0.5);
        for (b, cell) in report.cells_of(*kind, &method.name).iter().enumerate() {
            let x = frame.x(b as f64 + aside);
            let at = |value: f64| (x, frame.y(value));
            let (low, high) = (cell.mean - cell.deviation, cell.mean + cell.deviation);
            canvas.line(at(low), at(high), color(*kind), 2.2, None);
            let tip = format!(
                "{}, N = {}: {} ± {}, error {:.4}",
                kind.title(),
                cell.budget,
                format::score(cell.mean),
                format::score(cell.deviation),
                cell.error
            );
            canvas.circle(at(cell.mean), 4.5, color(*kind), Some(&tip));
        }
    }
}

fn description(report: &StudyReport<'_>, method: &RecordedMethod) -> String {
    let of = |kind: &Kind| {
        let cells = report.cells_of(*kind, &method.name);
        let errors: Vec<String> =
            cells.iter().map(|c| format!("{:.3} at {}", c.error, c.budget)).collect();
        format!("{} {}", kind.title(), errors.join(", "))
    };
    let kinds: Vec<String> = report.plan.kinds.iter().map(of).collect();
    format!("{}: root-mean-square errors of {}.", method.name, kinds.join("; "))
}

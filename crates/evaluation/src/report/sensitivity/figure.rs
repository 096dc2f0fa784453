//! The figure of a sensitivity: the methods under every distribution, and what is reported.

use super::shown::{SensitivityReport, score};
use crate::analysis::MethodSummary;
use crate::report::figure::{Figure, WIDTH};
use crate::report::figures::{OVERALL_LIMIT, color, dash, reference_line, sentence};
use crate::report::svg::{Anchor, Axes, Canvas, MUTED, TextStyle, nice_step, text_width};

/// Height of a row, pixels.
const ROW_PX: f64 = 34.0;

/// Height of a row of the legend, pixels.
const LEGEND_PX: f64 = 24.0;

/// Longest name of a row, characters.
const NAME: usize = 30;

/// Distance within which dots are drawn beside each other, pixels.
const NEAR_PX: f64 = 9.0;

/// A row: its name and what every method has there.
struct Line {
    name: String,
    values: Vec<Option<f64>>,
}

/// Draws the overall performance of every method under every distribution, and what is reported below.
pub(super) fn draw(report: &SensitivityReport<'_>) -> Figure {
    let data = report.data;
    let distributions: Vec<Line> = data
        .distributions
        .iter()
        .map(|d| Line {
            name: report.heading(d),
            values: d.overall.iter().copied().map(Some).collect(),
        })
        .collect();
    let reported: Vec<Line> = data
        .reported
        .iter()
        .map(|r| Line { name: short(&format!("reported: {}", r.name)), values: r.scores.clone() })
        .collect();
    let lines: Vec<&Line> = distributions.iter().chain(&reported).collect();
    let methods: Vec<Option<&MethodSummary>> = data
        .board
        .methods
        .iter()
        .map(|name| report.report.methods.iter().find(|m| m.method == *name))
        .collect();
    let relative = !report.report.reference.is_none();
    let (least, most) = range(&lines, relative);
    let left = lines.iter().map(|l| text_width(&l.name)).fold(80.0, f64::max) + 20.0;
    let right = WIDTH - 30.0;
    let slot = data.board.methods.iter().map(|m| text_width(m)).fold(60.0, f64::max) + 40.0;
    let per_row = ((WIDTH - 24.0) / slot).floor().max(1.0) as usize;
    let top = 44.0 + LEGEND_PX * methods.len().div_ceil(per_row) as f64;
    let bottom = top + ROW_PX * lines.len() as f64;
    let mut canvas = Canvas::new(WIDTH, bottom + 56.0);
    let frame = canvas.axes(&Axes {
        area: (left, top, right, bottom),
        x: (least, most),
        y: (0.0, lines.len() as f64),
        x_step: nice_step(most - least, 7.0),
        y_step: None,
        x_last: most,
        x_label: Some(format!("overall performance: {}", report.score())),
        y_label: None,
    });
    if relative && (least..=most).contains(&1.0) {
        reference_line(&mut canvas, report.report, &frame, (top, bottom), true);
    }
    for (i, line) in lines.iter().enumerate() {
        let y = top + ROW_PX * (i as f64 + 0.5);
        canvas.text(left - 10.0, y + 4.5, &line.name, TextStyle::new(Anchor::End));
    }
    if !reported.is_empty() {
        let y = top + ROW_PX * distributions.len() as f64;
        canvas.line((8.0, y), (right, y), MUTED, 1.0, None);
    }
    let mut taken: Vec<Vec<f64>> = vec![Vec::new(); lines.len()];
    for (m, method) in methods.iter().enumerate() {
        let Some(method) = method else { continue };
        let (color, dash) = (color(report.report, method), dash(report.report, method));
        let x = 16.0 + slot * (m % per_row) as f64;
        let y = 16.0 + LEGEND_PX * (m / per_row) as f64;
        canvas.line((x, y), (x + 20.0, y), color, 2.5, dash);
        canvas.circle((x + 10.0, y), 4.5, color, None);
        canvas.text(x + 27.0, y + 4.5, &method.method, TextStyle::new(Anchor::Start));
        let mut corners = Vec::new();
        for (i, line) in lines.iter().enumerate() {
            let Some(value) = line.values[m] else { continue };
            let x = frame.x(value.clamp(least, most));
            // Dots that would hide each other stand one below the other.
            let beside = taken[i].iter().filter(|other| (x - **other).abs() < NEAR_PX).count();
            taken[i].push(x);
            let shift = [0.0, -6.0, 6.0, -11.0, 11.0][beside.min(4)];
            let y = top + ROW_PX * (i as f64 + 0.5) + shift;
            if i < distributions.len() {
                corners.push((x, y));
            }
            let tip = format!("{}, {}: {}", method.method, line.name, score(value));
            if value > most {
                canvas.shape(&[(x - 10.0, y - 6.0), (x + 3.0, y), (x - 10.0, y + 6.0)], color);
            } else {
                canvas.circle((x, y), 4.5, color, Some(&tip));
            }
        }
        canvas.polyline(corners, color, 1.2, dash);
    }
    let described = lines.iter().map(|line| {
        let of = line.values.iter().zip(&data.board.methods);
        let of = of.filter_map(|(v, m)| Some(format!("{m} {}", score((*v)?))));
        format!("{}: {}", line.name, of.collect::<Vec<_>>().join(", "))
    });
    let title = "Overall performance of every method under other importance of the point MDPs";
    canvas.figure("sensitivity", title, &sentence(described))
}

/// Returns the ends of the axis: those of the values, but where scores are relative no further than to a limit.
fn range(lines: &[&Line], relative: bool) -> (f64, f64) {
    let values = || lines.iter().flat_map(|line| line.values.iter().copied().flatten());
    let least = values().fold(f64::INFINITY, f64::min);
    let mut most = values().fold(f64::NEG_INFINITY, f64::max);
    if relative {
        most = most.min(least.max(OVERALL_LIMIT));
    }
    let pad = if most > least { 0.06 * (most - least) } else { 0.5 };
    (least - pad, most + pad)
}

fn short(name: &str) -> String {
    match name.chars().count() > NAME {
        true => name.chars().take(NAME - 1).chain(['\u{2026}']).collect(),
        false => name.to_owned(),
    }
}

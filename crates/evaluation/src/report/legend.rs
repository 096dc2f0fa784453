//! Which line is which method: rows of samples above a drawing.

use super::figures::{color, dash, label};
use super::svg::{Anchor, Canvas, TextStyle, text_width};
use super::whole::Report;
use crate::analysis::MethodSummary;

/// Height of a row, pixels.
const ROW_PX: f64 = 24.0;

/// Space at the left, pixels.
const LEFT_PX: f64 = 16.0;

/// Length of a sample with the space behind it, and the space behind a name, pixels.
const SAMPLE_PX: f64 = 36.0;

/// Returns the width of a place and how many stand in a row.
fn places(data: &Report, methods: &[&MethodSummary], width: f64) -> (f64, usize) {
    let slot = methods.iter().map(|m| text_width(&label(data, m))).fold(60.0, f64::max) + SAMPLE_PX;
    (slot, ((width - 24.0) / slot).floor().max(1.0) as usize)
}

/// Returns the height of the legend in a drawing of this width, pixels.
pub(super) fn height(data: &Report, methods: &[&MethodSummary], width: f64) -> f64 {
    ROW_PX * methods.len().div_ceil(places(data, methods, width).1) as f64
}

/// Draws the legend at the upper edge of a drawing of this width; with dots where lines have some.
pub(super) fn draw(
    canvas: &mut Canvas,
    data: &Report,
    methods: &[&MethodSummary],
    width: f64,
    dots: bool,
) {
    let (slot, per_row) = places(data, methods, width);
    for (i, m) in methods.iter().enumerate() {
        let x = LEFT_PX + slot * (i % per_row) as f64;
        let y = 16.0 + ROW_PX * (i / per_row) as f64;
        canvas.line((x, y), (x + 20.0, y), color(data, m), 2.5, dash(data, m));
        if dots {
            canvas.circle((x + 10.0, y), 4.0, color(data, m), None);
        }
        canvas.text(x + 27.0, y + 4.5, &label(data, m), TextStyle::new(Anchor::Start));
    }
}

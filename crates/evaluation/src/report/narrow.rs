//! The overall performance for narrow screens: names and numbers stand above the bars, not beside them.

use super::figures::{axis_of, color, label, mark, reference_line, sentence, with_interval};
use super::svg::{Anchor, Axes, Canvas, MUTED, TextStyle, nice_step, text_width};
use super::whole::Report;

/// Width of the drawing, pixels: that of a telephone.
const WIDTH_PX: f64 = 360.0;

/// Height of the row of a method, pixels.
const ROW_PX: f64 = 46.0;

/// Space at the left and at the right, pixels.
const SIDE_PX: f64 = 14.0;

/// Space above the first row, pixels.
const TOP_PX: f64 = 30.0;

/// Draws the overall performance of every method with its interval; `None` without an estimate.
pub(super) fn overall(data: &Report) -> Option<String> {
    let methods: Vec<_> = data.methods.iter().filter(|m| m.overall.is_some()).collect();
    let (least, limit) = axis_of(data, &methods);
    let (left, right) = (SIDE_PX, WIDTH_PX - SIDE_PX);
    let bottom = TOP_PX + ROW_PX * methods.len() as f64;
    let mut canvas = Canvas::new(WIDTH_PX, bottom + 56.0);
    let frame = canvas.axes(&Axes {
        area: (left, TOP_PX, right, bottom),
        x: (least, limit),
        y: (0.0, methods.len() as f64),
        x_step: nice_step(limit - least, 5.0),
        y_step: None,
        x_last: limit,
        x_label: Some(format!("{}{} ({})", data.words.noun, data.relative(), data.better())),
        y_label: None,
    });
    reference_line(&mut canvas, data, &frame, (TOP_PX, bottom), false);
    // At the end of the line, or within the drawing where that would leave it.
    if !data.reference.is_none() {
        let name = format!("{} = 1", data.reference.as_label());
        let x = (frame.x(1.0) + text_width(&name) / 2.0).min(right);
        canvas.text(x, TOP_PX - 8.0, &name, TextStyle::new(Anchor::End).color(MUTED));
    }
    for (i, m) in methods.iter().enumerate() {
        let Some(value) = m.overall else { continue };
        let y = TOP_PX + ROW_PX * i as f64;
        // The dashed line does not cross the words.
        canvas.rect((left + 1.0, y + 3.0), (right, y + 22.0), "#ffffff", None);
        canvas.text(left + 6.0, y + 17.0, &label(data, m), TextStyle::new(Anchor::Start).bold());
        canvas.text(right, y + 17.0, &with_interval(m), TextStyle::new(Anchor::End));
        mark(&mut canvas, &frame, (value, m.interval), (y + 33.0, limit), color(data, m));
    }
    let description =
        sentence(methods.iter().map(|m| format!("{} {}", label(data, m), with_interval(m))));
    let svg = canvas.finish("overall-narrow", "Overall performance of every method", &description);
    (!methods.is_empty()).then_some(svg)
}

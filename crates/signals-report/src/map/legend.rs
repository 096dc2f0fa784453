//! The legend of the map: what colours, letters and rings mean.

use super::dot::{Dot, draw};
use crate::intersections::Basis;
use crate::level_of_service::{LEVELS, range};
use evaluation::report::WIDTH;
use evaluation::report::svg::{Anchor, Canvas, TextStyle, text_width};

/// Radius of the dots of the legend, pixels.
const RADIUS_PX: f64 = 7.0;

/// Distance of the first entry from the edge, pixels.
const LEFT_PX: f64 = 12.0;

/// Draws the classes in a first row, and in a second one what else is on the map.
pub(super) fn draw_legend(canvas: &mut Canvas, dots: &[Dot]) {
    let style = TextStyle::new(Anchor::Start);
    let slot = (WIDTH - 2.0 * LEFT_PX) / LEVELS.len() as f64;
    for (class, letter) in LEVELS.into_iter().enumerate() {
        let x = LEFT_PX + slot * class as f64;
        let at = (x + RADIUS_PX, 16.0);
        draw(canvas, at, RADIUS_PX, (Some(class), Basis::PointMdp), Some(letter));
        canvas.text(x + 19.0, 20.5, &range(class), style);
    }
    let has = |basis: Basis, result: bool| {
        dots.iter().any(|d| d.basis == basis && d.class.is_some() == result)
    };
    let own = if has(Basis::Simulated, true) { "simulated" } else { "its point MDP was simulated" };
    let represented = "not simulated: colour of the point MDP that stands for it";
    let any_hollow = dots.iter().any(|d| matches!(d.basis, Basis::Represented | Basis::None));
    let unknown = has(Basis::PointMdp, false)
        || has(Basis::Simulated, false)
        || has(Basis::Represented, false);
    let entries = [
        (any_hollow, Some(2), Basis::PointMdp, own),
        (has(Basis::Represented, true), Some(2), Basis::Represented, represented),
        (
            has(Basis::None, false),
            None,
            Basis::None,
            "not simulated, and no point MDP stands for it",
        ),
        (unknown, None, Basis::PointMdp, "no result"),
    ];
    let mut x = LEFT_PX;
    for (_, class, basis, text) in entries.into_iter().filter(|e| e.0) {
        draw(canvas, (x + RADIUS_PX, 40.0), RADIUS_PX, (class, basis), None);
        canvas.text(x + 19.0, 44.5, text, style);
        x += 19.0 + text_width(text) + 16.0;
    }
}

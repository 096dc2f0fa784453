//! The share of the family at each level of service, by method.

use super::level_of_service::{LEVELS, range, shares};
use evaluation::analysis::{Analysis, MethodSummary};
use evaluation::report::figures::{label, sentence, widest_name};
use evaluation::report::svg::{Anchor, Axes, Canvas, TextStyle};
use evaluation::report::{Figure, WIDTH, format, palette};

/// Height of the row of a method, pixels.
const ROW_PX: f64 = 34.0;

/// Smallest share of a bar that has room for its label.
const LABELLED_SHARE: f64 = 0.075;

/// Smallest width of a bar that has room for its letter, pixels.
const LETTER_PX: f64 = 11.0;

/// Draws the importance-weighted share of the levels of service of every method.
pub(super) fn levels(data: &Analysis) -> Option<Figure> {
    let methods: Vec<_> = data.methods.iter().filter(|m| m.points > 0).collect();
    let (left, right, top) = (widest_name(data) + 16.0, WIDTH - 24.0, 46.0);
    let bottom = top + ROW_PX * methods.len() as f64;
    let mut canvas = Canvas::new(WIDTH, bottom + 56.0);
    let frame = canvas.axes(&Axes {
        area: (left, top, right, bottom),
        x: (0.0, 100.0),
        y: (0.0, methods.len() as f64),
        x_step: 20.0,
        y_step: None,
        x_last: 100.0,
        x_label: Some("share of the family, weighted by importance (%)".to_owned()),
        y_label: None,
    });
    let slot = (WIDTH - 24.0) / LEVELS.len() as f64;
    for (l, letter) in LEVELS.iter().enumerate() {
        let x = 12.0 + slot * l as f64;
        canvas.rect((x, 10.0), (x + 16.0, 26.0), palette::ORDERED[l], Some("#1a1a1a"));
        let style = TextStyle::new(Anchor::Middle).color(palette::ink_on(l));
        canvas.text(x + 8.0, 22.5, &letter.to_string(), style);
        canvas.text(x + 22.0, 22.5, &range(l), TextStyle::new(Anchor::Start));
    }
    for (i, m) in methods.iter().enumerate() {
        let y = top + ROW_PX * i as f64;
        let middle = y + ROW_PX / 2.0 + 4.5;
        canvas.text(left - 10.0, middle, &label(data, m), TextStyle::new(Anchor::End));
        let mut from = 0.0;
        for (l, share) in level_shares(data, m).into_iter().enumerate().filter(|s| s.1 > 0.0) {
            let (a, b) = (frame.x(100.0 * from), frame.x(100.0 * (from + share)));
            let (above, below) = (y + 4.0, y + ROW_PX - 4.0);
            canvas.rect((a, above), (b, below), palette::ORDERED[l], Some("#1a1a1a"));
            let style = TextStyle::new(Anchor::Middle).color(palette::ink_on(l));
            if share >= LABELLED_SHARE {
                let label = format!("{} {}", LEVELS[l], format::percent(share));
                canvas.text((a + b) / 2.0, middle, &label, style);
            } else if b - a >= LETTER_PX {
                canvas.text((a + b) / 2.0, middle, &LEVELS[l].to_string(), style);
            }
            from += share;
        }
    }
    let description = sentence(methods.iter().map(|m| {
        let shares = level_shares(data, m);
        let parts: Vec<_> =
            LEVELS.iter().zip(shares).map(|(l, s)| format!("{l} {}", format::percent(s))).collect();
        format!("{}: {}", label(data, m), parts.join(", "))
    }));
    let title = "Level of service by method";
    (!methods.is_empty()).then(|| canvas.figure("level-of-service", title, &description))
}

/// Returns the share of the family at each level under a method.
fn level_shares(data: &Analysis, m: &MethodSummary) -> [f64; LEVELS.len()] {
    shares(data.results_of(m.index).map(|(p, r)| (p.weight, r.objective)))
}

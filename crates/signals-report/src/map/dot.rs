//! An intersection on the map: where, in which colour, with which letter.

use crate::intersections::{Basis, basis};
use crate::level_of_service::{letter, level};
use crate::map_view::MapView;
use crate::shown::{Seen, streets};
use evaluation::analysis::MethodSummary;
use evaluation::report::svg::{Anchor, Canvas, INK, TextStyle};
use evaluation::report::{format, palette};
use signals::places::MappedIntersection;

/// Width of the ring of what was not simulated, relative to its radius.
const RING: f64 = 0.4;

/// Radius of what was not simulated, relative to that of what was.
const SMALLER: f64 = 0.82;

/// Height of a letter relative to the radius of its dot.
const LETTER: f64 = 1.4;

/// An intersection on the map.
pub(super) struct Dot {
    /// Position of the intersection among all.
    pub(super) number: usize,
    /// Where on the canvas.
    pub(super) at: (f64, f64),
    /// Position in [`palette::ORDERED`]; `None` without a result.
    pub(super) class: Option<usize>,
    /// Where its result comes from.
    pub(super) basis: Basis,
    /// What the pointer shows.
    pub(super) tip: String,
}

impl Dot {
    /// Returns an intersection under the best method.
    pub(super) fn new(
        seen: Seen<'_>,
        best: &MethodSummary,
        (number, place): (usize, &MappedIntersection),
        view: &MapView,
    ) -> Self {
        let Seen { data, shown } = seen;
        let objective = &data.manifest.identity.objective;
        let (basis, point) = basis(data, place);
        let point = point.map(|p| &data.points[p]);
        let result = point.and_then(|p| p.results[best.index].as_ref());
        let name = match (streets(place), place.id.as_str()) {
            (Some(streets), id) => format!("{streets} ({id})"),
            (None, "") => shown.called(data, &place.point),
            (None, id) => format!("{id} ({})", place.point),
        };
        let of = match (basis, point) {
            (Basis::Represented, Some(p)) => {
                format!(" (of {}, which stands for it)", shown.called(data, &p.row.point))
            }
            (Basis::PointMdp, Some(p)) if !place.id.is_empty() => format!(" (of {})", p.row.name()),
            _ => String::new(),
        };
        let tip = match result {
            Some(r) => format!(
                "{name}: {objective} {} (level {}), score {}{of}",
                format::amount(r.objective),
                letter(r.objective),
                r.score.map_or_else(|| "-".to_owned(), format::score)
            ),
            None => format!("{name}: no result"),
        };
        Self {
            number,
            at: view.place(place.latitude, place.longitude),
            class: result.map(|r| level(r.objective)),
            basis,
            tip,
        }
    }
}

/// Draws an intersection: filled where it or its point MDP was simulated, else a ring.
pub(super) fn draw(
    canvas: &mut Canvas,
    at: (f64, f64),
    radius: f64,
    (class, basis): (Option<usize>, Basis),
    letter: Option<char>,
) {
    let hollow = matches!(basis, Basis::Represented | Basis::None);
    let radius = if hollow { SMALLER * radius } else { radius };
    let color = class.map_or(palette::UNKNOWN, |c| palette::ORDERED[c]);
    canvas.circle(at, radius, if hollow { "#ffffff" } else { color }, None);
    if hollow {
        let (width, r) = (RING * radius, radius * (1.0 - RING / 2.0) - 0.3);
        let (west, arc) = (at.0 - r, format!("a{r:.2} {r:.2} 0 1 0"));
        let d = format!("M{west:.1} {:.1}{arc} {:.2} 0{arc} {:.2} 0", at.1, 2.0 * r, -2.0 * r);
        canvas.path(d, color, width, None);
    }
    if let (Some(letter), Some(class)) = (letter, class) {
        let ink = if hollow { INK } else { palette::ink_on(class) };
        let size = (LETTER * radius).round();
        let style = TextStyle::new(Anchor::Middle).bold().color(ink).sized(size as u32);
        canvas.text(at.0, at.1 + 0.36 * size, &letter.to_string(), style);
    }
}

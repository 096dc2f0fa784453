//! The map of a derived family: streets, intersections coloured by how much of them is known, and
//! signals that are none.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::map_view::{MapFrame, MapView, scale_bar};
use evaluation::report::WIDTH;
use evaluation::report::svg::{Anchor, Canvas, MUTED, TextStyle};
use evaluation::report::{format, palette};
use signals::city::quality::{Quality, Spot};
use signals::city::surroundings::Drawing;

use super::{percent, streets};

/// Largest height of the map itself, with many and with few intersections, pixels.
const HEIGHT_PX: (f64, f64) = (900.0, 480.0);

/// Number of intersections up to which they are few.
const FEW: usize = 12;

/// Space below the map for the scale bar, pixels.
const BELOW_PX: f64 = 34.0;

/// Smallest and largest radius of an intersection, pixels.
const RADIUS_PX: (f64, f64) = (2.2, 7.0);

/// Radius relative to the distance that intersections would have if they were spread evenly.
const RADIUS: f64 = 0.1;

/// Half the width of the cross of a signal that is no intersection, pixels.
const CROSS_PX: f64 = 3.2;

/// Colour of the crosses.
const CROSS: &str = "#7a0177";

/// Least known share of the classes of intersections, most known first; less is the last class.
const LIMITS: [f64; 5] = [1.0, 2.0 / 3.0, 0.5, 1.0 / 3.0, 1e-6];

/// Names of the classes.
const CLASSES: [&str; 6] = ["all", "67 to 99%", "50 to 66%", "33 to 49%", "1 to 32%", "none"];

/// Colour and width of streets by importance, minor ones first, pixels.
const STREETS: [(&str, f64); 4] =
    [("#d4d4d4", 0.8), ("#c6c6c6", 1.1), ("#b4b4b4", 1.6), ("#a0a0a0", 2.4)];

/// Draws the map; `None` when there is nothing to draw.
pub(super) fn map(q: &Quality, drawing: &Drawing) -> Option<String> {
    let [south, west, north, east] = drawing.frame;
    if q.spots.is_empty() || south >= north || west >= east {
        return None;
    }
    let frame = frame(q.spots.len());
    let view = MapView::new(drawing.frame, frame);
    let bottom = frame.top_px + view.height;
    let mut canvas = Canvas::new(WIDTH, bottom + BELOW_PX);
    for (layer, (color, width)) in STREETS.into_iter().enumerate() {
        let streets = drawing.streets.iter().filter(|(rank, _)| *rank == layer);
        let d = view.path(streets.map(|(_, places)| places.iter().copied()));
        if !d.is_empty() {
            canvas.path(d, color, width, None);
        }
    }
    let mut crosses: BTreeMap<&str, String> = BTreeMap::new();
    for (latitude, longitude, reason) in &drawing.skipped {
        let ((x, y), r) = (view.place(*latitude, *longitude), CROSS_PX);
        let (w, s) = (x - r, y - r);
        let d = crosses.entry(*reason).or_default();
        write!(d, "M{w:.1} {s:.1}l{0:.1} {0:.1}m0-{0:.1}l-{0:.1} {0:.1}", 2.0 * r)
            .expect("writing to a string cannot fail");
    }
    for (reason, d) in crosses {
        canvas.path(d, CROSS, 1.5, Some(&format!("signal that is no intersection: {reason}")));
    }
    // The least known are drawn last, so that they are not hidden.
    let mut spots: Vec<&Spot> = q.spots.iter().collect();
    spots.sort_by(|a, b| b.known.total_cmp(&a.known));
    let radius = radius(q.spots.len(), view.height);
    for spot in spots {
        let at = view.place(spot.latitude, spot.longitude);
        canvas.circle(at, radius, palette::KNOWN[class(spot.known)], Some(&tip(spot)));
    }
    view.frame(&mut canvas, BELOW_PX);
    legend(&mut canvas, q, drawing);
    let note = "north is up; \u{a9} OpenStreetMap contributors, ODbL 1.0";
    scale_bar(&mut canvas, view.pixels_per_km, (8.0, bottom + 18.0), note);
    let counts = counts(q);
    let of = |c: &usize| format!("{} known: {}", CLASSES[*c], counts[*c]);
    let description: Vec<String> =
        (0..CLASSES.len()).filter(|c| counts[*c] > 0).map(|c| of(&c)).collect();
    let title = format!("Map of {}", format::count(q.spots.len(), "intersection"));
    Some(canvas.finish("map-figure", &title, &description.join("; ")))
}

/// Returns how the map of so many intersections lies on its canvas.
fn frame(spots: usize) -> MapFrame {
    MapFrame {
        height_px: (if spots > FEW { HEIGHT_PX.0 } else { HEIGHT_PX.1 }, 300.0),
        side_px: 2.0,
        top_px: 68.0,
        air_px: 0.0,
        least_km: 0.0,
        piece_px: 0.0,
    }
}

fn radius(spots: usize, height: f64) -> f64 {
    (RADIUS * (WIDTH * height / spots as f64).sqrt()).clamp(RADIUS_PX.0, RADIUS_PX.1)
}

fn class(known: f64) -> usize {
    LIMITS.iter().filter(|limit| known < **limit - 1e-9).count()
}

fn counts(q: &Quality) -> [usize; CLASSES.len()] {
    let mut counts = [0; CLASSES.len()];
    for spot in &q.spots {
        counts[class(spot.known)] += 1;
    }
    counts
}

fn tip(spot: &Spot) -> String {
    format!("{}: {}; {} arms; {} known", spot.id, streets(spot), spot.arms, percent(spot.known))
}

fn legend(canvas: &mut Canvas, q: &Quality, drawing: &Drawing) {
    let start = TextStyle::new(Anchor::Start);
    canvas.text(4.0, 20.0, "known:", start.bold());
    let slot = (WIDTH - 64.0) / CLASSES.len() as f64;
    for (c, (name, n)) in CLASSES.into_iter().zip(counts(q)).enumerate() {
        let x = 60.0 + slot * c as f64;
        canvas.circle((x + 6.0, 15.5), 6.0, palette::KNOWN[c], None);
        canvas.text(x + 17.0, 20.0, &format!("{name} ({n})"), start);
    }
    let mut x = 60.0;
    if !drawing.skipped.is_empty() {
        let d = format!("M{} 40.5l9 9m0-9l-9 9", x + 1.5);
        canvas.path(d, CROSS, 1.8, None);
        canvas.text(x + 17.0, 49.5, "signal that is no intersection", start);
        x += 2.0 * slot;
    }
    for ((color, width), name) in
        STREETS.into_iter().zip(["minor", "tertiary", "secondary", "primary, trunk"])
    {
        canvas.line((x, 45.0), (x + 16.0, 45.0), color, width + 0.6, None);
        canvas.text(x + 21.0, 49.5, name, start.color(MUTED));
        x += 0.72 * slot;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_is_in_the_class_that_starts_there() {
        assert_eq!([1.0, 0.99, 8.0 / 12.0, 4.0 / 12.0, 0.2, 0.0].map(class), [0, 1, 1, 3, 4, 5]);
    }

    #[test]
    fn circles_shrink_with_their_number() {
        assert_eq!(radius(1, 400.0), RADIUS_PX.1);
        assert!((2.5..4.0).contains(&radius(624, 850.0)));
        assert_eq!(radius(100_000, 850.0), RADIUS_PX.0);
    }
}

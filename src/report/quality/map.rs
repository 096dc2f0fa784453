//! The map of a derived family: streets, intersections coloured by how much of them is known, and
//! signals that are none.
//!
//! The projection is equirectangular with the longitudes scaled by the cosine of the mean latitude,
//! as on the map of a report.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::report::figures::WIDTH;
use crate::report::map::{KM_PER_DEGREE, scale_bar};
use crate::report::svg::{Anchor, Canvas, MUTED, TextStyle};
use crate::report::{format, palette};
use crate::traffic::city::drawing::{Drawing, DrawnStreet};
use crate::traffic::city::quality::Quality;
use crate::traffic::city::spots::Spot;
use crate::traffic::city::surroundings::rank;

use super::text::percent;

/// Largest height of the map itself, with many and with few intersections, pixels.
const HEIGHT_PX: (f64, f64) = (900.0, 480.0);

/// Number of intersections up to which they are few.
const FEW: usize = 12;

/// Smallest height of the map itself, pixels.
const MIN_HEIGHT_PX: f64 = 300.0;

/// Space beside, above (for the legend) and below the map (for the scale bar), pixels.
const MARGIN_PX: (f64, f64, f64) = (2.0, 68.0, 34.0);

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
    let view = View::new(drawing.frame, q.spots.len());
    let (side, top, below) = MARGIN_PX;
    let (right, bottom) = (WIDTH - side, top + view.height);
    let mut canvas = Canvas::new(WIDTH, bottom + below);
    for (layer, (color, width)) in STREETS.into_iter().enumerate() {
        let streets = drawing.streets.iter().filter(|s| rank(s.highway) == layer);
        let d = path(streets, &view);
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
    // Streets that leave the map are covered by its margins.
    for (a, b) in [
        ((0.0, 0.0), (WIDTH, top)),
        ((0.0, bottom), (WIDTH, bottom + below)),
        ((0.0, top), (side, bottom)),
        ((right, top), (WIDTH, bottom)),
    ] {
        canvas.rect(a, b, "#ffffff", None);
    }
    let corners = vec![(side, top), (right, top), (right, bottom), (side, bottom), (side, top)];
    canvas.polyline(corners, MUTED, 1.0, None);
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

/// Where places are on the canvas.
struct View {
    middle: (f64, f64),
    km_per_degree: (f64, f64),
    pixels_per_km: f64,
    height: f64,
}

impl View {
    fn new([south, west, north, east]: [f64; 4], spots: usize) -> Self {
        let highest = if spots > FEW { HEIGHT_PX.0 } else { HEIGHT_PX.1 };
        let middle = ((south + north) / 2.0, (west + east) / 2.0);
        let km_per_degree = (KM_PER_DEGREE, KM_PER_DEGREE * middle.0.to_radians().cos());
        let (high, wide) = ((north - south) * km_per_degree.0, (east - west) * km_per_degree.1);
        let pixels_per_km = ((WIDTH - 2.0 * MARGIN_PX.0) / wide).min(highest / high);
        let height = (high * pixels_per_km).max(MIN_HEIGHT_PX);
        Self { middle, km_per_degree, pixels_per_km, height }
    }

    fn place(&self, latitude: f64, longitude: f64) -> (f64, f64) {
        let east = (longitude - self.middle.1) * self.km_per_degree.1;
        let north = (latitude - self.middle.0) * self.km_per_degree.0;
        let middle = (WIDTH / 2.0, MARGIN_PX.1 + self.height / 2.0);
        (middle.0 + east * self.pixels_per_km, middle.1 - north * self.pixels_per_km)
    }

    /// Returns whether a line between two places on the canvas surely misses the map.
    fn misses(&self, a: (f64, f64), b: (f64, f64)) -> bool {
        let bottom = MARGIN_PX.1 + self.height;
        a.0.max(b.0) < 0.0
            || a.0.min(b.0) > WIDTH
            || a.1.max(b.1) < MARGIN_PX.1
            || a.1.min(b.1) > bottom
    }
}

/// Returns the path data of streets: absolute starts and relative lines in tenths of a pixel, so
/// that rounding does not add up.
fn path<'a>(streets: impl Iterator<Item = &'a DrawnStreet>, view: &View) -> String {
    let mut d = String::new();
    for street in streets {
        let places: Vec<(f64, f64)> = street.places.iter().map(|p| view.place(p.0, p.1)).collect();
        let mut pen = None;
        for (a, b) in places.iter().zip(places.iter().skip(1)) {
            if view.misses(*a, *b) {
                pen = None;
                continue;
            }
            let tenths = |(x, y): (f64, f64)| ((x * 10.0).round(), (y * 10.0).round());
            let (a, b) = (tenths(*a), tenths(*b));
            let separator = if pen == Some(a) { " " } else { "l" };
            if pen != Some(a) {
                write!(d, "M{} {}", a.0 / 10.0, a.1 / 10.0).expect("a string takes all");
            }
            let (x, y) = ((b.0 - a.0) / 10.0, (b.1 - a.1) / 10.0);
            write!(d, "{separator}{x} {y}").expect("a string takes all");
            pen = Some(b);
        }
    }
    d
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
    let streets = match spot.streets.is_empty() {
        true => "streets without a name".to_owned(),
        false => spot.streets.join(" / "),
    };
    format!("{}: {streets}; {} arms; {} known", spot.id, spot.arms.len(), percent(spot.known))
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
    use osm_signals::tags::Highway;

    #[test]
    fn a_third_is_in_the_class_that_starts_there() {
        assert_eq!([1.0, 0.99, 8.0 / 12.0, 4.0 / 12.0, 0.2, 0.0].map(class), [0, 1, 1, 3, 4, 5]);
    }

    #[test]
    fn a_street_is_one_line_and_what_is_outside_is_left_out() {
        let view = View::new([0.0, 0.0, 1.0, 1.0], 100);
        let places = vec![(0.5, 0.5), (0.5, 0.6), (0.5, 0.7), (0.5, 3.0), (0.5, 4.0)];
        let street = DrawnStreet { highway: Highway::Primary, places };
        let d = path(std::iter::once(&street), &view);
        assert_eq!((d.matches('M').count(), d.matches(' ').count()), (1, 6), "{d}");
    }

    #[test]
    fn circles_shrink_with_their_number() {
        assert_eq!(radius(1, 400.0), RADIUS_PX.1);
        assert!((2.5..4.0).contains(&radius(624, 850.0)));
        assert_eq!(radius(100_000, 850.0), RADIUS_PX.0);
    }
}

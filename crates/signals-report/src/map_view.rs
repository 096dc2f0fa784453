//! Where places are on a map, and how far apart.
//!
//! The projection is equirectangular with the longitudes scaled by the cosine of the mean latitude,
//! which is exact to less than 1% across a city.

use std::fmt::Write;

use evaluation::report::WIDTH;
use evaluation::report::svg::{Anchor, Canvas, INK, MUTED, TextStyle, nice_step};

/// Length of a degree of latitude, kilometres (mean radius of the Earth 6371 km).
const KM_PER_DEGREE: f64 = 111.195;

/// Largest and smallest height of the map itself, pixels.
const HEIGHT_PX: (f64, f64) = (860.0, 240.0);

/// Space beside the map, pixels.
pub(super) const SIDE_PX: f64 = 2.0;

/// Space above it, for the legend, pixels.
pub(super) const TOP_PX: f64 = 58.0;

/// Space between the outermost places and its edge, pixels.
const AIR_PX: f64 = 22.0;

/// Smallest height and width that is shown, kilometres: a single place gets a neighbourhood.
const LEAST_KM: f64 = 1.0;

/// Shortest piece of a street that is drawn, pixels.
const PIECE_PX: f64 = 1.2;

/// Maps degrees to the canvas.
pub(super) struct MapView {
    middle: (f64, f64),
    km_per_degree: (f64, f64),
    /// Pixels per kilometre.
    pub(super) pixels_per_km: f64,
    /// Height of the map itself, pixels.
    pub(super) height: f64,
}

impl MapView {
    /// Returns the view of places, latitude and longitude; `None` of none.
    pub(super) fn of(places: impl Iterator<Item = (f64, f64)>) -> Option<Self> {
        let most = f64::INFINITY;
        let ends = |[s, w, n, e]: [f64; 4], (latitude, longitude): (f64, f64)| {
            [s.min(latitude), w.min(longitude), n.max(latitude), e.max(longitude)]
        };
        let [south, west, north, east] = places.fold([most, most, -most, -most], ends);
        if south > north {
            return None;
        }
        let middle = ((south + north) / 2.0, (west + east) / 2.0);
        let km_per_degree = (KM_PER_DEGREE, KM_PER_DEGREE * middle.0.to_radians().cos());
        let high = ((north - south) * km_per_degree.0).max(LEAST_KM);
        let wide = ((east - west) * km_per_degree.1).max(LEAST_KM);
        let air = 2.0 * AIR_PX;
        let room = (WIDTH - 2.0 * SIDE_PX - air, HEIGHT_PX.0 - air);
        let pixels_per_km = (room.0 / wide).min(room.1 / high);
        let height = (high * pixels_per_km + air).max(HEIGHT_PX.1);
        Some(Self { middle, km_per_degree, pixels_per_km, height })
    }

    pub(super) fn place(&self, latitude: f64, longitude: f64) -> (f64, f64) {
        let east = (longitude - self.middle.1) * self.km_per_degree.1;
        let north = (latitude - self.middle.0) * self.km_per_degree.0;
        let middle = (WIDTH / 2.0, TOP_PX + self.height / 2.0);
        (middle.0 + east * self.pixels_per_km, middle.1 - north * self.pixels_per_km)
    }

    /// Returns whether a line between two places on the canvas surely misses the map.
    fn misses(&self, a: (f64, f64), b: (f64, f64)) -> bool {
        let (top, bottom) = (TOP_PX, TOP_PX + self.height);
        let (left, right, low, high) = (a.0.min(b.0), a.0.max(b.0), a.1.max(b.1), a.1.min(b.1));
        right < 0.0 || left > WIDTH || low < top || high > bottom
    }

    /// Returns the path data of lines of latitude and longitude: absolute starts and relative pieces in
    /// tenths of a pixel, so that rounding does not add up; pieces that nobody could see are joined.
    pub(super) fn path<L>(&self, lines: impl Iterator<Item = L>) -> String
    where
        L: Iterator<Item = (f64, f64)>,
    {
        let mut d = String::new();
        for line in lines {
            let places: Vec<(f64, f64)> = line.map(|(lat, lon)| self.place(lat, lon)).collect();
            let mut pen = None;
            let mut from = places.first().copied();
            for (i, to) in places.iter().enumerate().skip(1) {
                let Some(a) = from else { break };
                let short = (to.0 - a.0).hypot(to.1 - a.1) < PIECE_PX;
                if short && i + 1 < places.len() {
                    continue;
                }
                from = Some(*to);
                if self.misses(a, *to) {
                    pen = None;
                    continue;
                }
                let tenths = |(x, y): (f64, f64)| ((x * 10.0).round(), (y * 10.0).round());
                let (a, b) = (tenths(a), tenths(*to));
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

    /// Draws the map's edge, and covers the streets that leave it, also in the space below it.
    pub(super) fn frame(&self, canvas: &mut Canvas, below_px: f64) {
        let (left, top) = (SIDE_PX, TOP_PX);
        let (right, bottom) = (WIDTH - left, top + self.height);
        for (a, b) in [
            ((0.0, 0.0), (WIDTH, top)),
            ((0.0, bottom), (WIDTH, bottom + below_px)),
            ((0.0, top), (left, bottom)),
            ((right, top), (WIDTH, bottom)),
        ] {
            canvas.rect(a, b, "#ffffff", None);
        }
        let corners = vec![(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
        canvas.polyline(corners, MUTED, 1.0, None);
    }
}

/// Draws a scale bar from `x` on, and a note at the right end that says where north is.
pub(super) fn scale_bar(canvas: &mut Canvas, pixels_per_km: f64, (x, y): (f64, f64), note: &str) {
    let km = nice_step(180.0 / pixels_per_km, 1.0);
    let to = x + km * pixels_per_km;
    canvas.line((x, y), (to, y), INK, 2.0, None);
    for x in [x, to] {
        canvas.line((x, y - 5.0), (x, y + 5.0), INK, 2.0, None);
    }
    let length = if km < 1.0 { format!("{} m", 1000.0 * km) } else { format!("{km} km") };
    canvas.text(to + 10.0, y + 4.5, &length, TextStyle::new(Anchor::Start));
    canvas.text(WIDTH - 12.0, y + 4.5, note, TextStyle::new(Anchor::End).color(MUTED));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> MapView {
        MapView::of([(40.0, -111.0), (40.01, -110.99)].into_iter()).unwrap()
    }

    fn path(view: &MapView, lines: &[&[(f64, f64)]]) -> String {
        view.path(lines.iter().map(|line| line.iter().copied()))
    }

    #[test]
    fn a_single_place_is_in_the_middle_of_a_neighbourhood_and_none_has_no_view() {
        let view = MapView::of(std::iter::once((40.0, -111.0))).unwrap();
        let (x, y) = view.place(40.0, -111.0);
        assert_eq!((x, y), (WIDTH / 2.0, TOP_PX + view.height / 2.0));
        assert!(MapView::of(std::iter::empty()).is_none());
    }

    #[test]
    fn all_places_are_within_the_frame() {
        let view = view();
        let (left, top, air) = (SIDE_PX, TOP_PX, AIR_PX);
        for (latitude, longitude) in [(40.0, -111.0), (40.01, -110.99)] {
            let (x, y) = view.place(latitude, longitude);
            assert!((left + air - 0.1..=WIDTH - air).contains(&x), "{x}");
            assert!((top + air - 0.1..=top + view.height).contains(&y), "{y}");
        }
    }

    #[test]
    fn a_street_loses_what_is_too_small_and_what_is_outside() {
        let small = 1e-7;
        let line = [(40.0, -111.0), (40.0, -111.0 + small), (40.0, -110.995), (45.0, -110.995)];
        let d = path(&view(), &[&line, &[(40.0, -120.0), (40.0, -119.0)]]);
        assert_eq!((d.matches('M').count(), d.matches('l').count()), (1, 1), "{d}");
    }

    #[test]
    fn a_street_is_one_line_and_what_is_outside_is_left_out() {
        let view = MapView::of([(0.0, 0.0), (1.0, 1.0)].into_iter()).unwrap();
        let d = path(&view, &[&[(0.5, 0.5), (0.5, 0.6), (0.5, 0.7), (0.5, 3.0), (0.5, 4.0)]]);
        assert_eq!((d.matches('M').count(), d.matches(' ').count()), (1, 6), "{d}");
    }
}

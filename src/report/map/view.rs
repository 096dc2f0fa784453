//! Where places are on the map.

use std::fmt::Write;

use super::KM_PER_DEGREE;
use crate::report::figures::WIDTH;

/// Largest and smallest height of the map itself, pixels.
const HEIGHT_PX: (f64, f64) = (860.0, 240.0);

/// Space beside, above (for the legend) and below the map (for the scale bar), pixels.
pub(super) const MARGIN_PX: (f64, f64, f64) = (2.0, 58.0, 34.0);

/// Space between the outermost intersections and the edge of the map, pixels.
const AIR_PX: f64 = 22.0;

/// Smallest height and width that is shown, kilometres: a single place gets a neighbourhood.
const LEAST_KM: f64 = 1.0;

/// Shortest piece of a street that is drawn, pixels.
const PIECE_PX: f64 = 1.2;

/// Maps degrees to the canvas.
pub(super) struct View {
    middle: (f64, f64),
    km_per_degree: (f64, f64),
    pub(super) pixels_per_km: f64,
    pub(super) height: f64,
}

impl View {
    /// Returns the view of places, latitude and longitude; `None` of none.
    pub(super) fn new(places: impl Iterator<Item = (f64, f64)> + Clone) -> Option<Self> {
        let range = |of: fn((f64, f64)) -> f64| {
            let values = places.clone().map(of);
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
        };
        let ((south, north), (west, east)) = (range(|p| p.0), range(|p| p.1));
        if south > north {
            return None;
        }
        let middle = ((south + north) / 2.0, (west + east) / 2.0);
        let km_per_degree = (KM_PER_DEGREE, KM_PER_DEGREE * middle.0.to_radians().cos());
        let high = ((north - south) * km_per_degree.0).max(LEAST_KM);
        let wide = ((east - west) * km_per_degree.1).max(LEAST_KM);
        let room = (WIDTH - 2.0 * MARGIN_PX.0 - 2.0 * AIR_PX, HEIGHT_PX.0 - 2.0 * AIR_PX);
        let pixels_per_km = (room.0 / wide).min(room.1 / high);
        let height = (high * pixels_per_km + 2.0 * AIR_PX).max(HEIGHT_PX.1);
        Some(Self { middle, km_per_degree, pixels_per_km, height })
    }

    /// Returns where a place is on the canvas.
    pub(super) fn place(&self, latitude: f64, longitude: f64) -> (f64, f64) {
        let east = (longitude - self.middle.1) * self.km_per_degree.1;
        let north = (latitude - self.middle.0) * self.km_per_degree.0;
        let middle = (WIDTH / 2.0, MARGIN_PX.1 + self.height / 2.0);
        (middle.0 + east * self.pixels_per_km, middle.1 - north * self.pixels_per_km)
    }

    /// Returns whether a line between two places on the canvas surely misses the map.
    fn misses(&self, a: (f64, f64), b: (f64, f64)) -> bool {
        let bottom = MARGIN_PX.1 + self.height;
        let (left, right, low, high) = (a.0.min(b.0), a.0.max(b.0), a.1.max(b.1), a.1.min(b.1));
        right < 0.0 || left > WIDTH || low < MARGIN_PX.1 || high > bottom
    }

    /// Returns the path data of lines of longitude and latitude: absolute starts and relative pieces in
    /// tenths of a pixel, so that rounding does not add up; pieces that nobody could see are joined.
    pub(super) fn path(&self, lines: &[Vec<[f64; 2]>]) -> String {
        let mut d = String::new();
        for line in lines {
            let places: Vec<(f64, f64)> =
                line.iter().map(|[lon, lat]| self.place(*lat, *lon)).collect();
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
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> View {
        View::new([(40.0, -111.0), (40.01, -110.99)].into_iter()).unwrap()
    }

    #[test]
    fn a_single_place_is_in_the_middle_of_a_neighbourhood_and_none_has_no_view() {
        let view = View::new(std::iter::once((40.0, -111.0))).unwrap();
        let (x, y) = view.place(40.0, -111.0);
        assert_eq!((x, y), (WIDTH / 2.0, MARGIN_PX.1 + view.height / 2.0));
        assert!(View::new(std::iter::empty()).is_none());
    }

    #[test]
    fn all_places_are_within_the_frame() {
        let view = view();
        for (latitude, longitude) in [(40.0, -111.0), (40.01, -110.99)] {
            let (x, y) = view.place(latitude, longitude);
            assert!((MARGIN_PX.0 + AIR_PX - 0.1..=WIDTH - AIR_PX).contains(&x), "{x}");
            assert!((MARGIN_PX.1 + AIR_PX - 0.1..=MARGIN_PX.1 + view.height).contains(&y), "{y}");
        }
    }

    #[test]
    fn a_street_loses_what_is_too_small_and_what_is_outside() {
        let small = 1e-7;
        let line = vec![[-111.0, 40.0], [-111.0 + small, 40.0], [-110.995, 40.0], [-110.995, 45.0]];
        let d = view().path(&[line, vec![[-120.0, 40.0], [-119.0, 40.0]]]);
        assert_eq!((d.matches('M').count(), d.matches('l').count()), (1, 1), "{d}");
    }
}

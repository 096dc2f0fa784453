//! A map of the real instances of the point MDPs, coloured by what the best method achieves there.
//!
//! The projection is equirectangular with the longitudes scaled by the cosine of the mean latitude,
//! which is exact to less than 1% across a city.

use super::data::{MethodSummary, ReportData};
use super::figures::{Figure, WIDTH};
use super::level_of_service::{DELAY, LEVELS, level, range};
use super::svg::{Anchor, Canvas, INK, MUTED, TextStyle, nice_step};
use super::{format, palette};

/// Length of a degree of latitude, kilometres (mean radius of the Earth 6371 km).
pub(super) const KM_PER_DEGREE: f64 = 111.195;

/// Largest and smallest height of the map itself, pixels.
const HEIGHT_PX: (f64, f64) = (240.0, 760.0);

/// Space around the map, pixels: for the legend above and the scale bar below.
const MARGIN_PX: (f64, f64, f64) = (24.0, 56.0, 44.0);

/// Limits of the colours when the objective is no delay: scores.
const SCORE_LIMITS: [f64; 5] = [0.4, 0.6, 0.8, 1.0, 1.5];

/// A real instance of a point MDP.
struct Place {
    latitude: f64,
    longitude: f64,
    /// Position in [`palette::ORDERED`]; `None` without a result.
    class: Option<usize>,
    /// What the pointer shows.
    tip: String,
}

/// Draws the map; `None` when no place is known or no method has an estimate.
pub(super) fn places(data: &ReportData) -> Option<Figure> {
    let best = data.best()?;
    let places = known_places(data, best);
    if places.is_empty() {
        return None;
    }
    let (south, north) = bounds(places.iter().map(|p| p.latitude));
    let (west, east) = bounds(places.iter().map(|p| p.longitude));
    let km_x = KM_PER_DEGREE * ((south + north) / 2.0).to_radians().cos();
    // A single place still gets a neighbourhood of a kilometre.
    let (wide, high) =
        (((east - west) * km_x).max(1.0), ((north - south) * KM_PER_DEGREE).max(1.0));
    let (side, top, below) = MARGIN_PX;
    let pixels = ((WIDTH - 2.0 * side) / wide).min(HEIGHT_PX.1 / high);
    let map_height = (high * pixels).max(HEIGHT_PX.0);
    let (mid_lat, mid_lon) = ((south + north) / 2.0, (west + east) / 2.0);
    let mut canvas = Canvas::new(WIDTH, top + map_height + below);
    canvas.rect((1.0, top - 14.0), (WIDTH - 1.0, top + map_height + 14.0), "#fafafa", Some(MUTED));
    // The worst are drawn last, so that they are not hidden.
    let mut order: Vec<_> = places.iter().collect();
    order.sort_by_key(|p| p.class.map_or(0, |class| class + 1));
    for p in order {
        let x = WIDTH / 2.0 + (p.longitude - mid_lon) * km_x * pixels;
        let y = top + map_height / 2.0 - (p.latitude - mid_lat) * KM_PER_DEGREE * pixels;
        let fill = p.class.map_or(palette::UNKNOWN, |c| palette::ORDERED[c]);
        canvas.circle((x, y), 5.0, fill, Some(&p.tip));
    }
    legend(&mut canvas, data, places.iter().any(|p| p.class.is_none()));
    scale_bar(&mut canvas, pixels, (side, top + map_height + 32.0), "north is up");
    let counts: Vec<String> = (0..LEVELS.len())
        .map(|c| (c, places.iter().filter(|p| p.class == Some(c)).count()))
        .filter(|(_, n)| *n > 0)
        .map(|(c, n)| format!("{}: {n}", class_name(data, c)))
        .collect();
    let title = format!("Map of {} under {}", format::count(places.len(), "place"), best.method);
    Some(Figure { name: "map", svg: canvas.finish("map", &title, &counts.join("; ")) })
}

fn known_places(data: &ReportData, best: &MethodSummary) -> Vec<Place> {
    let objective = &data.manifest.identity.objective;
    let mut places = Vec::new();
    for point in &data.points {
        let result = point.results[best.index].as_ref();
        let class = result.and_then(|r| classify(data, r.objective, r.score));
        let tip = match result {
            Some(r) => format!(
                "{}: {objective} {}, score {}",
                point.row.point,
                format::delay(r.objective),
                r.score.map_or_else(|| "-".to_owned(), format::score)
            ),
            None => format!("{}: no result", point.row.point),
        };
        let known = point.row.places.iter().filter(|p| p.iter().all(|degrees| degrees.is_finite()));
        places.extend(known.map(|[latitude, longitude]| Place {
            latitude: *latitude,
            longitude: *longitude,
            class,
            tip: tip.clone(),
        }));
    }
    places
}

fn bounds(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

fn classify(data: &ReportData, objective: f64, score: Option<f64>) -> Option<usize> {
    match data.manifest.identity.objective == DELAY {
        true => Some(level(objective)),
        false => score.map(|s| SCORE_LIMITS.iter().filter(|l| s > **l).count()),
    }
}

fn class_name(data: &ReportData, class: usize) -> String {
    if data.manifest.identity.objective == DELAY {
        return format!("{}: {}", LEVELS[class], range(class));
    }
    match class {
        0 => format!("score to {}", SCORE_LIMITS[0]),
        c if c < SCORE_LIMITS.len() => format!("to {}", SCORE_LIMITS[c]),
        _ => format!("over {}", SCORE_LIMITS[SCORE_LIMITS.len() - 1]),
    }
}

fn legend(canvas: &mut Canvas, data: &ReportData, unknown: bool) {
    let mut entries: Vec<(&str, String)> = palette::ORDERED
        .into_iter()
        .enumerate()
        .map(|(class, color)| (color, class_name(data, class)))
        .collect();
    if unknown {
        entries.push((palette::UNKNOWN, "no result".to_owned()));
    }
    let slot = (WIDTH - 24.0) / entries.len() as f64;
    for (i, (color, label)) in entries.iter().enumerate() {
        let x = 12.0 + slot * i as f64;
        canvas.circle((x + 6.0, 18.0), 6.0, color, None);
        canvas.text(x + 17.0, 22.5, label, TextStyle::new(Anchor::Start));
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

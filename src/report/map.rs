//! A map of the intersections of the family, coloured by what the best method achieves there, with the
//! streets where a map of them is known.
//!
//! The projection is equirectangular with the longitudes scaled by the cosine of the mean latitude,
//! which is exact to less than 1% across a city.

mod legend;
mod view;

use super::data::ReportData;
use super::figures::{Figure, WIDTH};
use super::intersections::{Basis, basis};
use super::names::streets;
use super::svg::{Anchor, Canvas, INK, MUTED, TextStyle, nice_step};
use super::{format, palette};
use crate::analysis::MethodSummary;
use crate::store::places::Place;
use crate::traffic::report::level_of_service::{DELAY, LEVELS, level, range};
use view::{MARGIN_PX, View};

/// Length of a degree of latitude, kilometres (mean radius of the Earth 6371 km).
pub(super) const KM_PER_DEGREE: f64 = 111.195;

/// Smallest and largest radius of an intersection, pixels.
const RADIUS_PX: (f64, f64) = (6.0, 8.5);

/// Radius relative to the distance that intersections would have if they were spread evenly.
const RADIUS: f64 = 0.125;

/// Width of the ring of what was not simulated, relative to its radius.
const RING: f64 = 0.4;

/// Radius of what was not simulated, relative to that of what was.
const SMALLER: f64 = 0.82;

/// Height of a letter relative to the radius of its dot.
const LETTER: f64 = 1.4;

/// Colour and width of streets by rank, minor ones first, pixels.
const STREETS: [(&str, f64); 4] =
    [("#dedede", 0.8), ("#d2d2d2", 1.1), ("#c2c2c2", 1.6), ("#b0b0b0", 2.4)];

/// Limits of the colours when the objective is no delay: scores.
const SCORE_LIMITS: [f64; 5] = [0.4, 0.6, 0.8, 1.0, 1.5];

/// An intersection on the map.
struct Dot {
    at: (f64, f64),
    /// Position in [`palette::ORDERED`]; `None` without a result.
    class: Option<usize>,
    basis: Basis,
    /// What the pointer shows.
    tip: String,
}

/// Draws the map; `None` when no place is known or no method has an estimate.
pub(super) fn places(data: &ReportData) -> Option<Figure> {
    let best = data.best()?;
    let places = &data.places.intersections;
    let view = View::new(places.iter().map(|p| (p.latitude, p.longitude)))?;
    let mut dots: Vec<Dot> = places.iter().map(|p| dot(data, best, p, &view)).collect();
    let (side, top, below) = MARGIN_PX;
    let bottom = top + view.height;
    let mut canvas = Canvas::new(WIDTH, bottom + below);
    canvas.rect((side, top), (WIDTH - side, bottom), "#fafafa", None);
    for layer in &data.places.streets {
        let (color, width) = STREETS[layer.rank.min(STREETS.len() - 1)];
        let d = view.path(&layer.lines);
        if !d.is_empty() {
            canvas.path(d, color, width, None);
        }
    }
    // Streets that leave the map are covered by its margins.
    for (a, b) in [
        ((0.0, 0.0), (WIDTH, top)),
        ((0.0, bottom), (WIDTH, bottom + below)),
        ((0.0, top), (side, bottom)),
        ((WIDTH - side, top), (WIDTH, bottom)),
    ] {
        canvas.rect(a, b, "#ffffff", None);
    }
    let (left, right) = (side, WIDTH - side);
    let frame = vec![(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
    canvas.polyline(frame, MUTED, 1.0, None);
    // The worst are drawn last, so that they are not hidden.
    dots.sort_by_key(|d| d.class.map_or(0, |class| class + 1));
    let even = (WIDTH * view.height / dots.len() as f64).sqrt();
    let radius = (RADIUS * even).clamp(RADIUS_PX.0, RADIUS_PX.1);
    for dot in &dots {
        let letter = dot.class.and_then(|class| letter(data, class));
        draw(&mut canvas, dot.at, radius, (dot.class, dot.basis), letter, Some(&dot.tip));
    }
    legend::draw_legend(&mut canvas, data, &dots);
    let note = match data.places.streets.is_empty() {
        true => "north is up",
        false => "north is up; streets \u{a9} OpenStreetMap contributors, ODbL 1.0",
    };
    scale_bar(&mut canvas, view.pixels_per_km, (side + 8.0, bottom + 18.0), note);
    let counts: Vec<String> = (0..LEVELS.len())
        .map(|c| (c, dots.iter().filter(|d| d.class == Some(c)).count()))
        .filter(|(_, n)| *n > 0)
        .map(|(c, n)| format!("{}: {n}", class_name(data, c)))
        .collect();
    let title =
        format!("Map of {} under {}", format::count(dots.len(), "intersection"), best.method);
    Some(Figure { name: "map", svg: canvas.finish("map", &title, &counts.join("; ")) })
}

fn dot(data: &ReportData, best: &MethodSummary, place: &Place, view: &View) -> Dot {
    let objective = &data.manifest.identity.objective;
    let (basis, point) = basis(data, place);
    let point = point.map(|p| &data.points[p]);
    let result = point.and_then(|p| p.results[best.index].as_ref());
    let name = match (streets(place), place.id.as_str()) {
        (Some(streets), id) => format!("{streets} ({id})"),
        (None, "") => data.called(&place.point),
        (None, id) => format!("{id} ({})", place.point),
    };
    let of = match (basis, point) {
        (Basis::Represented, Some(p)) => {
            format!(" (of {}, which stands for it)", data.called(&p.row.point))
        }
        (Basis::PointMdp, Some(p)) if !place.id.is_empty() => format!(" (of {})", p.row.name()),
        _ => String::new(),
    };
    let tip = match result {
        Some(r) => format!(
            "{name}: {objective} {}{}, score {}{of}",
            format::delay(r.objective),
            class_letter(data, r.objective),
            r.score.map_or_else(|| "-".to_owned(), format::score)
        ),
        None => format!("{name}: no result"),
    };
    Dot {
        at: view.place(place.latitude, place.longitude),
        class: result.and_then(|r| classify(data, r.objective, r.score)),
        basis,
        tip,
    }
}

fn class_letter(data: &ReportData, objective: f64) -> String {
    match data.manifest.identity.objective == DELAY {
        true => format!(" (level {})", LEVELS[level(objective)]),
        false => String::new(),
    }
}

/// Draws an intersection: filled where it or its point MDP was simulated, else a ring.
fn draw(
    canvas: &mut Canvas,
    at: (f64, f64),
    radius: f64,
    (class, basis): (Option<usize>, Basis),
    letter: Option<char>,
    tip: Option<&str>,
) {
    let hollow = matches!(basis, Basis::Represented | Basis::None);
    let radius = if hollow { SMALLER * radius } else { radius };
    let color = class.map_or(palette::UNKNOWN, |c| palette::ORDERED[c]);
    canvas.circle(at, radius, if hollow { "#ffffff" } else { color }, tip);
    if hollow {
        let (width, r) = (RING * radius, radius * (1.0 - RING / 2.0) - 0.3);
        let (west, arc) = (at.0 - r, format!("a{r:.2} {r:.2} 0 1 0"));
        let d = format!("M{west:.1} {:.1}{arc} {:.2} 0{arc} {:.2} 0", at.1, 2.0 * r, -2.0 * r);
        canvas.path(d, color, width, tip);
    }
    if let (Some(letter), Some(class)) = (letter, class) {
        let ink = if hollow { INK } else { palette::ink_on(class) };
        let size = (LETTER * radius).round();
        let style = TextStyle::new(Anchor::Middle).bold().color(ink).sized(size as u32);
        canvas.text(at.0, at.1 + 0.36 * size, &letter.to_string(), style);
    }
}

fn classify(data: &ReportData, objective: f64, score: Option<f64>) -> Option<usize> {
    match data.manifest.identity.objective == DELAY {
        true => Some(level(objective)),
        false => score.map(|s| SCORE_LIMITS.iter().filter(|l| s > **l).count()),
    }
}

/// Returns the letter of a class, if classes have one.
fn letter(data: &ReportData, class: usize) -> Option<char> {
    (data.manifest.identity.objective == DELAY).then(|| LEVELS[class])
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

//! A map of the intersections of the family, coloured by what the best method achieves there, with the
//! streets where a map of them is known.

mod dot;

use super::intersections::{Basis, basis};
use super::level_of_service::{LEVELS, range};
use super::map_view::{MapView, SIDE_PX, TOP_PX, scale_bar};
use super::shown::Seen;
use dot::Dot;
use evaluation::report::svg::{Anchor, Canvas, TextStyle, text_width};
use evaluation::report::{Figure, WIDTH, format};

/// Space below the map for the scale bar, pixels.
const BELOW_PX: f64 = 34.0;

/// Smallest and largest radius of an intersection, pixels.
const RADIUS_PX: (f64, f64) = (6.0, 8.5);

/// Radius relative to the distance that intersections would have if they were spread evenly.
const RADIUS: f64 = 0.125;

/// Colour and width of streets by rank, minor ones first, pixels.
const STREETS: [(&str, f64); 4] =
    [("#dedede", 0.8), ("#d2d2d2", 1.1), ("#c2c2c2", 1.6), ("#b0b0b0", 2.4)];

/// Radius of the dots of the legend, pixels.
const LEGEND_PX: f64 = 7.0;

/// Distance of the first entry from the edge, pixels.
const LEFT_PX: f64 = 12.0;

/// Draws the map; `None` when no place is known or no method has an estimate.
pub(super) fn places(seen: Seen<'_>) -> Option<Figure> {
    let Seen { data, shown } = seen;
    let best = data.best()?;
    let places = &shown.places.intersections;
    let view = MapView::of(places.iter().map(|p| (p.latitude, p.longitude)))?;
    let numbered = places.iter().enumerate();
    let mut dots: Vec<Dot> = numbered.map(|(i, p)| Dot::new(seen, best, (i, p), &view)).collect();
    let (side, top) = (SIDE_PX, TOP_PX);
    let bottom = top + view.height;
    let mut canvas = Canvas::new(WIDTH, bottom + BELOW_PX);
    canvas.rect((side, top), (WIDTH - side, bottom), "#fafafa", None);
    for layer in &shown.places.streets {
        let (color, width) = STREETS[layer.rank.min(STREETS.len() - 1)];
        let line = |line: &Vec<[f64; 2]>| line.clone().into_iter().map(|[lon, lat]| (lat, lon));
        let d = view.path(layer.lines.iter().map(line));
        if !d.is_empty() {
            canvas.path(d, color, width, None);
        }
    }
    view.frame(&mut canvas, BELOW_PX);
    // The worst are drawn last, so that they are not hidden.
    dots.sort_by_key(|d| d.class.map_or(0, |class| class + 1));
    let even = (WIDTH * view.height / dots.len() as f64).sqrt();
    let radius = (RADIUS * even).clamp(RADIUS_PX.0, RADIUS_PX.1);
    for dot in &dots {
        let letter = dot.class.map(|class| LEVELS[class]);
        let number = dot.number;
        let attributes = format!("id=\"dot-{number}\" data-row=\"row-{number}\"");
        let look = (dot.class, dot.basis);
        canvas.group(&dot.tip, Some(attributes), |canvas| {
            dot::draw(canvas, dot.at, radius, look, letter);
        });
    }
    draw_legend(&mut canvas, &dots);
    let note = match shown.places.streets.is_empty() {
        true => "north is up",
        false => "north is up; streets \u{a9} OpenStreetMap contributors, ODbL 1.0",
    };
    scale_bar(&mut canvas, view.pixels_per_km, (side + 8.0, bottom + 18.0), note);
    let counts: Vec<String> = (0..LEVELS.len())
        .map(|c| (c, dots.iter().filter(|d| d.class == Some(c)).count()))
        .filter(|(_, n)| *n > 0)
        .map(|(c, n)| format!("{}: {}: {n}", LEVELS[c], range(c)))
        .collect();
    let title =
        format!("Map of {} under {}", format::count(dots.len(), "intersection"), best.method);
    let figure = canvas.figure("map", &title, &counts.join("; "));
    Some(Figure { svg: linked(figure.svg, seen, &dots), ..figure })
}

/// Lets the dots of intersections that have a page of their own lead to it.
fn linked(mut svg: String, seen: Seen<'_>, dots: &[Dot]) -> String {
    let pages = super::pages::links(seen);
    for dot in dots {
        let point = basis(seen.data, &seen.shown.places.intersections[dot.number]).1;
        let Some(page) = point.and_then(|point| pages.get(&point)) else { continue };
        let id = format!("id=\"dot-{}\"", dot.number);
        let Some(at) = svg.find(&id) else { continue };
        let (Some(from), Some(to)) = (svg[..at].rfind("<g"), svg[at..].find("</g>")) else {
            continue;
        };
        svg.insert_str(at + to + "</g>".len(), "</a>");
        svg.insert_str(from, &format!("<a href=\"{page}\">"));
    }
    svg
}

/// Draws the classes in a first row, and in a second one what else is on the map.
fn draw_legend(canvas: &mut Canvas, dots: &[Dot]) {
    let style = TextStyle::new(Anchor::Start);
    let slot = (WIDTH - 2.0 * LEFT_PX) / LEVELS.len() as f64;
    for (class, letter) in LEVELS.into_iter().enumerate() {
        let x = LEFT_PX + slot * class as f64;
        let at = (x + LEGEND_PX, 16.0);
        dot::draw(canvas, at, LEGEND_PX, (Some(class), Basis::PointMdp), Some(letter));
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
        dot::draw(canvas, (x + LEGEND_PX, 40.0), LEGEND_PX, (class, basis), None);
        canvas.text(x + 19.0, 44.5, text, style);
        x += 19.0 + text_width(text) + 16.0;
    }
}

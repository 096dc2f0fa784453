//! The figures of a report, drawn from its data.

use super::data::ReportData;
use super::svg::{Anchor, Axes, Canvas, Frame, MUTED, TextStyle, nice_step, text_width};
use super::{format, palette};
use crate::analysis::MethodSummary;
use crate::stats::Histogram;
use crate::traffic::report::level_of_service::{DELAY, LEVELS, range, shares};

/// Width of all figures, pixels.
pub(super) const WIDTH: f64 = 900.0;

/// Largest score on the axis of the overall performance; more is drawn as an arrow at the edge.
pub(super) const OVERALL_LIMIT: f64 = 2.5;

/// Height of the row of a method, pixels.
const ROW_PX: f64 = 34.0;

/// Radius of the dot of an estimate, pixels.
const DOT_PX: f64 = 4.5;

/// Height of the panel of a method, pixels.
const PANEL_PX: f64 = 92.0;

/// Height of a panel relative to its highest bar, so that a label fits above.
const HEADROOM: f64 = 1.4;

/// Smallest height of a bar that counts anything, pixels.
const MIN_BAR_PX: f64 = 1.5;

/// Smallest share of a bar that has room for its label.
const LABELLED_SHARE: f64 = 0.075;

/// Smallest width of a bar that has room for its letter, pixels.
const LETTER_PX: f64 = 11.0;

/// A figure: its file name without extension, and the SVG.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Figure {
    /// File name without extension, also its id in the page.
    pub(super) name: &'static str,
    /// The SVG.
    pub(super) svg: String,
}

/// Returns the colour of a method.
pub(super) fn color(data: &ReportData, m: &MethodSummary) -> &'static str {
    let identity = &data.manifest.identity;
    let mut others = identity.methods.iter().filter(|name| **name != identity.baseline);
    match others.position(|name| *name == m.method) {
        Some(position) => data.looks.color(&m.method, position),
        None => palette::baseline(),
    }
}

/// Returns the name of a method, with the number of its point MDPs where it lacks some.
pub(super) fn label(data: &ReportData, m: &MethodSummary) -> String {
    match m.points < data.points.len() {
        true => format!("{} ({}/{})", m.method, m.points, data.points.len()),
        false => m.method.clone(),
    }
}

pub(super) fn widest_name(data: &ReportData) -> f64 {
    data.methods.iter().map(|m| text_width(&label(data, m))).fold(60.0, f64::max)
}

/// (a) Draws the overall performance of every method with its interval.
pub(super) fn overall(data: &ReportData) -> Option<Figure> {
    let methods: Vec<_> = data.methods.iter().filter(|m| m.overall.is_some()).collect();
    let largest = methods
        .iter()
        .filter_map(|m| Some(m.interval.map_or(m.overall?, |i| i.1)))
        .fold(1.0, f64::max);
    let limit = (largest * 1.06).min(OVERALL_LIMIT);
    let (left, right) = (widest_name(data) + 16.0, WIDTH - 190.0);
    let bottom = 30.0 + ROW_PX * methods.len() as f64;
    let mut canvas = Canvas::new(WIDTH, bottom + 56.0);
    let frame = canvas.axes(&Axes {
        area: (left, 30.0, right, bottom),
        x: (0.0, limit),
        y: (0.0, methods.len() as f64),
        x_step: nice_step(limit, 7.0),
        y_step: None,
        x_last: limit,
        x_label: Some(format!(
            "overall performance: {} relative to {} (lower is better)",
            noun(data),
            data.reference.name
        )),
        y_label: None,
    });
    reference_line(&mut canvas, data, &frame, (30.0, bottom), true);
    let style = TextStyle::new(Anchor::End);
    canvas.text(WIDTH - 10.0, 20.0, "score and 95% interval", style.color(MUTED));
    for (i, m) in methods.iter().enumerate() {
        let Some(value) = m.overall else { continue };
        let y = 30.0 + ROW_PX * (i as f64 + 0.5);
        canvas.text(left - 10.0, y + 4.5, &label(data, m), TextStyle::new(Anchor::End));
        mark(&mut canvas, &frame, (value, m.interval), (y, limit), color(data, m));
        canvas.text(WIDTH - 10.0, y + 4.5, &with_interval(m), TextStyle::new(Anchor::End));
    }
    let description =
        sentence(methods.iter().map(|m| format!("{} {}", label(data, m), with_interval(m))));
    let svg = canvas.finish("overall", "Overall performance of every method", &description);
    (!methods.is_empty()).then_some(Figure { name: "overall", svg })
}

/// Draws an estimate with its interval; what lies beyond the limit becomes an arrow at the edge.
pub(super) fn mark(
    canvas: &mut Canvas,
    frame: &Frame,
    (value, interval): (f64, Option<(f64, f64)>),
    (y, limit): (f64, f64),
    color: &str,
) {
    let x = |v: f64| frame.x(v.min(limit));
    let arrow = |canvas: &mut Canvas, size: f64| {
        let tip = x(limit) + size;
        canvas
            .shape(&[(tip - 2.0 * size, y - size), (tip, y), (tip - 2.0 * size, y + size)], color);
    };
    if let Some((low, high)) = interval.filter(|(low, _)| *low < limit) {
        canvas.line((x(low), y), (x(high), y), color, 3.0, None);
        // Caps next to the dot would only blur it.
        let caps = x(high) - x(low) > 4.0 * DOT_PX;
        for end in [low, high].into_iter().filter(|end| caps && *end < limit) {
            canvas.line((x(end), y - 6.0), (x(end), y + 6.0), color, 2.0, None);
        }
        if high >= limit && value < limit {
            arrow(canvas, 5.0);
        }
    }
    if value < limit {
        canvas.circle((x(value), y), DOT_PX, color, None);
    } else {
        arrow(canvas, 7.0);
    }
}

/// (b) Draws per method how many point MDPs reach which score, as in the paper's figure.
pub(super) fn distribution(data: &ReportData) -> Option<Figure> {
    let methods: Vec<_> = data.methods.iter().filter(|m| !m.is_reference && m.points > 0).collect();
    let scores = |m: &MethodSummary| -> Vec<f64> {
        data.results_of(m.index).filter_map(|(_, r)| r.score).collect()
    };
    let all: Vec<f64> = methods.iter().flat_map(|m| scores(m)).collect();
    let scale = Histogram::scale(&all);
    let histograms: Vec<_> = methods.iter().map(|m| Histogram::new(&scores(m), scale)).collect();
    let peak = histograms.iter().map(Histogram::peak).max()? as f64;
    let (limit, width) = scale;
    let beyond = histograms.iter().any(|h| h.over > 0);
    // The bin of everything beyond the limit is three bins wide, after a gap of one.
    let x_end = if beyond { limit + 4.0 * width } else { limit };
    let (left, right, top) = (widest_name(data).max(135.0) + 62.0, WIDTH - 24.0, 30.0);
    let height = top + PANEL_PX * methods.len() as f64 + 44.0;
    let mut canvas = Canvas::new(WIDTH, height);
    for (i, (m, h)) in methods.iter().zip(&histograms).enumerate() {
        let area_top = top + PANEL_PX * i as f64 + 8.0;
        let area = (left, area_top, right, area_top + PANEL_PX - 20.0);
        let last = i + 1 == methods.len();
        let frame = canvas.axes(&Axes {
            area,
            x: (0.0, x_end),
            y: (0.0, peak * HEADROOM),
            x_step: nice_step(limit, 8.0),
            y_step: Some(nice_step(peak, 3.0).max(1.0)),
            x_last: if beyond { limit - width } else { limit },
            x_label: last.then(|| {
                format!(
                    "score on a point MDP: {} relative to {} (lower is better)",
                    noun(data),
                    data.reference.name
                )
            }),
            y_label: None,
        });
        bars(&mut canvas, &frame, h, color(data, m));
        reference_line(&mut canvas, data, &frame, (area.1, area.3), i == 0);
        overall_mark(&mut canvas, &frame, m, h, area);
        let (y, style) = ((area.1 + area.3) / 2.0, TextStyle::new(Anchor::End));
        canvas.text(left - 44.0, y - 3.0, &label(data, m), style.bold());
        let note = format!("worse than {}: {}", data.reference.as_label(), worse(data, m));
        canvas.text(left - 44.0, y + 13.0, &note, style.small().color(MUTED));
        if last && beyond {
            let x = frame.x(limit + 2.5 * width);
            let label = format!("\u{2265} {limit}");
            canvas.text(x, area.3 + 17.0, &label, TextStyle::new(Anchor::Middle));
        }
    }
    canvas.text(8.0, 20.0, "number of point MDPs", TextStyle::new(Anchor::Start).color(MUTED));
    let description = sentence(methods.iter().zip(&histograms).map(|(m, h)| {
        let n = worse(data, m);
        let (name, of) = (label(data, m), data.reference.in_short());
        format!("{name}: worse than {of} on {n}, beyond the axis {}", h.over)
    }));
    let title = "Distribution of scores over point MDPs";
    Some(Figure { name: "distribution", svg: canvas.finish("distribution", title, &description) })
}

/// Returns on how many point MDPs a method is worse than what scores are divided by.
fn worse(data: &ReportData, m: &MethodSummary) -> usize {
    data.results_of(m.index).filter(|(_, r)| r.score > Some(1.0)).count()
}

fn bars(canvas: &mut Canvas, frame: &Frame, h: &Histogram, color: &str) {
    let bottom = frame.y(0.0);
    for (b, count) in h.counts.iter().enumerate().filter(|(_, c)| **c > 0) {
        let (x, y) = (frame.x(b as f64 * h.width), frame.y(*count as f64).min(bottom - MIN_BAR_PX));
        canvas.rect((x, bottom), (frame.x((b + 1) as f64 * h.width), y), color, Some("#ffffff"));
    }
    if h.over > 0 {
        let (x, x2) = (frame.x(h.limit + h.width), frame.x(h.limit + 4.0 * h.width));
        let y = frame.y(h.over as f64);
        canvas.rect((x, bottom), (x2, y), color, Some("#1a1a1a"));
        let style = TextStyle::new(Anchor::Middle);
        canvas.text((x + x2) / 2.0, y - 4.0, &h.over.to_string(), style);
    }
}

fn overall_mark(
    canvas: &mut Canvas,
    frame: &Frame,
    m: &MethodSummary,
    h: &Histogram,
    (_, top, _, bottom): (f64, f64, f64, f64),
) {
    let Some(value) = m.overall else { return };
    let label = format!("overall {}", format::score(value));
    if value >= h.limit {
        let x = frame.x(h.limit + h.width) - 6.0;
        let style = TextStyle::new(Anchor::End).bold();
        canvas.text(x, top + 11.0, &format!("{label} \u{2192}"), style);
        return;
    }
    let x = frame.x(value);
    canvas.line((x, top), (x, bottom), "#1a1a1a", 2.0, None);
    let (anchor, side) =
        if value > 0.8 * h.limit { (Anchor::End, -1.0) } else { (Anchor::Start, 1.0) };
    let end = x + side * (text_width(&label) + 6.0);
    canvas.rect((x + side * 2.0, top), (end, top + 15.0), "#ffffff", None);
    canvas.text(x + side * 5.0, top + 11.0, &label, TextStyle::new(anchor).bold());
}

pub(super) fn reference_line(
    canvas: &mut Canvas,
    data: &ReportData,
    frame: &Frame,
    (top, bottom): (f64, f64),
    labelled: bool,
) {
    let x = frame.x(1.0);
    canvas.line((x, top), (x, bottom), MUTED, 1.5, Some("5 4"));
    if labelled {
        let label = format!("{} = 1", data.reference.as_label());
        canvas.text(x, top - 8.0, &label, TextStyle::new(Anchor::Middle).color(MUTED));
    }
}

/// (c) Draws the importance-weighted share of the levels of service of every method.
pub(super) fn levels(data: &ReportData) -> Option<Figure> {
    if data.manifest.identity.objective != DELAY {
        return None;
    }
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
        let label = range(l);
        canvas.text(x + 22.0, 22.5, &label, TextStyle::new(Anchor::Start));
    }
    for (i, m) in methods.iter().enumerate() {
        let y = top + ROW_PX * i as f64;
        let middle = y + ROW_PX / 2.0 + 4.5;
        canvas.text(left - 10.0, middle, &label(data, m), TextStyle::new(Anchor::End));
        let mut from = 0.0;
        for (l, share) in level_shares(data, m).into_iter().enumerate().filter(|s| s.1 > 0.0) {
            let (a, b) = (frame.x(100.0 * from), frame.x(100.0 * (from + share)));
            let corners = ((a, y + 4.0), (b, y + ROW_PX - 4.0));
            canvas.rect(corners.0, corners.1, palette::ORDERED[l], Some("#1a1a1a"));
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
    let svg = canvas.finish("level-of-service", title, &description);
    (!methods.is_empty()).then_some(Figure { name: "level-of-service", svg })
}

/// Returns the share of the family at each level under a method.
pub(super) fn level_shares(data: &ReportData, m: &MethodSummary) -> [f64; LEVELS.len()] {
    shares(data.results_of(m.index).map(|(p, r)| (p.weight, r.objective)))
}

/// Returns the name of what scores compare, for labels.
pub(super) fn noun(data: &ReportData) -> &str {
    match data.manifest.identity.objective.as_str() {
        DELAY => "delay",
        other => other,
    }
}

pub(super) fn with_interval(m: &MethodSummary) -> String {
    let value = m.overall.map_or_else(|| "-".to_owned(), |v| format::score_within(v, m.interval));
    match m.interval {
        _ if m.is_reference => format!("{value} (by definition)"),
        Some(i) => format!("{value} ({})", format::interval(i)),
        None => format!("{value} (no interval)"),
    }
}

pub(super) fn sentence(parts: impl Iterator<Item = String>) -> String {
    parts.collect::<Vec<_>>().join("; ")
}

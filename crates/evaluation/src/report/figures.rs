//! The figures of a report, drawn from its data.

use super::figure::{Figure, WIDTH};
use super::svg::{Anchor, Axes, Canvas, Frame, INK, MUTED, TextStyle, nice_step, text_width};
use super::whole::Report;
use super::{format, palette};
use crate::analysis::{Analysis, MethodSummary};
use crate::stats::Histogram;

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

/// Dashes of methods that the domain does not know, in turn.
const UNKNOWN_DASHES: [Option<&str>; 4] = [None, Some("7 4"), Some("2 4"), Some("9 3 2 3")];

/// Smallest height of a bar that counts anything, pixels.
const MIN_BAR_PX: f64 = 1.5;

/// Returns the colour of a method.
pub(super) fn color(data: &Report, m: &MethodSummary) -> &'static str {
    let identity = &data.manifest.identity;
    let others = || identity.methods.iter().filter(|name| **name != identity.baseline);
    let look = |name: &String| data.sections.look(name).map(|look| look.color);
    if !others().any(|name| *name == m.method) {
        return palette::baseline();
    }
    look(&m.method).unwrap_or_else(|| {
        let taken: Vec<&str> = others().filter_map(look).collect();
        let mut unknown = others().filter(|name| look(name).is_none());
        palette::method(unknown.position(|name| *name == m.method).unwrap_or(0), &taken)
    })
}

/// Returns the dashes of a method's lines, `None` for solid ones; methods that the domain does not know differ in theirs, for
/// colours are few.
pub(super) fn dash(data: &Report, m: &MethodSummary) -> Option<&'static str> {
    let look = |name: &str| data.sections.look(name);
    if let Some(look) = look(&m.method) {
        return Some(look.dash).filter(|dash| !dash.is_empty());
    }
    let mut unknown = data.manifest.identity.methods.iter().filter(|name| look(name).is_none());
    UNKNOWN_DASHES[unknown.position(|name| *name == m.method).unwrap_or(0) % UNKNOWN_DASHES.len()]
}

/// Returns the ends of an axis of estimates: from 0 on, and where scores are relative no further than to a
/// limit.
fn axis_of(data: &Report, methods: &[&MethodSummary]) -> (f64, f64) {
    let ends = methods.iter().filter_map(|m| {
        let value = m.overall?;
        Some(m.interval.unwrap_or((value, value)))
    });
    let start: (f64, f64) = if data.reference.is_none() { (0.0, 0.0) } else { (0.0, 1.0) };
    let (least, most) = ends.fold(start, |(a, b), (low, high)| (a.min(low), b.max(high)));
    match data.reference.is_none() {
        true if least == most => (0.0, 1.0),
        true => {
            let pad = 0.06 * (most - least);
            (if least < 0.0 { least - pad } else { 0.0 }, most + pad)
        }
        false => (0.0, (most * 1.06).min(OVERALL_LIMIT)),
    }
}

/// Returns the name of a method, with the number of its point MDPs where it lacks some.
pub fn label(data: &Analysis, m: &MethodSummary) -> String {
    match m.points < data.points.len() {
        true => format!("{} ({}/{})", m.method, m.points, data.points.len()),
        false => m.method.clone(),
    }
}

/// Returns the width of the longest name of a method, pixels.
pub fn widest_name(data: &Analysis) -> f64 {
    data.methods.iter().map(|m| text_width(&label(data, m))).fold(60.0, f64::max)
}

/// (a) Draws the overall performance of every method with its interval.
pub(super) fn overall(data: &Report) -> Option<Figure> {
    let methods: Vec<_> = data.methods.iter().filter(|m| m.overall.is_some()).collect();
    let (least, limit) = axis_of(data, &methods);
    let (left, right) = (widest_name(data) + 16.0, WIDTH - 190.0);
    let bottom = 30.0 + ROW_PX * methods.len() as f64;
    let mut canvas = Canvas::new(WIDTH, bottom + 56.0);
    let frame = canvas.axes(&Axes {
        area: (left, 30.0, right, bottom),
        x: (least, limit),
        y: (0.0, methods.len() as f64),
        x_step: nice_step(limit - least, 7.0),
        y_step: None,
        x_last: limit,
        x_label: Some(format!(
            "overall performance: {}{} ({})",
            data.words.noun,
            data.relative(),
            data.better()
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
    let title = "Overall performance of every method";
    (!methods.is_empty()).then(|| canvas.figure("overall", title, &description))
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
pub(super) fn distribution(data: &Report) -> Option<Figure> {
    let methods: Vec<_> = data.methods.iter().filter(|m| !m.is_reference && m.points > 0).collect();
    let scores = |m: &MethodSummary| -> Vec<f64> {
        data.results_of(m.index).filter_map(|(_, r)| r.score).collect()
    };
    let all: Vec<f64> = methods.iter().flat_map(|m| scores(m)).collect();
    let scale = match data.reference.is_none() {
        true => Histogram::range(&all),
        false => {
            let (limit, width) = Histogram::scale(&all);
            (0.0, limit, width)
        }
    };
    let histograms: Vec<_> = methods.iter().map(|m| Histogram::within(&scores(m), scale)).collect();
    let peak = histograms.iter().map(Histogram::peak).max()? as f64;
    let (start, limit, width) = scale;
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
            x: (start, x_end),
            y: (0.0, peak * HEADROOM),
            x_step: nice_step(limit - start, 8.0),
            y_step: Some(nice_step(peak, 3.0).max(1.0)),
            x_last: if beyond { limit - width } else { limit },
            x_label: last.then(|| {
                let (noun, relative) = (&data.words.noun, data.relative());
                format!("score on a point MDP: {noun}{relative} ({})", data.better())
            }),
            y_label: None,
        });
        bars(&mut canvas, &frame, h, color(data, m));
        reference_line(&mut canvas, data, &frame, (area.1, area.3), i == 0);
        if let Some(value) = m.overall.filter(|value| *value < limit) {
            let x = frame.x(value);
            canvas.line((x, area.1), (x, area.3), INK, 2.0, None);
        }
        let (y, style) = ((area.1 + area.3) / 2.0, TextStyle::new(Anchor::End));
        canvas.text(left - 44.0, y - 3.0, &label(data, m), style.bold());
        if let Some(worse) = worse(data, m) {
            let note = format!("worse than {}: {worse}", data.reference.as_label());
            canvas.text(left - 44.0, y + 13.0, &note, style.small().color(MUTED));
        }
        if last && beyond {
            let x = frame.x(limit + 2.5 * width);
            let label = format!("\u{2265} {limit}");
            canvas.text(x, area.3 + 17.0, &label, TextStyle::new(Anchor::Middle));
        }
    }
    canvas.text(8.0, 20.0, "number of point MDPs", TextStyle::new(Anchor::Start).color(MUTED));
    let description = sentence(
        methods
            .iter()
            .zip(&histograms)
            .map(|(m, h)| format!("{}: beyond the axis {}", label(data, m), h.over)),
    );
    let title = "Distribution of scores over point MDPs";
    Some(canvas.figure("distribution", title, &description))
}

/// Returns on how many point MDPs a method is worse than what scores are divided by; `None` where that is nothing.
fn worse(data: &Report, m: &MethodSummary) -> Option<usize> {
    let is_worse = |score: f64| data.direction().is_worse(score, 1.0);
    let worse = || data.results_of(m.index).filter(|(_, r)| r.score.is_some_and(is_worse)).count();
    (!data.reference.is_none()).then(worse)
}

fn bars(canvas: &mut Canvas, frame: &Frame, h: &Histogram, color: &str) {
    let bottom = frame.y(0.0);
    for (b, count) in h.counts.iter().enumerate().filter(|(_, c)| **c > 0) {
        let from = h.start + b as f64 * h.width;
        let (x, y) = (frame.x(from), frame.y(*count as f64).min(bottom - MIN_BAR_PX));
        let to = h.start + (b + 1) as f64 * h.width;
        canvas.rect((x, bottom), (frame.x(to), y), color, Some("#ffffff"));
    }
    if h.over > 0 {
        let (x, x2) = (frame.x(h.limit + h.width), frame.x(h.limit + 4.0 * h.width));
        let y = frame.y(h.over as f64);
        canvas.rect((x, bottom), (x2, y), color, Some("#1a1a1a"));
        let style = TextStyle::new(Anchor::Middle);
        canvas.text((x + x2) / 2.0, y - 4.0, &h.over.to_string(), style);
    }
}

fn reference_line(
    canvas: &mut Canvas,
    data: &Report,
    frame: &Frame,
    (top, bottom): (f64, f64),
    labelled: bool,
) {
    if data.reference.is_none() {
        return;
    }
    let x = frame.x(1.0);
    canvas.line((x, top), (x, bottom), MUTED, 1.5, Some("5 4"));
    if labelled {
        let label = format!("{} = 1", data.reference.as_label());
        canvas.text(x, top - 8.0, &label, TextStyle::new(Anchor::Middle).color(MUTED));
    }
}

fn with_interval(m: &MethodSummary) -> String {
    let value = m.overall.map_or_else(|| "-".to_owned(), |v| format::score_within(v, m.interval));
    match m.interval {
        _ if m.is_reference => format!("{value} (by definition)"),
        Some(i) => format!("{value} ({})", format::interval(i)),
        None => format!("{value} (no interval)"),
    }
}

/// Returns parts as one sentence.
pub fn sentence(parts: impl Iterator<Item = String>) -> String {
    parts.collect::<Vec<_>>().join("; ")
}

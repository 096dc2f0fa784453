//! Performance profiles: on which share of the family every method has a score better than any one asks for.

use super::figure::{Figure, WIDTH};
use super::figures::{OVERALL_LIMIT, color, dash, label, reference_line, sentence};
use super::legend;
use super::svg::{Anchor, Axes, Canvas, Frame, MUTED, TextStyle, nice_step};
use super::whole::Report;
use crate::analysis::{Estimated, MethodSummary, Profile};
use crate::stats::Histogram;

/// Width of the drawing for narrow screens, pixels.
const NARROW_PX: f64 = 360.0;

/// Height of the area of the curves, wide and narrow, pixels.
const HEIGHT_PX: (f64, f64) = (330.0, 260.0);

/// Steps nearer to each other than this are drawn as one, pixels.
const STEP_PX: f64 = 0.75;

/// Draws the profiles of all methods that are ranked; `None` without two.
pub(super) fn profiles(data: &Report) -> Option<Figure> {
    drawing(data, WIDTH, "profiles")
}

/// Draws the same for narrow screens.
pub(super) fn narrow(data: &Report) -> Option<String> {
    drawing(data, NARROW_PX, "profiles-narrow").map(|figure| figure.svg)
}

fn drawing(data: &Report, width: f64, name: &'static str) -> Option<Figure> {
    let all = &data.comparison.profiles;
    // That of what scores are divided by is the dashed line.
    let shown: Vec<(&MethodSummary, &Profile)> =
        all.iter().map(|p| (&data.methods[p.method], p)).filter(|(m, _)| !m.is_reference).collect();
    if all.len() < 2 || shown.is_empty() {
        return None;
    }
    let methods: Vec<&MethodSummary> = shown.iter().map(|(m, _)| *m).collect();
    let ends = ends(data, &shown);
    let wide = width > NARROW_PX;
    let height = if wide { HEIGHT_PX.0 } else { HEIGHT_PX.1 };
    let top = 54.0 + legend::height(data, &methods, width);
    let area = (52.0, top, width - 20.0, top + height);
    let mut canvas = Canvas::new(width, area.3 + 58.0);
    legend::draw(&mut canvas, data, &methods, width, false);
    let title = "share of the family, by importance, with a better score";
    canvas.text(10.0, top - 26.0, title, TextStyle::new(Anchor::Start).color(MUTED));
    let ticks = if wide { 8.0 } else { 4.0 };
    let frame = canvas.axes(&Axes {
        area,
        x: ends,
        y: (0.0, 1.0),
        x_step: nice_step(ends.1 - ends.0, ticks),
        y_step: Some(0.2),
        x_last: ends.1,
        x_label: Some(axis(data, wide)),
        y_label: None,
    });
    reference_line(&mut canvas, data, &frame, (area.1, area.3), ends.0 < 1.0 && 1.0 < ends.1);
    let drawn: Vec<(&MethodSummary, Vec<Segment>)> =
        shown.iter().map(|(m, p)| (*m, segments(data, p, &frame, ends))).collect();
    for (m, segments) in drawn.iter().rev() {
        canvas.band(&outline(segments, &frame), color(data, m));
    }
    for (m, segments) in drawn.iter().rev() {
        let corners = segments.iter().flat_map(|s| [(s.from, s.share), (s.to, s.share)]);
        let corners = corners.map(|(x, share)| (x, frame.y(share))).collect();
        canvas.polyline(corners, color(data, m), 2.2, dash(data, m));
    }
    let description = sentence(shown.iter().map(|(m, p)| described(data, m, p)));
    Some(canvas.figure(name, "Performance profiles", &description))
}

/// Says what the axis has.
fn axis(data: &Report, wide: bool) -> String {
    let better = data.better();
    match wide {
        true => format!(
            "score: {}{} ({better}; a higher curve is better)",
            data.words.noun,
            data.relative()
        ),
        false => format!("score ({better}; a higher curve too)"),
    }
}

/// Returns the ends of the axis of scores: all of them, and where they are relative no further than to a limit.
fn ends(data: &Report, shown: &[(&MethodSummary, &Profile)]) -> (f64, f64) {
    let scores: Vec<f64> = shown.iter().flat_map(|(_, p)| p.steps.iter().map(|s| s.0)).collect();
    if data.reference.is_none() {
        let (start, end, _) = Histogram::range(&scores);
        return (start, end);
    }
    let (least, most) =
        scores.iter().fold((1.0, 1.0), |(a, b): (f64, f64), s| (a.min(*s), b.max(*s)));
    let step = nice_step((most - least).max(0.1), 8.0);
    let end = ((most / step + 0.1).ceil() * step).min(OVERALL_LIMIT);
    (((least / step - 0.1).floor() * step).max(0.0), end)
}

/// A level part of a curve with its band, x in pixels.
struct Segment {
    from: f64,
    to: f64,
    share: f64,
    low: f64,
    high: f64,
}

/// Returns the level parts of a profile between the ends of the axis.
fn segments(data: &Report, p: &Profile, frame: &Frame, (start, end): (f64, f64)) -> Vec<Segment> {
    let lower = data.direction().is_lower();
    let mut segments: Vec<Segment> = Vec::new();
    let mut from = start;
    for i in 0..=p.steps.len() {
        // What lies beyond the axis has no place on it.
        if from >= end {
            break;
        }
        let to = p.steps.get(i).map_or(end, |s| s.0.clamp(start, end));
        // Where less is better a step is the share up to it, where more is better the share from it on.
        let step = if lower { i.checked_sub(1) } else { Some(i) };
        let share = step.and_then(|i| p.steps.get(i)).map_or(0.0, |s| s.1);
        // The band is that of the threshold at which a share holds still.
        // Beyond the best score nothing is reached, nor is there a threshold.
        let none = i == if lower { 0 } else { p.steps.len() };
        let at = if lower { to } else { from };
        let (down, up) = if none { (0.0, 0.0) } else { widths(&p.bands, at) };
        let (low, high) = ((share - down).max(0.0), (share + up).min(1.0));
        let segment = Segment { from: frame.x(from), to: frame.x(to), share, low, high };
        match segments.last_mut() {
            Some(last) if segment.to - last.from < STEP_PX => {
                (last.to, last.share, last.low, last.high) = (segment.to, share, low, high);
            }
            _ => segments.push(segment),
        }
        from = to;
    }
    segments
}

/// Returns how far a band reaches below and above the share, between two thresholds in proportion.
fn widths(bands: &[(f64, Estimated)], at: f64) -> (f64, f64) {
    let of = |(_, e): &(f64, Estimated)| {
        e.interval.map_or((0.0, 0.0), |(low, high)| (e.value - low, high - e.value))
    };
    let next = bands.partition_point(|(t, _)| *t < at);
    match (next.checked_sub(1).and_then(|i| bands.get(i)), bands.get(next)) {
        (Some(a), Some(b)) => {
            let part = (at - a.0) / (b.0 - a.0);
            let ((down, up), (down_b, up_b)) = (of(a), of(b));
            (down + part * (down_b - down), up + part * (up_b - up))
        }
        (Some(one), None) | (None, Some(one)) => of(one),
        (None, None) => (0.0, 0.0),
    }
}

/// Returns the corners of the band.
fn outline(segments: &[Segment], frame: &Frame) -> Vec<(f64, f64)> {
    let above = segments.iter().flat_map(|s| [(s.from, s.high), (s.to, s.high)]);
    let below = segments.iter().rev().flat_map(|s| [(s.to, s.low), (s.from, s.low)]);
    above.chain(below).map(|(x, share)| (x, frame.y(share))).collect()
}

/// Says where the quarters of a profile are.
fn described(data: &Report, m: &MethodSummary, p: &Profile) -> String {
    let mut best_first: Vec<(f64, f64)> = p.steps.clone();
    best_first.sort_by(|a, b| data.direction().compare(a.0, b.0));
    let at = |share: f64| {
        let reached = best_first.iter().find(|s| s.1 >= share - 1e-9).or(best_first.last());
        reached.map_or_else(String::new, |s| super::format::score(s.0))
    };
    let than = if data.direction().is_lower() { "at most" } else { "at least" };
    format!(
        "{} scores {than} {} on a quarter of the family, {than} {} on half, {than} {} on three quarters",
        label(data, m),
        at(0.25),
        at(0.5),
        at(0.75)
    )
}

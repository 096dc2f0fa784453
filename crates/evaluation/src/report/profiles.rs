//! Performance profiles: on which share of the family every method has a score better than any one asks for.

use super::figure::{Figure, WIDTH};
use super::figures::{OVERALL_LIMIT, color, dash, label, reference_line, sentence};
use super::legend;
use super::svg::{Anchor, Axes, Canvas, Frame, MUTED, TextStyle, nice_step};
use super::whole::Report;
use crate::analysis::{MethodSummary, Profile};
use crate::stats::Histogram;

/// Height of the area of the curves, pixels.
const HEIGHT_PX: f64 = 330.0;

/// Steps nearer to each other than this are drawn as one, pixels.
const STEP_PX: f64 = 0.75;

/// Draws the profiles of all methods that are ranked; `None` without two.
pub(super) fn profiles(data: &Report) -> Option<Figure> {
    let all = &data.comparison.profiles;
    // That of what scores are divided by is the dashed line.
    let shown: Vec<(&MethodSummary, &Profile)> =
        all.iter().map(|p| (&data.methods[p.method], p)).filter(|(m, _)| !m.is_reference).collect();
    if all.len() < 2 || shown.is_empty() {
        return None;
    }
    let methods: Vec<&MethodSummary> = shown.iter().map(|(m, _)| *m).collect();
    let ends = ends(data, &shown);
    let top = 54.0 + legend::height(data, &methods, WIDTH);
    let area = (52.0, top, WIDTH - 20.0, top + HEIGHT_PX);
    let mut canvas = Canvas::new(WIDTH, area.3 + 58.0);
    legend::draw(&mut canvas, data, &methods, WIDTH, false);
    let title = "share of the family, by importance, with a better score";
    canvas.text(10.0, top - 26.0, title, TextStyle::new(Anchor::Start).color(MUTED));
    let frame = canvas.axes(&Axes {
        area,
        x: ends,
        y: (0.0, 1.0),
        x_step: nice_step(ends.1 - ends.0, 8.0),
        y_step: Some(0.2),
        x_last: ends.1,
        x_label: Some(format!(
            "score: {}{} ({}; a higher curve is better)",
            data.words.noun,
            data.relative(),
            data.better()
        )),
        y_label: None,
    });
    reference_line(&mut canvas, data, &frame, (area.1, area.3), ends.0 < 1.0 && 1.0 < ends.1);
    let drawn: Vec<(&MethodSummary, Vec<Segment>)> =
        shown.iter().map(|(m, p)| (*m, segments(data, p, &frame, ends))).collect();
    for (m, segments) in drawn.iter().rev() {
        let corners = segments.iter().flat_map(|s| [(s.from, s.share), (s.to, s.share)]);
        let corners = corners.map(|(x, share)| (x, frame.y(share))).collect();
        canvas.polyline(corners, color(data, m), 2.2, dash(data, m));
    }
    let description = sentence(shown.iter().map(|(m, p)| described(data, m, p)));
    Some(canvas.figure("profiles", "Performance profiles", &description))
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

/// A level part of a curve, x in pixels.
struct Segment {
    from: f64,
    to: f64,
    share: f64,
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
        let segment = Segment { from: frame.x(from), to: frame.x(to), share };
        match segments.last_mut() {
            Some(last) if segment.to - last.from < STEP_PX => {
                (last.to, last.share) = (segment.to, share);
            }
            _ => segments.push(segment),
        }
        from = to;
    }
    segments
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

//! How the score depends on each context feature: where in the family a method is good.

use super::figure::{Figure, WIDTH};
use super::figures::{color, dash};
use super::svg::{Anchor, Axes, Canvas, Frame, MUTED, TextStyle, nice_step};
use super::whole::Report;
use super::{format, legend};
use crate::analysis::MethodSummary;
use crate::stats::score::weighted_mean;
use crate::store::manifest::FeatureColumn;

/// Fewest point MDPs for which a dependence says anything.
const MIN_POINTS: usize = 10;

/// Fewest point MDPs whose mean is part of a line; of fewer it is a hollow mark.
pub(super) const FEWEST_IN_LINE: usize = 5;

/// Most positions on x; a feature with more values is cut into as many groups of equal size.
const MAX_GROUPS: usize = 8;

/// Largest score on the axis; more is drawn as a triangle at the upper edge.
const SCORE_LIMIT: f64 = 2.0;

/// What hollow marks are filled with.
const PAPER: &str = "#ffffff";

/// Panels beside each other.
const COLUMNS: usize = 2;

/// Height of a panel with its labels, pixels.
const PANEL_PX: f64 = 242.0;

/// Baselines of the two rows of counts above a panel, and their least distance within a row, pixels.
const COUNTS_PX: [f64; 2] = [12.0, 25.0];
const COUNT_GAP_PX: f64 = 26.0;

/// The mean over a group of values of a feature.
struct Dot {
    /// Mean value of the feature, weighted by importance.
    x: f64,
    /// Mean score, weighted by importance.
    score: f64,
    /// Number of point MDPs.
    points: usize,
}

impl Dot {
    /// Whether enough point MDPs are behind it for a line.
    fn is_in_line(&self) -> bool {
        self.points >= FEWEST_IN_LINE
    }
}

/// Draws the importance-weighted mean score of every method over each feature that varies.
pub(super) fn by_feature(data: &Report) -> Option<Figure> {
    let methods: Vec<_> = data.methods.iter().filter(|m| !m.is_reference && m.points > 0).collect();
    let features: Vec<(usize, &FeatureColumn)> = data
        .manifest
        .identity
        .features
        .iter()
        .enumerate()
        .filter(|(f, _)| groups(data, *f).len() > 1)
        .collect();
    if methods.is_empty() || features.is_empty() || data.points.len() < MIN_POINTS {
        return None;
    }
    let curves: Vec<Vec<Vec<Dot>>> = features
        .iter()
        .map(|(f, _)| methods.iter().map(|m| curve(data, m, *f)).collect())
        .collect();
    let absolute = data.reference.is_none();
    let scores = || curves.iter().flatten().flatten().map(|dot| dot.score);
    let start = if absolute { 0.0 } else { 1.0 };
    let (least, largest) = (scores().fold(0.0, f64::min), scores().fold(start, f64::max));
    let (y_start, y_end) = match absolute {
        true if least == largest => (0.0, 1.0),
        true => (1.08 * least, largest + 0.08 * (largest - least)),
        false => (0.0, (largest * 1.08).min(SCORE_LIMIT)),
    };
    let (mut canvas, top) = with_legend(data, &methods, features.len().div_ceil(COLUMNS));
    let panel_width = WIDTH / COLUMNS as f64;
    for (i, ((f, feature), curves)) in features.iter().zip(&curves).enumerate() {
        let left = panel_width * (i % COLUMNS) as f64 + 52.0;
        let panel_top = top + PANEL_PX * (i / COLUMNS) as f64;
        let area = (left, panel_top + 38.0, left + panel_width - 72.0, panel_top + PANEL_PX - 56.0);
        let xs = || curves.iter().flatten().map(|dot| dot.x);
        let (low, high) =
            xs().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let pad = 0.05 * (high - low);
        let frame = canvas.axes(&Axes {
            area,
            x: (low - pad, high + pad),
            y: (y_start, y_end),
            // Half a lane is no tick.
            x_step: nice_step(high - low, 5.0).max(if xs().all(whole) { 1.0 } else { 0.0 }),
            y_step: Some(nice_step(y_end - y_start, 4.0)),
            x_last: high + pad,
            x_label: Some(format::feature_label(feature)),
            y_label: None,
        });
        if !absolute {
            let y = frame.y(1.0);
            canvas.line((area.0, y), (area.2, y), MUTED, 1.5, Some("5 4"));
        }
        counts(&mut canvas, &frame, (left, panel_top), &counted(data, *f));
        for (m, dots) in methods.iter().zip(curves).rev() {
            draw(&mut canvas, &frame, dots, y_end, (color(data, m), dash(data, m)));
        }
    }
    let description = format!(
        "Mean score over {}, for {}. The numbers are in scores.csv.",
        features.iter().map(|(_, f)| format::feature_label(f)).collect::<Vec<_>>().join(", "),
        methods.iter().map(|m| m.method.as_str()).collect::<Vec<_>>().join(", "),
    );
    Some(canvas.figure("context", "Score by context feature", &description))
}

/// Returns a canvas with the legend, and where the panels begin.
fn with_legend(data: &Report, methods: &[&MethodSummary], rows: usize) -> (Canvas, f64) {
    let top = 32.0 + legend::height(data, methods, WIDTH);
    let mut canvas = Canvas::new(WIDTH, top + PANEL_PX * rows as f64);
    legend::draw(&mut canvas, data, methods, WIDTH, true);
    let title = match data.reference.is_none() {
        true => format!("mean {} ({})", data.words.noun, data.better()),
        false => {
            format!("mean score ({} relative to {})", data.words.noun, data.reference.in_short())
        }
    };
    canvas.text(10.0, top - 10.0, &title, TextStyle::new(Anchor::Start).color(MUTED));
    (canvas, top)
}

fn whole(value: f64) -> bool {
    value.fract() == 0.0
}

/// Draws the means of a method: a line through those of enough point MDPs, and hollow marks for the others.
fn draw(
    canvas: &mut Canvas,
    frame: &Frame,
    dots: &[Dot],
    y_end: f64,
    (color, dash): (&str, Option<&str>),
) {
    let at = |dot: &Dot| (frame.x(dot.x), frame.y(dot.score.min(y_end)));
    for line in dots.chunk_by(|a, b| a.is_in_line() && b.is_in_line()) {
        if line.len() > 1 {
            canvas.polyline(line.iter().map(at).collect(), color, 2.0, dash);
        }
    }
    for dot in dots {
        let (x, y) = at(dot);
        let corners = [(x - 6.0, y + 9.0), (x, y - 2.0), (x + 6.0, y + 9.0)];
        match (dot.score <= y_end, dot.is_in_line()) {
            (true, true) => canvas.circle((x, y), 3.5, color, None),
            (true, false) => {
                canvas.circle((x, y), 4.5, color, None);
                canvas.circle((x, y), 2.5, PAPER, None);
            }
            (false, true) => canvas.shape(&corners, color),
            (false, false) => {
                canvas.shape(&corners, PAPER);
                for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                    canvas.line(corners[a], corners[b], color, 1.5, None);
                }
            }
        }
    }
}

/// Writes above a panel how many point MDPs each of its means is of, given where these are on x; counts that would touch
/// are in a second row.
fn counts(canvas: &mut Canvas, frame: &Frame, (left, top): (f64, f64), counted: &[(f64, usize)]) {
    let style = |anchor| TextStyle::new(anchor).color(MUTED).small();
    canvas.text(left - 10.0, top + COUNTS_PX[0], "n", style(Anchor::End));
    let mut last = f64::NEG_INFINITY;
    for (x, points) in counted {
        let x = frame.x(*x);
        let is_close = x - last < COUNT_GAP_PX;
        let row = COUNTS_PX[usize::from(is_close)];
        canvas.text(x, top + row, &points.to_string(), style(Anchor::Middle));
        if !is_close {
            last = x;
        }
    }
}

/// Returns per group of values the mean value, weighted by importance, and the number of point MDPs in the sample.
fn counted(data: &Report, feature: usize) -> Vec<(f64, usize)> {
    let count = |group: &Vec<f64>| {
        let valued =
            data.points.iter().filter_map(|p| Some((p.weight, *p.row.features.get(feature)?)));
        let members: Vec<(f64, f64)> = valued.filter(|(_, x)| group.contains(x)).collect();
        Some((weighted_mean(members.iter().copied())?, members.len()))
    };
    groups(data, feature).iter().filter_map(count).collect()
}

/// Returns the groups of a feature's values, in order: its values, or equally many per group.
fn groups(data: &Report, feature: usize) -> Vec<Vec<f64>> {
    let mut values: Vec<f64> =
        data.points.iter().filter_map(|p| p.row.features.get(feature).copied()).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let per_group = values.len().div_ceil(MAX_GROUPS).max(1);
    values.chunks(per_group).map(<[f64]>::to_vec).collect()
}

/// Returns the means of a method per group of values.
fn curve(data: &Report, m: &MethodSummary, feature: usize) -> Vec<Dot> {
    groups(data, feature)
        .iter()
        .filter_map(|group| {
            let (low, high) = (*group.first()?, *group.last()?);
            let members = || {
                data.results_of(m.index).filter_map(move |(p, r)| {
                    let x = *p.row.features.get(feature)?;
                    (low <= x && x <= high).then_some((p.weight, x, r.score?))
                })
            };
            let x = weighted_mean(members().map(|(w, x, _)| (w, x)))?;
            let score = weighted_mean(members().map(|(w, _, s)| (w, s)))?;
            Some(Dot { x, score, points: members().count() })
        })
        .collect()
}

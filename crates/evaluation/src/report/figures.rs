//! The figures of a report, drawn from its data.
//!
//! Learning curves, where figures of this kind differ:
//! - **Mean** over point MDPs with the weights of the score, after the mean over replicates.
//! - **Same point MDPs** for all learners, as far as they have some in common.
//! - **Validation** has the same seeds at every row, so that a curve is about the policy. A value counts until the next
//!   one. Episodes of training are smoothed by a trailing mean, which never shows what has not happened yet.
//! - **Band**: quantiles over trainings, each counting once; all of them when they are few.
//! - **Logarithmic** axis of what is relative: half and double the reference are equally far from it, and a method
//!   that fails does not flatten the others. Values themselves have a linear axis.
//! - A training without anything to decide ends after one episode; its curve goes on level.

use std::collections::{BTreeMap, BTreeSet};

use super::csv::{self, number};
use super::format;
use super::palette::{self, KNOWN, ink_on_known};
use super::svg::{
    Anchor, Axes, Canvas, Figure, Frame, INK, MUTED, TextStyle, WIDTH, nice_step, text_width,
};
use super::whole::Report;
use crate::analysis::{Analysis, MethodSummary, SMOOTHED_OVER, TrainingSummary};
use crate::stats::Histogram;
use crate::stats::quantile::quantile;
use crate::stats::score::{mean, weighted_mean};

/// Largest score on the axis of the overall performance; more is drawn as an arrow at the edge.
const OVERALL_LIMIT: f64 = 2.5;

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

/// Least probability of each shade, from the darkest on; less has the lightest.
const SHADES: [f64; 5] = [0.95, 0.75, 0.5, 0.25, 0.05];

/// Height of a row of cells, pixels.
const CELLS_PX: f64 = 30.0;

/// Widest cell and narrowest with a number, pixels.
const CELL_PX: (f64, f64) = (84.0, 25.0);

/// Space above the cells, and beside them, pixels.
const TOP_PX: f64 = 48.0;
const SIDE_PX: f64 = 14.0;

/// Height of the panel, pixels.
const HEIGHT_PX: f64 = 330.0;

/// Least distance of the labels at the ends of curves, pixels.
const LABEL_PX: f64 = 17.0;

/// Where the panel begins, pixels.
const PANEL_TOP_PX: f64 = 34.0;

/// Smallest ratio on the axis, which has no 0.
const LEAST: f64 = 0.01;

/// Space above and below the curves, decades, or as a share of their range.
const PAD_DECADES: f64 = 0.04;
const PAD: f64 = 0.06;

/// Trainings below which the band is their whole range.
pub(super) const FEW_TRAININGS: usize = 5;

/// Quantiles of the band.
const BAND: (f64, f64) = (0.1, 0.9);

pub(super) fn figures(data: &Report) -> Vec<Figure> {
    [overall(data), ranks(data), distribution(data), learning(data)].into_iter().flatten().collect()
}

fn color(data: &Report, m: &MethodSummary) -> &'static str {
    let identity = &data.manifest.identity;
    let others = || identity.methods.iter().filter(|name| **name != identity.baseline);
    let look = |name: &String| data.sections.look(name).map(|look| look.color);
    if !others().any(|name| *name == m.method) {
        return palette::BASELINE;
    }
    look(&m.method).unwrap_or_else(|| {
        let taken: Vec<&str> = others().filter_map(look).collect();
        let mut unknown = others().filter(|name| look(name).is_none());
        palette::method(unknown.position(|name| *name == m.method).unwrap_or(0), &taken)
    })
}

/// Returns the dashes of a method's lines, `None` for solid ones; methods that the domain does not know differ in theirs, for
/// colours are few.
fn dash(data: &Report, m: &MethodSummary) -> Option<&'static str> {
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

/// Draws the overall performance of every method with its interval.
fn overall(data: &Report) -> Option<Figure> {
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
fn mark(
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

/// Draws per method how many point MDPs reach which score, as in the paper's figure.
fn distribution(data: &Report) -> Option<Figure> {
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

/// Draws the probability of every place as a table of shaded cells; `None` where nothing was resampled.
fn ranks(data: &Report) -> Option<Figure> {
    let ranks = data.comparison.ranks.as_ref()?;
    let places = ranks.len() as f64;
    let left = widest_name(data) + 20.0;
    let cell = ((WIDTH - left - SIDE_PX) / places).min(CELL_PX.0);
    let bottom = TOP_PX + CELLS_PX * places;
    let mut canvas = Canvas::new(WIDTH, bottom + 14.0);
    let muted = TextStyle::new(Anchor::Start).color(MUTED);
    canvas.text(left, 18.0, "place by score (1 is the best); probability in per cent", muted);
    for place in 0..ranks.len() {
        let x = left + cell * (place as f64 + 0.5);
        canvas.text(x, TOP_PX - 8.0, &(place + 1).to_string(), TextStyle::new(Anchor::Middle));
    }
    for (i, (m, probabilities)) in data.methods.iter().zip(ranks).enumerate() {
        let top = TOP_PX + CELLS_PX * i as f64;
        canvas.text(left - 10.0, top + 20.0, &label(data, m), TextStyle::new(Anchor::End));
        for (place, p) in probabilities.iter().enumerate() {
            let shade = SHADES.iter().position(|least| p >= least).unwrap_or(SHADES.len());
            let x = left + cell * place as f64;
            let corners = ((x + 1.0, top + 1.0), (x + cell - 1.0, top + CELLS_PX - 1.0));
            canvas.rect(corners.0, corners.1, KNOWN[shade], Some("#c8c8c8"));
            if cell >= CELL_PX.1 && *p > 0.0 {
                let style = TextStyle::new(Anchor::Middle).color(ink_on_known(shade));
                let style = if cell < 34.0 { style.small() } else { style };
                canvas.text(x + cell / 2.0, top + 20.0, &rounded(*p), style);
            }
        }
    }
    let description = sentence(data.methods.iter().zip(ranks).map(|(m, probabilities)| {
        let likely = probabilities.iter().enumerate().filter(|(_, p)| **p >= 0.005);
        let likely = likely.map(|(place, p)| format!("place {} {}%", place + 1, rounded(*p)));
        format!("{}: {}", label(data, m), likely.collect::<Vec<_>>().join(", "))
    }));
    Some(canvas.figure("ranks", "Probability of every place", &description))
}

fn rounded(p: f64) -> String {
    match 100.0 * p {
        p if p <= 0.0 => "0".to_owned(),
        p if p < 0.5 => "<1".to_owned(),
        p if p >= 100.0 - 1e-9 => "100".to_owned(),
        p if p > 99.5 => ">99".to_owned(),
        p => format!("{p:.0}"),
    }
}

/// Mean, lower and upper end of the band in one episode; `None` where no training has a value.
type Band = Option<[f64; 3]>;

/// Returns a figure of a training, one value per episode; `None` where there is none.
type Values = fn(&TrainingSummary) -> &[Option<f64>];

/// Fills gaps of a curve, up to a number of episodes.
type Smooth = fn(&[Option<f64>], usize) -> Vec<Option<f64>>;

/// A learner's curve and its band, one value per row from the first that all its trainings have.
struct Curve<'a> {
    method: &'a MethodSummary,
    trainings: Vec<&'a TrainingSummary>,
    from: usize,
    mean: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
}

/// Returns the point MDPs that the learning curves are over: those that all learners finished, or
/// none when they have none in common and each curve is over its own.
pub(super) fn common_points(data: &Report) -> BTreeSet<usize> {
    let sets = drawn(data).into_iter().map(|m| {
        let with_curve = data.trainings_of(&m.method).filter(|t| !t.curve.is_empty());
        with_curve.map(|t| t.point).collect::<BTreeSet<usize>>()
    });
    sets.reduce(|a, b| &a & &b).unwrap_or_default()
}

fn drawn(data: &Report) -> Vec<&MethodSummary> {
    let has_curve = |m: &&MethodSummary| data.trainings_of(&m.method).any(|t| t.curve.len() > 1);
    data.methods.iter().filter(has_curve).collect()
}

/// Draws the learning curves; `None` without learners.
fn learning(data: &Report) -> Option<Figure> {
    let common = common_points(data);
    let curves: Vec<Curve> = drawn(data).iter().filter_map(|m| curve(data, m, &common)).collect();
    let episodes = curves.iter().map(|c| c.from + c.mean.len()).max()?;
    let bottom = PANEL_TOP_PX + HEIGHT_PX;
    let mut canvas = Canvas::new(WIDTH, bottom + 66.0);
    let (noun, row, is_ratio) = (&data.words.noun, &data.words.row, !data.reference.is_none());
    let of_validation = curves.iter().flat_map(|c| &c.trainings).any(|t| t.policy_row.is_some());
    let (when, how) = match of_validation {
        true => ("validation".to_owned(), "validation seeds".to_owned()),
        false => (format!("a training {row}"), format!("trailing mean of {SMOOTHED_OVER}")),
    };
    let title = match is_ratio {
        false => format!("{noun} in {when} ({})", data.better()),
        true => format!(
            "{noun} in {when} / mean of {} (log scale, {})",
            data.reference.name,
            data.better()
        ),
    };
    canvas.text(10.0, 18.0, &title, TextStyle::new(Anchor::Start).color(MUTED));
    let area = (56.0, PANEL_TOP_PX, WIDTH - widest_name(data).max(100.0) - 88.0, bottom);
    let at = |value: f64| if is_ratio { value.max(LEAST).log10() } else { value };
    // The axis of ratios contains 1.
    let start = if is_ratio { (0.0, 0.0) } else { (f64::INFINITY, f64::NEG_INFINITY) };
    let drawn = || curves.iter().flat_map(|c| c.mean.iter().chain(&c.low).chain(&c.high));
    let ends = drawn().fold(start, |(a, b): (f64, f64), v| (a.min(at(*v)), b.max(at(*v))));
    let pad = match is_ratio {
        true => PAD_DECADES,
        false if ends.1 > ends.0 => PAD * (ends.1 - ends.0),
        false => PAD * ends.0.abs().max(1.0),
    };
    let x_end = episodes.max(2) as f64;
    let frame = canvas.axes(&Axes {
        area,
        x: (0.0, x_end),
        y: (ends.0 - pad, ends.1 + pad),
        x_step: nice_step(x_end, 10.0).max(1.0),
        y_step: (!is_ratio).then(|| nice_step(ends.1 - ends.0 + 2.0 * pad, 4.0)),
        x_last: x_end,
        x_label: Some(format!("training {row} ({how})")),
        y_label: None,
    });
    let marks = if is_ratio { marks((ends.0 - pad, ends.1 + pad)) } else { Vec::new() };
    for (value, label) in marks {
        let y = frame.y(value);
        canvas.line((area.0, y), (area.2, y), "#e3e3e3", 1.0, None);
        canvas.text(area.0 - 7.0, y + 4.5, &label, TextStyle::new(Anchor::End));
    }
    let one = is_ratio.then_some(frame.y(0.0));
    let last_y = curves.iter().map(|c| frame.y(at(last(&c.mean))));
    let labels = spread(last_y.chain(one), (PANEL_TOP_PX, bottom));
    let style = TextStyle::new(Anchor::Start);
    if let Some((y, one)) = labels.get(curves.len()).zip(one) {
        canvas.line((area.0, one), (area.2, one), MUTED, 1.5, Some("5 4"));
        canvas.line((area.2, one), (area.2 + 22.0, *y), MUTED, 1.2, Some("5 4"));
        let label = format!("{} 1", data.reference.as_label());
        canvas.text(area.2 + 26.0, y + 4.5, &label, style.color(MUTED));
    }
    for (c, y) in curves.iter().zip(labels).rev() {
        let (color, dash) = (color(data, c.method), dash(data, c.method));
        let points = |values: &[f64]| -> Vec<(f64, f64)> {
            let point = |(e, v): (usize, &f64)| (frame.x((c.from + e + 1) as f64), frame.y(at(*v)));
            values.iter().enumerate().map(point).collect()
        };
        let mut band = points(&c.low);
        band.extend(points(&c.high).into_iter().rev());
        canvas.band(&band, color);
        let middle = points(&c.mean);
        let end = middle.last().copied().unwrap_or_default();
        canvas.polyline(middle, color, 2.2, dash);
        canvas.line(end, (area.2 + 22.0, y), color, 1.2, dash);
        let text = format!("{} {}", c.method.method, format::score(last(&c.mean)));
        canvas.text(area.2 + 26.0, y + 4.5, &text, style);
    }
    let description = sentence(curves.iter().map(|c| {
        let (first, last) = (c.mean.first().copied().unwrap_or(f64::NAN), last(&c.mean));
        let (first, last) = (format::score(first), format::score(last));
        let of =
            if is_ratio { format!(" of {}", data.reference.in_short()) } else { String::new() };
        format!("{} from {first} to {last}{of}", c.method.method)
    }));
    Some(canvas.figure("learning", "Learning curves", &description))
}

fn marks((low, high): (f64, f64)) -> Vec<(f64, String)> {
    let steps: &[f64] = match high - low {
        span if span < 0.8 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
        span if span < 2.0 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let decades = low.floor() as i32..=high.ceil() as i32;
    let all = decades.flat_map(|d| steps.iter().map(move |s| s * 10f64.powi(d)));
    let shown = all.filter(|t| (low..=high).contains(&t.log10()));
    shown.map(|t| (t.log10(), format::feature(t))).collect()
}

/// Returns `learning.csv`, what the figure shows: a row per learner and row of training, with the objective, the return and
/// the loss, each with its band; `None` without learners. A cell is empty where nothing was measured.
pub(super) fn learning_csv(data: &Report) -> Option<String> {
    let common = common_points(data);
    let curves: Vec<Curve> = drawn(data).iter().filter_map(|m| curve(data, m, &common)).collect();
    let names = |name: &str| [name.to_owned(), format!("{name}_low"), format!("{name}_high")];
    let objective = match data.reference.is_none() {
        true => data.manifest.identity.objective.clone(),
        false => "score".to_owned(),
    };
    let mut header = ["method", "row", "trainings"].map(str::to_owned).to_vec();
    header.extend([objective.as_str(), "return", "loss"].into_iter().flat_map(names));
    let rows = curves.iter().flat_map(|c| {
        let traces: [Values; 2] = [|t| &t.returns, |t| &t.losses];
        let traces = traces.map(|of| bands(data, &c.trainings, of, smoothed));
        (0..c.mean.len()).map(move |i| {
            let row = c.from + i;
            let of_traces = traces.iter().map(|bands| bands.get(row).copied().flatten());
            let bands = [Some([c.mean[i], c.low[i], c.high[i]])].into_iter().chain(of_traces);
            let cells =
                bands.flat_map(|band| (0..3).map(move |i| number(band.map(|band| band[i]))));
            let first =
                [c.method.method.clone(), (row + 1).to_string(), c.trainings.len().to_string()];
            first.into_iter().chain(cells).collect()
        })
    });
    (!curves.is_empty()).then(|| csv::table(&header, rows))
}

fn curve<'a>(
    data: &'a Report,
    method: &'a MethodSummary,
    points: &BTreeSet<usize>,
) -> Option<Curve<'a>> {
    let trainings: Vec<&TrainingSummary> = data
        .trainings_of(&method.method)
        .filter(|t| !t.curve.is_empty() && (points.is_empty() || points.contains(&t.point)))
        .collect();
    let firsts = trainings.iter().map(|t| t.curve.iter().position(Option::is_some));
    let from = firsts.flatten().max()?;
    let bands = bands(data, &trainings, |t| &t.curve, carried);
    let of = |i: usize| bands[from..].iter().flatten().map(|band| band[i]).collect();
    Some(Curve { method, from, mean: of(0), low: of(1), high: of(2), trainings })
}

fn last(values: &[f64]) -> f64 {
    values.last().copied().unwrap_or(f64::NAN)
}

fn smoothed(values: &[Option<f64>], episodes: usize) -> Vec<Option<f64>> {
    let trailing = |end: usize| {
        let window = &values[end.saturating_sub(SMOOTHED_OVER)..end];
        mean(&window.iter().flatten().copied().collect::<Vec<f64>>())
    };
    (1..=episodes).map(|e| trailing(e.min(values.len()))).collect()
}

fn carried(values: &[Option<f64>], episodes: usize) -> Vec<Option<f64>> {
    let rows = values.iter().copied().chain(std::iter::repeat(None)).take(episodes);
    rows.scan(None, |last, value| {
        *last = value.or(*last);
        Some(*last)
    })
    .collect()
}

fn bands(data: &Report, trainings: &[&TrainingSummary], of: Values, smooth: Smooth) -> Vec<Band> {
    let with_values = || trainings.iter().filter(|t| of(t).iter().any(Option::is_some));
    let episodes = with_values().map(|t| of(t).len()).max().unwrap_or(0);
    let smooth: Vec<(usize, Vec<Option<f64>>)> =
        with_values().map(|t| (t.point, smooth(of(t), episodes))).collect();
    let band = |e: usize| {
        let mut by_point: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for (point, values) in &smooth {
            if let Some(value) = values[e] {
                by_point.entry(*point).or_default().push(value);
            }
        }
        let middle = weighted_mean(
            by_point.iter().filter_map(|(p, v)| Some((data.points[*p].weight, mean(v)?))),
        )?;
        let mut all: Vec<f64> = by_point.into_values().flatten().collect();
        all.sort_by(f64::total_cmp);
        let (from, to) = if all.len() < FEW_TRAININGS { (0.0, 1.0) } else { BAND };
        Some([middle, quantile(&all, from), quantile(&all, to)])
    };
    (0..episodes).map(band).collect()
}

fn spread(wanted: impl Iterator<Item = f64>, (top, bottom): (f64, f64)) -> Vec<f64> {
    let wanted: Vec<f64> = wanted.collect();
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|a, b| wanted[*a].total_cmp(&wanted[*b]));
    let mut placed = wanted;
    let mut free = top;
    for i in &order {
        placed[*i] = placed[*i].max(free);
        free = placed[*i] + LABEL_PX;
    }
    let mut free = bottom;
    for i in order.iter().rev() {
        placed[*i] = placed[*i].min(free);
        free = placed[*i] - LABEL_PX;
    }
    placed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neither_nothing_nor_all_is_claimed_of_less() {
        let texts = [0.0, 0.0005, 0.254, 0.996, 0.9999, 1.0].map(rounded);
        assert_eq!(texts, ["0", "<1", "25", ">99", ">99", "100"]);
    }

    #[test]
    fn labels_keep_their_order_and_their_distance() {
        let placed = spread([50.0, 52.0, 99.0].into_iter(), (0.0, 100.0));
        assert_eq!(placed, [50.0, 67.0, 99.0]);
        assert_eq!(spread([99.0, 98.0].into_iter(), (0.0, 100.0)), [100.0, 83.0]);
    }

    #[test]
    fn marks_are_fewer_on_a_longer_axis() {
        let of = |ends| marks(ends).into_iter().map(|m| m.1).collect::<Vec<_>>();
        assert_eq!(of((-0.35, 0.2)), ["0.5", "0.7", "1", "1.5"]);
        assert_eq!(of((-0.5, 2.1)), ["1", "10", "100"]);
    }

    #[test]
    fn a_curve_is_smoothed_by_what_came_before() {
        let means = smoothed(&[6.0, 4.0, 2.0, 2.0, 1.0, 1.0].map(Some), 6);
        assert_eq!(means, [6.0, 5.0, 4.0, 3.5, 3.0, 2.0].map(Some));
    }

    #[test]
    fn episodes_without_a_loss_count_in_no_mean() {
        let losses = [None, None, Some(4.0), None, Some(2.0), None, None, None, None, None];
        let smooth = smoothed(&losses, 11);
        assert_eq!(smooth[..5], [None, None, Some(4.0), Some(4.0), Some(3.0)]);
        assert_eq!(smooth[8..], [Some(2.0), None, None]);
    }
}

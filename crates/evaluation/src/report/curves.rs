//! Learning curves: the objective in validation, or in training where there is no validation, relative to the reference if
//! there is one.
//!
//! Choices where figures of this kind differ:
//! - **Mean** over point MDPs with the weights of the score, after the mean over replicates, so that
//!   a curve ends near the score that the method had with exploration and on training seeds.
//! - **Same point MDPs** for all learners, as far as they have some in common.
//! - **Validation** has the same seeds at every row, so that a curve is about the policy. A value counts until the next
//!   one. Episodes of training are smoothed by a trailing mean, which never shows what has not happened yet.
//! - **Band**: quantiles over trainings, each counting once; all of them when they are few.
//! - **Logarithmic** axis of what is relative: half and double the reference are equally far from it, and a method
//!   that fails does not flatten the others. Values themselves have a linear axis.
//! - A training without anything to decide ends after one episode; its curve goes on level.

use std::collections::{BTreeMap, BTreeSet};

use super::csv::{self, number};
use super::figure::{Figure, WIDTH};
use super::figures::{color, dash, sentence, widest_name};
use super::format;
use super::svg::{Anchor, Axes, Canvas, MUTED, TextStyle, nice_step};
use super::whole::Report;
use crate::analysis::{MethodSummary, SMOOTHED_OVER, TrainingSummary};
use crate::stats::quantile::quantile;
use crate::stats::score::{mean, weighted_mean};

/// Height of the panel, pixels.
const HEIGHT_PX: f64 = 330.0;

/// Least distance of the labels at the ends of curves, pixels.
const LABEL_PX: f64 = 17.0;

/// Where the panel begins, pixels.
const TOP_PX: f64 = 34.0;

/// Smallest ratio on the axis, which has no 0.
const LEAST: f64 = 0.01;

/// Space above and below the curves, decades, or as a share of their range.
const PAD_DECADES: f64 = 0.04;
const PAD: f64 = 0.06;

/// Trainings below which the band is their whole range.
pub(super) const FEW_TRAININGS: usize = 5;

/// Quantiles of the band.
const BAND: (f64, f64) = (0.1, 0.9);

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
pub(super) fn learning(data: &Report) -> Option<Figure> {
    let common = common_points(data);
    let curves: Vec<Curve> = drawn(data).iter().filter_map(|m| curve(data, m, &common)).collect();
    let episodes = curves.iter().map(|c| c.from + c.mean.len()).max()?;
    let bottom = TOP_PX + HEIGHT_PX;
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
    let area = (56.0, TOP_PX, WIDTH - widest_name(data).max(100.0) - 88.0, bottom);
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
    let labels = spread(last_y.chain(one), (TOP_PX, bottom));
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
pub(super) fn table(data: &Report) -> Option<String> {
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

//! Learning curves: the objective in validation, or in training where there is no validation, relative to the reference if
//! there is one; below, each learner alone with its return and loss.
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

use std::collections::BTreeSet;

use super::csv::{self, number};
use super::figure::{Figure, WIDTH};
use super::figures::{color, dash, sentence, widest_name};
use super::scale::Scale;
use super::svg::{Anchor, Canvas, Frame, MUTED, TextStyle};
use super::traces::{TRACES, axes, bands, carried, smoothed};
use super::whole::Report;
use super::{format, traces};
use crate::analysis::{MethodSummary, SMOOTHED_OVER, TrainingSummary};

/// Height of the panel of all learners and of those of one each, pixels.
const HEIGHT_PX: (f64, f64) = (330.0, 150.0);

/// Panels of one learner beside each other, and the height that a row takes with its labels, pixels.
const COLUMNS: usize = 1 + TRACES.len();
const PANEL_PX: f64 = 226.0;

/// Least distance of the labels at the ends of curves, pixels.
const LABEL_PX: f64 = 17.0;

/// Where the first panel begins, pixels.
const TOP_PX: f64 = 34.0;

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

/// Returns the learners that have a curve, in the order of the ranking.
pub(super) fn drawn(data: &Report) -> Vec<&MethodSummary> {
    let has_curve = |m: &&MethodSummary| data.trainings_of(&m.method).any(|t| t.curve.len() > 1);
    data.methods.iter().filter(has_curve).collect()
}

/// Draws the learning curves; `None` without learners.
pub(super) fn learning(data: &Report) -> Option<Figure> {
    let common = common_points(data);
    let curves: Vec<Curve> = drawn(data).iter().filter_map(|m| curve(data, m, &common)).collect();
    let episodes = curves.iter().map(|c| c.from + c.mean.len()).max()?;
    let rows = curves.len();
    let bottom = TOP_PX + HEIGHT_PX.0;
    let mut canvas = Canvas::new(WIDTH, bottom + 66.0 + PANEL_PX * rows as f64);
    let (noun, row, scale) = (&data.words.noun, &data.words.row, Scale::of(data));
    let of_validation = curves.iter().flat_map(|c| &c.trainings).any(|t| t.policy_row.is_some());
    let (when, how) = match of_validation {
        true => ("validation".to_owned(), "validation seeds".to_owned()),
        false => (format!("a training {row}"), format!("trailing mean of {SMOOTHED_OVER}")),
    };
    let title = match scale {
        Scale::Value => format!("{noun} in {when} ({})", data.better()),
        Scale::Ratio => format!(
            "{noun} in {when} / mean of {} (log scale, {})",
            data.reference.name,
            data.better()
        ),
    };
    canvas.text(10.0, 18.0, &title, TextStyle::new(Anchor::Start).color(MUTED));
    let area = (56.0, TOP_PX, WIDTH - widest_name(data).max(100.0) - 88.0, bottom);
    let range = scale.range(curves.iter().flat_map(|c| &c.mean));
    let label = format!("training {row} ({how})");
    let frame = panel(&mut canvas, area, episodes, (scale, range), label);
    let one = (scale == Scale::Ratio).then_some(0.0);
    let ends = curves.iter().map(|c| scale.at(last(&c.mean))).chain(one).map(|v| frame.y(v));
    let labels = spread(ends, (TOP_PX, bottom));
    let style = TextStyle::new(Anchor::Start);
    if let Some(y) = labels.get(curves.len()) {
        canvas.line((area.2, frame.y(0.0)), (area.2 + 22.0, *y), MUTED, 1.2, Some("5 4"));
        let label = format!("{} 1", data.reference.as_label());
        canvas.text(area.2 + 26.0, y + 4.5, &label, style.color(MUTED));
    }
    for (c, y) in curves.iter().zip(labels).rev() {
        let (color, dash) = (color(data, c.method), dash(data, c.method));
        let end = line(&mut canvas, (&frame, scale), (c.from, &c.mean), (color, 2.2, dash));
        canvas.line(end, (area.2 + 22.0, y), color, 1.2, dash);
        let text = format!("{} {}", c.method.method, format::score(last(&c.mean)));
        canvas.text(area.2 + 26.0, y + 4.5, &text, style);
    }
    small_panels(&mut canvas, data, &curves, (bottom + 66.0, episodes));
    let description = sentence(curves.iter().map(|c| {
        let (first, last) = (c.mean.first().copied().unwrap_or(f64::NAN), last(&c.mean));
        let (first, last) = (format::score(first), format::score(last));
        match scale {
            Scale::Value => format!("{} from {first} to {last}", c.method.method),
            Scale::Ratio => {
                let of = data.reference.in_short();
                format!("{} from {first} to {last} of {of}", c.method.method)
            }
        }
    }));
    Some(canvas.figure("learning", "Learning curves", &description))
}

/// Returns `learning.csv`, what the figure shows: a row per learner and row of training, with the objective, the return and
/// the loss, each with its band; `None` without learners. A cell is empty where nothing was measured.
pub(super) fn table(data: &Report) -> Option<String> {
    let common = common_points(data);
    let curves: Vec<Curve> = drawn(data).iter().filter_map(|m| curve(data, m, &common)).collect();
    let names = |name: &str| [name.to_owned(), format!("{name}_low"), format!("{name}_high")];
    let objective = match Scale::of(data) {
        Scale::Value => data.manifest.identity.objective.clone(),
        Scale::Ratio => "score".to_owned(),
    };
    let mut header = ["method", "row", "trainings"].map(str::to_owned).to_vec();
    header.extend([objective.as_str(), "return", "loss"].into_iter().flat_map(names));
    let rows = curves.iter().flat_map(|c| {
        let traces = TRACES.map(|trace| bands(data, &c.trainings, trace.of, smoothed));
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

/// Draws a row per learner: its objective with its band, the others in grey, then its return and loss.
fn small_panels(
    canvas: &mut Canvas,
    data: &Report,
    curves: &[Curve],
    (top, episodes): (f64, usize),
) {
    let scale = Scale::of(data);
    let range = scale.range(curves.iter().flat_map(|c| c.mean.iter().chain(&c.low).chain(&c.high)));
    let width = (WIDTH - 10.0) / COLUMNS as f64;
    for (i, c) in curves.iter().enumerate() {
        let top = top + PANEL_PX * i as f64 + 10.0;
        let area = |column: usize| {
            let left = width * column as f64 + 56.0;
            (left, top, left + width - 70.0, top + HEIGHT_PX.1)
        };
        let looks = (episodes, color(data, c.method), dash(data, c.method));
        for (column, trace) in TRACES.iter().enumerate() {
            traces::panel(canvas, data, &c.trainings, trace, area(column + 1), looks);
        }
        let area = area(0);
        let frame =
            panel(canvas, area, episodes, (scale, range), format!("training {}", data.words.row));
        for other in curves.iter().filter(|o| o.method.index != c.method.index) {
            let values = (other.from, &*other.mean);
            line(canvas, (&frame, scale), values, ("#c4c4c4", 1.0, None));
        }
        let at = |(e, v): (usize, &f64)| (frame.x((c.from + e + 1) as f64), frame.y(scale.at(*v)));
        let mut corners: Vec<_> = c.low.iter().enumerate().map(at).collect();
        corners.extend(c.high.iter().enumerate().map(at).rev());
        let (_, color, dash) = looks;
        canvas.band(&corners, color);
        line(canvas, (&frame, scale), (c.from, &c.mean), (color, 2.2, dash));
        let style = TextStyle::new(Anchor::Start);
        canvas.text(area.0, top - 8.0, &c.method.method, style.bold());
        let note = format::count(c.trainings.len(), "training");
        let style = TextStyle::new(Anchor::End).small().color(MUTED);
        canvas.text(area.2, top - 8.0, &note, style);
    }
}

/// Returns the curve of a learner over some point MDPs, or over all it has when there are none.
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

/// Draws axes, and for ratios the line of what they are relative to.
pub(super) fn panel(
    canvas: &mut Canvas,
    area: (f64, f64, f64, f64),
    episodes: usize,
    (scale, (low, high)): (Scale, (f64, f64)),
    label: String,
) -> Frame {
    let frame = axes(canvas, area, (episodes, label), (low, high), scale.marks(low, high));
    if scale == Scale::Ratio {
        let y = frame.y(0.0);
        canvas.line((area.0, y), (area.2, y), MUTED, 1.5, Some("5 4"));
    }
    frame
}

/// Draws values by episode after some without, and returns where the line ends.
pub(super) fn line(
    canvas: &mut Canvas,
    (frame, scale): (&Frame, Scale),
    (from, values): (usize, &[f64]),
    (color, width, dash): (&str, f64, Option<&str>),
) -> (f64, f64) {
    let at = |(e, v): (usize, &f64)| (frame.x((from + e + 1) as f64), frame.y(scale.at(*v)));
    let points: Vec<_> = values.iter().enumerate().map(at).collect();
    let end = points.last().copied().unwrap_or_default();
    canvas.polyline(points, color, width, dash);
    end
}

/// Returns positions near the wanted ones, in the same order, that leave room for a label each.
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
}

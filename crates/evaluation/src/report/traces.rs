//! What a learner itself sees while it learns, beside the objective: return and loss per episode.
//!
//! Every reward has its own unit, so that each learner has axes of its own and no two curves are
//! comparable. As with the objective, a curve is the mean over point MDPs with the weights of the score,
//! smoothed by a trailing mean, and its band holds quantiles over trainings. An episode without an
//! update has no loss; it counts in no mean.

use std::collections::BTreeMap;

use super::figure::WIDTH;
use super::scale::{linear_marks, number, padded, ticks};
use super::svg::{Anchor, Axes, Canvas, Frame, MUTED, TextStyle, nice_step};
use super::whole::Report;
use crate::analysis::{SMOOTHED_OVER, TrainingSummary};
use crate::stats::quantile::quantile;
use crate::stats::score::{mean, weighted_mean};

/// Trainings below which the band is their whole range.
pub(super) const FEW_TRAININGS: usize = 5;

/// Quantiles of the band.
const BAND: (f64, f64) = (0.1, 0.9);

/// Factor between largest and smallest value from which on an axis is logarithmic.
const LOG_FROM: f64 = 5.0;

/// Mean, lower and upper end of the band in one episode; `None` where no training has a value.
type Band = Option<[f64; 3]>;

/// Returns a figure of a training, one value per episode; `None` where there is none.
type Values = fn(&TrainingSummary) -> &[Option<f64>];

/// A figure of training: its name and what its panel shows.
pub(super) struct Trace {
    label: &'static str,
    pub(super) of: Values,
}

/// The figures that stand beside the objective.
pub(super) const TRACES: [Trace; 2] = [
    Trace { label: "return (sum of rewards)", of: |t| &t.returns },
    Trace { label: "loss (mean of the updates)", of: |t| &t.losses },
];

/// Returns the trailing means of a figure, which goes on level to the given length.
pub(super) fn smoothed(values: &[Option<f64>], episodes: usize) -> Vec<Option<f64>> {
    let trailing = |end: usize| {
        let window = &values[end.saturating_sub(SMOOTHED_OVER)..end];
        mean(&window.iter().flatten().copied().collect::<Vec<f64>>())
    };
    (1..=episodes).map(|e| trailing(e.min(values.len()))).collect()
}

/// Returns the values of a curve, each of which counts until the next one, to the given length.
pub(super) fn carried(values: &[Option<f64>], episodes: usize) -> Vec<Option<f64>> {
    let rows = values.iter().copied().chain(std::iter::repeat(None)).take(episodes);
    rows.scan(None, |last, value| {
        *last = value.or(*last);
        Some(*last)
    })
    .collect()
}

/// Fills gaps of a curve, up to a number of episodes.
pub(super) type Smooth = fn(&[Option<f64>], usize) -> Vec<Option<f64>>;

/// Returns the mean and the band of a figure, one per episode.
///
/// # Arguments
///
/// * `smooth` — [`smoothed`] or [`carried`].
pub(super) fn bands(
    data: &Report,
    trainings: &[&TrainingSummary],
    of: Values,
    smooth: Smooth,
) -> Vec<Band> {
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

/// Draws the panel of a figure; without any value it says so.
pub(super) fn panel(
    canvas: &mut Canvas,
    data: &Report,
    trainings: &[&TrainingSummary],
    trace: &Trace,
    area: (f64, f64, f64, f64),
    (episodes, color, dash): (usize, &str, Option<&str>),
) {
    let bands = bands(data, trainings, trace.of, smoothed);
    let style = TextStyle::new(Anchor::Start).color(MUTED);
    canvas.text(area.0, area.1 - 8.0, trace.label, style);
    let values = || bands.iter().flatten().flatten().copied();
    let (least, most) =
        values().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if least > most {
        let middle = ((area.0 + area.2) / 2.0, (area.1 + area.3) / 2.0);
        canvas.text(
            middle.0,
            middle.1,
            "not recorded",
            TextStyle::new(Anchor::Middle).color(MUTED),
        );
        return;
    }
    let logarithmic = least > 0.0 && most > LOG_FROM * least;
    let at = |value: f64| if logarithmic { value.log10() } else { value };
    let y = padded(at(least), at(most));
    let marks = match logarithmic {
        true => ticks(y.0, y.1).into_iter().map(|t| (t.log10(), number(t))).collect(),
        false => linear_marks(y.0, y.1),
    };
    let label = format!("training {}", data.words.row);
    let frame = axes(canvas, area, (episodes, label), y, marks);
    let x = |e: usize| frame.x((e + 1) as f64);
    // Episodes without any value break the line.
    let mut from = 0;
    for part in bands.split(Option::is_none) {
        let points = |i: usize| {
            let part = part.iter().flatten().enumerate();
            part.map(|(k, b)| (x(from + k), frame.y(at(b[i])))).collect::<Vec<_>>()
        };
        let mut corners = points(1);
        corners.extend(points(2).into_iter().rev());
        if part.len() > 1 {
            canvas.band(&corners, color);
            canvas.polyline(points(0), color, 2.2, dash);
        } else {
            points(0).into_iter().for_each(|p| canvas.circle(p, 2.0, color, None));
        }
        from += part.len() + 1;
    }
}

/// Draws axes of what is shown by episode, with lines across at the marks.
pub(super) fn axes(
    canvas: &mut Canvas,
    area: (f64, f64, f64, f64),
    (episodes, label): (usize, String),
    y: (f64, f64),
    marks: Vec<(f64, String)>,
) -> Frame {
    let x_end = episodes.max(2) as f64;
    let wide = area.2 - area.0 > WIDTH / 2.0;
    let frame = canvas.axes(&Axes {
        area,
        x: (0.0, x_end),
        y,
        x_step: nice_step(x_end, if wide { 10.0 } else { 5.0 }).max(1.0),
        y_step: None,
        x_last: x_end,
        x_label: Some(label),
        y_label: None,
    });
    for (value, label) in marks {
        let y = frame.y(value);
        canvas.line((area.0, y), (area.2, y), "#e3e3e3", 1.0, None);
        canvas.text(area.0 - 7.0, y + 4.5, &label, TextStyle::new(Anchor::End));
    }
    frame
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_smoothed_by_what_came_before() {
        let means = smoothed(&[6.0, 4.0, 2.0, 2.0, 1.0, 1.0].map(Some), 6);
        assert_eq!(means, [6.0, 5.0, 4.0, 3.5, 3.0, 2.0].map(Some));
    }

    #[test]
    fn a_training_that_ended_early_goes_on_level() {
        assert_eq!(smoothed(&[Some(1.5)], 3), [Some(1.5); 3]);
    }

    #[test]
    fn episodes_without_a_loss_count_in_no_mean() {
        let losses = [None, None, Some(4.0), None, Some(2.0), None, None, None, None, None];
        let smooth = smoothed(&losses, 11);
        assert_eq!(smooth[..5], [None, None, Some(4.0), Some(4.0), Some(3.0)]);
        assert_eq!(smooth[8..], [Some(2.0), None, None]);
    }
}

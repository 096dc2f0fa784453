//! Learning curves of every point MDP by itself, where there are few: which of them train, and which do not.
//!
//! A curve is the mean over replicates, smoothed as in the figure of all. All panels have the same axes.

use std::ops::RangeInclusive;

use super::curves::{drawn, line, panel};
use super::figure::{Figure, WIDTH};
use super::figures::{color, dash, sentence};
use super::scale::Scale;
use super::svg::{Anchor, Canvas, TextStyle};
use super::traces::smoothed;
use super::whole::Report;
use super::{format, legend};
use crate::stats::score::mean;

/// How many point MDPs have a panel each. Of two the figure of all shows the ends, as its band.
const FEW: RangeInclusive<usize> = 3..=9;

/// Panels beside each other, and their height with and without labels, pixels.
const COLUMNS: usize = 3;
const ROW_PX: f64 = 226.0;
const HEIGHT_PX: f64 = 150.0;

/// Draws a panel per point MDP; `None` without learners, or where the point MDPs are not few.
pub(super) fn learning(data: &Report) -> Option<Figure> {
    let methods = drawn(data);
    if methods.is_empty() || !FEW.contains(&data.points.len()) {
        return None;
    }
    let curve = |method: &str, point: usize| {
        let trainings: Vec<&[Option<f64>]> = data
            .trainings_of(method)
            .filter(|t| t.point == point && !t.curve.is_empty())
            .map(|t| t.curve.as_slice())
            .collect();
        let rows = trainings.iter().map(|curve| curve.len()).max()?;
        let smooth: Vec<_> = trainings.iter().map(|curve| smoothed(curve, rows)).collect();
        let at = |row: usize| smooth.iter().filter_map(|s| s[row]).collect::<Vec<f64>>();
        (0..rows).map(|row| mean(&at(row))).collect()
    };
    let curves: Vec<Vec<Option<Vec<f64>>>> = (0..data.points.len())
        .map(|point| methods.iter().map(|m| curve(&m.method, point)).collect())
        .collect();
    let all = || curves.iter().flatten().flatten();
    let rows = all().map(Vec::len).max()?;
    let scale = Scale::of(data);
    let range = scale.range(all().flatten());
    let top = legend::height(data, &methods, WIDTH) + 30.0;
    let height = top + ROW_PX * data.points.len().div_ceil(COLUMNS) as f64;
    let mut canvas = Canvas::new(WIDTH, height);
    legend::draw(&mut canvas, data, &methods, WIDTH, false);
    let width = (WIDTH - 10.0) / COLUMNS as f64;
    let titles: Vec<String> = data.points.iter().map(|p| data.title_of(&p.row.point)).collect();
    for (point, curves) in curves.iter().enumerate() {
        let left = width * (point % COLUMNS) as f64 + 56.0;
        let top = top + ROW_PX * (point / COLUMNS) as f64;
        let area = (left, top, left + width - 70.0, top + HEIGHT_PX);
        let frame =
            panel(&mut canvas, area, rows, (scale, range), format!("training {}", data.words.row));
        for (method, curve) in methods.iter().zip(curves).rev() {
            let Some(curve) = curve else { continue };
            let looks = (color(data, method), 2.0, dash(data, method));
            line(&mut canvas, (&frame, scale), curve, looks);
        }
        let style = TextStyle::new(Anchor::Start).bold();
        canvas.text(left - 46.0, top - 8.0, &titles[point], style);
    }
    let description = sentence(titles.iter().zip(&curves).map(|(title, curves)| {
        let ends = methods.iter().zip(curves).filter_map(|(method, curve)| {
            Some(format!("{} {}", method.method, format::score(*curve.as_ref()?.last()?)))
        });
        format!("{title}: {}", ends.collect::<Vec<_>>().join(", "))
    }));
    Some(canvas.figure("learning-by-point", "Learning curves by point MDP", &description))
}

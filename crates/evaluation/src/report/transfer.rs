//! Models away from home, as a table and as a heat map.

use std::path::{Path, PathBuf};

use super::figure::{Figure, WIDTH};
use super::format;
use super::palette::{ORDERED, UNKNOWN, ink_on};
use super::svg::{Anchor, Canvas, INK, MUTED, TextStyle, text_width};
use super::table::{self, Columns, Table};
use crate::analysis::transfer::{Cell, Group, Moved, Transfer};
use basics::files::{FileError, make_folder_beneath, write_atomically};

/// Scores at which the colours of the heat map change; 1 is the baseline.
const BOUNDS: [f64; 5] = [0.5, 0.75, 1.0, 1.5, 3.0];

/// Heights of a row of cells, pixels: with a label beside it, and without.
const ROW_PX: (f64, f64) = (22.0, 6.0);

/// Most rows and columns that have labels.
const MOST_LABELLED: usize = 40;

/// Narrowest cell with a number in it, and widest cell, pixels.
const CELL_PX: (f64, f64) = (34.0, 84.0);

/// Space above the cells for the legend, and right of them, pixels.
const TOP_PX: f64 = 78.0;
const SIDE_PX: f64 = 14.0;

/// What the row of own training is called.
const OWN: &str = "own training";

/// Files that were written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// A row per model and point MDP.
    pub transfer: PathBuf,
    /// The heat map as SVG.
    pub figure: PathBuf,
}

/// Writes table and heat map to a folder.
///
/// # Arguments
///
/// * `root` — the folder itself or one above it, beneath which nothing is written through links.
///
/// # Errors
///
/// [`FileError`] when the folder cannot be written or the disk is full.
pub fn write(root: &Path, folder: &Path, data: &Transfer) -> Result<Written, FileError> {
    make_folder_beneath(root, folder)?;
    let transfer = folder.join("transfer.csv");
    write_atomically(&transfer, table(data).csv().as_bytes())?;
    let figure = heat_map(data).write(folder)?;
    Ok(Written { transfer, figure })
}

/// Returns a row per model and point MDP.
pub fn table(data: &Transfer) -> Table {
    type Row<'a> = (&'a Group, &'a Moved, usize);
    let own = |(group, _, p): &Row<'_>| group.own[*p];
    let score = |(_, model, p): &Row<'_>| model.cells[*p].score();
    let ratio = move |row: &Row<'_>| {
        score(row).zip(own(row)).filter(|(_, own)| *own != 0.0).map(|(score, own)| score / own)
    };
    let reason = |(_, model, p): &Row<'_>| match &model.cells[*p] {
        Cell::Failed(reason) => reason.clone(),
        Cell::Score(_) | Cell::Missing => String::new(),
    };
    let columns = Columns::new()
        .text("method", "", |(group, ..): &Row<'_>| group.method.clone())
        .text("trained_on", "", |(_, model, _)| model.origin.point.clone())
        .text("evaluated_on", "", |(.., p)| data.points[*p].clone())
        .file("weight", |(.., p)| table::Cell::exact(data.weights[*p]))
        .file("score", move |row| table::Cell::exact(score(row)))
        .file("own_training", move |row| table::Cell::exact(own(row)))
        .file("ratio", move |row| table::Cell::exact(ratio(row)))
        .text("reason", "", reason);
    let of_model = |(group, model)| (0..data.points.len()).map(move |p| (group, model, p));
    columns.table(data.models().flat_map(of_model))
}

/// A row of the heat map.
struct Row<'a> {
    label: String,
    scores: Vec<Option<f64>>,
    /// Where the model is at home.
    home: Option<usize>,
    is_own: bool,
    group: &'a Group,
}

/// Returns the rows: the models of each method, and its own training below them.
fn rows(data: &Transfer) -> Vec<Row<'_>> {
    let several = data.groups.len() > 1;
    let mut rows = Vec::new();
    for group in &data.groups {
        let called = |what: &str| match several {
            true => format!("{}: {what}", group.method),
            false => what.to_owned(),
        };
        rows.extend(group.models.iter().map(|model| Row {
            label: called(&model.origin.point),
            scores: model.cells.iter().map(Cell::score).collect(),
            home: data.points.iter().position(|point| *point == model.origin.point),
            is_own: false,
            group,
        }));
        let (scores, label) = (group.own.clone(), called(OWN));
        rows.push(Row { label, scores, home: None, is_own: true, group });
    }
    rows
}

/// Draws the heat map: rows are trained on, columns evaluated on.
fn heat_map(data: &Transfer) -> Figure {
    let rows = rows(data);
    let labelled = (rows.len() <= MOST_LABELLED, data.points.len() <= MOST_LABELLED);
    let widest = |texts: &mut dyn Iterator<Item = &str>| texts.map(text_width).fold(0.0, f64::max);
    let left = match labelled.0 {
        true => widest(&mut rows.iter().map(|row| row.label.as_str())) + 34.0,
        false => widest(&mut [OWN].into_iter()) + 34.0,
    };
    let row_px = if labelled.0 { ROW_PX.0 } else { ROW_PX.1 };
    let cell = ((WIDTH - left - SIDE_PX) / data.points.len() as f64).min(CELL_PX.1);
    let own_px = ROW_PX.0;
    let height_of = |row: &Row<'_>| if row.is_own { own_px } else { row_px };
    let bottom = TOP_PX + rows.iter().map(height_of).sum::<f64>();
    let below = match labelled.1 {
        true => widest(&mut data.points.iter().map(String::as_str)) + 40.0,
        false => 40.0,
    };
    let mut canvas = Canvas::new(WIDTH, bottom + below);
    legend(&mut canvas, left);
    let mut top = TOP_PX;
    let mut homes = Vec::new();
    for row in &rows {
        let height = height_of(row);
        if labelled.0 || row.is_own {
            let style = TextStyle::new(Anchor::End);
            let style = if row.is_own { style.bold() } else { style };
            canvas.text(left - 8.0, top + height / 2.0 + 4.5, &row.label, style);
        }
        for (point, score) in row.scores.iter().enumerate() {
            let x = left + cell * point as f64;
            let line = (height > ROW_PX.1).then_some("#ffffff");
            let fill = score.map_or(UNKNOWN, |score| ORDERED[shade(score)]);
            canvas.rect((x, top), (x + cell, top + height), fill, line);
            if cell >= CELL_PX.0 && height >= ROW_PX.0 {
                let (text, ink) = match score {
                    Some(score) => (format!("{score:.2}"), ink_on(shade(*score))),
                    None => ("\u{2013}".to_owned(), INK),
                };
                let style = TextStyle::new(Anchor::Middle).small().color(ink);
                canvas.text(x + cell / 2.0, top + height / 2.0 + 4.0, &text, style);
            }
        }
        homes.extend(row.home.map(|home| ((left + cell * home as f64, top), (cell, height))));
        top += height;
    }
    // Above the cells that come after them.
    homes.into_iter().for_each(|(corner, size)| outline(&mut canvas, corner, size));
    let turned = TextStyle::new(Anchor::Middle);
    canvas.text_upwards(14.0, (TOP_PX + bottom) / 2.0, "trained on", turned);
    if labelled.1 {
        for (i, point) in data.points.iter().enumerate() {
            let x = left + cell * (i as f64 + 0.5) + 4.5;
            canvas.text_upwards(x, bottom + 8.0, point, TextStyle::new(Anchor::End));
        }
    }
    let count = format::count(data.points.len(), "point MDP");
    let axis = format!("evaluated on: {count}, those with most weight first");
    canvas.text(left, bottom + below - 12.0, &axis, TextStyle::new(Anchor::Start));
    canvas.figure("transfer", "Models away from home", &description(data, &rows))
}

/// Draws what the colours mean.
fn legend(canvas: &mut Canvas, left: f64) {
    let muted = TextStyle::new(Anchor::Start).color(MUTED);
    let what =
        "score (1 is the baseline, less is better); a frame marks the point MDP of the training";
    canvas.text(left, 18.0, what, muted);
    let between = |i: usize| match i {
        0 => format!("to {}", BOUNDS[0]),
        i if i == BOUNDS.len() => format!("above {}", BOUNDS[i - 1]),
        i => format!("to {}", BOUNDS[i]),
    };
    let mut x = left;
    let entries = (0..ORDERED.len()).map(|i| (ORDERED[i], between(i)));
    for (color, text) in entries.chain([(UNKNOWN, "none".to_owned())]) {
        canvas.rect((x, 32.0), (x + 18.0, 46.0), color, Some("#c8c8c8"));
        canvas.text(x + 24.0, 44.0, &text, TextStyle::new(Anchor::Start));
        x += 44.0 + text_width(&text);
    }
}

/// Draws a frame within a cell.
fn outline(canvas: &mut Canvas, (x, y): (f64, f64), (width, height): (f64, f64)) {
    let (left, top, right, bottom) = (x + 0.8, y + 0.8, x + width - 0.8, y + height - 0.8);
    let corners = vec![(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
    canvas.polyline(corners, INK, 1.6, None);
}

/// Returns the position of a score's colour.
fn shade(score: f64) -> usize {
    BOUNDS.iter().filter(|bound| score > **bound).count()
}

fn description(data: &Transfer, rows: &[Row<'_>]) -> String {
    let sentence = |row: &Row<'_>| {
        let named = data.points.iter().zip(&row.scores).map(|(point, score)| match score {
            Some(score) => format!("{point} {}", format::score(*score)),
            None => format!("{point} none"),
        });
        let method = &row.group.method;
        let of = if row.label.starts_with(method.as_str()) { "" } else { method.as_str() };
        let scores: Vec<String> = named.collect();
        format!("{of} {}: {}.", row.label, scores.join(", ")).trim_start().to_owned()
    };
    rows.iter().map(sentence).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_score_has_the_colour_of_its_range() {
        assert_eq!([0.2, 0.5, 0.51, 1.0, 1.2, 3.0, 40.0].map(shade), [0, 0, 1, 2, 3, 4, 5]);
    }
}

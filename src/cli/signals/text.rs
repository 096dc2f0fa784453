//! A signal as text for people.

use osm_signals::DrivingSide;

use super::look::{Look, turn};
use crate::traffic::env::warnings::{folded, warnings};
use crate::traffic::sim::topology::edge;
use crate::traffic::vocabulary::Light;

/// Returns a signal in words.
pub(super) fn text(look: &Look, number: usize) -> String {
    let signal = &look.signals[number];
    let spec = &signal.spec;
    let head = match look.side {
        DrivingSide::Right => format!("signal {}", spec.id),
        DrivingSide::Left => format!(
            "signal {} (left-hand traffic; movements are numbered as in the mirror image)",
            spec.id
        ),
    };
    let mut lines = vec![head];

    let mut rows = vec![row(["lane", "length (m)", "seen (m)", "street (m)", "upstream"])];
    for (i, lane) in spec.lanes.iter().enumerate() {
        let of_scene = &look.scene.lanes[signal.lanes[i]];
        rows.push(vec![
            lane.id.clone(),
            format!("{:.1}", lane.length_m),
            format!("{:.1}", look.seen_m(signal, i)),
            format!("{:.1}", of_scene.street_width_m),
            list(of_scene.pieces.iter().map(|piece| piece.id.as_str())),
        ]);
    }
    table(&rows, &mut lines);

    let mut rows = vec![row(["movement", "from", "turn", "lanes", "links", "downstream"])];
    for (m, movement) in spec.movements.iter().enumerate() {
        let lanes = look.lanes(signal, m);
        rows.push(vec![
            movement.index.to_string(),
            lanes.first().map_or("", |lane| edge(lane)).to_owned(),
            turn(movement.turn, look.side).to_owned(),
            list(&lanes),
            list(&signal.movement_links[m]),
            list(look.downstream(signal, m)),
        ]);
    }
    table(&rows, &mut lines);

    let mut rows = vec![row(["phase", "state", "counts", "serves", "serves, yielding"])];
    for (i, phase) in spec.phases.iter().enumerate() {
        let index = |m: usize| spec.movements[m].index;
        let served = |wanted| {
            let of = (0..phase.service.len()).filter(|m| phase.service[*m] == wanted);
            list(of.map(index))
        };
        rows.push(vec![
            i.to_string(),
            phase.state.clone(),
            list(phase.pair.iter().map(|m| index(*m))),
            served(Light::Protected),
            served(Light::Permissive),
        ]);
    }
    table(&rows, &mut lines);
    lines.extend(folded(&warnings(signal)).iter().map(|warning| format!("  warning: {warning}")));
    lines.join("\n")
}

fn row<const N: usize>(cells: [&str; N]) -> Vec<String> {
    cells.map(str::to_owned).to_vec()
}

/// Returns values with spaces between them, or a dash.
fn list<T: ToString>(values: impl IntoIterator<Item = T>) -> String {
    let values: Vec<String> = values.into_iter().map(|value| value.to_string()).collect();
    if values.is_empty() { "-".to_owned() } else { values.join(" ") }
}

/// Adds a table whose first row is its head; columns of numbers are aligned to the right.
fn table(rows: &[Vec<String>], lines: &mut Vec<String>) {
    let width = |c: usize| rows.iter().map(|r| r[c].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..rows[0].len()).map(width).collect();
    let is_number = |c: usize| rows[1..].iter().all(|r| r[c].parse::<f64>().is_ok());
    let right: Vec<bool> = (0..rows[0].len()).map(|c| c > 0 && is_number(c)).collect();
    for row in rows {
        let mut text = String::new();
        for ((cell, width), right) in row.iter().zip(&widths).zip(&right) {
            text.push_str("  ");
            text.push_str(&match right {
                true => format!("{cell:>width$}"),
                false => format!("{cell:width$}"),
            });
        }
        lines.push(text.trim_end().to_owned());
    }
}

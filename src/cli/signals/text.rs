//! A signal as text for people.

use osm_signals::DrivingSide;
use serde_json::Value;

use super::look::Look;
use crate::traffic::env::warnings::{folded, warnings};

/// The tables of a signal: where its rows are in JSON, and heading and key of each column.
const TABLES: [(&str, &[(&str, &str)]); 3] = [
    (
        "lanes",
        &[
            ("lane", "lane"),
            ("length (m)", "length_m"),
            ("seen (m)", "seen_m"),
            ("street (m)", "street_width_m"),
            ("upstream", "upstream"),
        ],
    ),
    (
        "movements",
        &[
            ("movement", "movement"),
            ("from", "from"),
            ("turn", "turn"),
            ("lanes", "lanes"),
            ("links", "links"),
            ("downstream", "downstream"),
        ],
    ),
    (
        "phases",
        &[
            ("phase", "phase"),
            ("state", "state"),
            ("counts", "counts"),
            ("serves", "right_of_way"),
            ("serves, yielding", "yielding"),
        ],
    ),
];

/// Returns a signal in words.
pub(super) fn text(look: &Look, number: usize) -> String {
    let (signal, json) = (&look.signals[number], look.json(number));
    let side = match look.side {
        DrivingSide::Right => "",
        DrivingSide::Left => " (left-hand traffic; movements are numbered as in the mirror image)",
    };
    let mut lines = vec![format!("signal {}{side}", signal.spec.id)];
    for (name, columns) in TABLES {
        let mut rows = vec![columns.iter().map(|(heading, _)| (*heading).to_owned()).collect()];
        rows.extend(
            json[name]
                .as_array()
                .into_iter()
                .flatten()
                .map(|row| columns.iter().map(|(_, key)| cell(&row[key])).collect::<Vec<String>>()),
        );
        table(&rows, &mut lines);
    }
    lines.extend(folded(&warnings(signal)).iter().map(|warning| format!("  warning: {warning}")));
    lines.join("\n")
}

/// Returns a value; of several with spaces between them, of none a dash.
fn cell(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(values) if values.is_empty() => "-".to_owned(),
        Value::Array(values) => values.iter().map(cell).collect::<Vec<_>>().join(" "),
        Value::Number(number) if number.is_f64() => {
            format!("{:.1}", number.as_f64().unwrap_or_default())
        }
        other => other.to_string(),
    }
}

/// Adds a table whose first row is its head; columns of numbers are aligned to the right.
fn table(rows: &[Vec<String>], lines: &mut Vec<String>) {
    let width = |c: usize| rows.iter().map(|r| r[c].chars().count()).max().unwrap_or(0);
    let is_number = |c: usize| c > 0 && rows[1..].iter().all(|r| r[c].parse::<f64>().is_ok());
    let columns: Vec<_> = (0..rows[0].len()).map(|c| (width(c), is_number(c))).collect();
    for row in rows {
        let cells = row.iter().zip(&columns).map(|(cell, (width, right))| match right {
            true => format!("  {cell:>width$}"),
            false => format!("  {cell:width$}"),
        });
        lines.push(cells.collect::<String>().trim_end().to_owned());
    }
}

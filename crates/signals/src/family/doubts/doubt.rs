//! Something doubtful in a table, in words.

use std::borrow::Cow;
use std::fmt::{Display, Write};

/// Rows that a short message names.
const FEW_ROWS: usize = 5;

/// Something doubtful or changed, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Doubt {
    /// What it is, with the way out.
    pub about: String,
    /// The rows with their values, such as `line 7: 1200`; none if it is about the whole table.
    pub rows: Vec<String>,
}

impl Doubt {
    /// Returns a doubt about some rows; `None` without any.
    pub(crate) fn of(about: impl Into<String>, rows: Vec<String>) -> Option<Self> {
        (!rows.is_empty()).then(|| Self { about: about.into(), rows })
    }

    /// Returns a doubt about a whole table.
    pub(crate) fn whole(about: impl Into<String>) -> Self {
        Self { about: about.into(), rows: Vec::new() }
    }

    /// Returns it in one paragraph, with the first rows.
    pub fn brief(&self) -> String {
        let shown = &self.rows[..self.rows.len().min(FEW_ROWS)];
        let mut text = self.about.clone();
        if !shown.is_empty() {
            write!(text, " ({}", shown.join("; ")).expect("writing to a string cannot fail");
            let more = self.rows.len() - shown.len();
            text += &if more == 0 { ")".to_owned() } else { format!("; and {more} more)") };
        }
        text
    }

    /// Returns whether [`Self::brief`] leaves rows out.
    pub fn is_long(&self) -> bool {
        self.rows.len() > FEW_ROWS
    }

    /// Returns it with every row on a line of its own.
    pub fn full(&self) -> String {
        let rows = self.rows.iter().map(|row| format!("\n  {row}"));
        format!("{}{}", self.about, rows.collect::<String>())
    }
}

/// Doubts that are collected row by row, by what they are about, in their order.
#[derive(Debug, Default)]
pub(crate) struct Said(Vec<(Cow<'static, str>, Vec<String>)>);

impl Said {
    pub(crate) fn say(&mut self, about: impl Into<Cow<'static, str>>, row: String) {
        let about = about.into();
        match self.0.iter_mut().find(|(known, _)| *known == about) {
            Some((_, rows)) => rows.push(row),
            None => self.0.push((about, vec![row])),
        }
    }

    pub(crate) fn doubts(self) -> impl Iterator<Item = Doubt> {
        self.0.into_iter().filter_map(|(about, rows)| Doubt::of(about, rows))
    }
}

/// Returns the middle of some values; `None` of nothing.
pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Returns what stands at a line.
pub(super) fn at_line(line: u64, text: impl Display) -> String {
    format!("line {line}: {text}")
}

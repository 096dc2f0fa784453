//! Something doubtful in a table, or changed of it: nothing of it stops a run, and nothing is believed without a word.

use std::borrow::Cow;
use std::fmt::Write;

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
    pub fn of(about: impl Into<String>, rows: Vec<String>) -> Option<Self> {
        (!rows.is_empty()).then(|| Self { about: about.into(), rows })
    }

    /// Returns a doubt about a whole table.
    pub fn whole(about: impl Into<String>) -> Self {
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
pub struct Said(Vec<(Cow<'static, str>, Vec<String>)>);

impl Said {
    /// Adds a row to what is said about something.
    pub fn say(&mut self, about: impl Into<Cow<'static, str>>, row: String) {
        let about = about.into();
        match self.0.iter_mut().find(|(known, _)| *known == about) {
            Some((_, rows)) => rows.push(row),
            None => self.0.push((about, vec![row])),
        }
    }

    /// Returns a doubt for each thing that was said.
    pub fn doubts(self) -> impl Iterator<Item = Doubt> {
        self.0.into_iter().filter_map(|(about, rows)| Doubt::of(about, rows))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_message_names_five_rows_and_counts_the_others() {
        let doubt = Doubt::of("x", (0..7).map(|i| i.to_string()).collect()).unwrap();
        assert_eq!(doubt.brief(), "x (0; 1; 2; 3; 4; and 2 more)");
        assert_eq!(doubt.full().lines().count(), 8);
    }
}

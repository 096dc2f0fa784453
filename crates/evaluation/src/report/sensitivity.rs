//! How far the ranking depends on importance: a table, and what must be known beside it.

use std::path::{Path, PathBuf};

use basics::files::{make_folder, write_atomically};

use super::across::rank;
use super::error::ReportError;
use super::format;
use super::table::{Cell, Columns, Table};
use crate::analysis::sensitivity::{Distribution, RANDOM, Sensitivity};

/// Returns a score with as many decimals as distributions differ in.
fn score(value: f64) -> String {
    if value.abs() < 100.0 { format!("{value:.3}") } else { format::score(value) }
}

impl Sensitivity {
    /// Returns the table for terminals: a row per method, a column per distribution.
    pub fn text(&self) -> String {
        let cell = |d: &Distribution, m: usize| {
            Cell::number(d.overall[m], score).above(Some(rank(d.ranks[m])))
        };
        let range = |m: usize| {
            self.range[m].map_or_else(String::new, |(a, b)| format!("{} to {}", score(a), score(b)))
        };
        let mut columns =
            Columns::new().text("", "method", |m: &usize| self.board.methods[*m].clone());
        for d in &self.distributions {
            columns = columns.shown(&d.name, move |m| cell(d, *m));
        }
        columns = columns.shown(format!("95% of {RANDOM} random"), |m| Cell::text(range(*m)));
        let table = columns.table(0..self.board.methods.len());
        format!(
            "Overall performance on {} with the importance named (rank); D1 and so on are random:\n\n{}",
            format::count(self.board.points.len(), "point MDP"),
            table.plain()
        )
    }

    /// Returns a row per distribution and method.
    pub fn rows(&self) -> Table {
        let cells = self
            .distributions
            .iter()
            .flat_map(|d| (0..self.board.methods.len()).map(move |m| (d, m)));
        let columns = Columns::new()
            .text("distribution", "", |(d, _): &(&Distribution, usize)| d.name.clone())
            .text("method", "", |(_, m)| self.board.methods[*m].clone())
            .file("overall", |(d, m)| Cell::exact(d.overall[*m]))
            .file("rank", |(d, m)| Cell::exact(d.ranks[*m]))
            .file("effective_points", |(d, _)| Cell::exact(d.effective()));
        columns.table(cells)
    }

    /// Writes `distributions.csv` to a folder and returns its path.
    ///
    /// # Errors
    ///
    /// [`ReportError::Io`] when the folder cannot be written or the disk is full.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, ReportError> {
        make_folder(folder)?;
        let path = folder.join("distributions.csv");
        write_atomically(&path, self.rows().csv().as_bytes())?;
        Ok(path)
    }

    /// Returns what readers of the table must know: what is left out, and where the order turns round.
    pub fn notes(&self) -> Vec<String> {
        let mut notes: Vec<String> = self.board.lacks().into_iter().collect();
        let unknown = |sampled| format!("{sampled}; the effect of the others is not known");
        notes.extend(self.board.sampled().map(unknown));
        for d in &self.distributions[1..] {
            let ahead = self.reversals(d);
            let ahead: Vec<String> =
                ahead.iter().map(|(a, b)| format!("{a} is ahead of {b}")).collect();
            if !ahead.is_empty() {
                notes.push(format!("{}: {}, unlike by importance", d.name, ahead.join(", ")));
            }
        }
        notes.push(format!(
            "the order by importance holds under {:.1}% of the random distributions",
            100.0 * self.as_overall
        ));
        notes
    }
}

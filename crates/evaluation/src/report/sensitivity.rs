//! How far the ranking depends on importance: a table, and what must be known beside it.

use super::format;
use super::table::{Cell, Columns, Table};
use crate::analysis::sensitivity::{Distribution, RANDOM, Sensitivity};

fn score(value: f64) -> String {
    if value.abs() < 100.0 { format!("{value:.3}") } else { format::score(value) }
}

impl Sensitivity {
    /// Returns the table for terminals: a row per method, a column per distribution.
    pub fn text(&self) -> String {
        let mut columns =
            Columns::new().text("", "method", |m: &usize| self.board.methods[*m].clone());
        for d in &self.distributions {
            let cell =
                |m: &usize| Cell::number(d.overall[*m], score).above(Some(d.ranks[*m].to_string()));
            columns = columns.shown(&d.name, cell);
        }
        let range =
            |m: &usize| self.range[*m].map(|(a, b)| format!("{} to {}", score(a), score(b)));
        columns = columns
            .shown(format!("95% of {RANDOM} random"), |m| Cell::text(range(m).unwrap_or_default()));
        format!(
            "Overall performance on {} with the importance named (rank); D1 and so on are random:\n\n{}\n\nThe order by \
             importance holds under {:.1}% of {RANDOM} random distributions.",
            format::count(self.board.points.len(), "point MDP"),
            columns.table(0..self.board.methods.len()).plain(),
            100.0 * self.as_overall
        )
    }

    /// Returns a row per distribution and method.
    pub fn rows(&self) -> Table {
        let methods = 0..self.board.methods.len();
        let of = |d| methods.clone().map(move |m| (d, m));
        Columns::new()
            .text("distribution", "", |(d, _): &(&Distribution, usize)| d.name.clone())
            .text("method", "", |(_, m)| self.board.methods[*m].clone())
            .file("overall", |(d, m)| Cell::exact(d.overall[*m]))
            .file("rank", |(d, m)| Cell::exact(d.ranks[*m]))
            // How many point MDPs of equal weight would be as unequal.
            .file("effective_points", |(d, _)| {
                Cell::exact(1.0 / d.weights.iter().map(|w| w * w).sum::<f64>())
            })
            .table(self.distributions.iter().flat_map(of))
    }
}

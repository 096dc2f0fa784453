//! How methods rank across families, for terminals and as CSV.

use super::table::{Cell, Columns, Table};
use crate::analysis::across::{Across, Scale, Weighing};

/// Returns the table, a row per method.
pub fn table(data: &Across) -> Table {
    let reported = data.reported.as_ref();
    let mut columns = Columns::new()
        .text("method", "method", |m: &usize| data.methods[*m].clone())
        .column("score", data.scale.column(), |m| {
            Cell::number(data.expected[*m], |v| format!("{v:.3}"))
        })
        .column("mean_rank", "mean rank", |m| {
            Cell::number(data.mean_rank[*m], |v| format!("{v:.2}"))
        });
    for rank in 0..data.methods.len() {
        let name = (format!("rank_{}", rank + 1), format!("rank {}", rank + 1));
        columns = columns
            .column(name.0, name.1, move |m| Cell::number(data.ranks.shares[*m][rank], percent));
    }
    let heading = if reported.is_some() { "reported" } else { "" };
    columns = columns.file("reported_score", |m| Cell::exact(reported.map(|r| r.scores[*m])));
    columns = columns
        .column("reported_rank", heading, |m| Cell::number(reported.map(|r| r.ranks[*m]), rank));
    columns = columns.file("scale", |_| Cell::text(data.scale.name()));
    columns = columns.file("by", |_| Cell::text(data.weighing.name()));
    columns = columns.file("combinations", |_| Cell::parsed(&data.ranks.combinations.to_string()));
    columns.table(0..data.methods.len())
}

/// Returns the table for terminals, with what it is a table of above it and what follows below.
pub fn text(data: &Across) -> String {
    let families: Vec<String> =
        data.families.iter().map(|(name, points)| format!("{name} ({points})")).collect();
    let reported = data.reported.as_ref();
    let at =
        reported.map_or_else(String::new, |r| format!("\n\nreported at {}", r.points.join(", ")));
    format!(
        "{} combinations of one point MDP from each of {}, {};\n{}\n\n{}{at}\n\nThe order of the table holds in {} of the \
         combinations; {} have ties, which share their ranks.",
        grouped(data.ranks.combinations),
        families.join(", "),
        data.weighing.in_words(),
        data.scale.in_words(data.direction.name()),
        table(data).plain(),
        percent(data.ranks.as_expected),
        percent(data.ranks.tied),
    )
}

impl Scale {
    /// Returns the name as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Score => "score",
            Self::Range => "range",
            Self::Rank => "rank",
        }
    }

    fn column(self) -> &'static str {
        match self {
            Self::Score => "mean score",
            Self::Range => "mean of range",
            Self::Rank => "mean of ranks",
        }
    }

    fn in_words(self, better: &str) -> String {
        let what = match self {
            Self::Score => "ranked by the mean of their scores",
            Self::Range => {
                "ranked by the mean of their scores from 0, the family's worst, to 1, its best"
            }
            Self::Rank => "ranked by the mean of their ranks on the point MDPs",
        };
        format!("{what}, {better} is better:")
    }
}

impl Weighing {
    /// Returns the name as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Equal => "equal",
            Self::Importance => "importance",
        }
    }

    fn in_words(self) -> &'static str {
        match self {
            Self::Equal => "all counting the same",
            Self::Importance => "weighed by the product of importances",
        }
    }
}

/// Returns a share in percent with two decimals, as the paper gives it; a share above 0 is never 0.
pub(super) fn percent(share: f64) -> String {
    match 100.0 * share {
        0.0 => "0%".to_owned(),
        p if p < 0.005 => "<0.01%".to_owned(),
        p => format!("{p:.2}%"),
    }
}

/// Returns a rank, with a half where two tie.
pub(super) fn rank(rank: f64) -> String {
    if rank.fract() == 0.0 { format!("{rank:.0}") } else { format!("{rank:.1}") }
}

/// Returns a number with commas between thousands.
fn grouped(number: u128) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_easy_to_read() {
        assert_eq!([7, 1000, 10_036_224].map(grouped), ["7", "1,000", "10,036,224"]);
        assert_eq!([0.0, 0.00001, 0.1875, 1.0].map(percent), ["0%", "<0.01%", "18.75%", "100.00%"]);
        assert_eq!([1.0, 2.5].map(rank), ["1", "2.5"]);
    }
}

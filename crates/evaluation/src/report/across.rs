//! How methods rank across families, for terminals and as CSV.

use super::table::{Cell, Columns, Table};
use crate::analysis::across::{Across, Scale};

/// Returns the table, a row per method.
pub fn table(data: &Across) -> Table {
    let (heading, scale) = match data.scale {
        Scale::Score => ("mean score", "score"),
        Scale::Range => ("mean of range", "range"),
    };
    let shares = &data.ranks.shares;
    let mean_rank = |m: usize| {
        shares[m].iter().enumerate().map(|(r, share)| (r + 1) as f64 * share).sum::<f64>()
    };
    let mut columns = Columns::new()
        .text("method", "method", |m: &usize| data.methods[*m].clone())
        .column("score", heading, |m| Cell::number(data.expected[*m], |v| format!("{v:.3}")))
        .column("mean_rank", "mean rank", move |m| {
            Cell::number(mean_rank(*m), |v| format!("{v:.2}"))
        });
    for rank in 1..=data.methods.len() {
        let (name, heading) = (format!("rank_{rank}"), format!("rank {rank}"));
        columns =
            columns.column(name, heading, move |m| Cell::number(shares[*m][rank - 1], percent));
    }
    columns
        .file("scale", move |_| Cell::text(scale))
        .file("combinations", |_| Cell::parsed(&data.ranks.combinations.to_string()))
        .table(0..data.methods.len())
}

/// Returns the table for terminals, with what it is a table of above it and what follows below.
pub fn text(data: &Across) -> String {
    let families: Vec<String> =
        data.families.iter().map(|(name, points)| format!("{name} ({points})")).collect();
    let scale = match data.scale {
        Scale::Score => "their scores",
        Scale::Range => "their scores from 0, the family's worst, to 1, its best",
    };
    format!(
        "{} combinations of one point MDP from each of {}, all counting the same;\nranked by the mean of {scale}, {} is \
         better:\n\n{}\n\nThe order of the table holds in {} of the combinations; {} have ties, which share their ranks.",
        data.ranks.combinations,
        families.join(", "),
        data.direction.name(),
        table(data).plain(),
        percent(data.ranks.in_order),
        percent(data.ranks.tied),
    )
}

fn percent(share: f64) -> String {
    match 100.0 * share {
        0.0 => "0%".to_owned(),
        p if p < 0.005 => "<0.01%".to_owned(),
        p => format!("{p:.2}%"),
    }
}

//! How methods rank across families, for terminals and as CSV and JSON.

use serde_json::{Map, Value, json};

use super::csv::table;
use super::plain_table::plain_table;
use crate::analysis::across::{Across, Scale, Weighing};

/// Returns the table for terminals, with what it is a table of above it and what follows below.
pub fn text(data: &Across) -> String {
    let families: Vec<String> =
        data.families.iter().map(|(name, points)| format!("{name} ({points})")).collect();
    let mut header =
        vec!["method".to_owned(), data.scale.column().to_owned(), "mean rank".to_owned()];
    header.extend((1..=data.methods.len()).map(|rank| format!("rank {rank}")));
    header.extend(data.reported.as_ref().map(|_| "reported".to_owned()));
    let rows = data.methods.iter().enumerate().map(|(m, method)| {
        let mut row = vec![
            method.clone(),
            format!("{:.3}", data.expected[m]),
            format!("{:.2}", data.mean_rank[m]),
        ];
        row.extend(data.ranks.shares[m].iter().map(|share| percent(*share)));
        row.extend(data.reported.as_ref().map(|reported| rank(reported.ranks[m])));
        row
    });
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let right: Vec<usize> = (1..header.len()).collect();
    let mut text = format!(
        "{} combinations of one point MDP from each of {}, {};\n{}\n\n{}",
        grouped(data.ranks.combinations),
        families.join(", "),
        data.weighing.in_words(),
        data.scale.in_words(data.direction.name()),
        plain_table(&header, &right, rows.collect()),
    );
    if let Some(reported) = reported_order(data) {
        text.push_str(&format!("\n\nreported: {reported}"));
    }
    text.push_str(&format!(
        "\n\nThe order of the table holds in {} of the combinations; {} have ties, which share their ranks.",
        percent(data.ranks.as_expected),
        percent(data.ranks.tied),
    ));
    text
}

/// Returns the methods in the order of the reported combination, those that tie joined by `=`, and its point MDPs.
fn reported_order(data: &Across) -> Option<String> {
    let reported = data.reported.as_ref()?;
    let mut order: Vec<usize> = (0..data.methods.len()).collect();
    order.sort_by(|a, b| reported.ranks[*a].total_cmp(&reported.ranks[*b]));
    let mut text = String::new();
    for (i, m) in order.iter().enumerate() {
        let ties = i > 0 && reported.ranks[order[i - 1]] == reported.ranks[*m];
        text.push_str(if i == 0 {
            ""
        } else if ties {
            " = "
        } else {
            ", "
        });
        text.push_str(&data.methods[*m]);
    }
    Some(format!("{text} (at {})", reported.points.join(", ")))
}

/// Returns the table as CSV, a row per method.
pub fn csv(data: &Across) -> String {
    let mut header = ["method", "score", "mean_rank"].map(str::to_owned).to_vec();
    header.extend((1..=data.methods.len()).map(|rank| format!("rank_{rank}")));
    header.extend(
        ["reported_score", "reported_rank", "scale", "by", "combinations"].map(str::to_owned),
    );
    let rows = (0..data.methods.len()).map(|m| {
        let mut row = vec![
            data.methods[m].clone(),
            data.expected[m].to_string(),
            data.mean_rank[m].to_string(),
        ];
        row.extend(data.ranks.shares[m].iter().map(f64::to_string));
        let reported = data.reported.as_ref();
        let cell = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
        row.push(cell(reported.map(|r| r.scores[m])));
        row.push(cell(reported.map(|r| r.ranks[m])));
        row.extend([data.scale.name().to_owned(), data.weighing.name().to_owned()]);
        row.push(data.ranks.combinations.to_string());
        row
    });
    table(&header, rows)
}

/// Returns the lines of `--json`: one of the whole, then one per method.
pub fn json(data: &Across) -> Vec<Value> {
    let families =
        data.families.iter().map(|(name, points)| json!({"results": name, "points": points}));
    let mut lines = vec![json!({
        "event": "across",
        "families": families.collect::<Vec<_>>(),
        "combinations": data.ranks.combinations as f64,
        "distinct": data.ranks.distinct as f64,
        "scale": data.scale.name(),
        "by": data.weighing.name(),
        "direction": data.direction.name(),
        "order_holds": data.ranks.as_expected,
        "tied": data.ranks.tied,
        "reported": data.reported.as_ref().map(|r| r.points.clone()),
    })];
    for (m, method) in data.methods.iter().enumerate() {
        let mut row = Map::new();
        row.insert("event".to_owned(), "method".into());
        row.insert("method".to_owned(), method.clone().into());
        row.insert("score".to_owned(), data.expected[m].into());
        row.insert("mean_rank".to_owned(), data.mean_rank[m].into());
        for (r, share) in data.ranks.shares[m].iter().enumerate() {
            row.insert(format!("rank_{}", r + 1), (*share).into());
        }
        let reported = data.reported.as_ref();
        row.insert("reported_score".to_owned(), reported.map(|r| r.scores[m]).into());
        row.insert("reported_rank".to_owned(), reported.map(|r| r.ranks[m]).into());
        lines.push(Value::Object(row));
    }
    lines
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

//! The tables on how sure the ranking is: `pairs.csv` with one row per two methods, `ranks.csv` with one per method and
//! place, `profiles.csv` with one per method and score. A cell is empty where nothing is known.

use super::csv::{number, table};
use super::whole::Report;
use crate::analysis::{Decided, Estimated, Pair};

/// Returns `pairs.csv`.
pub(super) fn pairs(data: &Report) -> String {
    let estimated = |name: &str| [name.to_owned(), format!("{name}_low"), format!("{name}_high")];
    let mut header: Vec<String> = ["method", "other", "points"].map(str::to_owned).to_vec();
    header.extend(estimated("ahead"));
    header.extend(estimated("improvement"));
    header.extend(["better", "against"].map(str::to_owned));
    table(&header, data.comparison.pairs.iter().map(|pair| pair_row(data, pair)))
}

fn pair_row(data: &Report, pair: &Pair) -> Vec<String> {
    let (first, second) = (&data.methods[pair.first].method, &data.methods[pair.second].method);
    let mut row = vec![first.clone(), second.clone(), pair.points.to_string()];
    row.extend(cells(pair.ahead));
    row.extend(cells(pair.improvement));
    row.push(match pair.decided() {
        Decided::First => first.clone(),
        Decided::Second => second.clone(),
        Decided::Open => "open".to_owned(),
        Decided::Unknown => String::new(),
    });
    row.push(data.reference.name.clone());
    row
}

fn cells(e: Estimated) -> [String; 3] {
    [Some(e.value), e.interval.map(|i| i.0), e.interval.map(|i| i.1)].map(number)
}

/// Returns `ranks.csv`.
pub(super) fn ranks(data: &Report) -> String {
    let header = ["method", "rank", "probability", "against"].map(str::to_owned);
    let all = data.comparison.ranks.as_deref().unwrap_or_default();
    let rows = data.methods.iter().zip(all).flat_map(|(m, probabilities)| {
        probabilities.iter().enumerate().map(|(place, p)| {
            let place = (place + 1).to_string();
            vec![m.method.clone(), place, p.to_string(), data.reference.name.clone()]
        })
    });
    table(&header, rows)
}

/// Returns `profiles.csv`.
pub(super) fn profiles(data: &Report) -> String {
    let header = ["method", "score", "share", "against"].map(str::to_owned);
    let rows = data.comparison.profiles.iter().flat_map(|profile| {
        profile.steps.iter().map(|(score, share)| {
            let method = data.methods[profile.method].method.clone();
            let [score, share] = [score, share].map(f64::to_string);
            vec![method, score, share, data.reference.name.clone()]
        })
    });
    table(&header, rows)
}

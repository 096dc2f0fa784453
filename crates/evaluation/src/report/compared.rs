//! The tables on how sure the ranking is: `ranks.csv` with one row per method and place, `profiles.csv` with one per
//! method and score. A cell is empty where nothing is known.

use super::csv::table;
use super::whole::Report;

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

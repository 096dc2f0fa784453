//! The tables on how sure the ranking is: `pairs.csv` with one row per two methods, `ranks.csv` with one per method and
//! place, `profiles.csv` with one per method and threshold. A cell is empty where nothing is known.

use super::csv::{number, table};
use super::whole::Report;
use crate::analysis::{Decided, Estimated, Pair};
use crate::stats::Verdict;

/// Returns `pairs.csv`.
pub(super) fn pairs(data: &Report) -> String {
    let estimated = |name: &str| [name.to_owned(), format!("{name}_low"), format!("{name}_high")];
    let mut header: Vec<String> = ["method", "other", "points"].map(str::to_owned).to_vec();
    header.extend(estimated("ahead"));
    header.extend(estimated("improvement"));
    let of_profiles = [
        "better", "dominates", "most_ahead", "most_behind", "p_nowhere_behind",
        "p_other_nowhere_behind",
    ];
    header.extend(of_profiles.iter().chain(&["against"]).map(|name| (*name).to_owned()));
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
    let dominance = pair.dominance;
    row.push(dominance.map_or_else(String::new, |d| match d.verdict {
        Verdict::First => first.clone(),
        Verdict::Second => second.clone(),
        Verdict::Neither => "none".to_owned(),
        Verdict::Open => "open".to_owned(),
    }));
    let p = dominance.and_then(|d| d.p);
    let ahead = dominance.map(|d| d.ahead);
    let of_profiles = [ahead.map(|a| a.0), ahead.map(|a| a.1), p.map(|p| p.0), p.map(|p| p.1)];
    row.extend(of_profiles.map(number));
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
    let header = ["method", "threshold", "share", "share_low", "share_high", "against"];
    let rows = data.comparison.profiles.iter().flat_map(|profile| {
        profile.bands.iter().map(|(threshold, share)| {
            let mut row = vec![data.methods[profile.method].method.clone(), threshold.to_string()];
            row.extend(cells(*share));
            row.push(data.reference.name.clone());
            row
        })
    });
    table(&header.map(str::to_owned), rows)
}

//! Where the choice of a method matters most: where the best one differs most from the others, and where most depends
//! on that difference.

use minijinja::{Value, context};

use super::figures::shown;
use super::format;
use super::sure::certain;
use super::whole::Report;
use crate::analysis::{PointSummary, Winner};

/// Point MDPs of a table.
const CHOICES: usize = 10;

/// A point MDP on which some other method is worse than the best.
struct Choice {
    /// By how much the mean of the others is worse, in the objective's unit.
    difference: f64,
    /// What that amounts to, where it is known.
    stake: Option<f64>,
    value: Value,
}

/// Returns the tables, each with its caption; the second only where the domain knows what a difference amounts to.
///
/// # Arguments
///
/// * `row_of` — number of a row of the table of everything for each point MDP.
pub(super) fn choices(data: &Report, row_of: &[Option<usize>]) -> Vec<Value> {
    let stakes = data.sections.stakes(data);
    let factor = |p: usize| stakes.as_ref().and_then(|s| s.factors[p]);
    let mut all: Vec<Choice> = data
        .points
        .iter()
        .filter_map(|p| choice(data, p, row_of[p.index], factor(p.index)))
        .collect();
    all.sort_by(|a, b| b.difference.total_cmp(&a.difference));
    let stake = stakes.as_ref().map(|s| vec![s.heading.clone(), s.unit.clone()]);
    let table = |of: &[&Choice], by_stake: bool, say: &dyn Fn(usize) -> String| {
        let rows: Vec<Value> = of.iter().take(CHOICES).map(|c| c.value.clone()).collect();
        let caption = say(rows.len());
        context! { rows, caption, by_stake, stake => stake.clone() }
    };
    let by_difference: Vec<&Choice> = all.iter().collect();
    if all.is_empty() {
        return Vec::new();
    }
    let mut tables = vec![table(&by_difference, false, &|n| {
        format!(
            "Where the choice of a method matters most: the {n} point MDPs on which the best method differs most from \
             the mean of the others."
        )
    })];
    if let Some(stakes) = &stakes {
        let mut by_stake: Vec<&Choice> = all.iter().filter(|c| c.stake.is_some()).collect();
        by_stake.sort_by(|a, b| b.stake.unwrap_or(0.0).total_cmp(&a.stake.unwrap_or(0.0)));
        tables.push(table(&by_stake, true, &|n| {
            format!(
                "Where it matters most in {}: the {n} point MDPs with the largest product, the same difference {}.",
                stakes.heading.to_lowercase(),
                stakes.from
            )
        }));
    }
    tables
}

fn choice(
    data: &Report,
    p: &PointSummary,
    row: Option<usize>,
    factor: Option<f64>,
) -> Option<Choice> {
    let methods = &data.manifest.identity.methods;
    let winner = data.winners[p.index].as_ref()?;
    let own = p.results[winner.best].as_ref()?.objective;
    let others: Vec<(usize, f64)> = (0..methods.len())
        .filter(|m| *m != winner.best)
        .filter_map(|m| Some((m, p.results[m].as_ref()?.objective)))
        .collect();
    let worst = others.iter().max_by(|a, b| data.direction().compare(a.1, b.1))?;
    let mean = others.iter().map(|(_, value)| value).sum::<f64>() / others.len() as f64;
    let difference = (mean - own).abs();
    let stake = factor.map(|factor| factor * difference);
    let value = context! {
        row => row.map(|row| format!("row-{row}")),
        name => data.title_of(&p.row.point),
        stands_for => data.sections.stands_for(&p.row),
        best => shown(data, &methods[winner.best]),
        own => data.words.value(own),
        others => data.words.value(mean),
        difference => data.words.value(difference),
        stake => stake.map_or_else(dash, format::thousands),
        worst => format!("{} under {}", data.words.value(worst.1), shown(data, &methods[worst.0])),
        probability => probability(Some(winner)),
        decided => decided(Some(winner)),
    };
    (difference > 0.0).then_some(Choice { difference, stake, value })
}

/// Returns the probability of a winner in words.
pub(super) fn probability(winner: Option<&Winner>) -> String {
    winner.and_then(|w| w.probability).map_or_else(dash, certain)
}

/// Says whether the leads of a winner are more than chance.
pub(super) fn decided(winner: Option<&Winner>) -> String {
    match winner {
        Some(w) if w.lead.is_none() => dash(),
        Some(w) if w.is_decided => "yes".to_owned(),
        Some(_) => "open".to_owned(),
        None => dash(),
    }
}

pub(super) fn dash() -> String {
    "\u{2013}".to_owned()
}

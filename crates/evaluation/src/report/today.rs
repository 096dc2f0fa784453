//! What is done today, which the headline and the first page compare with where a domain knows it and the run has it: a
//! method that beats an untuned baseline may be worse than what is there.

use super::answers::{AS_MUCH, change};
use super::whole::Report;
use crate::analysis::{Decided, MethodSummary, Pair};
use crate::stats::score::weighted_mean;

/// Returns the method that does what is done today, if it is ranked and not what scores are divided by anyway.
pub(super) fn today(data: &Report) -> Option<&MethodSummary> {
    let name = data.sections.today(data)?;
    data.methods.iter().find(|m| m.method == name && m.rank.is_some() && !m.is_reference)
}

/// Returns the mean over point MDPs of what one method has of the objective of another; `None` where there is none.
pub(super) fn relative(data: &Report, own: &MethodSummary, other: &MethodSummary) -> Option<f64> {
    let ratio = |p: &crate::analysis::PointSummary| {
        let [own, other] = [own, other].map(|m| Some(p.results[m.index].as_ref()?.objective));
        let other = other.filter(|value| *value > 0.0)?;
        Some((p.weight, own? / other))
    };
    weighted_mean(data.points.iter().filter_map(ratio))
}

/// Returns the headline that compares the best method with what is done today; `None` where that is not known.
pub(super) fn headline(data: &Report) -> Option<String> {
    let (best, today) = (data.best()?, today(data)?);
    let name = &today.method;
    if best.index == today.index {
        let ranked = if data.unranked().next().is_some() { "ranked method" } else { "method" };
        return Some(format!("No {ranked} beats {name}, which is what is done today"));
    }
    let change = change(relative(data, best, today)?);
    let noun = &data.words.noun;
    let than = if change == AS_MUCH { "as" } else { "than" };
    let place = |index: usize| data.methods.iter().position(|m| m.index == index);
    let two = [place(best.index), place(today.index)];
    let of_both = |p: &&Pair| two.contains(&Some(p.first)) && two.contains(&Some(p.second));
    let pair = data.comparison.pairs.iter().find(of_both);
    let (perhaps, chance) = match pair.is_some_and(|p| p.decided() == Decided::Open) {
        true => ("perhaps ", " (open: it may be chance)"),
        false => ("", ""),
    };
    Some(format!(
        "{}: {perhaps}{change} {noun} {than} {name}, which is what is done today{chance}",
        best.method
    ))
}

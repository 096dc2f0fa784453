//! Says which few point MDPs decide who is first.

use super::format;
use super::whole::Report;
use super::words::Words;

/// Most point MDPs that are named.
const NAMED: usize = 3;

/// Says without which few point MDPs another method would be first, where the lead is more than chance explains; of one
/// that may be chance the interval says enough.
pub(super) fn sentence(data: &Report) -> Option<String> {
    data.lead.as_ref().filter(|lead| lead.interval.0 > 0.0)?;
    let found = data.decisive_points()?;
    let is_there = |p: usize| found.points.contains(&p);
    let extent = data.extent(|p| is_there(p.index));
    let Words { instance, .. } = &data.words;
    let much = extent.in_words(instance, format::percent);
    let called = |p: &usize| data.called(&data.points[*p].row.point);
    let names: Vec<String> = found.points.iter().take(NAMED).map(called).collect();
    let names = match found.points.len() - names.len() {
        0 => names.join(", "),
        others => format!("{} and {others} more", names.join(", ")),
    };
    let (decisive_points, without) = match found.points.len() {
        1 => ("one point MDP".to_owned(), "it"),
        n => (format!("{n} of {} point MDPs", data.points.len()), "them"),
    };
    let value = |x: f64| match data.reference.is_none() {
        true => data.words.value(x),
        false => format::score(x),
    };
    let best = &data.best()?.method;
    let other = &data.methods[found.method].method;
    let (ahead, behind) = (value(found.without.0), value(found.without.1));
    let figures = match ahead == behind {
        true => String::new(),
        false => format!(", with {ahead} against {behind}"),
    };
    Some(format!(
        "The first place of {best} depends on {decisive_points}, {names} ({much}): without {without}, {other} would be \
         first{figures}."
    ))
}

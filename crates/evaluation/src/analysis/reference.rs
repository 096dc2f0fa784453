//! What scores are divided by: the run's baseline, or with `--against` another of its methods; nothing where a
//! run has no baseline.

use std::collections::HashSet;

use crate::store::manifest::{Identity, Task};
use crate::store::record::{Outcome, Record};
use crate::store::results::Results;
use basics::suggest::did_you_mean;

/// Point MDPs that a refusal names.
const NAMED_POINTS: usize = 3;

/// Suffixes that are units, with how people write them.
const UNITS: [(&str, &str); 7] = [
    ("s", "s"),
    ("m", "m"),
    ("veh", "vehicles"),
    ("vph", "vehicles per hour"),
    ("mph", "mph"),
    ("kmh", "km/h"),
    ("rad", "rad"),
];

/// Why results cannot be analysed as asked, with the way out.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct AnalysisError(pub(super) String);

/// Most names that a message lists.
const LISTED: usize = 12;

/// What scores are divided by.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reference {
    /// Name of the method; empty where the objective itself is the score.
    pub name: String,
    /// Its position in the manifest's list of methods.
    pub index: Option<usize>,
    /// Whether it is the run's baseline.
    pub is_baseline: bool,
}

impl Reference {
    /// Returns the run's baseline, if it has one.
    pub fn baseline(identity: &Identity) -> Self {
        let index = identity.methods.iter().position(|m| *m == identity.baseline);
        Self { name: identity.baseline.clone(), index, is_baseline: true }
    }

    /// Whether there is none, so that the objective itself is the score.
    pub fn is_none(&self) -> bool {
        self.name.is_empty()
    }

    /// Returns another method of the run, or its baseline if that is the name.
    ///
    /// # Errors
    ///
    /// [`AnalysisError`] for a method that is not in the run, and for one without a result on some of the chosen point MDPs:
    /// the scores of others would be over whatever it finished, which is no comparison.
    pub fn against(results: &Results, name: &str) -> Result<Self, AnalysisError> {
        let identity = &results.manifest.identity;
        if name == identity.baseline && !name.is_empty() {
            return Ok(Self::baseline(identity));
        }
        let index = position("method", name, identity.methods.iter().map(String::as_str))?;
        let missing = without_result(results, name);
        if !missing.is_empty() {
            let some = missing[..missing.len().min(NAMED_POINTS)].join(", ");
            return Err(AnalysisError(format!(
                "no scores against `{name}`: it has no {} above 0 on {} of {} point MDPs (such as {some}); finish the run, or \
                 leave --against out",
                noun(&identity.objective),
                missing.len(),
                identity.points.len()
            )));
        }
        Ok(Self { name: name.to_owned(), index: Some(index), is_baseline: false })
    }
}

/// Checks that scores can be divided by a method of this name.
///
/// # Errors
///
/// [`AnalysisError`] with the names that there are.
pub fn check_name(name: &str, methods: &[String]) -> Result<(), AnalysisError> {
    position("method", name, methods.iter().map(String::as_str)).map(drop)
}

fn without_result<'a>(results: &'a Results, method: &str) -> Vec<&'a str> {
    let identity = &results.manifest.identity;
    let measured = |(task, record): &(&Task, &Record)| {
        let objective = record.summary.metrics.get(&identity.objective);
        (&*task.method, record.summary.outcome) == (method, Outcome::Ok)
            && objective.is_some_and(|v| *v > 0.0)
    };
    let measured: HashSet<&str> =
        results.done().filter(measured).map(|(task, _)| &*task.point).collect();
    let points = identity.points.iter().map(|p| p.point.as_str());
    points.filter(|point| !measured.contains(point)).collect()
}

/// Returns what a metric is called in a sentence: its name as words, without the unit.
pub fn noun(metric: &str) -> String {
    let stem = split(metric).map_or(metric, |(stem, _)| stem);
    stem.replace('_', " ")
}

/// Returns the unit of a metric; empty where its name has none.
pub fn unit(metric: &str) -> &'static str {
    split(metric).map_or("", |(_, unit)| unit)
}

fn split(metric: &str) -> Option<(&str, &'static str)> {
    let (stem, suffix) = metric.rsplit_once('_')?;
    UNITS.iter().find(|(name, _)| *name == suffix).map(|(_, unit)| (stem, *unit))
}

pub(super) fn position<'a>(
    what: &str,
    name: &str,
    all: impl Iterator<Item = &'a str> + Clone,
) -> Result<usize, AnalysisError> {
    all.clone().position(|other| other == name).ok_or_else(|| {
        let meant = did_you_mean(name, all.clone());
        let there: Vec<&str> = all.clone().take(LISTED).collect();
        let more = all.count() - there.len();
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let there = there.join(", ");
        AnalysisError(format!(
            "there is no {what} `{name}` in the results{meant}; there are: {there}{more}"
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_of_a_metric_is_its_suffix() {
        assert_eq!((noun("delay_s"), unit("delay_s")), ("delay".to_owned(), "s"));
        assert_eq!((noun("queue_veh"), unit("queue_veh")), ("queue".to_owned(), "vehicles"));
        assert_eq!((noun("score"), unit("score")), ("score".to_owned(), ""));
        assert_eq!((noun("episode_return"), unit("episode_return")), ("episode return".into(), ""));
    }
}

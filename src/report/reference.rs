//! What scores are divided by: the run's baseline, or with `--against` another of its methods.

use super::ReportError;
use super::format::count;
use crate::store::manifest::Identity;
use crate::store::record::Outcome;
use crate::store::results::Results;

/// Point MDPs that a refusal names.
const NAMED_POINTS: usize = 3;

/// What scores are divided by.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reference {
    /// Name of the method.
    pub name: String,
    /// Its position in the manifest's list of methods.
    pub index: Option<usize>,
    /// Whether it is the run's baseline.
    pub is_baseline: bool,
}

impl Reference {
    /// Returns the run's baseline.
    pub fn baseline(identity: &Identity) -> Self {
        let index = identity.methods.iter().position(|m| *m == identity.baseline);
        Self { name: identity.baseline.clone(), index, is_baseline: true }
    }

    /// Returns another method of the run, or its baseline if that is the name.
    ///
    /// # Errors
    ///
    /// [`ReportError::NotInRun`] for a method that is not in the run, [`ReportError::Incomplete`] for
    /// one without a result on some of the chosen point MDPs: the scores of others would be over
    /// whatever it finished, which is no comparison.
    pub fn against(results: &Results, name: &str) -> Result<Self, ReportError> {
        let identity = &results.manifest.identity;
        if name == identity.baseline {
            return Ok(Self::baseline(identity));
        }
        check_name(name, &identity.methods)?;
        let missing = without_result(results, name);
        if !missing.is_empty() {
            let mut some = missing[..missing.len().min(NAMED_POINTS)].join(", ");
            if missing.len() > NAMED_POINTS {
                some.push_str(", ...");
            }
            let points = identity.points.len();
            return Err(ReportError::Incomplete {
                method: name.to_owned(),
                missing: missing.len(),
                points: count(points, "point MDP"),
                some,
            });
        }
        let index = identity.methods.iter().position(|m| m == name);
        Ok(Self { name: name.to_owned(), index, is_baseline: false })
    }

    /// Returns it in a sentence: `the baseline NAME`, or `NAME`.
    pub(super) fn in_full(&self) -> String {
        if self.is_baseline { baseline_in_full(&self.name) } else { self.name.clone() }
    }

    /// Returns it in a sentence, short: `the baseline`, or `NAME`.
    pub(super) fn in_short(&self) -> &str {
        if self.is_baseline { "the baseline" } else { &self.name }
    }

    /// Returns it in a label: `baseline`, or `NAME`.
    pub(super) fn as_label(&self) -> &str {
        if self.is_baseline { "baseline" } else { &self.name }
    }

    /// Returns its name in a table, marked as what the others are divided by.
    pub(super) fn marked(&self) -> String {
        match self.is_baseline {
            true if self.name == "baseline" => self.name.clone(),
            true => format!("{} (baseline)", self.name),
            false => format!("{} (divisor)", self.name),
        }
    }
}

/// Returns a baseline in a sentence: `the baseline NAME`, without a name that says just that.
pub(super) fn baseline_in_full(name: &str) -> String {
    if name == "baseline" { "the baseline".to_owned() } else { format!("the baseline {name}") }
}

/// Checks that scores can be divided by a method of this name.
///
/// # Errors
///
/// [`ReportError::NotInRun`].
pub fn check_name(name: &str, methods: &[String]) -> Result<(), ReportError> {
    match methods.iter().any(|m| m == name) {
        true => Ok(()),
        false => {
            Err(ReportError::NotInRun { method: name.to_owned(), methods: methods.join(", ") })
        }
    }
}

/// Returns the chosen point MDPs where the method has no record with an objective above 0.
fn without_result<'a>(results: &'a Results, method: &str) -> Vec<&'a str> {
    let identity = &results.manifest.identity;
    let measured = |point: &str| {
        results.records.values().any(|r| {
            let s = &r.summary;
            let objective = s.metrics.get(&identity.objective);
            (s.method.as_str(), s.point.as_str(), s.outcome) == (method, point, Outcome::Ok)
                && objective.is_some_and(|v| *v > 0.0)
        })
    };
    let points = identity.points.iter().map(|p| p.point.as_str());
    points.filter(|point| !measured(point)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reference(name: &str, is_baseline: bool) -> Reference {
        Reference { name: name.into(), index: Some(0), is_baseline }
    }

    #[test]
    fn the_baseline_is_called_so_and_another_method_is_not() {
        let baseline = reference("untuned", true);
        assert_eq!(baseline.in_full(), "the baseline untuned");
        assert_eq!(baseline.in_short(), "the baseline");
        assert_eq!(reference("baseline", true).in_full(), "the baseline");
        assert_eq!(reference("fixed-time", false).in_full(), "fixed-time");
        assert_eq!(reference("fixed-time", false).as_label(), "fixed-time");
    }

    #[test]
    fn a_table_does_not_say_baseline_twice() {
        assert_eq!(reference("baseline", true).marked(), "baseline");
        assert_eq!(reference("untuned", true).marked(), "untuned (baseline)");
        assert_eq!(reference("fixed-time", false).marked(), "fixed-time (divisor)");
    }

    #[test]
    fn a_method_that_is_not_in_the_run_is_refused_with_those_that_are() {
        let methods = ["baseline".to_owned(), "actuated".to_owned()];
        assert!(check_name("actuated", &methods).is_ok());
        assert_eq!(
            check_name("fixed-time", &methods).unwrap_err().to_string(),
            "no scores against `fixed-time`, which is not in the run; its methods are baseline, actuated"
        );
    }
}

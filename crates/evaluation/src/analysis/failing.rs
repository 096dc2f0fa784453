//! Where methods fail: on point MDPs on which a metric is beyond a limit.

use super::board::position;
use super::error::AnalysisError;
use super::points::PointSummary;
use super::whole::Analysis;
use crate::stats::Limit;

impl Analysis {
    /// Sets what a failure is.
    ///
    /// # Errors
    ///
    /// [`AnalysisError`] for a metric that no record has.
    pub fn fail_beyond(&mut self, limit: Limit) -> Result<(), AnalysisError> {
        self.check_metric(&limit.metric)?;
        self.failure = Some(limit);
        Ok(())
    }

    /// Whether a method fails on a point MDP, by the mean over evaluation seeds and replicates; `None` where that is
    /// not known.
    pub fn fails(&self, point: &PointSummary, method: usize) -> Option<bool> {
        is_beyond(self.failure.as_ref()?, point, method)
    }

    /// Checks that records have a metric.
    fn check_metric(&self, name: &str) -> Result<(), AnalysisError> {
        let mut names = self.metrics();
        names.insert(0, self.manifest.identity.objective.clone());
        position("metric", name, names.iter().map(String::as_str)).map(|_| ())
    }
}

/// Whether a metric of a method is beyond a limit on a point MDP; `None` where that is not known.
pub(super) fn is_beyond(limit: &Limit, point: &PointSummary, method: usize) -> Option<bool> {
    let result = point.results[method].as_ref()?;
    result.metrics.get(&limit.metric).map(|value| limit.is_beyond(*value))
}

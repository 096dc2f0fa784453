//! What a report says: the analysis, and what traffic adds to it.

use std::ops::Deref;

use super::plans::{TaskPlan, plans};
use crate::analysis::{Analysis, AnalysisError, Reference};
use crate::store::places::Places;
use crate::store::results::Results;
use crate::traffic::report::{Overloaded, TrafficMeasures, overloaded};

/// Everything that a report says.
#[derive(Debug, Clone, PartialEq)]
pub struct ReportData {
    /// What records say.
    pub analysis: Analysis,
    /// The part of the family that the baseline leaves at level of service F.
    pub overloaded: Option<Overloaded>,
    /// What every finished task ran, in the order of the plan.
    pub plans: Vec<TaskPlan>,
    /// Where the intersections are.
    pub places: Places,
}

impl Deref for ReportData {
    type Target = Analysis;

    fn deref(&self) -> &Analysis {
        &self.analysis
    }
}

impl ReportData {
    /// Computes everything that a report says, with scores relative to the run's baseline.
    pub fn new(results: &Results) -> Self {
        Self::of(results, Analysis::new(results, &TrafficMeasures))
    }

    /// Computes everything that a report says, with scores relative to another method.
    ///
    /// # Errors
    ///
    /// Those of [`Analysis::against`].
    pub fn against(results: &Results, method: &str) -> Result<Self, AnalysisError> {
        Ok(Self::of(results, Analysis::against(results, method, &TrafficMeasures)?))
    }

    fn of(results: &Results, analysis: Analysis) -> Self {
        let baseline = Reference::baseline(&analysis.manifest.identity).index;
        Self {
            overloaded: baseline.and_then(|baseline| overloaded(&analysis.points, baseline)),
            plans: plans(results, &analysis.tasks),
            places: results.places.clone(),
            analysis,
        }
    }
}

//! What a report says: the analysis, and what traffic adds to it.

use std::ops::Deref;

use super::palette::Looks;
use super::plans::{TaskPlan, plans};
use crate::analysis::{Analysis, AnalysisError, Reference};
use crate::run::method::Method;
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
    /// What methods look like.
    pub(super) looks: Looks,
}

impl Deref for ReportData {
    type Target = Analysis;

    fn deref(&self) -> &Analysis {
        &self.analysis
    }
}

impl ReportData {
    /// Computes everything that a report says, with scores relative to the run's baseline.
    ///
    /// # Arguments
    ///
    /// * `methods` — those of the domain, in whose colours the methods of the run are drawn.
    pub fn new(results: &Results, methods: &[Method]) -> Self {
        Self::of(results, methods, Analysis::new(results, &TrafficMeasures))
    }

    /// Computes everything that a report says, with scores relative to another method, `divisor`.
    ///
    /// # Errors
    ///
    /// Those of [`Analysis::against`].
    pub fn against(
        results: &Results,
        methods: &[Method],
        divisor: &str,
    ) -> Result<Self, AnalysisError> {
        let analysis = Analysis::against(results, divisor, &TrafficMeasures)?;
        Ok(Self::of(results, methods, analysis))
    }

    fn of(results: &Results, methods: &[Method], analysis: Analysis) -> Self {
        let baseline = Reference::baseline(&analysis.manifest.identity).index;
        Self {
            overloaded: baseline.and_then(|baseline| overloaded(&analysis.points, baseline)),
            plans: plans(results, &analysis.tasks),
            places: results.places.clone(),
            looks: Looks::of(methods),
            analysis,
        }
    }
}

//! A sample as a file that others can reuse: which point MDPs, with which weights, over what they were spread.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{Design, SamplePlan, Sampling};
use crate::family::MdpFamily;
use crate::sample::quadrature::Quadrature;
use basics::files::numbers;

/// Version of the file; a change of its form raises it.
const VERSION: u32 = 1;

/// How far the importance of a point MDP in a plan may be from the family's.
const TOLERANCE: f64 = 1e-6;

/// A sample as a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanFile {
    /// Version of the file.
    pub tsc_family_plan: u32,
    /// Name of the scenario.
    pub scenario: String,
    /// The choice.
    pub sample: SamplePlan,
    /// What a sample was spread over.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub design: Option<Design>,
    /// What is kept of the settings of the run whose scores assist it; left out where no run does, and in files from
    /// before it was kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub assisting: Option<Value>,
    /// What to expect of it, by method that stands in for those to come; empty where that is not known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub expected: Vec<Expected>,
}

/// What samples like this one missed on a method that is known everywhere.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expected {
    /// The method.
    pub method: String,
    /// Root-mean-square error of its estimates.
    pub rmse: f64,
    /// Mean half-width of their 95% intervals.
    pub half_width: Option<f64>,
    /// Share of the intervals that hold its overall performance.
    pub coverage: Option<f64>,
}

/// Why a plan cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// No plan.
    #[error("it is no plan that `tsc-family plan` wrote: {0}")]
    Malformed(String),
    /// A file of another version.
    #[error(
        "its version is {found}, this program reads {VERSION}; write it anew with `tsc-family plan`"
    )]
    Version {
        /// The version of the file.
        found: u32,
    },
    /// A plan of another family.
    #[error(
        "it is for another family than {scenario}: {what}; give the scenario and settings it was made for"
    )]
    OtherFamily {
        /// Name of the scenario.
        scenario: String,
        /// What differs.
        what: String,
    },
    /// A plan that was edited.
    #[error("it was altered: {0}; write it anew with `tsc-family plan`")]
    Altered(String),
}

impl PlanFile {
    /// Returns the plan of a sample.
    pub fn new(scenario: &str, sample: SamplePlan, design: Option<Design>) -> Self {
        let scenario = scenario.to_owned();
        let (assisting, expected) = (None, Vec::new());
        Self { tsc_family_plan: VERSION, scenario, sample, design, assisting, expected }
    }

    /// Reads a plan.
    ///
    /// # Errors
    ///
    /// [`PlanError::Malformed`], [`PlanError::Version`].
    pub fn parse(text: &str) -> Result<Self, PlanError> {
        let malformed = |e: serde_json::Error| PlanError::Malformed(e.to_string());
        let value: Value = serde_json::from_str(text).map_err(malformed)?;
        match value["tsc_family_plan"].as_u64() {
            Some(version) if version == u64::from(VERSION) => {}
            Some(found) => {
                let found = u32::try_from(found).unwrap_or(u32::MAX);
                return Err(PlanError::Version { found });
            }
            None => return Err(PlanError::Malformed("it has no `tsc_family_plan`".to_owned())),
        }
        numbers::check(&value).map_err(PlanError::Altered)?;
        serde_json::from_value(value).map_err(malformed)
    }

    /// Returns the bytes of the file.
    pub fn to_json(&self) -> Vec<u8> {
        let mut json = serde_json::to_vec_pretty(self).expect("a plan is plain data");
        json.push(b'\n');
        json
    }

    /// Checks that the plan is one for a family, as it was written.
    ///
    /// # Errors
    ///
    /// [`PlanError::OtherFamily`], [`PlanError::Altered`].
    pub fn check(&self, family: &MdpFamily) -> Result<(), PlanError> {
        let other =
            |what: String| Err(PlanError::OtherFamily { scenario: family.name.clone(), what });
        let altered = |what: String| Err(PlanError::Altered(what));
        let (own, size) = (self.sample.family_size, family.points.len());
        if own != size {
            return other(format!("its family has {own} point MDPs, this one {size}"));
        }
        if self.sample.growth.is_some() {
            return altered("whether it grows is said when it is run".to_owned());
        }
        if !has_its_size(&self.sample, family) {
            let (budget, sampling) = (self.sample.budget, self.sample.sampling.name());
            return altered(format!(
                "its draws are not those of a {sampling} sample with a budget of {budget}"
            ));
        }
        let mut total = 0.0;
        for draw in &self.sample.draws {
            if family.position(&draw.point).is_none() {
                return other(format!("this one has no point MDP {}", draw.point));
            }
            if u64::from(draw.count) > size as u64 {
                return altered(format!("{} was drawn {} times", draw.point, draw.count));
            }
            // K-means represents what has no importance with no weight.
            let weighs = draw.weight.is_finite() && draw.weight >= 0.0;
            if !weighs || draw.inclusion.is_some_and(|pi| !(pi > 0.0 && pi <= 1.0)) {
                return altered(format!(
                    "the weight or probability of {} is not a valid number",
                    draw.point
                ));
            }
            total += draw.weight;
        }
        let mut points: Vec<&str> = self.sample.draws.iter().map(|d| d.point.as_str()).collect();
        points.sort_unstable();
        let draws = points.len();
        points.dedup();
        if draws == 0 || points.len() < draws || (total - 1.0).abs() > TOLERANCE {
            return altered(
                "its draws are not distinct point MDPs whose weights sum to 1".to_owned(),
            );
        }
        match (&self.design, self.sample.sampling.has_design()) {
            (Some(design), true) => check_design(self, design, family),
            (None, false) if self.sample.design.is_empty() => Ok(()),
            _ => altered(
                "a design belongs to a balanced sample or one by Bayesian quadrature, and to no other"
                    .to_owned(),
            ),
        }
    }
}

/// Whether a sample has the numbers of draws that its sampling makes of its budget.
fn has_its_size(sample: &SamplePlan, family: &MdpFamily) -> bool {
    let (draws, budget) = (sample.draws.len(), sample.budget);
    let counted: u64 = sample.draws.iter().map(|d| u64::from(d.count)).sum();
    let is_once = counted == draws as u64;
    // A point MDP without importance is never drawn at random.
    let possible = || family.points.iter().filter(|p| p.importance > 0.0).count();
    match sample.sampling {
        Sampling::All => is_once && draws == budget && budget == sample.family_size,
        Sampling::BayesianQuadrature => is_once && draws == budget,
        Sampling::Balanced | Sampling::WithoutReplacement => {
            is_once && draws == budget.min(possible())
        }
        Sampling::KMeans => draws == budget && counted == sample.family_size as u64,
        Sampling::WithReplacement => counted == budget as u64,
    }
}

fn check_design(plan: &PlanFile, design: &Design, family: &MdpFamily) -> Result<(), PlanError> {
    if design.sha256() != plan.sample.design {
        return Err(PlanError::Altered(
            "its design is not the one the sample was drawn over".into(),
        ));
    }
    let is_by_quadrature = plan.sample.sampling == Sampling::BayesianQuadrature;
    if is_by_quadrature && Quadrature::of(design).is_none() {
        return Err(PlanError::Altered("its process is not that of its design".into()));
    }
    // Only samples by Bayesian quadrature rest on a process.
    if !is_by_quadrature && design.process.is_some() {
        return Err(PlanError::Altered("its sampling is not that of its design".into()));
    }
    if design.points.len() != family.points.len() {
        return Err(PlanError::Altered("its design lacks point MDPs of its family".into()));
    }
    for (own, point) in design.points.iter().zip(&family.points) {
        if own.point != point.id || (own.importance - point.importance).abs() > TOLERANCE {
            let what = format!(
                "{} with importance {:.6} there, {} with {:.6} here",
                own.point, own.importance, point.id, point.importance
            );
            return Err(PlanError::OtherFamily { scenario: family.name.clone(), what });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::family::testing::{city, other_city, pair};
    use crate::sample::choose;

    fn plan() -> (MdpFamily, PlanFile) {
        let family = city();
        let sample = choose(&family, Sampling::Balanced, 12, 1).unwrap();
        let design = Design::of(&family);
        let plan = PlanFile::new(&family.name, sample, Some(design));
        (family, plan)
    }

    #[test]
    fn a_plan_is_read_as_it_was_written_and_fits_its_family() {
        let (family, plan) = plan();
        let read = PlanFile::parse(&String::from_utf8(plan.to_json()).unwrap()).unwrap();
        assert_eq!(read, plan);
        assert_eq!(read.check(&family), Ok(()));
    }

    #[test]
    fn a_plan_of_another_family_is_refused() {
        let (_, plan) = plan();
        let other = pair();
        let e = plan.check(&other).unwrap_err().to_string();
        assert!(e.contains("its family has 164 point MDPs, this one 2"), "{e}");
        let peak = other_city();
        assert!(matches!(plan.check(&peak), Err(PlanError::OtherFamily { .. })));
    }

    #[test]
    fn an_altered_plan_is_refused() {
        let (family, plan) = plan();
        let refused = |alter: &dyn Fn(&mut PlanFile)| {
            let mut plan = plan.clone();
            alter(&mut plan);
            assert!(matches!(plan.check(&family), Err(PlanError::Altered(_))));
        };
        refused(&|p| p.sample.draws[0].weight = 0.9);
        refused(&|p| p.sample.draws[0].weight = f64::NAN);
        refused(&|p| p.sample.draws[0].weight *= -1.0);
        refused(&|p| p.sample.draws[0].inclusion = Some(2.0));
        refused(&|p| p.sample.draws[0] = p.sample.draws[1].clone());
        refused(&|p| p.sample.draws.clear());
        refused(&|p| p.sample.budget = 5);
        refused(&|p| p.sample.draws[0].count = 2);
        refused(&|p| p.design = None);
        refused(&|p| p.design.as_mut().unwrap().points[3].describing[0] = 9.0);
    }

    #[test]
    fn every_sampling_fits_its_own_name_and_no_other() {
        let family = city();
        let all = [
            Sampling::Balanced,
            Sampling::BayesianQuadrature,
            Sampling::KMeans,
            Sampling::WithReplacement,
            Sampling::WithoutReplacement,
        ];
        for (sampling, budget) in all.into_iter().flat_map(|s| [(s, 12), (s, 1), (s, 164)]) {
            let sample = choose(&family, sampling, budget, 1).unwrap();
            let design = sampling.has_design().then(|| Design::of(&family).for_sampling(sampling));
            let plan = PlanFile::new(&family.name, sample, design);
            assert_eq!(plan.check(&family), Ok(()), "{} of {budget}", sampling.name());
            for other in all.into_iter().filter(|o| o.has_design() && *o != sampling) {
                let mut altered = plan.clone();
                altered.sample.sampling = other;
                let e = altered.check(&family);
                assert!(matches!(e, Err(PlanError::Altered(_))), "{e:?}");
            }
        }
    }

    #[test]
    fn what_is_no_plan_is_refused() {
        assert!(matches!(PlanFile::parse("{"), Err(PlanError::Malformed(_))));
        assert!(matches!(PlanFile::parse("{}"), Err(PlanError::Malformed(_))));
        let e = PlanFile::parse("{\"tsc_family_plan\": 7}").unwrap_err().to_string();
        assert!(e.contains("its version is 7, this program reads 1"), "{e}");
    }
}

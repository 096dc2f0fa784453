//! A family that was evaluated as a whole, as samples of it are drawn from.

use std::collections::HashMap;

use crate::analysis::{Analysis, PointSummary};
use crate::family::{FamilyError, Feature, MdpFamily, PointMdp};
use crate::sample::SampleError;
use crate::sample::design::{Design, Input, Measure};
use crate::stats::{Direction, PointObjectives, StatsError};

/// How far the importance of the same point MDP may differ.
const TOLERANCE: f64 = 1e-9;

/// A method on every point MDP of a family.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedMethod {
    /// Its name.
    pub name: String,
    /// Whether it learns, so that it is too expensive to run everywhere.
    pub learns: bool,
    /// What was measured, in the order of the family.
    pub objectives: Vec<PointObjectives>,
    /// Its scores, in the order of the family.
    pub scores: Vec<f64>,
    /// Time that its tasks took, seconds, in the order of the family; `None` where that is not known.
    pub cost_s: Vec<Option<f64>>,
}

/// A family with what methods achieved on every point MDP.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// The family.
    pub family: MdpFamily,
    /// Whether lower scores are better.
    pub direction: Direction,
    /// The methods but the one that scores are divided by; those with a score on every point MDP.
    pub methods: Vec<RecordedMethod>,
    /// Methods that lack scores, and on how many point MDPs.
    pub lacking: Vec<(String, usize)>,
    /// What is known everywhere: objective of the baseline and scores of the methods that do not learn.
    pub inputs: Vec<(Input, Vec<f64>)>,
}

/// Why estimators cannot be studied on results.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// Results that do not say what is needed, with the way out.
    #[error("{0}")]
    Results(String),
    /// No family can be made of the point MDPs.
    #[error(transparent)]
    Family(#[from] FamilyError),
    /// A budget that the family does not allow.
    #[error(transparent)]
    Sample(#[from] SampleError),
    /// A score that is none.
    #[error(transparent)]
    Stats(#[from] StatsError),
}

fn refused<T>(reason: String) -> Result<T, StudyError> {
    Err(StudyError::Results(reason))
}

/// Seconds that tasks took, by method and point MDP; `None` where that is not known.
type Costs<'a> = HashMap<(&'a str, &'a str), Option<f64>>;

impl Recorded {
    /// Returns what an analysis of a whole family says.
    ///
    /// # Arguments
    ///
    /// * `dir` — the results directory, for errors.
    ///
    /// # Errors
    ///
    /// [`StudyError`] for results on a sample, and when no method is complete.
    pub fn of(analysis: &Analysis, dir: &str) -> Result<Self, StudyError> {
        let identity = &analysis.manifest.identity;
        let (chosen, size) = (identity.points.len(), identity.sample.family_size);
        if chosen != size {
            return refused(format!(
                "{dir} has {chosen} of the {size} point MDPs of {}: what estimators miss is only known where all were \
                 evaluated; run it with --budget all",
                identity.scenario
            ));
        }
        let features = identity.features.iter();
        let features = features.map(|f| Feature { name: f.name.clone(), unit: f.unit.clone() });
        let total: f64 = identity.points.iter().map(|p| p.importance).sum();
        let point = |p: &crate::store::manifest::PointRow| PointMdp {
            id: p.point.clone(),
            title: p.name().to_owned(),
            features: p.features.clone(),
            importance: p.importance / total,
            instances: p.instances,
        };
        let points = identity.points.iter().map(point).collect();
        let family = MdpFamily::new(&identity.scenario, features.collect(), points, dir)?;
        let mut recorded = Self {
            family,
            direction: identity.direction,
            methods: Vec::new(),
            lacking: Vec::new(),
            inputs: Vec::new(),
        };
        let rows = analysis.points.iter().map(|p| (p.row.point.as_str(), p)).collect();
        let mut costs = Costs::new();
        for task in &analysis.tasks {
            let point = analysis.points[task.point].row.point.as_str();
            let cost =
                costs.entry((identity.methods[task.method].as_str(), point)).or_insert(Some(0.0));
            *cost = cost.zip(task.wall_s).map(|(sum, wall_s)| sum + wall_s);
        }
        for (index, name) in identity.methods.iter().enumerate() {
            recorded.add(analysis, (&rows, &costs), index, name);
        }
        if recorded.methods.is_empty() {
            let lacking = recorded.lacking.iter().map(|(m, n)| format!("{m} lacks {n}"));
            let lacking = lacking.collect::<Vec<_>>().join(", ");
            return refused(format!(
                "{dir}: no method has a score on all {size} point MDPs ({lacking}); finish the run first"
            ));
        }
        Ok(recorded)
    }

    /// Adds a method.
    fn add(
        &mut self,
        analysis: &Analysis,
        (rows, costs): (&HashMap<&str, &PointSummary>, &Costs<'_>),
        index: usize,
        name: &str,
    ) {
        let results: Vec<_> = (self.family.points.iter())
            .map(|p| rows.get(p.id.as_str()).and_then(|row| row.results[index].as_ref()))
            .collect();
        if Some(index) == analysis.reference.index {
            let objective: Option<Vec<f64>> =
                results.iter().map(|r| r.map(|r| r.objective)).collect();
            let input = Input { method: name.to_owned(), measure: Measure::Objective };
            self.inputs.extend(objective.map(|values| (input, values)));
            return;
        }
        let scored: Vec<Option<(f64, PointObjectives)>> = results
            .iter()
            .map(|r| r.and_then(|r| Some((r.score?, r.objectives.clone()?))))
            .collect();
        let missing = scored.iter().filter(|s| s.is_none()).count();
        if missing > 0 {
            self.lacking.push((name.to_owned(), missing));
            return;
        }
        let (scores, objectives): (Vec<f64>, Vec<PointObjectives>) =
            scored.into_iter().flatten().unzip();
        let learns = analysis.trainings.iter().any(|t| t.method == name);
        if !learns {
            let input = Input { method: name.to_owned(), measure: Measure::Score };
            self.inputs.push((input, scores.clone()));
        }
        let cost = |id: &str| costs.get(&(name, id)).copied().unwrap_or(Some(0.0));
        let cost_s = self.family.points.iter().map(|p| cost(&p.id)).collect();
        let name = name.to_owned();
        self.methods.push(RecordedMethod { name, learns, objectives, scores, cost_s });
    }

    /// Takes the inputs of other results on the same family, instead of its own.
    ///
    /// # Errors
    ///
    /// [`StudyError`] when point MDPs or their importance differ.
    pub fn assisted_by(&mut self, other: &Self, dir: &str, than: &str) -> Result<(), StudyError> {
        let ours = self.family.points.iter().map(|p| (p.id.as_str(), p.importance));
        other.check_points(ours, (dir, than))?;
        self.inputs = other.inputs.clone();
        Ok(())
    }

    /// Adds the inputs to what is known of a family.
    ///
    /// # Arguments
    ///
    /// * `dir` — the results directory, for errors.
    ///
    /// # Errors
    ///
    /// [`StudyError`] when point MDPs or their importance differ, and when no method without learning was run everywhere.
    pub fn add_to(&self, design: &mut Design, dir: &str) -> Result<(), StudyError> {
        let points = design.points.iter().map(|p| (p.point.as_str(), p.importance));
        self.check_points(points, (dir, "the scenario"))?;
        if self.inputs.iter().all(|(input, _)| input.measure == Measure::Objective) {
            return refused(format!(
                "{dir} has no method without learning on all point MDPs; run some, or leave --assist out"
            ));
        }
        self.inputs.iter().for_each(|(input, values)| design.add_input(input, values));
        Ok(())
    }

    /// Checks that others are the point MDPs of this family.
    fn check_points<'a>(
        &self,
        others: impl ExactSizeIterator<Item = (&'a str, f64)>,
        (dir, than): (&str, &str),
    ) -> Result<(), StudyError> {
        let own = self.family.points.iter();
        let same = |(point, (id, importance)): (&PointMdp, (&str, f64))| {
            point.id == id && (point.importance - importance).abs() <= TOLERANCE
        };
        if own.len() == others.len() && own.zip(others).all(same) {
            return Ok(());
        }
        refused(format!(
            "{dir} has another family than {than}: other point MDPs, or another importance; give results of the same scenario"
        ))
    }

    /// Returns the overall performance of a method.
    pub fn truth(&self, method: &RecordedMethod) -> f64 {
        self.family.points.iter().zip(&method.scores).map(|(p, s)| p.importance * s).sum()
    }

    /// Returns what is known everywhere when methods are to be estimated: all inputs but their own.
    pub fn design_for(&self, methods: &[&str]) -> Design {
        let mut design = Design::of(&self.family);
        let others =
            self.inputs.iter().filter(|(input, _)| !methods.contains(&input.method.as_str()));
        others.for_each(|(input, values)| design.add_input(input, values));
        design
    }
}

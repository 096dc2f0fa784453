//! All that records say, put together.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use super::choice::choice;
use super::comparison::{Comparison, compare};
use super::episodes::episodes;
use super::error::AnalysisError;
use super::estimator::{Estimator, estimator_of};
use super::evidence::Evidence;
use super::measures::{Measures, Regime, Share};
use super::method::MethodSummary;
use super::points::{PointResult, PointSummary, TaskScore, summarise_points};
use super::ranking::{OnCommonPoints, on_common_points, rank};
use super::reference::Reference;
use super::training::{LearnerSummary, TrainingSummary, learned, learner, trained, trainings};
use super::winners::{Winner, winners};
use crate::sample::Design;
use crate::stats::{Direction, Limit};
use crate::store::manifest::Manifest;
use crate::store::record::Outcome;
use crate::store::results::Results;

/// All that records say: one summary per method, one row per task, episode and point MDP.
#[derive(Debug, Clone, PartialEq)]
pub struct Analysis {
    /// What the run was.
    pub manifest: Arc<Manifest>,
    /// Classes of point MDPs.
    pub regimes: &'static [Regime],
    /// What is measured of evaluation episodes.
    pub shares: &'static [Share],
    /// What scores are divided by.
    pub reference: Reference,
    /// One summary per method, best first, methods without an estimate last.
    pub methods: Vec<MethodSummary>,
    /// One row per task, in the order of the plan.
    pub tasks: Vec<TaskScore>,
    /// The chosen point MDPs, in the order of the family.
    pub points: Vec<PointSummary>,
    /// How sure the ranking is.
    pub comparison: Comparison,
    /// All methods on the point MDPs that all finished; there when some method is not ranked.
    pub common: Option<OnCommonPoints>,
    /// One entry per task of a learner, in the order of the plan.
    pub trainings: Vec<TrainingSummary>,
    /// The records that all this is of, for what is shown of every episode.
    pub results: Results,
    /// Methods that tune or learn.
    pub trained: BTreeSet<String>,
    /// Those of them that learn.
    pub learned: BTreeSet<String>,
    /// The best method of every point MDP, in the order of [`Self::points`].
    pub winners: Vec<Option<Winner>>,
    /// What a failure is; `None` where the task does not say and nobody did.
    pub failure: Option<Limit>,
    positions: HashMap<String, usize>,
    /// The most that a score can be; infinite where that is not known.
    pub(super) most: f64,
    /// What is known of the whole family; `None` where the run keeps no list of it.
    pub design: Option<Design>,
}

impl Analysis {
    /// Analyses results, with scores relative to the run's baseline.
    pub fn new(results: &Results, measures: &dyn Measures) -> Self {
        let reference = Reference::baseline(&results.manifest.identity);
        Self::relative_to(results, reference, measures)
    }

    /// Analyses results, with scores relative to another method.
    ///
    /// # Errors
    ///
    /// Those of [`Reference::against`].
    pub fn against(
        results: &Results,
        method: &str,
        measures: &dyn Measures,
    ) -> Result<Self, AnalysisError> {
        let reference = Reference::against(results, method)?;
        Ok(Self::relative_to(results, reference, measures))
    }

    fn relative_to(results: &Results, reference: Reference, measures: &dyn Measures) -> Self {
        let (manifest, design) = (results.manifest.clone(), results.design.clone());
        let identity = &manifest.identity;
        let (points, tasks) = summarise_points(results, &reference, measures);
        let episodes = episodes(results, &reference, measures);
        let chosen = choice(identity, design.as_ref(), &points);
        let learned = learned(results);
        let once =
            |method: &String| learned.contains(method) && identity.replicates_of(method) == 1;
        let learned_once: Vec<bool> = identity.methods.iter().map(once).collect();
        // Of scores that are quotients it is not known.
        let most = measures.most(&identity.objective).filter(|_| reference.is_none());
        let most = most.unwrap_or(f64::INFINITY);
        let evidence = Evidence {
            identity,
            most,
            learned_once: &learned_once,
            chosen: &chosen,
            reference: &reference,
            measures,
            points: &points,
            tasks: &tasks,
            episodes: &episodes,
            design: design.as_ref(),
        };
        let trainings = trainings(results, evidence);
        let ids = points.iter().map(|p| p.row.point.clone());
        let positions = ids.enumerate().map(|(i, id)| (id, i)).collect();
        let estimates = rank(evidence);
        let common = on_common_points(evidence, &estimates);
        let comparison = compare(evidence, &estimates);
        let winners = winners(evidence);
        let regimes = measures.regimes(&identity.objective);
        Self {
            regimes,
            shares: measures.shares(),
            winners,
            comparison,
            methods: estimates.into_iter().map(|(summary, _)| summary).collect(),
            common,
            trainings,
            trained: trained(results),
            learned,
            failure: None,
            reference,
            tasks,
            points,
            positions,
            most,
            results: results.clone(),
            manifest,
            design,
        }
    }

    /// Returns the names of the metrics that some task has besides the objective, those of its training among them.
    pub fn metrics(&self) -> Vec<String> {
        self.without_objective(self.tasks.iter().flat_map(|task| task.metrics.keys()))
    }

    /// Returns the names of the metrics that some episode has besides the objective.
    pub fn episode_metrics(&self) -> Vec<String> {
        self.without_objective(self.results.episode_metrics().into_iter())
    }

    fn without_objective<'a>(&self, names: impl Iterator<Item = &'a String>) -> Vec<String> {
        let names: BTreeSet<&String> = names.collect();
        let objective = &self.manifest.identity.objective;
        names.into_iter().filter(|name| *name != objective).cloned().collect()
    }

    /// Returns what the estimates rest on.
    pub fn estimator(&self) -> Estimator {
        estimator_of(&self.manifest.identity.sample)
    }

    /// Returns a summary per learner, in the order of the ranking.
    pub fn learners(&self) -> Vec<LearnerSummary<'_>> {
        let mut learners = Vec::new();
        for method in &self.methods {
            let trainings: Vec<&TrainingSummary> = self.trainings_of(&method.method).collect();
            if !trainings.is_empty() {
                let weighed = (&self.manifest.identity, &self.points[..]);
                learners.push(learner(method, &trainings, weighed, self.direction()));
            }
        }
        learners
    }

    /// Returns the trainings of a method.
    pub fn trainings_of<'a>(
        &'a self,
        method: &'a str,
    ) -> impl Iterator<Item = &'a TrainingSummary> {
        self.trainings.iter().filter(move |t| t.method == method)
    }

    /// Whether less or more of the objective is better.
    pub fn direction(&self) -> Direction {
        self.manifest.identity.direction
    }

    /// Returns the best of the ranked methods.
    pub fn best(&self) -> Option<&MethodSummary> {
        self.methods.first().filter(|m| m.rank.is_some())
    }

    /// Returns the methods with an estimate that lack point MDPs which others have.
    pub fn unranked(&self) -> impl Iterator<Item = &MethodSummary> {
        self.methods.iter().filter(|m| m.overall.is_some() && m.rank.is_none())
    }

    /// Returns the methods of which some point MDP has results of only a part of its replicates.
    pub fn partly_replicated(&self) -> BTreeSet<&str> {
        let done = |row: &&TaskScore| row.outcome == Some(Outcome::Ok);
        let finished: BTreeSet<(usize, usize)> =
            self.tasks.iter().filter(done).map(|r| (r.method, r.point)).collect();
        let partial = |r: &&TaskScore| !done(r) && finished.contains(&(r.method, r.point));
        let name = |r: &TaskScore| self.manifest.identity.methods[r.method].as_str();
        self.tasks.iter().filter(partial).map(name).collect()
    }

    /// Returns the number of tasks without a record.
    pub fn missing(&self) -> usize {
        self.tasks.iter().filter(|r| r.outcome.is_none()).count()
    }

    /// Returns the failed tasks.
    pub fn failed(&self) -> impl Iterator<Item = &TaskScore> {
        self.tasks.iter().filter(|r| r.outcome == Some(Outcome::Failed))
    }

    /// Returns the position of a chosen point MDP in [`Self::points`].
    pub fn position(&self, point: &str) -> Option<usize> {
        self.positions.get(point).copied()
    }

    /// Returns the name of the sampling as on the command line.
    pub fn sampling(&self) -> &'static str {
        self.manifest.identity.sample.sampling.name()
    }

    /// Returns what a method achieved on every point MDP in its estimate, with the point MDP.
    pub fn results_of(&self, method: usize) -> impl Iterator<Item = (&PointSummary, &PointResult)> {
        self.points.iter().filter_map(move |p| {
            let result = p.results[method].as_ref()?;
            result.score.map(|_| (p, result))
        })
    }
}

//! All that records say, put together.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use super::choice::choice;
use super::comparison::{Comparison, Decided, Pair, compare};
use super::estimator::{Estimator, estimator_of};
use super::measures::{Measures, Regime, Share};
use super::method::{MethodSummary, on_common_points, rank};
use super::points::{Evidence, PointResult, PointSummary, TaskScore, episodes, summarise_points};
use super::reference::Reference;
use super::reference::{AnalysisError, position};
use super::training::{LearnerSummary, TrainingSummary, learned, learner, trained, trainings};
use super::winners::{Winner, winners};
use crate::sample::Design;
use crate::stats::{Direction, Limit};
use crate::store::dropped::Dropped;
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
    /// Number of the point MDPs that all methods with results finished, and the methods over these, best first; there when some
    /// method is not ranked.
    pub common: Option<(usize, Vec<MethodSummary>)>,
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
        let episodes = episodes(results, &tasks, &reference, measures);
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
    fn partly_replicated(&self) -> BTreeSet<&str> {
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

impl Analysis {
    /// Sets what a failure is.
    ///
    /// # Errors
    ///
    /// [`AnalysisError`] for a metric that no record has.
    pub fn fail_beyond(&mut self, limit: Limit) -> Result<(), AnalysisError> {
        let mut names = self.metrics();
        names.insert(0, self.manifest.identity.objective.clone());
        position("metric", &limit.metric, names.iter().map(String::as_str))?;
        self.failure = Some(limit);
        Ok(())
    }

    /// Whether a method fails on a point MDP, by the mean over evaluation seeds and replicates; `None` where that is
    /// not known.
    pub fn fails(&self, point: &PointSummary, method: usize) -> Option<bool> {
        let limit = self.failure.as_ref()?;
        let result = point.results[method].as_ref()?;
        result.metrics.get(&limit.metric).map(|value| limit.is_beyond(*value))
    }
}

/// By how much counts that importance and instances imply may differ, relative to the count.
const SAME_COUNT: f64 = 1e-6;

impl Analysis {
    /// Whether all point MDPs of the family were to be evaluated.
    pub fn is_whole(&self) -> bool {
        self.points.len() == self.manifest.identity.sample.family_size
    }

    /// Returns the number of instances of the whole family; `None` where importance is something else than the
    /// number of a point MDP's instances among all.
    pub fn family_instances(&self) -> Option<f64> {
        let mut counts = (self.points.iter())
            .filter(|p| p.row.importance > 0.0)
            .map(|p| f64::from(p.row.instances) / p.row.importance);
        let first = counts.next().filter(|count| *count > 0.0)?;
        let same = |count: f64| (count / first - 1.0).abs() < SAME_COUNT;
        let whole = (first.round() / first - 1.0).abs() < SAME_COUNT;
        (whole && counts.all(same)).then(|| first.round())
    }
}

/// Where a sample that grows stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Standing {
    /// Look of the sample, from 1.
    pub look: usize,
    /// Number of looks.
    pub looks: usize,
    /// Whether what was asked for is reached.
    pub is_enough: bool,
    /// The answer, with the methods that may be as good or better.
    pub answer: Option<(String, Vec<String>)>,
    /// The best method so far with each against which it may lose more than is asked for.
    pub open: Vec<(String, String)>,
    /// Methods that cannot be the best: they are surely behind another one.
    pub behind: Vec<Dropped>,
}

impl Standing {
    /// Whether there is another look, and a reason for it.
    pub fn goes_on(&self) -> bool {
        !self.is_enough && self.look < self.looks
    }
}

impl Analysis {
    /// Returns where the sample stands; `None` where it does not grow.
    pub fn standing(&self) -> Option<Standing> {
        let sample = &self.manifest.identity.sample;
        let growth = sample.growth.as_ref()?;
        let look = sample.look()? + 1;
        let (methods, within) = growth.until.question();
        let dropped = &self.results.dropped;
        let stays = |m: &&str| {
            methods.iter().any(|n| n == m) && !dropped.iter().any(|dropped| dropped.method == *m)
        };
        let ranking = self.methods.iter().map(|m| m.method.as_str());
        let stay: Vec<&str> = ranking.filter(stays).collect();
        let is_ahead = |a: &str, b: &str| self.winner(a, b) == Some(a);
        let loses = |a: &str, b: &str| a != b && !self.is_within(a, b, within);
        let is_answer = |a: &&&str| !stay.iter().any(|b| loses(a, b));
        let answer = stay.iter().find(is_answer).map(|answer| {
            let others = stay.iter().filter(|other| *other != answer && !is_ahead(answer, other));
            ((*answer).to_owned(), others.map(|other| (*other).to_owned()).collect())
        });
        let open = stay.iter().skip(1).filter(|m| answer.is_none() && loses(stay[0], m));
        let open: Vec<_> = open.map(|m| (stay[0].to_owned(), (*m).to_owned())).collect();
        // What scores are divided by never drops out.
        let droppable = self.methods.iter().filter(|m| !m.is_reference && stays(&&*m.method));
        let behind = droppable.filter_map(|m| {
            let ahead = stay.iter().find(|other| is_ahead(other, &m.method))?;
            Some(Dropped { method: m.method.clone(), look, behind: (*ahead).to_owned() })
        });
        let behind = behind.collect();
        // Methods that lack results may lack what decides.
        let is_enough = answer.is_some() && self.missing() == 0;
        Some(Standing { look, looks: growth.looks.len(), is_enough, answer, open, behind })
    }

    fn scorable(&self) -> usize {
        self.reference.index.map_or(self.points.len(), |index| self.results_of(index).count())
    }

    /// Whether the first method loses at most so much against the second, by the interval of their difference; within 0 it
    /// is ahead by more than chance.
    fn is_within(&self, first: &str, second: &str, within: f64) -> bool {
        let Some((pair, is_first)) = self.pair(first, second) else { return false };
        match pair.ahead.interval {
            _ if within == 0.0 => self.winner(first, second) == Some(first),
            Some((low, high)) => {
                pair.fragile.is_empty() && if is_first { -low <= within } else { high <= within }
            }
            None => false,
        }
    }

    /// Returns the comparison of two methods on all point MDPs, and whether the first of them comes first in it.
    fn pair(&self, first: &str, second: &str) -> Option<(&Pair, bool)> {
        let name = |m: usize| self.methods[m].method.as_str();
        let of = |p: &&Pair| {
            let named = [name(p.first), name(p.second)];
            named == [first, second] || named == [second, first]
        };
        let found = self.comparison.pairs.iter().find(of)?;
        // Where one of them failed, in one training or all, may be what decides.
        let partly = self.partly_replicated();
        let is_whole = ![first, second].iter().any(|method| partly.contains(method));
        let found = Some(found).filter(|p| is_whole && p.points == self.scorable())?;
        Some((found, name(found.first) == first))
    }

    /// Returns which of two methods is ahead by more than chance on all point MDPs, if one is.
    fn winner<'a>(&self, first: &'a str, second: &'a str) -> Option<&'a str> {
        let (found, is_first) = self.pair(first, second)?;
        match found.decided() {
            Decided::First => Some(if is_first { first } else { second }),
            Decided::Second => Some(if is_first { second } else { first }),
            Decided::Open | Decided::Unknown => None,
        }
    }
}

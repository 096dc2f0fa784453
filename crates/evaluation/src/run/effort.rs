//! About how long tasks take: what a forecast starts from before anything has been measured.

use std::collections::HashMap;

use serde_json::Value;

use super::domain::{Domain, Effort, EffortOf};
use super::error::RunError;
use super::method::{Method, Training, find};
use super::plan::Request;
use super::selection::Selection;
use crate::family::PointMdp;
use crate::store::manifest::{Identity, PointRow};

/// Processor time of starting a worker and of loading its network, seconds.
pub const SECONDS_PER_TASK: f64 = 0.2;

impl Effort {
    /// Returns how many episodes the task has at most.
    pub fn episodes(&self) -> u32 {
        self.training + self.evaluation
    }

    /// Returns the processor time of a worker until it has done the first `episodes` episodes, seconds.
    pub fn worker_seconds(&self, episodes: u32) -> f64 {
        SECONDS_PER_TASK + self.seconds(episodes)
    }

    /// Returns the processor time of a worker that does the whole task, seconds.
    pub fn whole_seconds(&self) -> f64 {
        self.worker_seconds(self.episodes())
    }

    /// Returns the processor time of the first `episodes` episodes, seconds.
    pub fn seconds(&self, episodes: u32) -> f64 {
        let training = episodes.min(self.training);
        let evaluation = (episodes - training).min(self.evaluation);
        f64::from(training) * self.training_s + f64::from(evaluation) * self.evaluation_s
    }
}

/// Features and number of agents of point MDPs.
type Points<'a> = HashMap<&'a str, (&'a [f64], u32)>;

/// The efforts of tasks on some point MDPs.
pub struct Efforts<'a> {
    methods: &'a [Method],
    of: Box<EffortOf>,
    evaluation: u32,
    selection: Selection,
    /// Names of the features.
    features: Vec<&'a str>,
    /// Features and number of agents of every point MDP.
    points: Points<'a>,
}

impl<'a> Efforts<'a> {
    /// Returns those of what is asked for, on all point MDPs of the family.
    ///
    /// # Errors
    ///
    /// [`RunError::Prepare`] with what is wrong with the settings.
    pub fn of_request(request: &Request<'a>) -> Result<Self, RunError> {
        let (problem, evaluation) = (request.problem, request.evaluation_seeds);
        let family = problem.family();
        let features = family.features.iter().map(|f| f.name.as_str()).collect();
        let point =
            |p: &'a PointMdp| (p.id.as_str(), (p.features.as_slice(), problem.agents(&p.id)));
        let points = family.points.iter().map(point).collect();
        Self::of(request.domain, &problem.settings(), evaluation, features, points)
    }

    /// Returns those of a run that was planned.
    ///
    /// # Errors
    ///
    /// [`RunError::Prepare`] with what is wrong with its settings.
    pub fn of_run(domain: &'a dyn Domain, identity: &'a Identity) -> Result<Self, RunError> {
        let evaluation = u32::try_from(identity.evaluation_seeds.len()).unwrap_or(u32::MAX);
        let features = identity.features.iter().map(|f| f.name.as_str()).collect();
        let point = |p: &'a PointRow| (p.point.as_str(), (p.features.as_slice(), domain.agents(p)));
        let points = identity.points.iter().map(point).collect();
        Self::of(domain, &identity.settings, evaluation, features, points)
    }

    fn of(
        domain: &'a dyn Domain,
        settings: &Value,
        evaluation: u32,
        features: Vec<&'a str>,
        points: Points<'a>,
    ) -> Result<Self, RunError> {
        let wrong = |reason: String| RunError::Prepare(reason.into());
        let of = domain.efforts(settings).map_err(wrong)?;
        let selection = Selection::of(settings).map_err(wrong)?;
        Ok(Self { methods: domain.methods(), of, evaluation, selection, features, points })
    }

    /// Returns that of a method on a point MDP.
    ///
    /// # Errors
    ///
    /// [`RunError::Method`] for a name that no method has, [`RunError::Unprepared`] for a point MDP that is not among them.
    pub fn task(&self, method: &str, point: &str) -> Result<Effort, RunError> {
        let unprepared = || RunError::Unprepared(point.to_owned());
        let (features, agents) = self.points.get(point).ok_or_else(unprepared)?;
        let feature = |name: &str| {
            let position = self.features.iter().position(|feature| *feature == name)?;
            features.get(position).copied()
        };
        let method = find(self.methods, method)?;
        let of = (self.of)(method, *agents, &feature);
        let validation = match method.training {
            Training::Learned => self.selection.most_episodes(of.training),
            _ => 0,
        };
        // The last policy is evaluated too, where validation chose another.
        let evaluation = self.evaluation * if validation > 0 { 2 } else { 1 } + validation;
        Ok(Effort { evaluation, ..of })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A task with episodes of training and evaluation of these seconds.
    fn effort(training: (u32, f64), evaluation: (u32, f64)) -> Effort {
        Effort {
            training: training.0,
            training_s: training.1,
            evaluation: evaluation.0,
            evaluation_s: evaluation.1,
            is_informed: true,
        }
    }

    #[test]
    fn episodes_of_training_come_first_and_count_at_their_own_price() {
        let effort = effort((3, 10.0), (2, 1.0));
        assert_eq!(effort.episodes(), 5);
        let seconds: Vec<_> = [0, 2, 3, 4, 5, 9].map(|n| effort.seconds(n)).to_vec();
        assert_eq!(seconds, [0.0, 20.0, 30.0, 31.0, 32.0, 32.0]);
    }
}

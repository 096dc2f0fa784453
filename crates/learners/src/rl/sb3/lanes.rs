//! Environments that are played side by side, each with one episode after the other.

use super::Progress;
use crate::nn::state::{State, kept};
use crate::rl::environment::{Actions, Environment, Step};

/// An environment and its running episode.
#[derive(Debug, Clone)]
struct Lane<E> {
    environment: E,
    observation: Vec<f32>,
    /// Sum of rewards of the running episode.
    total: f64,
}

/// Environments side by side.
#[derive(Debug, Clone)]
pub(super) struct Lanes<E> {
    lanes: Vec<Lane<E>>,
    /// Episodes begun, in all environments.
    begun: u32,
    /// Episodes ended since [`Self::report`], and the sums of their returns and scores.
    ended: u32,
    returns: f64,
    scores: f64,
}

impl<E: Environment> Lanes<E> {
    pub(super) fn new(environments: Vec<E>) -> Self {
        let lane = |environment: E| {
            let observation = vec![0.0; environment.width()];
            Lane { environment, observation, total: 0.0 }
        };
        Self {
            lanes: environments.into_iter().map(lane).collect(),
            begun: 0,
            ended: 0,
            returns: 0.0,
            scores: 0.0,
        }
    }

    pub(super) fn count(&self) -> usize {
        self.lanes.len()
    }

    pub(super) fn width(&self) -> usize {
        self.lanes[0].environment.width()
    }

    pub(super) fn actions(&self) -> Actions {
        self.lanes[0].environment.actions()
    }

    /// Begins the first episodes, once.
    pub(super) fn begin(&mut self, seeds: &mut dyn FnMut(u32) -> u64) {
        if self.begun == 0 {
            for Lane { environment, observation, .. } in &mut self.lanes {
                environment.reset(seeds(self.begun), observation);
                self.begun += 1;
            }
        }
    }

    /// Returns the observation that a lane acts on.
    pub(super) fn observation(&self, lane: usize) -> &[f32] {
        &self.lanes[lane].observation
    }

    /// Takes an action in a lane and writes the observation after it; an episode that is over is followed by
    /// the next one.
    pub(super) fn step(
        &mut self,
        lane: usize,
        action: &[f32],
        after: &mut [f32],
        seeds: &mut dyn FnMut(u32) -> u64,
    ) -> Step {
        let Lane { environment, observation, total } = &mut self.lanes[lane];
        let step = environment.step(action, after);
        *total += f64::from(step.reward);
        if step.over() {
            self.ended += 1;
            self.scores += environment.score(*total);
            self.returns += std::mem::take(total);
            environment.reset(seeds(self.begun), observation);
            self.begun += 1;
        } else {
            observation.copy_from_slice(after);
        }
        step
    }

    /// Returns the episodes that ended since this was last asked for.
    pub(super) fn report(&mut self) -> Progress {
        let episodes = std::mem::take(&mut self.ended);
        let returns = std::mem::take(&mut self.returns);
        let scores = std::mem::take(&mut self.scores);
        let mean = |sum: f64| (episodes > 0).then(|| sum / f64::from(episodes));
        let (mean_return, mean_score) = (mean(returns), mean(scores));
        Progress { begun: self.begun, episodes, mean_return, mean_score, ..Progress::default() }
    }
}

impl<E: Environment> State for Lane<E> {
    kept! { State { "total": total, "observation": observation, "": environment } }
}

impl<E: Environment> State for Lanes<E> {
    kept! { State { "episodes": begun, "lane": lanes } }
}

//! The algorithms as Stable-Baselines3 (2.9) computes them, for environments of one agent.
//!
//! They are a second flavour beside [`super::ppo`] and [`super::dqn`], which are PFRL's and are fed step by
//! step: here a trainer holds its environments, plays and learns until a number of steps is done. It can stop
//! after every update; what it then saves is all that it goes on from, with the same bytes at the end.

pub(super) mod actor_critic;
pub mod ars;
pub(super) mod distribution;
pub mod dqn;
mod off_policy;
pub(super) mod on_policy;
pub mod ppo;
pub(super) mod rollout;
pub mod sac;
pub mod td3;
#[cfg(test)]
mod testing;
pub mod trpo;

use serde::{Deserialize, Serialize};

use super::environment::{Actions, Environment, Step};
use super::persist::Persist;
use crate::nn::state::{State, kept};

/// Hidden layers of every network.
const HIDDEN_LAYERS: usize = 2;

/// How a number changes over a training.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Schedule {
    /// Not at all.
    Constant,
    /// In a straight line to 0 at the end.
    Linear,
}

impl Schedule {
    /// Returns the number when `steps` of `total` are done.
    /// Deviation: in Stable-Baselines3 a training that ends with a whole update has a negative number in it.
    fn at(self, start: f32, steps: u64, total: u64) -> f32 {
        match self {
            Self::Constant => start,
            Self::Linear => start * (1.0 - steps as f64 / total as f64).max(0.0) as f32,
        }
    }
}

/// What a part of a training was like.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Progress {
    /// Steps done, from the beginning of the training.
    pub steps: u64,
    /// Episodes that began, from the beginning of the training.
    pub begun: u32,
    /// Episodes that ended.
    pub episodes: u32,
    /// Mean return of these episodes.
    pub mean_return: Option<f64>,
    /// Mean of what [`super::environment::Environment::score`] says of them.
    pub mean_score: Option<f64>,
    /// Mean loss of the updates.
    pub loss: Option<f64>,
    /// Mean entropy of the policy in the updates.
    pub entropy: Option<f64>,
    /// Share of random actions at the end.
    pub epsilon: Option<f64>,
}

/// A training in its environments; it is kept and goes on also within an episode.
pub trait Trainer: Persist {
    /// Goes on until at least `steps` steps are done since the training began, and the update that follows them; `seeds`
    /// gives the seed of the episode of a number. Never goes on beyond the training's own steps by more than an update.
    fn advance(&mut self, steps: u64, seeds: &mut dyn FnMut(u32) -> u64) -> Progress;

    /// Steps done.
    fn steps(&self) -> u64;

    /// Whether all steps of the training are done.
    fn finished(&self) -> bool;

    /// Writes the action that is thought best.
    fn act(&mut self, observation: &[f32], action: &mut [f32]);
}

#[derive(Debug, Clone)]
struct Lane<E> {
    environment: E,
    observation: Vec<f32>,
    total: f64,
}

#[derive(Debug, Clone)]
struct Lanes<E> {
    lanes: Vec<Lane<E>>,
    begun: u32,
    /// Episodes ended since [`Self::report`], and the sums of their returns and scores.
    ended: u32,
    returns: f64,
    scores: f64,
}

impl<E: Environment> Lanes<E> {
    fn new(environments: Vec<E>) -> Self {
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

    fn count(&self) -> usize {
        self.lanes.len()
    }

    fn width(&self) -> usize {
        self.lanes[0].environment.width()
    }

    fn actions(&self) -> Actions {
        self.lanes[0].environment.actions()
    }

    /// Begins the first episodes, once.
    fn begin(&mut self, seeds: &mut dyn FnMut(u32) -> u64) {
        if self.begun == 0 {
            for Lane { environment, observation, .. } in &mut self.lanes {
                environment.reset(seeds(self.begun), observation);
                self.begun += 1;
            }
        }
    }

    fn observation(&self, lane: usize) -> &[f32] {
        &self.lanes[lane].observation
    }

    /// An episode that is over is followed by the next one.
    fn step(
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

    fn report(&mut self) -> Progress {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_falls_to_0_and_never_below() {
        let at = |steps| Schedule::Linear.at(0.5, steps, 100);
        assert_eq!((at(0), at(50), at(100), at(130)), (0.5, 0.25, 0.0, 0.0));
        assert_eq!(Schedule::Constant.at(0.5, 130, 100), 0.5);
    }
}

//! The algorithms as Stable-Baselines3 (2.9) computes them, for environments of one agent.
//!
//! They are a second flavour beside [`super::ppo`] and [`super::dqn`], which are PFRL's and are fed step by
//! step: here a trainer holds its environments, plays and learns until a number of steps is done. It can stop
//! after every update; what it then saves is all that it goes on from, with the same bytes at the end.

pub(super) mod actor_critic;
pub mod ars;
pub(super) mod distribution;
pub mod dqn;
mod lanes;
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

use super::persist::Persist;

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
    ///
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
    /// Goes on until at least `steps` steps are done since the training began, and the update that follows
    /// them; `seeds` gives the seed of the episode of a number. Never goes on beyond the training's own steps
    /// by more than an update.
    fn advance(&mut self, steps: u64, seeds: &mut dyn FnMut(u32) -> u64) -> Progress;

    /// Steps done.
    fn steps(&self) -> u64;

    /// Whether all steps of the training are done.
    fn finished(&self) -> bool;

    /// Writes the action that is thought best.
    fn act(&mut self, observation: &[f32], action: &mut [f32]);
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

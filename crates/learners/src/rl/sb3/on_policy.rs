//! What Stable-Baselines3's algorithms share that learn from what the policy itself has just done: environments side by
//! side, the steps of an update, and networks of a policy and its value.

use super::Lanes;
use super::actor_critic::ActorCritic;
use super::rollout::Rollout;
use super::{Progress, Trainer};
use crate::nn::state::{Learned, State, kept};
use crate::rl::Losses;
use crate::rl::environment::Environment;
use crate::rl::persist::Persist;
use crate::rl::random::Generator;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Play {
    pub(super) total_steps: u64,
    pub(super) environments: usize,
    pub(super) num_steps: usize,
    pub(super) gamma: f32,
    pub(super) gae_lambda: f32,
    pub(super) hidden: usize,
    pub(super) adam_epsilon: f32,
}

#[derive(Debug, Clone)]
pub(in crate::rl) struct Experience {
    pub(in crate::rl) networks: ActorCritic,
    pub(in crate::rl) rollout: Rollout,
    pub(in crate::rl) shuffling: Generator,
    pub(super) order: Vec<usize>,
}

impl Experience {
    pub(in crate::rl) fn new(
        networks: ActorCritic,
        rollout: Rollout,
        shuffling: Generator,
    ) -> Self {
        Self { networks, rollout, shuffling, order: Vec::new() }
    }
}

/// How policy and value learn from the steps of an update.
pub trait Algorithm {
    /// Learns from steps whose advantages are known, when `steps` are done since the training began.
    #[expect(private_interfaces, reason = "only algorithms of this folder learn so")]
    fn update(&mut self, experience: &mut Experience, steps: u64, losses: &mut Losses);
}

/// A training of a policy and its value.
#[derive(Debug, Clone)]
pub struct OnPolicy<E, A> {
    play: Play,
    pub(super) algorithm: A,
    pub(super) experience: Experience,
    lanes: Lanes<E>,
    sampling: Generator,
    pub(super) steps: u64,
}

impl<E: Environment + Clone, A: Algorithm> OnPolicy<E, A> {
    /// Returns a training that has not begun; `algorithm` makes what moves the networks.
    pub(super) fn start(
        play: Play,
        environment: E,
        seed: u64,
        algorithm: impl FnOnce(&ActorCritic) -> A,
    ) -> Self {
        let lanes = Lanes::new(vec![environment; play.environments.max(1)]);
        let (width, actions) = (lanes.width(), lanes.actions());
        let Play { hidden, adam_epsilon, num_steps, .. } = play;
        let networks = ActorCritic::new(width, actions, hidden, adam_epsilon, seed);
        Self {
            algorithm: algorithm(&networks),
            experience: Experience::new(
                networks,
                Rollout::new(lanes.count(), num_steps, width, actions.width()),
                Generator::new(seed, &["shuffling"]),
            ),
            sampling: Generator::new(seed, &["sampling"]),
            steps: 0,
            lanes,
            play,
        }
    }

    pub(super) fn collect(&mut self, seeds: &mut dyn FnMut(u32) -> u64) {
        let Experience { networks, rollout, .. } = &mut self.experience;
        rollout.collect(networks, &mut self.lanes, &mut self.sampling, seeds);
        self.steps += rollout.len() as u64;
    }

    pub(super) fn update(&mut self, losses: &mut Losses) {
        let Play { gamma, gae_lambda, .. } = self.play;
        let Experience { networks, rollout, .. } = &mut self.experience;
        rollout.estimate(networks, gamma, gae_lambda);
        self.algorithm.update(&mut self.experience, self.steps, losses);
    }
}

impl<E: Environment + Clone, A: Algorithm> Trainer for OnPolicy<E, A> {
    fn advance(&mut self, steps: u64, seeds: &mut dyn FnMut(u32) -> u64) -> Progress {
        let mut losses = Losses::default();
        while !self.finished() && self.steps < steps {
            self.collect(seeds);
            self.update(&mut losses);
        }
        let (loss, entropy) = losses.take();
        Progress { steps: self.steps, loss, entropy, ..self.lanes.report() }
    }

    fn steps(&self) -> u64 {
        self.steps
    }

    fn finished(&self) -> bool {
        self.steps >= self.play.total_steps
    }

    fn act(&mut self, observation: &[f32], action: &mut [f32]) {
        self.experience.networks.best(observation, action);
    }
}

impl<E: Environment + Clone, A: Algorithm> Persist for OnPolicy<E, A> {
    fn is_finite(&self) -> bool {
        self.experience.networks.is_finite()
    }

    fn is_alive(&mut self) -> bool {
        let states = self.experience.rollout.probes();
        self.experience.networks.is_alive(&states)
    }
}

impl<E, A> Learned for OnPolicy<E, A> {
    kept! { Learned { "": experience.networks } }
}

impl<E: Environment, A> State for OnPolicy<E, A> {
    kept! { State {
        "steps": steps, "": experience.networks, "sampling": sampling, "shuffling": experience.shuffling, "": lanes,
    } }
}

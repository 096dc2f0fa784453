//! What Stable-Baselines3's algorithms share that learn from what the policy itself has just done: environments side by
//! side, the steps of an update, and networks of a policy and its value.

use super::actor_critic::ActorCritic;
use super::lanes::Lanes;
use super::rollout::Rollout;
use super::{Progress, Trainer};
use crate::nn::archive::{Archive, ArchiveError};
use crate::rl::environment::{Actions, Environment};
use crate::rl::persist::Persist;
use crate::rl::random::Generator;

/// How much is played between updates, and with which networks.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Play {
    /// Steps of the training, in all environments together.
    pub(super) total_steps: u64,
    /// Environments side by side.
    pub(super) environments: usize,
    /// Steps per environment and update.
    pub(super) num_steps: usize,
    /// Discount per step.
    pub(super) gamma: f32,
    /// Discount of later errors in the advantage.
    pub(super) gae_lambda: f32,
    /// Units of both hidden layers of either network.
    pub(super) hidden: usize,
    /// Adam's epsilon.
    pub(super) adam_epsilon: f32,
}

/// The steps of an update, and what is to learn from them.
#[derive(Debug, Clone)]
pub(super) struct Experience {
    pub(super) networks: ActorCritic,
    pub(super) rollout: Rollout,
    pub(super) shuffling: Generator,
    /// Places of the steps, for permutations.
    pub(super) order: Vec<usize>,
}

/// Sums over what an algorithm counts its losses by: gradient steps, or updates.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Losses {
    loss: f64,
    entropy: f64,
    count: u32,
}

impl Losses {
    /// Adds a loss and an entropy.
    pub(super) fn add(&mut self, loss: f64, entropy: f64) {
        self.loss += loss;
        self.entropy += entropy;
        self.count += 1;
    }

    /// Returns how many were added.
    #[cfg(test)]
    pub(super) fn count(&self) -> u32 {
        self.count
    }

    /// Returns the mean loss and the mean entropy; nothing of nothing.
    pub(super) fn means(&self) -> (Option<f64>, Option<f64>) {
        let mean = |sum: f64| (self.count > 0).then(|| sum / f64::from(self.count));
        (mean(self.loss), mean(self.entropy))
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
    /// Returns a training that has not begun; `algorithm` makes what learns actions of a kind.
    pub(super) fn start(
        play: Play,
        environment: E,
        seed: u64,
        algorithm: impl FnOnce(Actions) -> A,
    ) -> Self {
        let lanes = Lanes::new(vec![environment; play.environments.max(1)]);
        let (width, actions) = (lanes.width(), lanes.actions());
        let Play { hidden, adam_epsilon, num_steps, .. } = play;
        Self {
            algorithm: algorithm(actions),
            experience: Experience {
                networks: ActorCritic::new(width, actions, hidden, adam_epsilon, seed),
                rollout: Rollout::new(lanes.count(), num_steps, width, actions.width()),
                shuffling: Generator::new(seed, &["shuffling"]),
                order: Vec::new(),
            },
            sampling: Generator::new(seed, &["sampling"]),
            steps: 0,
            lanes,
            play,
        }
    }

    /// Plays the steps of an update.
    pub(super) fn collect(&mut self, seeds: &mut dyn FnMut(u32) -> u64) {
        let Experience { networks, rollout, .. } = &mut self.experience;
        rollout.collect(networks, &mut self.lanes, &mut self.sampling, seeds);
        self.steps += rollout.len() as u64;
    }

    /// Learns from the steps of an update.
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
        let (loss, entropy) = losses.means();
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

    fn learned(&self, prefix: &str, archive: &mut Archive) {
        self.experience.networks.learned(prefix, archive);
    }

    fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        self.experience.networks.load(prefix, archive)
    }

    fn save(&self, prefix: &str, archive: &mut Archive) {
        archive.put(&format!("{prefix}steps"), self.steps);
        self.experience.networks.save(prefix, archive);
        self.sampling.save(&format!("{prefix}sampling"), archive);
        self.experience.shuffling.save(&format!("{prefix}shuffling"), archive);
        self.lanes.save(prefix, archive);
    }

    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        self.steps = archive.get(&format!("{prefix}steps"))?;
        self.experience.networks.restore(prefix, archive)?;
        self.sampling.restore(&format!("{prefix}sampling"), archive)?;
        self.experience.shuffling.restore(&format!("{prefix}shuffling"), archive)?;
        self.lanes.restore(prefix, archive)
    }
}

//! What an algorithm learns in: states as vectors of numbers, numbered actions, rewards.

use crate::nn::archive::{Archive, ArchiveError};

/// What an action led to, beside the state after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Reward received.
    pub reward: f32,
    /// Whether nothing can follow: the state after is worth nothing.
    pub terminated: bool,
    /// Whether the episode was cut by a limit of time: the state after has its value.
    pub truncated: bool,
}

impl Step {
    /// Whether the episode is over, for either reason.
    pub fn over(&self) -> bool {
        self.terminated || self.truncated
    }
}

/// A decision process of one agent, as in gymnasium.
pub trait Environment {
    /// Numbers of an observation.
    fn width(&self) -> usize;

    /// Number of actions, which are 0 up to it.
    fn actions(&self) -> usize;

    /// Begins the episode of a seed and writes its first observation.
    fn reset(&mut self, seed: u64, observation: &mut [f32]);

    /// Takes an action and writes the observation after it.
    fn step(&mut self, action: usize, observation: &mut [f32]) -> Step;

    /// Adds the state of a running episode to an archive.
    fn save(&self, prefix: &str, archive: &mut Archive);

    /// Takes the state of a running episode from an archive.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] when it is missing or of another kind.
    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError>;
}

/// What an episode came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Sum of rewards.
    pub total: f64,
    /// Steps it took.
    pub steps: u32,
}

/// Plays the episode of a seed with a policy.
pub fn play(
    environment: &mut dyn Environment,
    seed: u64,
    policy: &mut dyn FnMut(&[f32]) -> usize,
) -> Outcome {
    let mut observation = vec![0.0; environment.width()];
    environment.reset(seed, &mut observation);
    let mut outcome = Outcome { total: 0.0, steps: 0 };
    loop {
        let step = environment.step(policy(&observation), &mut observation);
        outcome.total += f64::from(step.reward);
        outcome.steps += 1;
        if step.over() {
            return outcome;
        }
    }
}

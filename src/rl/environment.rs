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
